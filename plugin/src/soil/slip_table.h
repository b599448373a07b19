/// Slope stability of Li and Moshell as tables over slope, made once per material in double
/// precision.
#pragma once

#include <cstdint>
#include <vector>

#include "bsoil/soil_def.h"

namespace bsoil {

/// What slides at a slope of rise h over run dx (both in metres): angle of the failure plane,
/// height of the wedge above it (h - tan(theta) dx; negative when the slope is stable) and the
/// wedge's acceleration.
struct SlipWedge {
    bool fails = false;
    double theta_rad = 0;
    double height_m = 0;
    double acceleration_m_s2 = 0;
};

/// Thesis (1) to (4) and (8), for c [Pa], gamma [N/m3] and a slice one metre thick.
SlipWedge find_slip_wedge(const MaterialDef& material, double gravity_m_s2, double rise_m,
                          double run_m);

/// What Coulomb friction changes the speed of soil by that rests on a body, in a step: Q16 voxels a
/// step, as the kernels have it.
int32_t friction_speed(double friction, const SoilDef& def);

/// What seeps out of a saturated voxel in a water step, water units Q4; a voxel's water at most.
int32_t seepage_q4(double conductivity_m_s, const SoilDef& def);

/// Suction of dry pores, as a height of water: Q16 voxels.
int32_t suction_q16(const MaterialDef& material, const SoilDef& def);

/// The table of one material in the layout of the kernels (kTableWords words): slopes, and what
/// else kernels need to know of it.
std::vector<int32_t> make_slip_table(const MaterialDef& material, const SoilDef& def);

/// tan(phi) of soil that was never moved by its relative density (kTableByDensity), Q16: Bolton's
/// peak.
std::vector<int32_t> peak_frictions(const MaterialDef& material);

/// Strengths of moved soil by its relative density (kTableByDensity): Hvorslev's share of the
/// pressure that belongs to the density, no less than loose soil keeps and no more than it had.
/// Over its weight at that density. loose: table of its loose soil, whose strength all are where
/// compaction gives it none.
std::vector<int32_t> regained_strengths(const MaterialDef& material, const SoilDef& def,
                                        const int32_t* loose);

}  // namespace bsoil
