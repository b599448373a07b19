/// Water in the soil, written from docs/decisions/moisture.md: one water step of every column, and
/// the cohesion that it gives.
#pragma once

#include "oracle/field.h"

namespace oracle {

/// Of a material.
struct PoreSoil {
    double pores = 0;         ///< mass of water that fills them, of the soil's mass
    double residual = 0;      ///< saturation that does not drain
    double conductivity = 0;  ///< water through full pores [voxels of the reference mass a step]
    double suction = 0;       ///< of dry pores, as a height of water [voxels]
};
/// Rates in a water step, mass in voxels of the reference density.
struct Weather {
    double rain = 0, drying = 0, floor = 0;
    double table = 0;  ///< height of the groundwater over the floor [voxels]; 0: there is none
};
/// What the step has brought and taken.
struct WaterStep {
    Field field;
    double in = 0, out = 0;
};

double saturation(const Voxel& voxel, const std::vector<PoreSoil>& soils);

/// c / gamma with 4 S (1 - S) of the moist cohesion over unit weight, and the water's weight.
double moist_strength(double strength, double moist, double saturation, double water_of_mass);

WaterStep move_water(const Model& model, const Field& before, const std::vector<PoreSoil>& soils,
                     const Weather& weather);

}  // namespace oracle
