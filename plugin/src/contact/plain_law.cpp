#include "bsoil/contact/plain_law.h"

#include <algorithm>
#include <cmath>

#include "bsoil/contact/load_side.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/passive_wedge.h"
#include "bsoil/contact/resistive_force_theory.h"
#include "bsoil/contact/trapped_soil.h"

namespace bsoil {

PlainLaw::PlainLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface)
    : ContactLaw(std::move(soil)) {
    for (const MaterialDef& material : this->soil().materials) {
        const double phi = material.friction_angle_rad, tan_phi = std::tan(phi);
        const double gravity_m_s2 = this->soil().gravity_m_s2;
        Strength& strength = strengths_.emplace_back();
        strength.stiffness_pa_m =
            resistive_stiffness_pa_m(material.density_kg_m3, gravity_m_s2, tan_phi);
        strength.friction =
            std::min(surface.friction >= 0 ? surface.friction : material.tool_friction, tan_phi);
        strength.friction_angle_rad = phi;
        strength.tan_phi = tan_phi;
        if (!def().passive_wedge) continue;
        const double wall_rad = std::atan(strength.friction);
        strength.passive_factor = log_spiral_passive_factor(phi, wall_rad);
        const Vec3 level{1, 0, 0};
        const double wall_stress =
            -dot(resistive_stress(level, level, Vec3{0, 0, 1}, strength.friction), level);
        if (!(strength.stiffness_pa_m * wall_stress > 0)) continue;
        strength.wedge_share = material.density_kg_m3 * gravity_m_s2 * strength.passive_factor *
                               std::cos(wall_rad) / (strength.stiffness_pa_m * wall_stress);
    }
}

// Between wall and sole an element takes both, by the squares of its normal's parts.
double PlainLaw::size_factor(const Strength& soil, const FaceExtent& face, Vec3 normal) const {
    if (!def().passive_wedge) return 1;
    const SoleAndWall parts = bearing_parts(looks_down(normal, up()));
    const double wedge =
        soil.wedge_share * passive_width_factor(soil.passive_factor, soil.friction_angle_rad,
                                                face.width_m, face.foot_m);
    return parts.sole + parts.wall * std::min(1.0, wedge);
}

ElementYield PlainLaw::yield(const ContactElement& element, const ElementMotion& along,
                             const ContactHistory& memory) const {
    const ContactVoxel& contact = element.voxel;
    if (contact.is_load_side) return load_side_yield(this->soil(), contact, along);
    const Strength& soil = strengths_[static_cast<size_t>(contact.material)];
    const double depth_m = bearing_depth_of(contact, up()), creep = def().creep;
    const Vec3 n = contact.normal, motion = along.share;
    const double heavier =
        this->soil().materials[static_cast<size_t>(contact.material)].wet_mass_share(
            contact.saturation);
    const double xi_depth =
        heavier * (soil.stiffness_pa_m * depth_m * size_factor(soil, element.face, n));
    const double approach = dot(motion, n);
    const Vec3 slide = motion - approach * n;
    const double sliding = length(slide);

    const bool is_soil = contact.teeth.part == ToothPart::over_tips;
    const double friction = is_soil ? soil.tan_phi : soil.friction;

    ElementYield out;
    out.area_share = area_share_of(contact, soil.friction_angle_rad, def(), up());
    const Vec3 push = slide + (std::max(approach, 0.0) + creep) * n;
    const Vec3 pushed = resistive_stress(n, push * (1 / length(push)), up(), friction);
    const double normal = std::max(0.0, -dot(pushed, n));
    out.pushed_pa = xi_depth * normal;
    out.normal_limit_pa = unloaded_share(depth_m, memory.retreat_m, def()) * out.pushed_pa;
    const double slid = sliding / (sliding + creep);
    // What a row along the sliding can give is the shear against it. The rest comes with the normal
    // force: in front of a wheel that rolls resistive force theory drags the rim along with its
    // sliding.
    const Vec3 shear = pushed - dot(pushed, n) * n;
    const double against = sliding > 0 ? std::max(0.0, -dot(shear, slide) / sliding) : 0;
    // What moves into the soil yields whichever way it slides, and is at rest as it stops.
    const double moving = length(motion) / (length(motion) + creep);
    if (sliding > 0 && normal > 0) {
        out.drag_pa =
            (out.normal_limit_pa / normal * moving) * (shear + slide * (against / sliding));
    }
    const double sliding_friction = normal > 0 ? std::min(against / normal, friction) : friction;
    out.friction = friction + moving * (sliding_friction - friction);
    if (sliding > 0) out.slide = slide * (slid / sliding);
    if (along.asks_mobilized && approach > 0) {
        const Vec3 stress = resistive_stress(n, motion * (1 / length(motion)), up(), friction);
        if (dot(stress, n) < 0) out.mobilized_pa = xi_depth * stress;
    }
    return out;
}

}  // namespace bsoil
