#include "page_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "files/text_file.h"
#include "page_figures.h"
#include "plot.h"

namespace bsoil::experiment {
namespace {

constexpr int kDigits = 3;

std::string digits(double value, int count) {
    if (value == 0 || !std::isfinite(value)) return "0";
    const int whole = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
    return fmt::format("{:.{}f}", value, std::max(0, count - whole));
}

/// The columns of results that a page shows; those of what is swept first.
std::vector<std::string> page_columns(const Experiment& experiment, const CsvTable& results) {
    std::vector<std::string> columns;
    const auto add = [&](const std::string& column) {
        if (results.column_index(column) >= 0 && std::ranges::count(columns, column) == 0) {
            columns.push_back(column);
        }
    };
    if (!experiment.points.empty()) {
        for (const Parameter& swept : experiment.points.front().parameters) add(swept.name);
    }
    for (const ExpectItem& expectation : experiment.expectations) add(expectation.column);
    for (const PlotItem& plot : experiment.plots) add(plot.y);
    return columns;
}

}  // namespace

Shown shown(const std::string& column) {
    std::string name = column.substr(column.rfind('.') + 1);  // without its table
    Shown out{axis_title(name), 1};
    const auto with = [&](size_t suffix, const char* unit, double factor) {
        name.resize(name.size() - suffix);
        std::replace(name.begin(), name.end(), '_', ' ');
        out = {name + unit, factor};
    };
    if (name.ends_with("_pa")) with(3, ", kPa", 1e-3);
    if (name.ends_with("_m") && !name.ends_with("_n_m")) with(2, ", mm", 1e3);
    return out;
}

std::string figure_text(const std::optional<double>& value, double factor) {
    return value ? digits(*value * factor, kDigits) : "-";
}

std::string key_text(const std::string& cell_text, double factor) {
    const auto number = number_in(cell_text);
    return number ? fmt::format("{:.5g}", *number * factor) : cell_text;
}

std::string table_row(const std::vector<std::string>& cells) {
    std::string out = "|";
    for (const std::string& text : cells) out += ' ' + text + " |";
    return out + '\n';
}
std::string table_head(const std::vector<std::string>& cells) {
    std::string out = table_row(cells) + "|";
    for (size_t i = 0; i < cells.size(); ++i) out += "---|";
    return out + '\n';
}

Result<Block> block_of(const std::string& page, const std::string& command,
                       const std::string& name) {
    const std::string marker = "<!-- bsoil " + command + ": " + name + " -->\n";
    const size_t at = page.find(marker);
    const size_t end = at == std::string::npos ? at : page.find("<!-- end -->", at);
    if (end == std::string::npos) {
        return Error{"the page must have \"<!-- bsoil " + command + ": " + name +
                     " -->\" with a line \"<!-- end -->\" after it"};
    }
    return Block{at + marker.size(), end};
}

Status has_blocks(const std::string& path, const std::string& command,
                  const std::vector<std::string>& names) {
    const auto page = scene::read_file(path, kPageBytesMost);
    if (!page) return Error{page.error() + "; its prose is written by hand, name the page"};
    for (const std::string& name : names) {
        if (const auto block = block_of(*page, command, name); !block) {
            return Error{path + ": " + block.error()};
        }
    }
    return Done{};
}

Result<std::string> update_results(std::string page, const Experiment& experiment,
                                   const CsvTable& results) {
    const std::string name = std::filesystem::path(experiment.path).stem().string();
    const auto block = block_of(page, experiment.rig, name);
    if (!block) return Error{block.error()};
    const std::vector<std::string> columns = page_columns(experiment, results);
    const size_t swept =
        experiment.points.empty() ? 0 : experiment.points.front().parameters.size();
    std::vector<std::string> head;
    for (const std::string& column : columns) head.push_back(shown(column).title);
    std::string table = table_head(head);
    for (size_t r = 0; r < results.rows.size(); ++r) {
        std::vector<std::string> row;
        for (size_t c = 0; c < columns.size(); ++c) {
            const double factor = shown(columns[c]).factor;
            const auto index = static_cast<size_t>(results.column_index(columns[c]));
            row.push_back(c < swept ? key_text(results.rows[r][index], factor)
                                    : figure_text(results.number(r, columns[c]), factor));
        }
        table += table_row(row);
    }
    page.replace(block->begin, block->end - block->begin, table);
    const std::string tables = page;
    return fill_figures(std::move(page), tables);
}

}  // namespace bsoil::experiment
