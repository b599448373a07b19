#include "bsoil/contact/load_side.h"

#include <algorithm>
#include <cmath>

#include "bsoil/contact/granular_law.h"
#include "contact/wall_friction.h"

namespace bsoil {

ElementYield load_side_yield(const ContactSoil& soil, const ContactVoxel& contact,
                             const ElementMotion& motion) {
    const MaterialDef& material = soil.materials[static_cast<size_t>(contact.material)];
    const double phi = material.friction_angle_rad, depth_m = contact.depth_m;
    const double weight_n_m3 =
        material.density_kg_m3 * material.wet_mass_share(contact.saturation) * soil.gravity_m_s2;
    const double cohesion_pa =
        cohesion_share(material, contact) *
        (material.cohesion_pa + material.moisture_cohesion_pa(contact.saturation));
    const double held_n_m =
        depth_m *
        (rest_pressure_factor(phi) * std::tan(phi) * weight_n_m3 * depth_m / 2 + cohesion_pa);
    const double rise = dot(motion.share, contact.normal), creep = soil.law.creep;
    ElementYield out;
    out.pushed_pa = out.normal_limit_pa =
        held_n_m / soil.voxel_m * (creep + std::max(rise, 0.0)) / (creep + length(motion.share));
    if (motion.asks_mobilized && rise > creep) {
        out.mobilized_pa = -out.normal_limit_pa * contact.normal;
    }
    return out;
}

}  // namespace bsoil
