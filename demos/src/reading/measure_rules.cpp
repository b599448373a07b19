#include "measure_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace bsoil::scene {
namespace {

class MeasureRules {
  public:
    explicit MeasureRules(const Scene& scene) : scene_(scene) {}
    std::vector<SchemaError> run() {
        for (const double t_s : scene_.record.moments_s) {
            check_time(scene_.record, "moments_s", t_s);
        }
        for (const ProbeItem& probe : scene_.probes) {
            check_place(probe, "from_m", probe.from_m);
            check_place(probe, "to_m", probe.to_m);
        }
        for (const CheckItem& check : scene_.checks) {
            check_times(check);
            check_limits(check);
            check_place(check, "at_m", check.at_m);
            check_place(check, "center_m", check.center_m);
            if (check.has("direction") && length(check.direction) < 1e-6) {
                error(check, "direction", "the direction must have a length");
            }
        }
        return std::move(errors_);
    }

  private:
    void error(const SceneItem& item, const char* key, std::string text) {
        errors_.push_back({item.where(key), std::move(text)});
    }

    void check_time(const SceneItem& item, const char* key, double t_s) {
        if (!item.has(key) || t_s <= scene_.world.duration_s) return;
        error(item, key,
              fmt::format("`{}` {} lies after the end of the run, {} s; raise `duration_s`", key,
                          t_s, scene_.world.duration_s));
    }

    void check_times(const CheckItem& check) {
        for (const auto& [key, t_s] :
             {std::pair{"by_s", check.by_s}, std::pair{"at_s", check.at_s},
              std::pair{"from_s", check.from_s}, std::pair{"to_s", check.to_s.value_or(0)},
              std::pair{"reference_s", check.reference_s}}) {
            check_time(check, key, t_s);
        }
        if (check.to_s && *check.to_s <= check.from_s) {
            return error(
                check, "to_s",
                fmt::format("`to_s` {} must lie after `from_s` {}", *check.to_s, check.from_s));
        }
        if (check.max_deviation_fraction || check.max_range_fraction) check_samples(check);
    }

    /// Any two samples lie on a straight line. Steps are counted as RunChecks does.
    void check_samples(const CheckItem& check) {
        constexpr int kSampleCountLeast = 3;
        const double step_s = frame_length(scene_).step_s;
        const double end_s = std::round(scene_.world.duration_s / step_s) * step_s;
        const double to_s = std::min(check.to_s.value_or(end_s), end_s);
        // The force is the mean of a step: there is none before the first.
        const double first = std::max(check.kind == "force_steady" ? 1.0 : 0.0,
                                      std::ceil(check.from_s / step_s - 0.5));
        const double count = std::max(0.0, std::floor(to_s / step_s + 0.5) - first + 1);
        if (count >= kSampleCountLeast) return;
        error(check, "from_s",
              fmt::format("from `from_s` {} until {:g} s there are {:g} steps, and unsteadiness "
                          "needs at least {}; measure longer: lower `from_s`, or raise `{}`",
                          check.from_s, to_s, count, kSampleCountLeast,
                          check.to_s ? "to_s" : "duration_s"));
    }

    void check_limits(const CheckItem& check) {
        struct Limits {
            const char *min_key, *max_key;
            const std::optional<double>&min, &max;
        };
        for (const Limits& l :
             {Limits{"min_kg", "max_kg", check.min_kg, check.max_kg},
              Limits{"min_fraction", "max_fraction", check.min_fraction, check.max_fraction},
              Limits{"min_m", "max_m", check.min_m, check.max_m},
              Limits{"min_n", "max_n", check.min_n, check.max_n},
              Limits{"min_m_s", "max_m_s", check.min_m_s, check.max_m_s}}) {
            if (!l.min || !l.max || *l.min <= *l.max) continue;
            error(check, l.max_key,
                  fmt::format("`{}` {} must not be below `{}` {}: no value lies between", l.max_key,
                              *l.max, l.min_key, *l.min));
        }
    }

    /// Beside the soil's box there is no surface. Its middle is `floor_center_m`, whatever its
    /// turn; its sides are whole voxels.
    void check_place(const SceneItem& item, const char* key, Vec3 at_m) {
        if (!scene_.soil || !item.has(key)) return;
        const SoilDef& soil = scene_.soil->def;
        const bool is_y_up = scene_.world.up == "y";
        const auto level = [is_y_up](Vec3 v) { return std::pair{v.x, is_y_up ? -v.z : v.y}; };
        const auto [x, y] = level(at_m - soil.floor_center_m);
        const double along_m = std::cos(soil.yaw_rad) * x + std::sin(soil.yaw_rad) * y,
                     across_m = std::cos(soil.yaw_rad) * y - std::sin(soil.yaw_rad) * x;
        const auto is_within = [&soil](double from_middle_m, double size_m) {
            const double whole_m = std::ceil(size_m / soil.voxel_m - 1e-6) * soil.voxel_m;
            return std::abs(from_middle_m) <= whole_m / 2 + 1e-6 * soil.voxel_m;
        };
        const double width_m = is_y_up ? soil.size_m.z : soil.size_m.y;
        if (is_within(along_m, soil.size_m.x) && is_within(across_m, width_m)) return;
        const Vec3 c = soil.floor_center_m;
        error(item, key,
              fmt::format("`{}` {} lies beside the soil, whose box of {:g} x {:g} m has its middle "
                          "at [{:g}, {:g}, {:g}]; move it inside, or enlarge `size_m` of [soil]",
                          key, item.said.at(key), soil.size_m.x, width_m, c.x, c.y, c.z));
    }

    const Scene& scene_;
    std::vector<SchemaError> errors_;
};

}  // namespace

std::vector<SchemaError> measure_errors(const Scene& scene) { return MeasureRules(scene).run(); }

}  // namespace bsoil::scene
