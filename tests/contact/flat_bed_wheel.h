/// Wheels with and without lugs in a flat bed.
#pragma once

#include "flat_bed.h"

namespace bsoil::flat_bed {

/// A wheel of a measurement.
struct Wheel {
    Soil soil;
    double radius_m, width_m;
    int lug_count = 0;
    double lug_height_m = 0, lug_thickness_m = 0;
};

struct WheelForce {
    double pull_n = 0, side_n = 0, sinkage_m = 0, torque_n_m = 0;
};

/// At the sinkage at which the soil carries the load. slip: of the speed of travel. today_smooth:
/// whether today's law takes a smooth rim for smooth metal.
WheelForce wheel_under_load(const Law& law, const Wheel& wheel, double slip, double angle_rad,
                            double load_n, bool today_smooth);

}  // namespace bsoil::flat_bed
