#include "run_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>

#include "scene/rotations.h"

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
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            top_m = std::max(top_m, soil.surface_height_m(x, y) - base_m);
        }
    }
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

Steadiness steadiness(const std::vector<double>& samples) {
    Steadiness out;
    if (samples.empty()) return out;
    const double count = static_cast<double>(samples.size());
    const double middle = (count - 1) / 2;
    for (const double y : samples) out.mean += y / count;
    double cross = 0, spread = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
        const double x = static_cast<double>(i) - middle;
        cross += x * (samples[i] - out.mean);
        spread += x * x;
    }
    const double slope = spread > 0 ? cross / spread : 0;
    double squares = 0, least = 0, most = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
        const double off = samples[i] - out.mean - slope * (static_cast<double>(i) - middle);
        squares += off * off;
        least = std::min(least, off);
        most = std::max(most, off);
    }
    out.deviation = std::sqrt(squares / count);
    out.range = most - least;
    return out;
}

RunChecks::RunChecks(const SceneRun& run) : run_(run) {
    for (const CheckItem& item : run.scene().checks) {
        if (item.kind != "soil_conserved") watches_.push_back(watch(item));
    }
    observe();
}

bool RunChecks::in_window(const CheckItem& item) const {
    return reached(item.from_s) && (!item.to_s || run_.time_s() <= *item.to_s + run_.step_s() / 2);
}

double RunChecks::energy_j(const CheckItem& item) const {
    double sum_j = 0;
    for (const SceneBody& body : run_.bullet().bodies()) {
        const bool named =
            std::find(item.bodies.begin(), item.bodies.end(), body.name) != item.bodies.end();
        if (item.bodies.empty() || named) {
            sum_j += body.mechanical_energy_j(run_.bullet().gravity_m_s2());
        }
    }
    return sum_j;
}

/// What a check that measures over a time sees in this step.
std::optional<double> RunChecks::sample(const CheckItem& item) const {
    if (!in_window(item)) return std::nullopt;
    if (item.kind == "energy_not_rising") return energy_j(item);
    const auto& bodies = run_.bullet().bodies();
    const auto body = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const SceneBody& b) { return b.name == item.body; });
    if (item.kind == "body_rise" || item.kind == "body_height") {
        const Vec3 at_m = body->pose().position;
        return run_.scene().world.up == "y" ? at_m.y : at_m.z;
    }
    Vec3 vector;
    if (item.kind == "force_steady") {
        if (run_.step_count() == 0) return std::nullopt;  // a reading is the mean of a step
        vector = run_.readings()[static_cast<size_t>(body - bodies.begin())].force_n;
    } else if (item.kind == "speed_steady") {
        vector = body->linear_velocity_m_s();
    } else {
        return std::nullopt;
    }
    const double size = length(item.direction);
    return size > 0 ? dot(vector, item.direction) / size : length(vector);
}

RunChecks::Watch RunChecks::watch(const CheckItem& item) const {
    Watch w;
    w.item = &item;
    if (item.kind == "distance_travelled") {
        w.start_m = run_.bullet().find_body(item.body)->pose().position;
    }
    return w;
}

bool RunChecks::reached(double t_s) const { return run_.time_s() >= t_s - run_.step_s() / 2; }

void RunChecks::serialize(StateStream& stream, Watch& w) {
    const auto optional = [&](auto& value) {
        bool has = value.has_value();
        stream(has);
        if (!has) return value.reset();
        if (!value) value.emplace();
        stream(*value);
    };
    optional(w.start_m);
    optional(w.value);
    optional(w.reference);
    stream(w.peak_n);
    stream.list(w.samples, 8, [&](double& sample) { stream(sample); });
}

std::vector<uint8_t> RunChecks::state() const {
    StateStream stream;
    std::vector<Watch> watches = watches_;
    for (Watch& w : watches) {
        std::string kind = w.item->kind;
        stream(kind);
        serialize(stream, w);
    }
    return stream.bytes();
}

Status RunChecks::set_state(std::span<const uint8_t> state) {
    StateStream stream(state);
    std::vector<Watch> watches = watches_;
    for (Watch& w : watches) {
        std::string kind;
        stream(kind);
        if (kind != w.item->kind) stream.refuse();
        serialize(stream, w);
    }
    if (!stream.at_end()) {
        return Error{"the snapshot is of a scene with other checks; run that scene anew"};
    }
    watches_ = std::move(watches);
    return Done{};
}

