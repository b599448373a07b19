#include "page_figures.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <vector>

namespace bsoil::experiment {
namespace {

constexpr std::string_view kPlace = "<!-- figure: ", kPlaceEnd = "<!-- / -->";

std::string trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(' ');
    if (first == std::string_view::npos) return {};
    return std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

std::vector<std::string> parts_of(std::string_view text, std::string_view separator) {
    std::vector<std::string> parts;
    while (true) {
        const size_t at = text.find(separator);
        parts.push_back(trimmed(text.substr(0, at)));
        if (at == std::string_view::npos) return parts;
        text.remove_prefix(at + separator.size());
    }
}

std::vector<std::string> lines_of(std::string_view text) { return parts_of(text, "\n"); }

/// "| a | b |" is a, b.
std::vector<std::string> cells_of(std::string_view row) {
    std::vector<std::string> cells = parts_of(row, "|");
    if (cells.size() < 2) return {};
    return {cells.begin() + 1, cells.end() - 1};
}

/// The rows of a block's table, its head first; nothing where there is no such table.
std::vector<std::vector<std::string>> table_of(const std::string& tables, const std::string& block,
                                               const std::string& title) {
    const std::string name = ": " + block + " -->\n";
    const size_t at = tables.find(name);
    if (at == std::string::npos || tables.rfind("<!-- bsoil ", at) != tables.rfind("<!--", at)) {
        return {};
    }
    const size_t begin = at + name.size();
    bool is_here = title == "-";
    std::vector<std::vector<std::string>> rows;
    for (const std::string& line : lines_of(
             std::string_view(tables).substr(begin, tables.find("<!-- end -->", begin) - begin))) {
        if (line.starts_with('|') && is_here) {
            if (!line.starts_with("|---")) rows.push_back(cells_of(line));
        } else if (!rows.empty()) {
            break;
        } else if (line.ends_with(':')) {
            is_here = is_here || line == title + ":" || line.starts_with(title + ",");
        }
    }
    return rows;
}

std::optional<size_t> column_of(const std::vector<std::string>& head, const std::string& name) {
    for (size_t c = 0; c < head.size(); ++c) {
        if (head[c] == name) return c;
    }
    // A column after another one.
    for (size_t before = 0; before < head.size(); ++before) {
        if (!name.starts_with(head[before] + " ")) continue;
        const std::string rest = name.substr(head[before].size() + 1);
        for (size_t c = before + 1; c < head.size(); ++c) {
            if (head[c] == rest) return c;
        }
    }
    return std::nullopt;
}

bool fits(const std::vector<std::string>& row, const std::vector<std::string>& keys) {
    if (row.size() < keys.size()) return false;
    for (size_t k = 0; k < keys.size(); ++k) {
        const bool is_link = row[k].ends_with("](#" + keys[k] + ")");
        if (keys[k] != "*" && keys[k] != row[k] && !is_link) return false;
    }
    return true;
}

double value_of(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

/// What the place "BLOCK / TITLE / KEYS / COLUMN" holds.
std::optional<std::string> figure_at(const std::string& tables, const std::string& place) {
    const std::vector<std::string> words = parts_of(place, " / ");
    if (words.size() != 4) return std::nullopt;
    const auto rows = table_of(tables, words[0], words[1]);
    if (rows.empty()) return std::nullopt;
    const auto column = column_of(rows.front(), words[3]);
    if (!column) return std::nullopt;
    std::vector<std::string> found;
    for (size_t r = 1; r < rows.size(); ++r) {
        if (fits(rows[r], parts_of(words[2], ",")) && *column < rows[r].size()) {
            found.push_back(rows[r][*column]);
        }
    }
    if (found.empty()) return std::nullopt;
    // A cell without a figure is neither the least nor the greatest.
    if (std::ranges::count(found, "-") < std::ssize(found)) std::erase(found, "-");
    const auto less = [](const std::string& a, const std::string& b) {
        return value_of(a) < value_of(b);
    };
    const auto [least, greatest] = std::ranges::minmax_element(found, less);
    return *least == *greatest ? *least : *least + " to " + *greatest;
}

}  // namespace

bool names_figures(const std::string& page) { return page.find(kPlace) != std::string::npos; }

Result<std::string> fill_figures(std::string page, const std::string& tables) {
    for (size_t at = page.find(kPlace); at != std::string::npos; at = page.find(kPlace, at)) {
        const size_t name = at + kPlace.size(), name_end = page.find(" -->", name);
        const std::string place = page.substr(name, name_end - name);
        const size_t end =
            name_end == std::string::npos ? name_end : page.find(kPlaceEnd, name_end);
        if (end == std::string::npos) {
            return Error{"\"" + place + "\" has no <!-- / --> after it; add one"};
        }
        const auto figure = figure_at(tables, place);
        if (!figure) return Error{"no table has \"" + place + "\"; check the name"};
        const size_t begin = name_end + 4;
        page.replace(begin, end - begin, *figure);
        at = begin;
    }
    return page;
}

}  // namespace bsoil::experiment
