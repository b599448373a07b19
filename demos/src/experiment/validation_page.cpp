#include "validation_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "classical_columns.h"
#include "figures.h"
#include "page_figures.h"
#include "page_tables.h"
#include "plot.h"
#include "svg_figure.h"

namespace bsoil::experiment {
namespace {

constexpr const char* kSoil = "BulletSoil";

std::string percent(const std::optional<double>& share, bool with_sign) {
    if (!share) return "-";
    return with_sign ? fmt::format("{:+.0f} %", *share * 100)
                     : fmt::format("{:.0f} %", *share * 100);
}

/// "pressure".
std::string quantity_title(const ComparedQuantity& quantity) {
    if (!quantity.item.title.empty()) return quantity.item.title;
    std::string title = shown(quantity.item.column).title;
    title.erase(std::ranges::find(title, ','), title.end());
    return title;
}
/// What the quantity's figures are in.
Shown quantity_shown(const ComparedQuantity& quantity) {
    return shown(quantity.item.statistic == "janosi_k" ? quantity.item.over : quantity.item.column);
}

std::string points_table(const Comparison& comparison, const ComparedQuantity& quantity) {
    const bool of_load = quantity.item.of_load;
    const Shown figure = quantity_shown(quantity);
    const std::string classical = classical_name(comparison.experiment->validation->classical);
    std::vector<std::string> head;
    for (const std::string& key : quantity.key_columns) head.push_back(shown(key).title);
    head.push_back("measured");
    for (const std::string& model : {std::string(kSoil), classical}) {
        head.insert(head.end(), {model, "error"});
        if (of_load) head.push_back("of load");
    }
    const std::string unit = figure.title.find(',') == std::string::npos
                                 ? ""
                                 : figure.title.substr(figure.title.find(','));
    std::string out = quantity_title(quantity) + unit + ":\n\n" + table_head(head);
    for (const ComparedPoint& point : quantity.points) {
        std::vector<std::string> row;
        for (size_t k = 0; k < point.keys.size(); ++k) {
            row.push_back(key_text(point.keys[k], shown(quantity.key_columns[k]).factor));
        }
        row.push_back(figure_text(point.measured, figure.factor));
        for (const ComparedFigure* model : {&point.soil, &point.classical}) {
            row.push_back(figure_text(model->value, figure.factor));
            row.push_back(percent(model->error, true));
            if (of_load) row.push_back(percent(model->load_error, true));
        }
        out += table_row(row);
    }
    return out;
}

std::string medians_text(const ErrorMedians& model) {
    std::string text = percent(model.relative, false);
    if (model.of_load) text += fmt::format("; {:.1f} % of load", *model.of_load * 100);
    return text;
}

std::string aim_text(const ComparedQuantity& quantity) {
    if (!quantity.item.aim) return "-";
    const bool reached = quantity.soil.relative && *quantity.soil.relative <= *quantity.item.aim;
    return percent(quantity.item.aim, false) + (reached ? ", reached" : ", **not reached**");
}

std::string gates_text(const Comparison& comparison) {
    const auto met = std::count_if(comparison.verdicts.begin(), comparison.verdicts.end(),
                                   [](const Verdict& v) { return v.kind == Verdict::Kind::pass; });
    const std::string text = fmt::format("{} of {}", met, comparison.verdicts.size());
    return comparison.holds() ? text : "**" + text + "**";
}

/// Rows of the summary; they name the experiment, by which they are found again.
std::string link_to(const std::string& name) { return "](#" + name + ")"; }
std::string summary_rows(const Comparison& comparison) {
    std::string out;
    for (const ComparedQuantity& quantity : comparison.quantities) {
        const bool first = &quantity == &comparison.quantities.front();
        std::string points = std::to_string(quantity.points.size());
        if (quantity.relative_count != quantity.points.size()) {
            points += fmt::format(" ({})", quantity.relative_count);
        }
        out += table_row({"[" + comparison.experiment->title + link_to(comparison.name),
                          quantity_title(quantity), points, medians_text(quantity.soil),
                          medians_text(quantity.classical), aim_text(quantity),
                          first ? gates_text(comparison) : ""});
    }
    return out;
}

std::string section(const Comparison& comparison, const std::string& pictures) {
    const Experiment& experiment = *comparison.experiment;
    const ValidationItem& validation = *experiment.validation;
    std::string out = fmt::format("<a id=\"{0}\"></a>\n\n![{1}]({2}/{0}.svg)\n\n", comparison.name,
                                  experiment.title, pictures);
    out += "Classical model: " + classical_name(validation.classical);
    if (!comparison.classical_parameters.empty()) out += "; " + comparison.classical_parameters;
    out += validation.classical_note.empty() ? ".\n" : ". " + validation.classical_note + '\n';
    if (!comparison.verdicts.empty()) {
        out += "\nGates:\n\n";
        for (const Verdict& verdict : comparison.verdicts) {
            out += fmt::format("- {}: {}\n",
                               verdict.kind == Verdict::Kind::pass ? "met" : "**not met**",
                               verdict.text);
        }
    }
    out += "\n<details><summary>All points</summary>\n\n";
    for (const ComparedQuantity& quantity : comparison.quantities) {
        out += points_table(comparison, quantity) + '\n';
    }
    return out + "</details>\n";
}

/// Medians over the points of all experiments of one rig, quantity by quantity; of those that more
/// than one experiment measures.
std::string pooled_table(const std::vector<Comparison>& comparisons) {
    struct Pool {
        std::vector<double> soil, classical;
        int experiment_count = 0;
    };
    std::map<std::pair<std::string, std::string>, Pool> pools;
    for (const Comparison& comparison : comparisons) {
        for (const ComparedQuantity& quantity : comparison.quantities) {
            Pool& pool = pools[{comparison.experiment->rig, quantity_title(quantity)}];
            ++pool.experiment_count;
            for (const ComparedPoint& point : quantity.points) {
                if (point.soil.error) pool.soil.push_back(std::abs(*point.soil.error));
                if (point.classical.error) {
                    pool.classical.push_back(std::abs(*point.classical.error));
                }
            }
        }
    }
    const auto text = [](const std::vector<double>& errors) {
        return percent(errors.empty() ? std::nullopt : std::optional(median(errors)), false);
    };
    std::string out =
        table_head({"rig", "quantity", "data sets", "points", kSoil, "classical model"});
    for (const auto& [key, pool] : pools) {
        if (pool.experiment_count > 1) {
            out += table_row({key.first, key.second, std::to_string(pool.experiment_count),
                              std::to_string(pool.soil.size()), text(pool.soil),
                              text(pool.classical)});
        }
    }
    return out;
}

Result<Block> validate_block(const std::string& page, const std::string& name) {
    return block_of(page, "validate", name);
}

/// The summary's rows of an experiment, as the page has them.
std::string rows_in(const std::string& text, const std::string& name) {
    std::string rows;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
        const std::string line = text.substr(at, end - at);
        if (line.find(link_to(name)) != std::string::npos) rows += line;
        at = end;
    }
    return rows;
}

/// The experiments a page has places for, in its order.
std::vector<std::string> places_in(const std::string& page) {
    const std::string before = "<!-- bsoil validate: ", after = " -->";
    std::vector<std::string> names;
    for (size_t at = page.find(before); at != std::string::npos; at = page.find(before, at)) {
        at += before.size();
        const std::string name = page.substr(at, page.find(after, at) - at);
        if (name != "summary" && name != "pooled") names.push_back(name);
    }
    return names;
}

}  // namespace

