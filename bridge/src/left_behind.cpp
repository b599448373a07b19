// ContactCoupling: bodies that their host has put elsewhere since the soil held them.
#include <algorithm>

#include "bullet_types.h"
#include "contact_coupling.h"
#include "coupling_def.h"

namespace bsoil::bullet {

/// Lets go of patches on carriers that have gone. A driven one has no speed that Bullet keeps it
/// to: it goes as far in a substep as its host likes, and the soil on it as far as the soil sweeps.
void ContactCoupling::leave_carriers(CoupledBody& coupled, double slack_m, double swept_most_m) {
    for (const Carrier& carrier : coupled.carriers) {
        if (!carrier.body.object || !is_in_world(world_, carrier.body)) continue;
        if (carrier.left.is_at(*carrier.body.object)) continue;
        const double most_m = carrier.feels() ? slack_m : swept_most_m;
        std::erase_if(coupled.patches, [&](const CoupledPatch& patch) {
            return patch.patch.carrier == carrier.id &&
                   carrier.left.moved_m(*carrier.body.object, patch.carrier_offset_m) > most_m;
        });
    }
}

void ContactCoupling::leave_behind(double swept_most_m) {
    rows_.take_out();
    const double slack_m = kCoupling.put_elsewhere_voxels * soil_->voxel_m;
    for (auto it = coupled_.begin(); it != coupled_.end();) {
        CoupledBody& coupled = it->second;
        const bool is_there = !coupled.patches.empty() && is_in_world(world_, coupled.body);
        const auto has_left = [&](const CoupledPatch& patch) {
            return coupled.left.moved_m(*coupled.body.object, patch.offset_m) > slack_m;
        };
        if (is_there && !coupled.left.is_at(*coupled.body.object) &&
            std::ranges::any_of(coupled.patches, has_left)) {
            wake(coupled);
            it = coupled_.erase(it);
            continue;
        }
        if (is_there) leave_carriers(coupled, slack_m, swept_most_m);
        ++it;
    }
}

void ContactCoupling::note_found(CoupledBody& coupled) const {
    coupled.left.set(*coupled.body.object);
    for (Carrier& carrier : coupled.carriers) {
        if (carrier.body.object && is_in_world(world_, carrier.body)) {
            carrier.left.set(*carrier.body.object);
        }
    }
}

/// Contacts of a step that is through late are of where bodies were when it began.
bool ContactCoupling::is_elsewhere(const BodyState& body, double duration_s) const {
    if (body.role != BodyRole::rigid) return false;
    const Vec3 now_m = from_bullet(body.object->getWorldTransform().getOrigin());
    const double moved_m = length(now_m - body.motion.center_of_mass_m);
    const double slack_m = kCoupling.put_elsewhere_voxels * soil_->voxel_m;
    if (moved_m <= slack_m) return false;
    const auto now_m_s =
        static_cast<double>(body.object->getInterpolationLinearVelocity().length());
    const double speed_m_s = std::max(length(body.motion.linear_velocity_m_s), now_m_s);
    return moved_m > slack_m + duration_s * speed_m_s;
}

}  // namespace bsoil::bullet