void RunChecks::observe() {
    for (Watch& w : watches_) observe(w);
}

void RunChecks::observe(Watch& w) const {
    const CheckItem& item = *w.item;
    if (const std::optional<double> value = sample(item)) w.samples.push_back(*value);
    if (item.kind == "body_at_rest") {
        if (!w.start_m && reached(item.by_s)) {
            w.start_m = run_.bullet().find_body(item.body)->pose().position;
        }
    } else if (item.kind == "mass_in_region") {
        const ProbeItem& probe = *run_.scene().find_probe(item.probe);
        if (!w.reference && item.has("reference_s") && reached(item.reference_s)) {
            w.reference = run_.probe_mass_kg(probe);
        }
        if (!w.value && reached(item.at_s)) w.value = run_.probe_mass_kg(probe);
    } else if (item.kind == "mass_in" || item.kind == "mass_out") {
        if (!w.value && reached(item.at_s)) {
            w.value = run_.soil().moved_kg(item.kind == "mass_in" ? FlowWay::in : FlowWay::out);
        }
    } else if (item.kind == "surface_height") {
        if (!w.value && reached(item.at_s)) w.value = surface_height_m(run_.soil(), item.at_m);
    } else if (item.kind == "body_force" && run_.time_s() > item.from_s && in_window(item)) {
        const auto& bodies = run_.bullet().bodies();
        for (size_t b = 0; b < bodies.size(); ++b) {
            if (bodies[b].name != item.body) continue;
            const BodyReading& reading = run_.readings()[b];
            const bool is_number = is_finite(reading.force_n);
            // The larger of NaN and another is NaN, but not the other way round.
            w.peak_n = is_number ? std::max(w.peak_n, reading.peak_force_n)
                                 : std::numeric_limits<double>::quiet_NaN();
        }
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
    const SoilTotals now = run_.soil().totals();
    CheckResult result{Verdict::pass, "soil_conserved", ""};
    for (size_t i = 0; i < start.size(); ++i) {
        const int64_t change = now.units[i] - start[i];
        if (change != now.units_in[i] - now.units_out[i]) result.verdict = Verdict::fail;
        result.figure += fmt::format("{}{}: {} units, {:+} since the start", i ? "; " : "",
                                     run_.soil().materials()[i].name, now.units[i], change);
        if (now.units_in[i] != 0 || now.units_out[i] != 0) {
            result.figure += fmt::format(", {} in, {} out", now.units_in[i], now.units_out[i]);
        }
    }
    const int64_t water = now.water_units - run_.totals_at_start().water_units;
    if (water != now.water_units_in - now.water_units_out) result.verdict = Verdict::fail;
    if (now.water_units != 0 || water != 0) {
        result.figure +=
            fmt::format("; water: {} units, {:+} since the start, {} in, {} out", now.water_units,
                        water, now.water_units_in, now.water_units_out);
    }
    return result;
}

void RunChecks::judge_steady(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    const bool force = item.kind == "force_steady";
    const char* unit = force ? "N" : "m/s";
    const std::optional<double>&min = force ? item.min_n : item.min_m_s,
          &max = force ? item.max_n : item.max_m_s;
    const Steadiness s = steadiness(w.samples);
    result.verdict = verdict(within(s.mean, min, max));
    result.figure = fmt::format("mean {:.4g} {}", s.mean, unit);
    if (min || max) result.figure += ", " + limits_text(min, max, unit);
    const auto share = [&](const char* name, double value, const std::optional<double>& most) {
        if (!most) return;
        if (value > *most * std::abs(s.mean)) result.verdict = Verdict::fail;
        result.figure += fmt::format("; {} {:.3g} {}, {:.3g} of the mean, wanted at most {:g}",
                                     name, value, unit, value / std::abs(s.mean), *most);
    };
    share("standard deviation", s.deviation, item.max_deviation_fraction);
    share("range", s.range, item.max_range_fraction);
}

namespace {

/// The run ended before a check could be made.
void not_reached(CheckResult& result, double t_s) {
    result.verdict = Verdict::not_reached;
    result.figure = fmt::format("the run ended before {:g} s", t_s);
}

}  // namespace

void RunChecks::judge_rest(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    const double time_s = run_.time_s() - item.by_s;
    if (!w.start_m || time_s < run_.step_s()) return not_reached(result, item.by_s);
    const SceneBody& body = *run_.bullet().find_body(item.body);
    const double creep_mm_s = 1000 * length(body.pose().position - *w.start_m) / time_s;
    const bool asleep = !body.is_awake();
    result.verdict = verdict(creep_mm_s <= item.creep_mm_s && (asleep || !item.must_sleep));
    result.figure = fmt::format("{:.3f} mm/s from {:g} s on, wanted at most {:g}; {}", creep_mm_s,
                                item.by_s, item.creep_mm_s, asleep ? "asleep" : "awake");
    if (item.must_sleep) result.figure += ", wanted asleep";
}

void RunChecks::judge_mass_in_region(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    if (!w.value) return not_reached(result, item.at_s);
    const bool has_share = item.min_fraction || item.max_fraction;
    if (has_share && !w.reference) return not_reached(result, item.reference_s);
    result.verdict = verdict(within(*w.value, item.min_kg, item.max_kg));
    result.figure = fmt::format("{:.1f} kg at {:g} s", *w.value, item.at_s);
    if (item.min_kg || item.max_kg) {
        result.figure += ", " + limits_text(item.min_kg, item.max_kg, "kg");
    }
    if (!has_share) return;
    const double fraction = *w.reference > 0 ? *w.value / *w.reference : 0;
    if (!within(fraction, item.min_fraction, item.max_fraction)) result.verdict = Verdict::fail;
    result.figure +=
        fmt::format(", {:.3f} of the {:.1f} kg at {:g} s, {}", fraction, *w.reference,
                    item.reference_s, limits_text(item.min_fraction, item.max_fraction, "of it"));
}

void RunChecks::judge_flow(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    if (!w.value) return not_reached(result, item.at_s);
    result.verdict = verdict(within(*w.value, item.min_kg, item.max_kg));
    result.figure = fmt::format("{:.2f} kg at {:g} s, {}", *w.value, item.at_s,
                                limits_text(item.min_kg, item.max_kg, "kg"));
}

void RunChecks::judge_repose_angle(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    if (!run_.finished_scene()) return not_reached(result, run_.scene().world.duration_s);
    const std::optional<double> angle = repose_angle_rad(run_.soil(), item.center_m);
    result.verdict = verdict(angle && std::abs(*angle - item.expected_rad) <= item.tolerance_rad);
    result.figure = fmt::format("{}, wanted {:g} +- {:g} deg",
                                angle ? fmt::format("{:.2f} deg", *angle / kDegree) : "no slope",
                                item.expected_rad / kDegree, item.tolerance_rad / kDegree);
}

void RunChecks::judge_surface_height(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    if (!w.value) return not_reached(result, item.at_s);
    result.verdict = verdict(std::abs(*w.value - item.expected_m) <= item.tolerance_m);
    result.figure = fmt::format("{:.3f} m at {:g} s, wanted {:g} +- {:g}", *w.value, item.at_s,
                                item.expected_m, item.tolerance_m);
}

void RunChecks::judge_distance(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    if (!run_.finished_scene()) return not_reached(result, run_.scene().world.duration_s);
    const double distance_m =
        length(run_.bullet().find_body(item.body)->pose().position - *w.start_m);
    result.verdict = verdict(within(distance_m, item.min_m, item.max_m));
    result.figure =
        fmt::format("{:.3f} m, {}", distance_m, limits_text(item.min_m, item.max_m, "m"));
}

void RunChecks::judge_peak_force(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    const bool finished = run_.finished_scene();
    if (!finished && run_.time_s() <= item.from_s) return not_reached(result, item.from_s);
    if (!finished && item.min_n && w.peak_n < *item.min_n) {
        return not_reached(result, run_.scene().world.duration_s);
    }
    result.verdict = verdict(within(w.peak_n, item.min_n, item.max_n));
    result.figure =
        fmt::format("{:.0f} N at most, {}", w.peak_n, limits_text(item.min_n, item.max_n, "N"));
}

void RunChecks::judge_rise(const Watch& w, CheckResult& result) const {
    double lowest_m = w.samples.front(), rise_m = 0;
    for (const double height_m : w.samples) {
        lowest_m = std::min(lowest_m, height_m);
        rise_m = std::max(rise_m, height_m - lowest_m);
    }
    result.verdict = verdict(within(rise_m, {}, w.item->max_m));
    result.figure = fmt::format("{:.4f} m, {}", rise_m, limits_text({}, w.item->max_m, "m"));
}

void RunChecks::judge_height(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    const auto [low, high] = std::minmax_element(w.samples.begin(), w.samples.end());
    result.verdict =
        verdict(within(*low, item.min_m, item.max_m) && within(*high, item.min_m, item.max_m));
    result.figure = fmt::format("{:.4f} .. {:.4f} m, {}", *low, *high,
                                limits_text(item.min_m, item.max_m, "m"));
}

void RunChecks::judge_energy(const Watch& w, CheckResult& result) const {
    const CheckItem& item = *w.item;
    double rise_j = 0;
    size_t where = 0;
    for (size_t i = 1; i < w.samples.size(); ++i) {
        if (w.samples[i] - w.samples[i - 1] <= rise_j) continue;
        rise_j = w.samples[i] - w.samples[i - 1];
        where = i;
    }
    result.verdict = verdict(rise_j <= item.tolerance_j);
    result.figure = fmt::format("{:.3g} J at most", rise_j);
    if (rise_j > 0) {
        const double from_s = std::ceil(item.from_s / run_.step_s() - 0.5) * run_.step_s();
        result.figure +=
            fmt::format(", at {:.3f} s", from_s + static_cast<double>(where) * run_.step_s());
    }
    result.figure += fmt::format(", wanted at most {:g} J; {:.4g} J lost over the time",
                                 item.tolerance_j, w.samples.front() - w.samples.back());
}

void RunChecks::judge_status(const Watch&, CheckResult& result) const {
    std::vector<std::string> set = run_.condition_texts();
    for (std::string& text : run_.shortfall_texts()) set.push_back(std::move(text));
    result.verdict = verdict(set.empty());
    result.figure = set.empty() ? "no condition set" : fmt::format("{}", fmt::join(set, "; "));
}

CheckResult RunChecks::result(const Watch& w) const {
    struct Judge {
        std::string_view kind;
        void (RunChecks::*judge)(const Watch&, CheckResult&) const;
        bool needs_samples = false;  ///< of the whole time that the check measures
    };
    static constexpr Judge kJudges[] = {
        {"body_at_rest", &RunChecks::judge_rest},
        {"mass_in_region", &RunChecks::judge_mass_in_region},
        {"mass_in", &RunChecks::judge_flow},
        {"mass_out", &RunChecks::judge_flow},
        {"repose_angle", &RunChecks::judge_repose_angle},
        {"surface_height", &RunChecks::judge_surface_height},
        {"distance_travelled", &RunChecks::judge_distance},
        {"body_force", &RunChecks::judge_peak_force},
        {"force_steady", &RunChecks::judge_steady, true},
        {"speed_steady", &RunChecks::judge_steady, true},
        {"body_rise", &RunChecks::judge_rise, true},
        {"body_height", &RunChecks::judge_height, true},
        {"energy_not_rising", &RunChecks::judge_energy, true},
        {"no_status", &RunChecks::judge_status},
    };
    const CheckItem& item = *w.item;
    CheckResult result;
    result.name = item.kind;
    const std::string& subject = item.body.empty() ? item.probe : item.body;
    if (!subject.empty()) result.name += ' ' + subject;
    const Judge* judge = std::ranges::find(kJudges, item.kind, &Judge::kind);
    assert(judge != std::end(kJudges));  // the schema knows the kinds
    const double end_s = item.to_s.value_or(run_.scene().world.duration_s);
    const bool are_numbers =
        std::ranges::all_of(w.samples, [](double sample) { return std::isfinite(sample); });
    if (!are_numbers) {  // comparisons pass over what is none
        result.verdict = Verdict::fail;
        result.figure = "it was no number at some time";
    } else if (judge->needs_samples && (!reached(end_s) || w.samples.empty())) {
        not_reached(result, end_s);
    } else {
        (this->*judge->judge)(w, result);
    }
    return result;
}

}  // namespace bsoil::scene