Result<std::string> update_page(std::string page, const std::vector<Comparison>& comparisons,
                                const std::string& pictures) {
    const std::vector<std::string> places = places_in(page);
    const auto summary = validate_block(page, "summary");
    if (!summary) return Error{summary.error()};
    const std::string before = page.substr(summary->begin, summary->end - summary->begin);
    std::string rows = table_head({"data set", "quantity", "points", kSoil, "classical model",
                                   "aim for BulletSoil", "gates met"});
    for (const std::string& name : places) {
        const auto found = std::find_if(comparisons.begin(), comparisons.end(),
                                        [&](const Comparison& c) { return c.name == name; });
        rows += found == comparisons.end() ? rows_in(before, name) : summary_rows(*found);
    }
    page.replace(summary->begin, summary->end - summary->begin, rows);
    if (const auto pooled = validate_block(page, "pooled");
        pooled && comparisons.size() == places.size()) {
        page.replace(pooled->begin, pooled->end - pooled->begin, pooled_table(comparisons));
    }
    for (const Comparison& comparison : comparisons) {
        const auto block = validate_block(page, comparison.name);
        if (!block) return Error{block.error()};
        page.replace(block->begin, block->end - block->begin, section(comparison, pictures));
    }
    const std::string tables = page;
    return fill_figures(std::move(page), tables);
}

