/// Soil that comes and goes: sources out of which it falls or flows, sinks that take it away. The
/// grid's open sides are SoilDef::open_sides. Each is counted: what lies in the grid is what lay in
/// it, plus SoilTotals::units_in, minus SoilTotals::units_out.
#pragma once

#include <cstdint>
#include <string>

#include "bsoil/body.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// The end of a source or sink that has none [s]: some 30 years.
inline constexpr double kFlowForever = 1e9;

/// A flat region out of which soil comes at a rate: the end of a pipe or a belt, a hopper's slot,
/// rain. It pours loose soil, spread over the voxels that the soil crosses in a step. It does so in
/// lumps of at least 500 kg a cubic metre of voxel: 0.06 kg where voxels are 5 cm, 500 kg where
/// they are a metre. Less waits until it is one. What finds no room there waits for up to 8 steps;
/// what comes beyond that is held back, for good.
struct SourceDef {
    /// Its form.
    enum class Shape { disc, rectangle };
    Shape shape = Shape::disc;
    Vec3 center_m;          ///< world, -1e7..1e7
    Vec3 direction;         ///< the soil leaves along it, square to the region; zero: down
    double radius_m = 0.1;  ///< disc: 1e-4..1e4
    double length_m = 0.2;  ///< rectangle: 1e-4..1e4; see turn_rad
    double width_m = 0.2;   ///< rectangle: across its length, 1e-4..1e4
    /// Rectangle: about `direction`. At 0 the length lies along the world's x, as far as that is
    /// square to the direction; where x is the direction, along the world's up. -7..7
    double turn_rad = 0;
    double speed_m_s = 0;   ///< along `direction`, 0..100; at most 8 voxels a step
    double spread_rad = 0;  ///< half the angle of a jet's cone, 0..1
    double rate_kg_s = 0;   ///< 0..1e9; one of the two rates is above 0
    double rate_m3_s = 0;   ///< of loose soil, 0..1e6
    double start_s = 0;     ///< simulated time, 0..1e9; the first step starts at 0
    double end_s = kFlowForever;
    std::string material;  ///< a name out of the SoilDef; empty: its first

    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// A region that takes soil away, resting or not: a pit, a belt's end, the mouth of a suction pipe.
/// The soil of the voxels whose centres are inside; what lies buried in ground bodies stays.
struct SinkDef {
    ConvexShape region;  ///< box, sphere, capsule, cylinder or cone
    Pose pose;           ///< body frame of the region -> world
    /// What it takes, from all soil in the region alike: as much as there is, up to this, 0..1e9.
    /// 0: all of it, in every step. It takes whole mass units out of each voxel; less than one of
    /// each waits until it is one.
    double rate_kg_s = 0;
    /// Not 0: a well. It moves no soil but water, once a second: so much out of the region's pores,
    /// down to their residual saturation; below 0, into them until they are full. -1e9..1e9
    double water_kg_s = 0;
    double start_s = 0;  ///< simulated time, 0..1e9
    double end_s = kFlowForever;

    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// Into the grid or out of it.
enum class FlowWay { in, out };

/// What a source or sink has done.
struct FlowState {
    int64_t units = 0;  ///< mass units moved so far; a well's as SoilTotals::water_units
    /// Mass units that were due and will never come: the source found no room, the sink no soil.
    int64_t missed_units = 0;
    double mass_kg = 0, missed_kg = 0;
};

}  // namespace bsoil
#pragma GCC visibility pop
