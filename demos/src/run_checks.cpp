#include "run_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "schema_table.h"

namespace bsoil::scene {
namespace {

using Verdict = CheckResult::Verdict;

Verdict verdict(bool pass) { return pass ? Verdict::pass : Verdict::fail; }

/// Whether a value lies within limits of which either may be missing.
bool within(double value, const std::optional<double>& min, const std::optional<double>& max) {
    return (!min || value >= *min) && (!max || value <= *max);
}

std::string limits_text(const std::optional<double>& min, const std::optional<double>& max,
                        const char* unit) {
    if (min && max) return fmt::format("wanted {:g} .. {:g} {}", *min, *max, unit);
    if (min) return fmt::format("wanted at least {:g} {}", *min, unit);
    if (max) return fmt::format("wanted at most {:g} {}", *max, unit);
    return "no limit given";
}

}  // namespace

const char* verdict_text(Verdict verdict) {
    switch (verdict) {
        case Verdict::pass:
            return "PASS";
        case Verdict::fail:
            return "FAIL";
        case Verdict::not_reached:
            break;
    }
    return "SKIP";
}

std::optional<double> repose_angle_rad(const Soil& soil, Vec3 center_m) {
    const GridFrame& frame = soil.frame();
    const Vec3 center = frame.to_grid(center_m);
    const double base_m = center.z * frame.voxel_m;
    double top_m = 0;
    for (int y = 0; y < frame.size[1]; ++y)
        for (int x = 0; x < frame.size[0]; ++x)
            top_m = std::max(top_m, soil.surface_height_m(x, y) - base_m);
    double n = 0, sum_r = 0, sum_h = 0, sum_rr = 0, sum_rh = 0;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            const double h = soil.surface_height_m(x, y) - base_m;
            if (h < 0.15 * top_m || h > 0.85 * top_m) continue;  // the toe and the tip are rounded
            const double r = frame.voxel_m * std::hypot(x + 0.5 - center.x, y + 0.5 - center.y);
            // weighed by 1/r: rings count alike, however many columns they have
            const double weight = 1 / std::max(r, frame.voxel_m);
            n += weight;
            sum_r += weight * r;
            sum_h += weight * h;
            sum_rr += weight * r * r;
            sum_rh += weight * r * h;
        }
    }
    const double spread = n * sum_rr - sum_r * sum_r;
    if (spread <= 0) return std::nullopt;
    return std::atan(-(n * sum_rh - sum_r * sum_h) / spread);
}

RunChecks::RunChecks(const SceneRun& run) : run_(run) {
    for (const CheckItem& item : run.scene().checks)
        if (item.kind != "soil_conserved") watches_.push_back(watch(item));
}

RunChecks::Watch RunChecks::watch(const CheckItem& item) const {
    Watch w;
    w.item = &item;
    if (item.kind == "distance_travelled")
        w.start_m = run_.bullet().find_body(item.body)->pose().position;
    return w;
}

bool RunChecks::reached(double t_s) const { return run_.time_s() >= t_s - run_.step_s() / 2; }

void RunChecks::observe() {
    for (Watch& w : watches_) observe(w);
}

void RunChecks::observe(Watch& w) const {
    const CheckItem& item = *w.item;
    if (item.kind == "body_at_rest") {
        if (!w.start_m && reached(item.by_s))
            w.start_m = run_.bullet().find_body(item.body)->pose().position;
    } else if (item.kind == "mass_in_region") {
        const ProbeItem& probe = *run_.scene().find_probe(item.probe);
        if (!w.reference && item.has("reference_s") && reached(item.reference_s))
            w.reference = run_.probe_mass_kg(probe);
        if (!w.value && reached(item.at_s)) w.value = run_.probe_mass_kg(probe);
    } else if (item.kind == "surface_height") {
        if (!w.value && reached(item.at_s)) w.value = surface_height_m(run_.soil(), item.at_m);
    } else if (item.kind == "body_force" && run_.time_s() > item.from_s) {
        const auto& bodies = run_.bullet().bodies();
        for (size_t b = 0; b < bodies.size(); ++b)
            if (bodies[b].name == item.body)
                w.peak_n = std::max(w.peak_n, run_.readings()[b].peak_force_n);
    }
}

std::vector<CheckResult> RunChecks::results() const {
    std::vector<CheckResult> results;
    if (run_.has_soil()) results.push_back(conserved());
    for (const Watch& w : watches_) results.push_back(result(w));
    return results;
}

CheckResult RunChecks::conserved() const {
    const std::vector<int64_t>& start = run_.totals_at_start().units;
    const std::vector<int64_t> end = run_.soil().totals().units;
    CheckResult result{verdict(start == end), "soil_conserved", ""};
    for (size_t i = 0; i < start.size(); ++i)
        result.figure += fmt::format("{}{}: {} units, {:+} since the start", i ? "; " : "",
                                     run_.soil().materials()[i].name, end[i], end[i] - start[i]);
    return result;
}

