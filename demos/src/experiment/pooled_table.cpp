#include "pooled_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "comparison_text.h"
#include "page_tables.h"

namespace bsoil::experiment {
namespace {

/// The largest median error that the project asks for, over all points of a kind.
struct Bar {
    const char* rig;
    const char* quantity;
    double relative;
    std::optional<double> of_load;
};
constexpr std::array kBars{
    Bar{"plate", "pressure", 0.20, {}},      Bar{"traction", "pull", 0.20, 0.06},
    Bar{"traction", "side force", 0.25, {}}, Bar{"traction", "sinkage", 0.12, {}},
    Bar{"traction", "torque", 0.10, {}},     Bar{"blade", "draft", 0.15, {}},
};

struct Pool {
    std::vector<ComparedPoint> points;
    int experiment_count = 0;
};

std::string verdict_text(const std::optional<double>& found, double bar) {
    return found && *found <= bar ? "reached" : "**not reached**";
}

std::string bar_text(const Bar& bar, const ErrorMedians& found) {
    std::string text =
        percent_text(bar.relative, false) + ", " + verdict_text(found.relative, bar.relative);
    if (bar.of_load) {
        text += fmt::format("; {:.0f} % of load, {}", *bar.of_load * 100,
                            verdict_text(found.of_load, *bar.of_load));
    }
    return text;
}

}  // namespace

std::string pooled_table(const std::vector<Comparison>& comparisons) {
    std::map<std::pair<std::string, std::string>, Pool> pools;
    for (const Comparison& comparison : comparisons) {
        for (const ComparedQuantity& quantity : comparison.quantities) {
            Pool& pool = pools[{comparison.experiment->rig, quantity_title(quantity)}];
            ++pool.experiment_count;
            pool.points.insert(pool.points.end(), quantity.points.begin(), quantity.points.end());
        }
    }
    std::string out =
        table_head({"rig", "quantity", "data sets", "points", kSoilName, "classical model", "bar"});
    for (const auto& entry : pools) {
        const auto& [rig, quantity] = entry.first;
        const Pool& pool = entry.second;
        const auto bar = std::ranges::find_if(kBars, [&entry](const Bar& b) {
            return entry.first == std::pair<std::string, std::string>(b.rig, b.quantity);
        });
        if (bar == kBars.end() && pool.experiment_count < 2) continue;
        const ErrorMedians soil = medians_of(pool.points, &ComparedPoint::soil);
        out += table_row({rig, quantity, std::to_string(pool.experiment_count),
                          points_text(pool.points), medians_text(soil),
                          medians_text(medians_of(pool.points, &ComparedPoint::classical)),
                          bar == kBars.end() ? "-" : bar_text(*bar, soil)});
    }
    return out;
}

}  // namespace bsoil::experiment
