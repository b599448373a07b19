/// A round column of soil that stands free on the grid's floor and comes down, as in chapter 4 of
/// the thesis. No body takes part: the soil is alone.
#include <algorithm>
#include <cmath>
#include <limits>

#include "reading/scene_load.h"
#include "rig_world.h"
#include "run/run_checks.h"
#include "scene/rotations.h"

namespace bsoil::experiment {
namespace {

using scene::kDegree;
/// A layer thinner than this share of the column's radius is no part of the heap.
constexpr double kThinLayer = 0.01;
/// A column stands where less than this share of its soil lies outside of its place.
constexpr double kStandingShare = 0.01;
/// The whole surface is read for a row of the series.
constexpr double kSeriesInterval_s = 0.1;

/// What the soil looks like after a step.
struct Heap {
    double height_m = 0;   ///< of its top above the floor
    double reach_m = 0;    ///< of its furthest soil from the column's axis
    double beyond_m3 = 0;  ///< of soil that lies further out than the column stood
    double held_m3 = 0;    ///< of all soil
};

Heap heap_of(const Soil& soil, const ColumnItem& column) {
    const GridFrame& frame = soil.frame();
    const double area_m2 = frame.voxel_m * frame.voxel_m;
    Heap heap;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            const double height_m = soil.surface_height_m(x, y);
            const double radius_m = frame.voxel_m * std::hypot(x + 0.5 - frame.size[0] / 2.0,
                                                               y + 0.5 - frame.size[1] / 2.0);
            heap.height_m = std::max(heap.height_m, height_m);
            heap.held_m3 += height_m * area_m2;
            // The voxels of the column's rim reach half a voxel out.
            if (radius_m > column.radius_m + frame.voxel_m) heap.beyond_m3 += height_m * area_m2;
            if (height_m > kThinLayer * column.radius_m) {
                heap.reach_m = std::max(heap.reach_m, radius_m + frame.voxel_m / 2);
            }
        }
    }
    return heap;
}

/// Steepest face on which soil `height_m` high stands (Culmann): H = 4 c / gamma sin(b) cos(phi) /
/// (1 - cos(b - phi)), which falls from any height at phi to that of a vertical cut.
double steepest_face_rad(const MaterialDef& m, double gravity_m_s2, double height_m) {
    const double phi = m.friction_angle_rad;
    double stands = phi, falls = std::acos(0.0);
    const auto stable = [&](double face) {
        const double weight = m.density_kg_m3 * gravity_m_s2 * height_m;
        return weight * (1 - std::cos(face - phi)) <=
               4 * m.cohesion_pa * std::sin(face) * std::cos(phi);
    };
    if (stable(falls)) return falls;
    for (int i = 0; i < 60; ++i) {
        const double middle = (stands + falls) / 2;
        (stable(middle) ? stands : falls) = middle;
    }
    return stands;
}

}  // namespace

Result<RigOutput> run_column(const RigSetup& setup, const ColumnItem& column,
                             const RigProgress& progress) {
    SoilDef def = scene::soil_def(setup.scene);
    def.backend = Backend::cpu;
    def.thread_count = 1;  // a sweep keeps the cores busy with its points
    auto made = Soil::create(def);
    if (!made) return Error{setup.scene.message(setup.scene.soil->at, made.error())};
    Soil& soil = **made;
    const MaterialDef& material = soil.materials().front();
    const Vec3 base_m = def.floor_center_m;
    const Status filled =
        soil.fill(CylinderFill{base_m, column.radius_m, column.height_m, material.name});
    if (!filled) return Error{setup.scene.message(column.at, filled.error())};

    // Its rim's voxels reach out further than its radius.
    const double placed_reach_m = heap_of(soil, column).reach_m;

    RigOutput out;
    out.series_columns = {"time_s", "height_m", "reach_m", "beyond_m3"};
    double time_s = 0, rest_s = std::numeric_limits<double>::quiet_NaN();
    for (int i = 1; std::isnan(rest_s) && time_s < column.duration_s; ++i) {
        const bool rests = soil.step({}).block_active_count == 0;
        time_s = i * def.step_s;
        if (rests) rest_s = time_s;
        if (rests || time_s >= static_cast<double>(out.series.size()) * kSeriesInterval_s) {
            const Heap heap = heap_of(soil, column);
            out.series.push_back({time_s, heap.height_m, heap.reach_m, heap.beyond_m3});
        }
        progress(time_s / column.duration_s);
    }
    if (!soil.device_failure().empty()) return Error{soil.device_failure()};
    const Heap heap = heap_of(soil, column);
    const bool stands = heap.beyond_m3 < kStandingShare * heap.held_m3;
    const double slope_rad = stands ? std::acos(0.0)
                                    : scene::repose_angle_rad(soil, base_m)
                                          .value_or(std::numeric_limits<double>::quiet_NaN());
    const double steepest_rad = steepest_face_rad(material, def.gravity_m_s2, heap.height_m);
    out.results.push_back({slope_rad / kDegree, material.friction_angle_rad / kDegree,
                           steepest_rad / kDegree, heap.height_m,
                           (heap.reach_m - placed_reach_m) / column.radius_m, rest_s});
    out.status = status_texts(soil.status_bits());
    if (std::isnan(rest_s)) out.faults.push_back("moving: the heap was not at rest at the end");
    return out;
}

}  // namespace bsoil::experiment