CheckResult RunChecks::result(const Watch& w) const {
    const CheckItem& item = *w.item;
    CheckResult result;
    result.name = item.kind;
    const std::string& subject = item.body.empty() ? item.probe : item.body;
    if (!subject.empty()) result.name += ' ' + subject;
    const auto not_reached = [&](double t_s) {
        result.verdict = Verdict::not_reached;
        result.figure = fmt::format("the run ended before {:g} s", t_s);
        return result;
    };

    if (item.kind == "body_at_rest") {
        const double time_s = run_.time_s() - item.by_s;
        if (!w.start_m || time_s < run_.step_s()) return not_reached(item.by_s);
        const SceneBody& body = *run_.bullet().find_body(item.body);
        const double creep_mm_s = 1000 * length(body.pose().position - *w.start_m) / time_s;
        const bool asleep = !body.body->isActive();
        result.verdict = verdict(creep_mm_s <= item.creep_mm_s && (asleep || !item.must_sleep));
        result.figure =
            fmt::format("{:.3f} mm/s from {:g} s on, wanted at most {:g}; {}", creep_mm_s,
                        item.by_s, item.creep_mm_s, asleep ? "asleep" : "awake");
        if (item.must_sleep) result.figure += ", wanted asleep";
    } else if (item.kind == "mass_in_region") {
        if (!w.value) return not_reached(item.at_s);
        result.verdict = verdict(within(*w.value, item.min_kg, item.max_kg));
        result.figure = fmt::format("{:.1f} kg at {:g} s", *w.value, item.at_s);
        if (item.min_kg || item.max_kg)
            result.figure += ", " + limits_text(item.min_kg, item.max_kg, "kg");
        if (item.min_fraction || item.max_fraction) {
            if (!w.reference) return not_reached(item.reference_s);
            const double fraction = *w.reference > 0 ? *w.value / *w.reference : 0;
            if (!within(fraction, item.min_fraction, item.max_fraction))
                result.verdict = Verdict::fail;
            result.figure += fmt::format(
                ", {:.3f} of the {:.1f} kg at {:g} s, {}", fraction, *w.reference, item.reference_s,
                limits_text(item.min_fraction, item.max_fraction, "of it"));
        }
    } else if (item.kind == "repose_angle") {
        if (!run_.finished_scene()) return not_reached(run_.scene().world.duration_s);
        const std::optional<double> angle = repose_angle_rad(run_.soil(), item.center_m);
        result.verdict =
            verdict(angle && std::abs(*angle - item.expected_rad) <= item.tolerance_rad);
        result.figure =
            fmt::format("{}, wanted {:g} +- {:g} deg",
                        angle ? fmt::format("{:.2f} deg", *angle / kDegree) : "no slope",
                        item.expected_rad / kDegree, item.tolerance_rad / kDegree);
    } else if (item.kind == "surface_height") {
        if (!w.value) return not_reached(item.at_s);
        result.verdict = verdict(std::abs(*w.value - item.expected_m) <= item.tolerance_m);
        result.figure = fmt::format("{:.3f} m at {:g} s, wanted {:g} +- {:g}", *w.value, item.at_s,
                                    item.expected_m, item.tolerance_m);
    } else if (item.kind == "distance_travelled") {
        const double way_m =
            length(run_.bullet().find_body(item.body)->pose().position - *w.start_m);
        if (!run_.finished_scene()) return not_reached(run_.scene().world.duration_s);
        result.verdict = verdict(within(way_m, item.min_m, item.max_m));
        result.figure =
            fmt::format("{:.3f} m, {}", way_m, limits_text(item.min_m, item.max_m, "m"));
    } else if (item.kind == "body_force") {
        if (!run_.finished_scene() && run_.time_s() <= item.from_s) return not_reached(item.from_s);
        result.verdict = verdict(within(w.peak_n, item.min_n, item.max_n));
        if (!run_.finished_scene() && result.verdict == Verdict::fail && item.min_n &&
            w.peak_n < *item.min_n)
            return not_reached(run_.scene().world.duration_s);
        result.figure =
            fmt::format("{:.0f} N at most, {}", w.peak_n, limits_text(item.min_n, item.max_n, "N"));
    } else {  // no_status
        const std::vector<std::string> set = status_texts(run_.soil().status_bits());
        result.verdict = verdict(set.empty());
        result.figure = set.empty() ? "no condition set" : fmt::format("{}", fmt::join(set, "; "));
    }
    return result;
}

}  // namespace bsoil::scene
