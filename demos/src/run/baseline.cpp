#include "baseline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "files/json_text.h"
#include "files/text_file.h"

namespace bsoil::scene {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMomentCount = 8;

void compare(const std::string& where, const Json& expected, const Json& found, double tolerance,
             std::vector<std::string>& differences) {
    if (tolerance > 0 && where.ends_with("checksum")) return;
    if (found.is_null()) {
        differences.push_back(
            fmt::format("{}: expected {}, found no number", where, expected.dump()));
        return;
    }
    if (expected.is_number() && found.is_number()) {
        if (expected == found) return;
        const double a = expected.get<double>(), b = found.get<double>();
        if (tolerance > 0 && std::abs(a - b) <= tolerance * std::max(1.0, std::abs(a))) return;
        differences.push_back(fmt::format("{}: expected {}, found {}, off by {:+.6g}", where,
                                          expected.dump(), found.dump(), b - a));
    } else if (expected.is_array() && found.is_array() && expected.size() == found.size()) {
        for (size_t i = 0; i < expected.size(); ++i) {
            compare(fmt::format("{}[{}]", where, i), expected[i], found[i], tolerance, differences);
        }
    } else if (expected.is_object() && found.is_object()) {
        for (const auto& [key, value] : expected.items()) {
            const std::string inside = where.empty() ? key : where + '.' + key;
            if (found.contains(key)) {
                compare(inside, value, found[key], tolerance, differences);
            } else {
                differences.push_back(inside + ": expected, but not there");
            }
        }
        for (const auto& [key, value] : found.items()) {
            if (!expected.contains(key)) {
                differences.push_back((where.empty() ? key : where + '.' + key) +
                                      ": there, but not expected");
            }
        }
    } else if (expected != found) {
        differences.push_back(
            fmt::format("{}: expected {}, found {}", where, expected.dump(), found.dump()));
    }
}

std::optional<std::string> first_null(const std::string& where, const Json& json) {
    if (json.is_null()) return where;
    if (!json.is_structured()) return {};
    for (const auto& [key, value] : json.items()) {
        const std::string inside = json.is_array() ? fmt::format("{}[{}]", where, key)
                                   : where.empty() ? key
                                                   : where + '.' + key;
        if (auto found = first_null(inside, value)) return found;
    }
    return {};
}

/// As it would stand in a file: names are in UTF-8 there, and what is no number is null.
Json as_in_a_file(const Json& json) { return Json::parse(json_text(json)); }

/// Of a baseline file: bytes, and values inside each other. One of ours is 4 deep.
constexpr size_t kFileCapacity = size_t{64} << 20;
constexpr int kDepthCapacity = 16;

}  // namespace

Result<Json> read_baseline(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) {
        return Error{path + ": not there; write it with --update"};
    }
    const auto text = read_file(path, kFileCapacity);
    if (!text) return Error{text.error()};
    bool is_deep = false;
    const auto stay_flat = [&](int depth, Json::parse_event_t, Json&) {
        is_deep |= depth > kDepthCapacity;
        return !is_deep;
    };
    Json json = Json::parse(*text, stay_flat, false);
    if (is_deep) {
        return Error{fmt::format("{}: values must lie at most {} deep inside each other", path,
                                 kDepthCapacity)};
    }
    if (!json.is_object()) return Error{path + ": is no baseline; write it with --update"};
    if (json.contains("steps") &&
        (!json["steps"].is_number_integer() || json["steps"].get<int64_t>() < 0)) {
        return Error{path + ": its \"steps\" must be a number of steps"};
    }
    return json;
}

std::vector<double> sample_moments_s(const SceneRun& run) {
    const double end_s = static_cast<double>(run.step_target()) * run.step_s();
    std::vector<double> moments;
    for (const double t_s : run.scene().record.moments_s) {
        if (t_s <= end_s + run.step_s() / 2) moments.push_back(t_s);  // the last step is nearest
    }
    if (moments.empty()) {
        for (int i = 1; i <= kMomentCount; ++i) moments.push_back(end_s * i / kMomentCount);
    }
    std::sort(moments.begin(), moments.end());
    return moments;
}

BaselineRecorder::BaselineRecorder(const SceneRun& run)
    : run_(run), moments_s_(sample_moments_s(run)), trajectory_(Json::array()) {}

Json BaselineRecorder::state() const {
    Json bodies = Json::object();
    for (const SceneBody& body : run_.bullet().bodies()) {
        const Pose p = body.pose();
        bodies[body.name] = Json{p.position.x, p.position.y, p.position.z, p.rotation.x,
                                 p.rotation.y, p.rotation.z, p.rotation.w};
    }
    Json probes = Json::object();
    for (const ProbeItem& probe : run_.scene().probes) {
        if (probe.kind == "mass_inside") probes[probe.name] = run_.probe_mass_kg(probe);
    }
    Json json{{"bodies", bodies}, {"probes_kg", probes}};
    if (run_.has_soil()) json["checksum"] = fmt::format("{:016x}", run_.soil().checksum());
    return json;
}

void BaselineRecorder::observe() {
    const size_t next = trajectory_.size();
    if (next >= moments_s_.size() || run_.time_s() < moments_s_[next] - run_.step_s() / 2) return;
    Json sample{{"step", run_.step_count()}};
    sample.update(state());
    trajectory_.push_back(std::move(sample));
}

Json BaselineRecorder::finish() const {
    const Json summary = run_.summary();
    Json json;
    json["scene"] = std::filesystem::path(run_.scene().path).filename().string();
    for (const char* key : {"up", "steps", "voxels_total", "soil_units_start", "soil_units_end",
                            "soil_units_in", "soil_units_out", "status"}) {
        if (summary.contains(key)) json[key] = summary[key];
    }
    json["trajectory"] = trajectory_;
    json["end"] = state();
    return json;
}

std::vector<std::string> compare_baselines(const Json& expected, const Json& found,
                                           double tolerance) {
    std::vector<std::string> differences;
    compare("", expected, as_in_a_file(found), tolerance, differences);
    return differences;
}

std::optional<std::string> not_a_number_in(const Json& baseline) {
    return first_null({}, as_in_a_file(baseline));
}

}  // namespace bsoil::scene
