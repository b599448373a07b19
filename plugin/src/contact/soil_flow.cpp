#include "bsoil/contact/soil_flow.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/contact/orientation.h"

namespace bsoil {

double flow_slope(double friction_angle_rad) {
    return std::tan(std::numbers::pi / 4 - friction_angle_rad / 2);
}

Vec3 slide_past_flow(Vec3 slide, double approach, Vec3 normal, Vec3 up, double slope) {
    if (!(approach > 0)) return slide;
    const Vec3 along = up - dot(up, normal) * normal;
    const double level = length(along);
    if (!(level > 0)) return slide;
    const Vec3 to_surface = along * (1 / level);
    const double fastest = slope * approach * std::min(1.0, level / kLeaningSine);
    return slide - std::clamp(dot(slide, to_surface), 0.0, fastest) * to_surface;
}

double upward_share(Vec3 past, Vec3 normal, Vec3 up) {
    const Vec3 along = up - dot(up, normal) * normal;
    const double level = length(along), size = length(past);
    if (!(level > 0) || !(size > 0)) return 0;
    const double cosine = dot(past, along) / (size * level);
    return std::max(0.0, cosine) * std::min(1.0, level / kLeaningSine);
}

double fan_share(double friction_angle_rad, double friction) {
    const double sine = std::sin(friction_angle_rad);
    const double angle = std::min(std::atan(friction), friction_angle_rad);
    if (!(angle > 0)) return 1;
    const double own = std::sin(angle), cosine = std::cos(angle);
    const double turn = std::asin(std::min(1.0, own / sine)) + angle;
    return cosine * (cosine + std::sqrt(std::max(0.0, sine * sine - own * own))) / (1 + sine) *
           std::exp(-turn * std::tan(friction_angle_rad));
}

}  // namespace bsoil
