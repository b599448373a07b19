#include "patch_heirs.h"

#include <algorithm>
#include <limits>

#include "coupling_def.h"

namespace bsoil::bullet {

void PatchHeirs::replace(CoupledBody& coupled, std::span<const ContactPatch> patches) {
    previous_.swap(coupled.patches);
    coupled.patches.clear();
    double extent_m = 0;
    for (const ContactPatch& p : patches) {
        extent_m = std::max(extent_m, length(p.point_m - coupled.body.motion.center_of_mass_m));
    }
    heirs_.assign(previous_.size(), 0);
    nearest_.clear();
    for (const ContactPatch& p : patches) {
        CoupledPatch next;
        next.patch = p;
        next.offset_m = p.point_m - coupled.body.motion.center_of_mass_m;
        next.shear_offset_m = p.shear_point_m - coupled.body.motion.center_of_mass_m;
        if (p.carrier >= 0) {
            const Vec3 under_m = coupled.carrier_of(next).body.motion.center_of_mass_m;
            next.carrier_offset_m = p.point_m - under_m;
            next.carrier_shear_offset_m = p.shear_point_m - under_m;
        }
        // Without an old patch the body has just come in, and the soil yields.
        next.friction_normal_n = p.normal_limit_n;
        int nearest = -1;
        double least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < previous_.size(); ++i) {
            const CoupledPatch& old = previous_[i];
            const double cosine = dot(old.patch.normal, p.normal);
            const Vec3 apart = old.offset_m - next.offset_m;
            const double distance = dot(apart, apart) + (1 - cosine) * extent_m * extent_m;
            if (cosine < kCoupling.same_patch_cosine || distance >= least ||
                old.patch.carrier != p.carrier) {
                continue;
            }
            least = distance;
            nearest = static_cast<int>(i);
        }
        nearest_.push_back(nearest);
        if (nearest >= 0) heirs_[nearest] += p.normal_limit_n;
        coupled.patches.push_back(next);
    }
    for (size_t i = 0; i < coupled.patches.size(); ++i) {
        if (nearest_[i] < 0) continue;
        CoupledPatch& next = coupled.patches[i];
        const CoupledPatch& old = previous_[nearest_[i]];
        const double limit_n = next.patch.normal_limit_n;
        next.friction_normal_n =
            std::min(1.0, limit_n / old.patch.normal_limit_n) * old.friction_normal_n;
        next.applied_force_n = limit_n / heirs_[nearest_[i]] * old.applied_force_n;
        next.drift_m = old.drift_m;
    }
}

}  // namespace bsoil::bullet
