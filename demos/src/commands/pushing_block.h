/// The experiment of the thesis, section 4.2, that `bsoil bench` repeats: a rigid block pushes soil
/// along the surface of a half-full cube of N^3 voxels.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "bsoil/soil.h"

namespace bsoil::command {

/// phi 25 deg, c 0, 2 t/m3. Its density does not change.
inline MaterialDef pushed_material() {
    MaterialDef material;
    material.name = "thesis";
    material.density_kg_m3 = 2000;
    material.friction_angle_rad = 25 * std::numbers::pi / 180;
    return material;
}

/// A block that goes to and fro through the upper half of the soil.
class PushingBlock {
  public:
    static constexpr double kVoxelM = 0.05, kVoxelsPerStep = 0.5;
    PushingBlock(double side_m, double step_s) : side_m_(side_m), step_s_(step_s) {
        ConvexShape box;
        box.half_extents_m = {side_m / 16, side_m / 6, side_m / 8};
        shapes_.push_back(box);
        body_.shapes = &shapes_;
        body_.id = 1;
    }
    /// Where it is at the end of frame `frame`; its lower half is in the soil, whose surface is at
    /// half height.
    const SoilBody& at(int frame) {
        const double way = side_m_ * 0.6, step = kVoxelsPerStep * kVoxelM;
        const double along = std::fmod(frame * step, 2 * way);
        const bool forth = along < way;
        body_.pose.position = {(forth ? along : 2 * way - along) - way / 2, 0, side_m_ * 0.52};
        body_.center_of_mass_m = body_.pose.position;
        body_.linear_velocity_m_s = {(forth ? step : -step) / step_s_, 0, 0};
        return body_;
    }

  private:
    double side_m_, step_s_;
    std::vector<ConvexShape> shapes_;
    SoilBody body_;
};

}  // namespace bsoil::command
