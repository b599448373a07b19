#include "validation_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "classical_columns.h"
#include "comparison_text.h"
#include "figures.h"
#include "page_figures.h"
#include "page_tables.h"
#include "plot.h"
#include "pooled_table.h"
#include "svg_figure.h"

namespace bsoil::experiment {
namespace {

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
    for (const std::string& model : {std::string(kSoilName), classical}) {
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
            row.push_back(percent_text(model->error, true));
            if (of_load) row.push_back(percent_text(model->load_error, true));
        }
        out += table_row(row);
    }
    return out;
}

std::string aim_text(const ComparedQuantity& quantity) {
    if (!quantity.item.aim) return "-";
    const bool reached = quantity.soil.relative && *quantity.soil.relative <= *quantity.item.aim;
    return percent_text(quantity.item.aim, false) + (reached ? ", reached" : ", **not reached**");
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
        out += table_row({"[" + comparison.experiment->title + link_to(comparison.name),
                          quantity_title(quantity), points_text(quantity.points),
                          medians_text(quantity.soil), medians_text(quantity.classical),
                          aim_text(quantity), first ? gates_text(comparison) : ""});
    }
    return out;
}

/// Where a force that counts has the other sign: "slip ratio 0.5: -0.235 for 2.80".
std::string wrong_signs(const ComparedQuantity& quantity) {
    const double factor = quantity_shown(quantity).factor;
    std::string out;
    for (const ComparedPoint& point : quantity.points) {
        if (!has_wrong_sign(point.soil)) continue;
        if (!out.empty()) out += "; ";
        for (size_t k = 0; k < point.keys.size(); ++k) {
            if (quantity.key_columns[k] == "load_n") continue;
            const Shown key = shown(quantity.key_columns[k]);
            out += key.title.substr(0, key.title.find(',')) + ' ' +
                   key_text(point.keys[k], key.factor) + ", ";
        }
        if (out.ends_with(", ")) out.replace(out.size() - 2, 2, ": ");
        out +=
            figure_text(point.soil.value, factor) + " for " + figure_text(point.measured, factor);
    }
    return out;
}
/// Rows of the table of signs: the pulls of an experiment.
std::string sign_rows(const Comparison& comparison) {
    std::string out;
    for (const ComparedQuantity& quantity : comparison.quantities) {
        if (!quantity.item.of_load) continue;
        const auto wrong =
            std::count_if(quantity.points.begin(), quantity.points.end(),
                          [](const ComparedPoint& point) { return has_wrong_sign(point.soil); });
        out += table_row({"[" + comparison.experiment->title + link_to(comparison.name),
                          quantity_title(quantity), std::to_string(quantity.relative_count),
                          wrong == 0 ? "none" : fmt::format("**{}**", wrong),
                          wrong == 0 ? "-" : wrong_signs(quantity)});
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
        if (name != "summary" && name != "pooled" && name != "signs") names.push_back(name);
    }
    return names;
}

}  // namespace

Result<std::string> update_page(std::string page, const std::vector<Comparison>& comparisons,
                                const std::string& pictures) {
    const std::vector<std::string> places = places_in(page);
    if (const auto summary = validate_block(page, "summary"); !summary) {
        return Error{summary.error()};
    }
    const auto put_rows = [&](const std::string& block_name, const std::vector<std::string>& head,
                              const auto& rows_of) {
        const auto block = validate_block(page, block_name);
        if (!block) return;
        const std::string before = page.substr(block->begin, block->end - block->begin);
        std::string rows = table_head(head);
        for (const std::string& name : places) {
            const auto found = std::find_if(comparisons.begin(), comparisons.end(),
                                            [&](const Comparison& c) { return c.name == name; });
            rows += found == comparisons.end() ? rows_in(before, name) : rows_of(*found);
        }
        page.replace(block->begin, block->end - block->begin, rows);
    };
    put_rows("summary",
             {"data set", "quantity", "points", kSoilName, "classical model", "aim for BulletSoil",
              "gates met"},
             summary_rows);
    put_rows("signs", {"data set", "force", "points", "wrong direction", "where, N"}, sign_rows);
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
                 {SvgCurve::Style::line, kSoilName},
                 {SvgCurve::Style::dashes, classical_name(experiment.validation->classical)}});
}

}  // namespace bsoil::experiment
