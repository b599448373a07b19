#include "csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "files/csv_cell.h"

namespace bsoil::experiment {
namespace {

/// The cells of the next record; quoted cells may hold commas, line ends and doubled quotes.
std::vector<std::string> read_record(std::istream& file) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (char c; file.get(c);) {
        if (quoted) {
            if (c != '"') {
                cells.back() += c;
            } else if (file.peek() == '"') {
                cells.back() += static_cast<char>(file.get());
            } else {
                quoted = false;
            }
        } else if (c == '"') {
            quoted = true;
        } else if (c == ',') {
            cells.emplace_back();
        } else if (c == '\n') {
            break;
        } else if (c != '\r') {
            cells.back() += c;
        }
    }
    return cells;
}

}  // namespace

int CsvTable::column_index(const std::string& name) const {
    const auto found = std::find(columns.begin(), columns.end(), name);
    return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

std::optional<double> CsvTable::number(size_t row, const std::string& column) const {
    const int index = column_index(column);
    if (index < 0) return std::nullopt;
    return number_in(rows[row][static_cast<size_t>(index)]);
}

Result<CsvTable> read_csv(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return Error{path + ": cannot be read; check its name and rights"};
    CsvTable table;
    table.columns = read_record(file);
    // The mark with which spreadsheets begin a file in UTF-8 is no part of the first heading.
    constexpr std::string_view kMark = "\xef\xbb\xbf";
    if (table.columns[0].starts_with(kMark)) table.columns[0].erase(0, kMark.size());
    while (file.peek() != std::char_traits<char>::eof()) {
        std::vector<std::string> cells = read_record(file);
        if (cells.size() == 1 && cells[0].empty()) continue;  // an empty line
        if (cells.size() > table.columns.size()) {
            return Error{fmt::format("{}: row {} has {} cells, must have {} as the headings", path,
                                     table.rows.size() + 2, cells.size(), table.columns.size())};
        }
        cells.resize(table.columns.size());
        table.rows.push_back(std::move(cells));
    }
    return table;
}

Status write_csv(const CsvTable& table, const std::string& path) {
    std::ofstream file(path, std::ios::binary);
    const auto write = [&](const std::vector<std::string>& cells) {
        for (size_t i = 0; i < cells.size(); ++i) {
            file << (i ? "," : "") << scene::csv_cell(cells[i]);
        }
        file << '\n';
    };
    write(table.columns);
    for (const std::vector<std::string>& row : table.rows) write(row);
    if (!file.flush()) return Error{path + ": cannot be written; check its folder and the disk"};
    return Done{};
}

std::string cell(double value) {
    return std::isfinite(value) ? fmt::format("{:.6g}", value) : std::string();
}

std::optional<double> number_in(const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool is_number = end != text.c_str() && std::isfinite(value);
    while (*end == ' ' || *end == '\t') ++end;  // as before a number
    if (!is_number || *end != '\0') return std::nullopt;
    return value;
}

}  // namespace bsoil::experiment
