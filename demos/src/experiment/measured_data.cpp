#include "measured_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bsoil::experiment {
namespace {

/// Two cells are one value when they are the same text or the same number.
bool same_cell(const std::string& a, const std::string& b) {
    const auto x = number_in(a), y = number_in(b);
    return x && y ? same_value(*x, *y) : a == b;
}

/// The cell's number, or the one that its word stands for.
std::optional<double> number_of(const std::string& text, const MeasuredColumnItem& column) {
    if (column.values.empty()) return number_in(text);
    const auto found = column.values.find(text);
    return found == column.values.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

bool same_value(double a, double b) {
    return std::abs(a - b) <= 1e-5 * std::max(std::abs(a), std::abs(b));
}

Result<MeasuredTable> select_measured(const CsvTable& file, const MeasuredItem& item) {
    const auto index_of = [&](const std::string& column) -> Result<size_t> {
        const int index = file.column_index(column);
        if (index >= 0) return static_cast<size_t>(index);
        std::string known;
        for (const std::string& name : file.columns) known += (known.empty() ? "" : ", ") + name;
        return Error{fmt::format("there is no column \"{}\"; the columns are {}", column, known)};
    };
    std::vector<size_t> filters, columns;
    for (const MeasuredFilterItem& filter : item.filters) {
        const auto index = index_of(filter.column);
        if (!index) return Error{index.error()};
        filters.push_back(*index);
    }
    MeasuredTable table;
    for (const MeasuredColumnItem& column : item.columns) {
        const auto index = index_of(column.column);
        if (!index) return Error{index.error()};
        columns.push_back(*index);
        table.columns.push_back(column.name);
    }
    size_t asked_for = 0;
    for (const std::vector<std::string>& cells : file.rows) {
        bool taken = true;
        for (size_t f = 0; f < filters.size(); ++f) {
            taken = taken && std::any_of(item.filters[f].equals.begin(),
                                         item.filters[f].equals.end(), [&](const auto& wanted) {
                                             return same_cell(cells[filters[f]], wanted);
                                         });
        }
        asked_for += taken;
        std::vector<double> row;
        for (size_t c = 0; taken && c < columns.size(); ++c) {
            const auto number = number_of(cells[columns[c]], item.columns[c]);
            taken = number.has_value();
            if (number) row.push_back(*number * item.columns[c].factor);
        }
        if (taken) table.rows.push_back(std::move(row));
    }
    if (asked_for == 0) {
        return Error{"no row has what [[measured.where]] asks for; check its numbers"};
    }
    if (table.rows.empty()) {
        return Error{fmt::format(
            "none of {} rows has a number in each [[measured.column]]; leave out a column",
            asked_for)};
    }
    return table;
}

void add_measured(CsvTable& results, const MeasuredTable& measured,
                  const std::vector<std::string>& keys) {
    const auto is_key = [&](const std::string& name) {
        return std::find(keys.begin(), keys.end(), name) != keys.end();
    };
    std::vector<size_t> key_columns, value_columns;
    for (size_t c = 0; c < measured.columns.size(); ++c) {
        (is_key(measured.columns[c]) ? key_columns : value_columns).push_back(c);
    }
    for (const size_t c : value_columns) {
        results.columns.push_back(measured.columns[c] + "_measured");
        results.columns.push_back(measured.columns[c] + "_error");
    }
    for (size_t r = 0; r < results.rows.size(); ++r) {
        std::vector<double> sum(value_columns.size());
        int count = 0;
        for (const std::vector<double>& row : measured.rows) {
            const bool agrees = std::all_of(key_columns.begin(), key_columns.end(), [&](size_t c) {
                const auto value = results.number(r, measured.columns[c]);
                return value && same_value(*value, row[c]);
            });
            if (!agrees) continue;
            ++count;
            for (size_t v = 0; v < sum.size(); ++v) sum[v] += row[value_columns[v]];
        }
        for (size_t v = 0; v < sum.size(); ++v) {
            const auto value = results.number(r, measured.columns[value_columns[v]]);
            const double mean = sum[v] / count;
            results.rows[r].push_back(count ? cell(mean) : "");
            results.rows[r].push_back(count && value && mean != 0 ? cell(*value / mean - 1) : "");
        }
    }
}

}  // namespace bsoil::experiment