std::string comparison_picture(const Comparison& comparison) {
    const Experiment& experiment = *comparison.experiment;
    const CsvTable& results = comparison.results;
    std::vector<SvgPanel> panels;
    for (const PlotItem& plot : experiment.plots) {
        const Shown x = shown(plot.x), y = shown(plot.y);
        SvgPanel& panel = panels.emplace_back();
        panel.title = plot.title;
        panel.x_title = x.title;
        panel.y_title = y.title;
        panel.log_x = plot.log_x;
        panel.log_y = plot.log_y;
        const std::vector<std::string> keys = curve_keys(experiment, plot);
        std::vector<size_t> all(results.rows.size());
        for (size_t r = 0; r < all.size(); ++r) all[r] = r;
        int color = 0;
        for (const auto& rows : grouped(results, all, keys)) {
            std::string title;
            for (const std::string& key : keys) {
                const Shown shown_key = shown(key);
                const auto c = static_cast<size_t>(results.column_index(key));
                title += (title.empty() ? "" : ", ") + shown_key.title + " = " +
                         key_text(results.rows[rows.front()][c], shown_key.factor);
            }
            const auto add = [&](SvgCurve::Style style, const std::string& suffix) {
                SvgCurve curve{style, color, title, {}};
                for (const size_t r : rows) {
                    const auto at = results.number(r, plot.x);
                    const auto value = results.number(r, plot.y + suffix);
                    if (at && value) curve.points.push_back({*at * x.factor, *value * y.factor});
                }
                std::sort(curve.points.begin(), curve.points.end());
                panel.curves.push_back(std::move(curve));
            };
            add(SvgCurve::Style::dashes, "_classical");
            add(SvgCurve::Style::line, "");
            add(SvgCurve::Style::circles, "_measured");
            ++color;
        }
    }
    return svg_figure(
        panels, {{SvgCurve::Style::circles, experiment.measured_item->label},
                 {SvgCurve::Style::line, kSoil},
                 {SvgCurve::Style::dashes, classical_name(experiment.validation->classical)}});
}

std::string comparison_text(const Comparison& comparison) {
    std::string out = comparison.name + ": " + comparison.experiment->title + '\n';
    for (const ComparedQuantity& quantity : comparison.quantities) {
        out += fmt::format("  {}: {} points, median error {} {}, {} {}\n", quantity_title(quantity),
                           quantity.points.size(), kSoil, medians_text(quantity.soil),
                           classical_name(comparison.experiment->validation->classical),
                           medians_text(quantity.classical));
    }
    for (const Verdict& verdict : comparison.verdicts) {
        out += fmt::format("  {} {}\n",
                           verdict.kind == Verdict::Kind::pass   ? "PASS"
                           : verdict.kind == Verdict::Kind::fail ? "FAIL"
                                                                 : "SKIP",
                           verdict.text);
    }
    return out;
}

}  // namespace bsoil::experiment
