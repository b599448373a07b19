#include "flat_bed_bow.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bsoil/contact/contact_law_def.h"
#include "bsoil/contact/passive_wedge.h"
#include "bsoil/contact/resistive_force_theory.h"

namespace bsoil::flat_bed {
namespace {

constexpr double kGravity = 9.81;
constexpr Vec3 kUp{0, 0, 1};

/// Kp of a wall of soil. Made once for each angle.
double rough_passive_factor(double phi_rad) {
    static std::map<double, double> made;
    const auto found = made.find(phi_rad);
    if (found != made.end()) return found->second;
    return made[phi_rad] = log_spiral_passive_factor(phi_rad, phi_rad);
}

}  // namespace

BodyBow::BodyBow(Bow rule, const MaterialDef& material, Vec3 velocity_m_s,
                 std::span<const ContactVoxel> voxels)
    : rule_(rule), tan_phi_(std::tan(material.friction_angle_rad)) {
    const Vec3 level = velocity_m_s - dot(velocity_m_s, kUp) * kUp;
    travels_ = length(level) > 0 && !voxels.empty();
    if (rule == Bow::none || !travels_) return;
    travel_ = level * (1 / length(level));
    const Vec3 across = cross(kUp, travel_);
    double least = 1e9, most = -1e9;
    for (const ContactVoxel& voxel : voxels) {
        least = std::min(least, dot(voxel.position_m, across));
        most = std::max(most, dot(voxel.position_m, across));
        foot_m_ = std::max(foot_m_, voxel.depth_m);
    }
    const double phi = material.friction_angle_rad, passive = rough_passive_factor(phi);
    wedge_pa_m_ = material.density_kg_m3 * kGravity * passive * std::cos(phi) *
                  passive_width_factor(passive, phi, most - least, foot_m_);
    const double stiffness_pa_m =
        resistive_stiffness_pa_m(material.density_kg_m3, kGravity, tan_phi_);
    upright_pa_m_ =
        stiffness_pa_m * -dot(resistive_stress(travel_, travel_, kUp, tan_phi_), travel_);
    const Vec3 along = travel_ - ContactLawDef{}.creep * kUp;
    base_pa_m_ =
        stiffness_pa_m * resistive_stress(-1 * kUp, along * (1 / length(along)), kUp, tan_phi_);
}

Vec3 BodyBow::stress_pa(Vec3 stress_pa, const ContactVoxel& element, Vec3 velocity) const {
    const double forward = travels_ ? dot(velocity, travel_) : 0;
    if (rule_ == Bow::none || forward <= 0) return stress_pa;
    if (rule_ == Bow::turned || rule_ == Bow::held) return turned(stress_pa, element, velocity);
    const double cosine = forward / length(velocity), share = cosine * cosine;
    return (1 - share) * stress_pa +
           share * (rule_ == Bow::block ? of_block(element) : turned(stress_pa, element, velocity));
}

Vec3 BodyBow::turned(Vec3 stress_pa, const ContactVoxel& element, Vec3 velocity) const {
    const Vec3 back = velocity * (-1 / length(velocity));
    const double size = length(stress_pa);
    if (!(size > 0)) return stress_pa;
    const Vec3 off = stress_pa - dot(stress_pa, back) * back;
    const double own_rad = std::atan2(length(off), dot(stress_pa, back));
    const double phi = std::atan(tan_phi_);
    if (own_rad <= phi || !(length(off) > 0)) return stress_pa;
    const Vec3 across = off * (1 / length(off));
    const auto at = [&](double angle_rad) {
        return size * (std::cos(angle_rad) * back + std::sin(angle_rad) * across);
    };
    if (rule_ != Bow::held) return at(phi);
    const double front_pa =
        wedge_pa_m_ * element.depth_m * std::max(0.0, dot(element.normal, travel_));
    const auto holds = [&](Vec3 stress) {
        return -dot(stress, travel_) <= front_pa + tan_phi_ * std::max(0.0, dot(stress, kUp));
    };
    if (holds(at(phi))) return at(phi);
    if (!holds(stress_pa)) return stress_pa;
    double held = own_rad, lost = phi;
    for (int i = 0; i < 20; ++i) {
        const double middle = (held + lost) / 2;
        (holds(at(middle)) ? held : lost) = middle;
    }
    return at(held);
}

Vec3 BodyBow::of_block(const ContactVoxel& element) const {
    const double front = std::max(0.0, dot(element.normal, travel_)),
                 base = std::max(0.0, -dot(element.normal, kUp));
    const double front_pa = std::min(wedge_pa_m_, upright_pa_m_) * element.depth_m;
    return front * front_pa * (tan_phi_ * kUp - travel_) + base * foot_m_ * base_pa_m_;
}

}  // namespace bsoil::flat_bed
