#include "bsoil/contact/bekker_law.h"

#include <algorithm>
#include <cmath>

#include "bsoil/contact/load_side.h"
#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

/// Half the hydraulic diameter of the face: what stands for b.
double bearing_width_m(const FaceExtent& face) {
    const double sum_m = face.width_m + face.length_m;
    return sum_m > 0 ? face.width_m * face.length_m / sum_m : 0;
}

double pressure_pa(const BekkerSoil& soil, double width_m, double sinkage_m) {
    if (!(sinkage_m > 0)) return 0;
    const double cohesive = width_m > 0 ? soil.kc_pa_m_n1 / width_m : 0;
    return std::max(0.0, cohesive + soil.kphi_pa_m_n) * std::pow(sinkage_m, soil.n);
}

}  // namespace

BekkerLaw::BekkerLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface)
    : ContactLaw(std::move(soil)), surface_(surface) {}

ElementYield BekkerLaw::yield(const ContactElement& element, const ElementMotion& motion,
                              const ContactHistory& memory) const {
    const ContactVoxel& contact = element.voxel;
    if (contact.is_load_side) return load_side_yield(this->soil(), contact, motion);
    const BekkerSoil& soil = def().bekker[static_cast<size_t>(contact.material)];
    const Vec3 n = contact.normal;
    const double depth_m = contact.bearing_depth_m;
    const double upright = std::min(1.0, looks_down(n, up()) / kUprightCosine);
    const double held = unloaded_share(depth_m, memory.retreat_m, def());
    const double developed = soil.shear_displacement_m > 0
                                 ? -std::expm1(-memory.sheared_m / soil.shear_displacement_m)
                                 : 1;
    const double tan_phi = std::tan(soil.friction_angle_rad);

    ElementYield out;
    out.pushed_pa = upright * pressure_pa(soil, bearing_width_m(element.face), depth_m);
    out.normal_limit_pa = held * out.pushed_pa;
    out.friction =
        developed * (surface_.friction >= 0 ? std::min(surface_.friction, tan_phi) : tan_phi);
    if (out.normal_limit_pa > 0) out.adhesion_pa = held * developed * soil.cohesion_pa;

    const double approach = dot(motion.share, n);
    const Vec3 slide = motion.share - approach * n;
    const double sliding = length(slide);
    const double creep = def().creep;
    if (sliding > 0) out.slide = slide * (1 / (sliding + creep));
    if (motion.asks_mobilized && approach > creep) {
        out.mobilized_pa = -out.normal_limit_pa * n;
        if (sliding > creep) {
            out.mobilized_pa +=
                slide * (-(out.friction * out.normal_limit_pa + out.adhesion_pa) / sliding);
        }
    }
    return out;
}

}  // namespace bsoil
