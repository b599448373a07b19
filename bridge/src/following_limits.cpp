// What ContactCoupling knows of the way of bodies between the soil's steps: how they have come to
// where they are, and what their patches bear on the way from there.
#include <cmath>
#include <vector>

#include "bullet_types.h"
#include "contact_coupling.h"
#include "coupling_def.h"

namespace bsoil::bullet {
namespace {

/// A body that turns further than this in a step of the soil [rad] has the turning that it has at
/// the end of it. Ours: a quarter turn, by which two poses still tell which way it was. Larger:
/// bodies that spin fast seem to turn backwards; smaller: a body that rocks fast draws back by its
/// last speed.
constexpr double kTurnMost = 1.57;

/// Axis times angle of a rotation, the short way.
Vec3 turn_rad(Quat turn) {
    const Vec3 axis{turn.x, turn.y, turn.z};
    const double sine = length(axis), side = turn.w < 0 ? -1 : 1;
    return sine > 0 ? (2 * side / sine * std::atan2(sine, std::abs(turn.w))) * axis : Vec3{};
}

}  // namespace

BodyMotion ContactCoupling::moved_since(const CoupledBody& coupled, const BodyState& body,
                                        double duration_s) {
    BodyMotion out = body.motion;
    const bool is_known = coupled.met_motion && is_same_object(coupled.body, body);
    if (is_given(body) || !is_known || !(duration_s > 0)) return out;
    const BodyMotion& before = *coupled.met_motion;
    out.linear_velocity_m_s = (out.center_of_mass_m - before.center_of_mass_m) * (1 / duration_s);
    // The pose of a raycast vehicle's wheel does not spin.
    const double turned = duration_s * length(out.angular_velocity_rad_s);
    if (body.role == BodyRole::wheel || turned > kTurnMost) return out;
    out.angular_velocity_rad_s =
        turn_rad(out.pose.rotation * conjugate(before.pose.rotation)) * (1 / duration_s);
    return out;
}

void ContactCoupling::follow() {
    for (auto& [id, coupled] : coupled_) {
        if (coupled.elements.empty() || coupled.patches.empty() || coupled.body.is_asleep ||
            !is_in_world(world_, coupled.body)) {
            continue;
        }
        const Vec3 now_m = from_bullet(coupled.body.object->getWorldTransform().getOrigin());
        find_shares(coupled, coupled.patches.size(), now_m - coupled.body.motion.center_of_mass_m);
        for (size_t i = 0; i < coupled.patches.size(); ++i) {
            ContactPatch& patch = coupled.patches[i].patch;
            if (patch.carrier < 0) patch.normal_limit_n = shares_[i] * patch.found_limit_n;
        }
    }
}

void ContactCoupling::follow_wheel(int body_id, Vec3 shift_m) {
    const auto found = coupled_.find(body_id);
    if (found == coupled_.end() || found->second.elements.empty()) return;
    std::vector<ContactPatch>& patches = found->second.wheel_patches;
    find_shares(found->second, patches.size(), shift_m);
    for (size_t i = 0; i < patches.size(); ++i) {
        if (patches[i].carrier >= 0) continue;
        patches[i].normal_limit_n = shares_[i] * patches[i].found_limit_n;
    }
}

void ContactCoupling::find_shares(const CoupledBody& coupled, size_t patch_count, Vec3 shift_m) {
    shares_.resize(patch_count);
    limit_shares(coupled.elements, shift_m, soil_->up, soil_->law, shares_);
}

/// Soil over a wheel of a btRaycastVehicle weighs nothing on it, nor does it hold it down: its
/// solver knows what bears it and what it pushes.
void ContactCoupling::set_wheel_patches(CoupledBody& coupled, const ContactPatches& found) const {
    coupled.wheel_patches.clear();
    coupled.elements.clear();
    std::vector<int> places;
    for (const ContactPatch& patch : found.patches()) {
        const bool counts = dot(patch.normal, soil_->up) <= kCoupling.wheel_top_cosine;
        places.push_back(counts ? static_cast<int>(coupled.wheel_patches.size()) : -1);
        if (counts) coupled.wheel_patches.push_back(patch);
    }
    for (PatchElement element : found.patch_elements()) {
        element.patch = places[static_cast<size_t>(element.patch)];
        if (element.patch >= 0) coupled.elements.push_back(element);
    }
}

}  // namespace bsoil::bullet
