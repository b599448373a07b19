#include "oracle/banks.h"

#include <cmath>
#include <limits>
#include <optional>

#include "oracle/spans.h"

namespace oracle {
namespace {

constexpr int kStepsMost = 256;
constexpr double kSteepest = 3;  // slope

struct Plane {
    double start = 0;  ///< steps before the first column
    double climb = 0;  ///< a step
    int count = 0;     ///< steps to where it comes out
    double height(int n) const { return (n - 0.5 + start) * climb; }
};

}  // namespace

double moved_strength_m(const bsoil::MaterialDef& soil, double relative_density,
                        double gravity_m_s2) {
    const double kept_pa = soil.loose_cohesion_fraction * soil.cohesion_pa;
    if (soil.compaction_cohesion_ratio == 0) return kept_pa / (soil.density_kg_m3 * gravity_m_s2);
    const double volume = (1 - relative_density) / soil.loose_density_kg_m3 +
                          relative_density / soil.compacted_density_kg_m3;
    const double pressure_pa = std::pow(10, 3 + 3 * relative_density);
    const double cohesion_pa =
        std::max(kept_pa, std::min(soil.cohesion_pa, soil.compaction_cohesion_ratio * pressure_pa));
    return cohesion_pa * volume / gravity_m_s2;
}

double peak_friction(const bsoil::MaterialDef& soil, double relative_density) {
    const double index = std::clamp(5 * relative_density - 1, 0.0, 4.0);
    return std::tan(soil.friction_angle_rad + index * soil.dilatancy_angle_rad);
}

double relative_density(const Model& model, const Voxel& voxel) {
    const VolumeRange range = volume_range(model, voxel);
    if (range.loose <= range.compacted) return 0;
    const double volume = voxel.soil / voxel.total_mass();
    return std::clamp((range.loose - volume) / (range.loose - range.compacted), 0.0, 1.0);
}

FailingPlanes failing_planes(const Model& model, const Field& field, const BankSoilLookup& soil,
                             double least_friction, double strength, double blur,
                             const std::function<bool(const Way&)>& asks) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const auto column = [&](int x, int y) { return static_cast<size_t>(y) * field.nx + x; };
    std::vector<double> ground;
    FailingPlanes found_planes{std::vector<double>(static_cast<size_t>(field.nx) * field.ny, kNone),
                               {}};
    for (int y = 0; y < field.ny; ++y) {
        for (int x = 0; x < field.nx; ++x) {
            ground.push_back(
                free_surface(model, field, height_spans(model, field, x, y), x, y).height);
        }
    }
    // Within `blur` of a height the strongest soil, or the weakest; no end of cohesion in what is
    // rigid. It counts as cohesive where all of it is, or any: a plane without any has nothing to
    // fall apart.
    const auto soil_at = [&](int x, int y, double height) {
        std::optional<BankSoil> found;
        double friction = 0;
        bool is_cohesive = strength > 1;
        for (double z : {height - blur, height, height + blur}) {
            const int at = std::clamp(static_cast<int>(std::ceil(z)) - 1, 0, field.nz - 1);
            const Voxel& voxel = field.at(x, y, at);
            const bool bonded = z - at - 1e-4 < voxel.terrain + voxel.bond;
            BankSoil here = voxel.soil > 0 ? soil(voxel, bonded) : BankSoil{};
            const bool holds = voxel.soil > 0 && here.cohesion_height > 0;
            is_cohesive = strength > 1 ? is_cohesive && holds : is_cohesive || holds;
            if (field.closed(model, x, y, at)) here.cohesion_height = kNone;
            const bool strongest = strength > 1;
            friction = z < height ? here.friction
                                  : (strongest ? std::max(friction, here.friction)
                                               : std::min(friction, here.friction));
            if (!found || (here.cohesion_height > found->cohesion_height) == strongest) {
                found = here;
            }
        }
        found->friction = friction;
        found->is_cohesive = is_cohesive;
        return *found;
    };
    const auto search = [&](int x, int y, int dx, int dy) -> std::optional<Plane> {
        const double length = std::hypot(dx, dy), toe = ground[column(x, y)];
        const auto inside = [&](int n) { return field.inside(x + n * dx, y + n * dy, 0); };
        const auto rise = [&](int n) { return ground[column(x + n * dx, y + n * dy)] - toe; };
        if (!inside(1) || rise(1) <= least_friction * length ||
            field.closed(model, x, y, static_cast<int>(toe)) || !asks({x, y, dx, dy})) {
            return {};
        }
        const auto fails = [&](const Plane& plane) {
            const double slope = plane.climb / length;
            double balance = 0;
            bool any_cohesion = false;
            for (int n = 1; n <= plane.count; ++n) {
                const BankSoil held = soil_at(x + n * dx, y + n * dy, toe + plane.height(n));
                if (held.cohesion_height == kNone) return false;
                const double stretch =
                    n == plane.count ? 0.5 : (n == 1 ? 1 + plane.start : 1);  // of the plane, steps
                balance -= strength * held.cohesion_height * (1 + slope * slope) * stretch;
                if (n < plane.count) {
                    balance += std::max(0.0, rise(n) - plane.height(n)) * (slope - held.friction);
                    any_cohesion |= held.is_cohesive;
                }
            }
            return any_cohesion && balance > 0;
        };
        const double second = inside(2) ? rise(2) - rise(1) : 0;
        Plane plane{0.5 * std::clamp(second / rise(1), 0.0, 1.0), kNone, 0};
        std::optional<Plane> flattest;
        for (int n = 1; n <= kStepsMost && inside(n); ++n) {
            const double climb = rise(n) / (n - 0.5 + plane.start);
            if (climb <= least_friction * length) break;
            if (climb > plane.climb) continue;  // it has come out of the ground before
            plane.climb = climb;
            plane.count = n;
            if (n > 1 && climb <= kSteepest * length && fails(plane)) flattest = plane;
        }
        return flattest;
    };
    for (int y = 0; y < field.ny; ++y) {
        for (int x = 0; x < field.nx; ++x) {
            for (const auto& [dx, dy] : {std::pair{1, 0},
                                         {2, 1},
                                         {1, 1},
                                         {1, 2},
                                         {0, 1},
                                         {-1, 2},
                                         {-1, 1},
                                         {-2, 1},
                                         {-1, 0},
                                         {-2, -1},
                                         {-1, -1},
                                         {-1, -2},
                                         {0, -1},
                                         {1, -2},
                                         {1, -1},
                                         {2, -1}}) {
                const std::optional<Plane> plane = search(x, y, dx, dy);
                if (plane) found_planes.ways.insert({x, y, dx, dy});
                for (int n = 1; plane && n < plane->count; ++n) {
                    double& low = found_planes.lowest[column(x + n * dx, y + n * dy)];
                    low = std::min(low, ground[column(x, y)] + plane->height(n));
                }
            }
        }
    }
    return found_planes;
}

}  // namespace oracle
