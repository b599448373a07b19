#include "comparison_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "classical_columns.h"
#include "page_tables.h"

namespace bsoil::experiment {

std::string percent_text(const std::optional<double>& share, bool with_sign) {
    if (!share) return "-";
    return with_sign ? fmt::format("{:+.0f} %", *share * 100)
                     : fmt::format("{:.0f} %", *share * 100);
}

std::string quantity_title(const ComparedQuantity& quantity) {
    if (!quantity.item.title.empty()) return quantity.item.title;
    std::string title = shown(quantity.item.column).title;
    title.erase(std::ranges::find(title, ','), title.end());
    return title;
}

std::string points_text(const std::vector<ComparedPoint>& points) {
    const auto relative = std::ranges::count_if(
        points, [](const ComparedPoint& p) { return p.soil.error.has_value(); });
    std::string text = std::to_string(points.size());
    if (relative != std::ssize(points)) text += fmt::format(" ({})", relative);
    return text;
}

std::string medians_text(const ErrorMedians& model) {
    std::string text = percent_text(model.relative, false);
    if (model.of_load) text += fmt::format("; {:.1f} % of load", *model.of_load * 100);
    return text;
}

std::string comparison_text(const Comparison& comparison) {
    std::string out = comparison.name + ": " + comparison.experiment->title + '\n';
    for (const ComparedQuantity& quantity : comparison.quantities) {
        out += fmt::format("  {}: {} points, median error {} {}, {} {}\n", quantity_title(quantity),
                           quantity.points.size(), kSoilName, medians_text(quantity.soil),
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
