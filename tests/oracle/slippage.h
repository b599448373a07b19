/// Soil slippage (20) of the thesis: slope stability of Li and Moshell (1) to (10), soil slices
/// (31), (32), edge spans.
///
/// Deviations from the thesis:
/// - slopes are those of the eight triangular facets between an axis neighbour and a diagonal one
/// (Tarboton 1997,
///   D-infinity), not of slices along x and z only; what slides on a facet is shared between its
///   two neighbours by the tangent of its direction;
/// - a voxel of several materials has the means by mass of their tan(phi), cohesion over unit
/// weight and acceleration;
/// - cohesion is that of bonded soil where most of the soil at the top never moved, else that of
/// loose soil;
/// - sliding soil takes over the greatest slip speed around it;
/// - a slide moves at least slip_rate_least and at most slip_rate_most of the steepest wedge, and
/// at most slip_depth voxels, of which no neighbour gets more than slip_intake;
/// - soil slides slip_stride voxels at once, as if columns that far apart were neighbours, where
/// the ground falls all along that way; by more than one voxel it leaves no edge of a rigid body;
/// - what slides takes soil below it along only where that soil would not stand at this slope;
/// - a slide is reckoned from a wedge higher by slip_overshoot, but by a quarter of tan(phi) at
/// most, so that it ends below phi; not for soil that falls or keeps momentum, nor for longer
/// strides;
/// - no share is too small to go, as the kernel has them, and so no slope stands for that;
/// - f in (9) is a force with g in it (the thesis counts in tons-force);
/// - wedges up to slip_tolerance do not slide, nor those of rough soil up to between half and all
/// of its roughness, by chance of the place;
/// - where slides keep their momentum, a failing slope sets soil in motion (sliding.h), and of the
/// wedge up to slide_creep slips;
/// - into a voxel that is covered in part a span slides that ends above the voxel; others no more
/// than a part of what still fits in without the voxel counting as full, which would raise its top
/// above theirs;
/// - viscous soil that fails slides by chance, with another number in each pass.
#pragma once

#include <functional>

#include "oracle/field.h"
#include "oracle/spans.h"

namespace oracle {

/// Soil parameters of the slope analysis: SI units, a slice one metre thick.
struct SlopeSoil {
    double cohesion_pa = 0;
    double friction_angle_rad = 0;
    double unit_weight_n_m3 = 0;
};

struct Wedge {
    double height_m = 0;           ///< h - tan(theta) dx; 0 when stable
    double acceleration_m_s2 = 0;  ///< f / mass, (8) and (9)
};

/// Solves (4) for the flattest failure plane of a slope of rise h over run dx.
Wedge failure_wedge(const SlopeSoil& soil, double gravity_m_s2, double rise_m, double run_m);

/// Up to this height a failing wedge of soil in that voxel stands, in voxels.
double standing_wedge(const Model& model, const Voxel& soil, int x, int y, int z);

/// A wedge at a slope (voxels of rise per voxel of run) of a material, in voxels and voxels a step
/// squared.
struct GridWedge {
    double height = 0, acceleration = 0;
};
/// Soil that was never moved, that was, and that lies above a plane that fails in this step, which
/// has no cohesion.
enum class SoilState { bonded, loose, failing };
using WedgeLookup = std::function<GridWedge(const Voxel& soil, SoilState state, double slope)>;

/// Slip speeds of the spans, [(y * nx + x) * span_capacity + span].
using SlipSpeeds = std::vector<double>;

struct Slippage {
    Field field;
    SlipSpeeds speeds;
};
/// One slip pass. failing_above: by column [y * nx + x] the height of the plane that fails in this
/// step, infinity where none does; empty: nowhere.
Slippage slip_soil(const Model& model, const Field& before, const SlipSpeeds& speeds,
                   const WedgeLookup& wedge, const std::vector<double>& failing_above = {});

}  // namespace oracle
