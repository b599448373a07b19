#include "world_gravity.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// Share by which the two may differ: Bullet's own default is 10 m/s2.
constexpr double kSameGravity = 0.05;
/// Cosine of an angle from -up beyond which it is another axis that points up: 45 deg.
constexpr double kSameAxis = 0.7071;

/// What a gravity of another size says of the world's unit of length; empty: nothing.
std::string unit_hint(double ratio) {
    constexpr std::pair<double, const char*> kUnits[] = {{100, "centimetres"},
                                                         {1000, "millimetres"}};
    for (const auto& [per_metre, unit] : kUnits) {
        if (std::abs(ratio / per_metre - 1) <= kSameGravity) {
            return std::string(": a world in ") + unit +
                   "? The soil's units are SI; give the world metres and kilograms";
        }
    }
    return "";
}

std::string text_of(Vec3 v) {
    char text[96];
    std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g) m/s2", v.x, v.y, v.z);
    return text;
}

}  // namespace

Vec3 gravity_of(const SoilDef& def) {
    return def.up == UpAxis::y ? Vec3{0, -def.gravity_m_s2, 0} : Vec3{0, 0, -def.gravity_m_s2};
}

bool has_gravity_of(const btDiscreteDynamicsWorld& world, const SoilDef& def) {
    const Vec3 here = from_bullet(world.getGravity());
    const double most = std::max(length(here), def.gravity_m_s2);
    return length(here) == 0 || length(here - gravity_of(def)) <= kSameGravity * most;
}

Status check_gravity(const btDiscreteDynamicsWorld& world, const SoilDef& def) {
    if (has_gravity_of(world, def)) return Done{};
    const Vec3 here = from_bullet(world.getGravity());
    const bool y_up = def.up == UpAxis::y;
    const double along = -(y_up ? here.y : here.z);
    const std::string cure = "; give the soil the world's, and set the world's before it is made";
    if (along < kSameAxis * length(here)) {
        return Error{std::string("up is ") + (y_up ? "y" : "z") + ", but the world's gravity is " +
                     text_of(here) + cure};
    }
    const std::string hint = unit_hint(length(here) / std::max(def.gravity_m_s2, 1e-3));
    return Error{"gravity_m_s2 is " + std::to_string(def.gravity_m_s2) +
                 " along -up, but the world's gravity is " + text_of(here) +
                 (hint.empty() ? cure : hint)};
}

}  // namespace bsoil::bullet
