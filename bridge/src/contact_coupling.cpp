#include "contact_coupling.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bsoil/contact/mean_pressure.h"
#include "bullet_types.h"
#include "coupling_def.h"
#include "lowest_point.h"
#include "same_contact.h"

namespace bsoil::bullet {

/// A thread takes at least this many contacts.
constexpr size_t kRangeContacts = 512;

ContactCoupling::ContactCoupling(btDiscreteDynamicsWorld& world, ContactSoil soil,
                                 KnownContacts& known, const SoilActionDef& options,
                                 const WorkThreads& threads)
    : world_(world),
      soil_(std::make_shared<const ContactSoil>(std::move(soil))),
      known_(known),
      threads_(threads),
      wake_limit_fraction_(options.wake_limit_fraction),
      wake_weight_fraction_(options.wake_weight_fraction),
      rows_(world, coupled_, known, soil_->voxel_m) {}

ContactCoupling::~ContactCoupling() = default;

void ContactCoupling::set_bodies(std::span<const BodyState> bodies) {
    by_id_.clear();
    for (const BodyState& body : bodies) by_id_.push_back(&body);
    std::sort(by_id_.begin(), by_id_.end(),
              [](const BodyState* a, const BodyState* b) { return a->id < b->id; });
}

void ContactCoupling::set_contacts(std::span<const BodyState> bodies,
                                   std::span<const ContactVoxel> contacts, double duration_s,
                                   bool are_unchanged) {
    set_bodies(bodies);
    are_unchanged = are_unchanged && contact_count_ == contacts.size();
    const bool are_same_bodies =
        std::equal(by_id_.begin(), by_id_.end(), sorted_ids_.begin(), sorted_ids_.end(),
                   [](const BodyState* body, int id) { return body->id == id; });
    if (!are_unchanged || !are_same_bodies) sort_by_body(contacts);
    for (auto& [id, coupled] : coupled_) coupled.seen = false;
    size_t count = 0;
    for (const BodyState& body : bodies) {
        const auto rank = static_cast<size_t>(rank_of(body.id));
        const size_t first = starts_[rank], own = starts_[rank + 1] - first;
        if (own == 0 && !coupled_.contains(body.id)) continue;
        if (is_elsewhere(body, duration_s)) continue;
        if (count == works_.size()) works_.emplace_back();
        BodyWork& work = works_[count++];
        work.voxels = std::span(by_body_).subspan(first, own);
        work.carriers = std::span(carriers_).subspan(first, own);
        prepare(work, body, duration_s, are_unchanged);
    }
    const std::span works = std::span(works_).first(count);
    if (std::ranges::any_of(
            works, [](const BodyWork& work) { return work.kind == BodyWork::Kind::moved; })) {
        list_pressed_soil();
    }
    find_faces(works);
    for_ranges(&threads_, count, 1, [&](size_t first, size_t last) {
        for (BodyWork& work : works.subspan(first, last - first)) find_contact(work, duration_s);
    });
    for (const BodyWork& work : works) {
        if (work.kind != BodyWork::Kind::kept) report_contact(work);
        if (work.kind == BodyWork::Kind::moved) act(work);
        wake_if_changed(*work.coupled);
        keep_awake_with_carriers(*work.coupled);
    }
    for (auto it = coupled_.begin(); it != coupled_.end();) {
        if (it->second.seen) {
            ++it;
            continue;
        }
        wake(it->second);
        it = coupled_.erase(it);
    }
}

void ContactCoupling::prepare(BodyWork& work, const BodyState& body, double duration_s,
                              bool are_unchanged) {
    const std::span<const ContactVoxel> voxels = work.voxels;
    const auto [place, is_new] = coupled_.try_emplace(body.id);
    CoupledBody& coupled = place->second;
    coupled.seen = true;
    if (coupled.body.role != body.role) {  // the host has turned it kinematic or back
        wake(coupled);
        coupled.rigid_rows.clear();
        coupled.carriers.clear();
        coupled.motions.clear();
        coupled.patches.clear();
        coupled.elements.clear();
        coupled.met_motion.reset();
    }
    work.moved = moved_since(coupled, body, duration_s);
    coupled.met_motion = body.motion;
    coupled.body = body;
    work.coupled = &coupled;
    // What bears a body that sleeps is what bore it when it fell asleep: here nothing of the soil.
    if (is_new && body.is_asleep && !is_given(body)) wake(coupled);
    const bool is_sleeper =
        body.is_asleep && coupled.asleep_step_count > 0 && !coupled.carriers.empty();
    if (!is_sleeper) {
        work.kind = BodyWork::Kind::moved;
        coupled.slept_voxels.reset();
        update_law(coupled);
        update_carriers(coupled, work.carriers);
        update_motions(coupled, voxels, duration_s);
        return;
    }
    for (Carrier& carrier : coupled.carriers) {
        if (const BodyState* state = state_of(carrier.id);
            state && is_same_object(*state, carrier.body)) {
            carrier.body = *state;
        }
    }
    const bool has_law = update_law(coupled);
    const bool has_same =
        are_unchanged || (has_law && coupled.slept_voxels &&
                          std::ranges::equal(voxels, *coupled.slept_voxels, is_same_contact));
    if (has_same && coupled.has_limits) {
        work.kind = BodyWork::Kind::kept;
        return;
    }
    work.kind = BodyWork::Kind::slept;
    if (!coupled.slept_voxels) coupled.slept_voxels.emplace();
    coupled.slept_voxels->assign(voxels.begin(), voxels.end());
}

/// Sorts contacts by body. The soil hands them over in the order of its voxels, and each body's
/// contacts keep that order.
void ContactCoupling::sort_by_body(std::span<const ContactVoxel> contacts) {
    contact_count_ = contacts.size();
    sorted_ids_.clear();
    for (const BodyState* body : by_id_) sorted_ids_.push_back(body->id);
    starts_.assign(by_id_.size() + 1, 0);
    ranks_.resize(contacts.size());
    for_ranges(&threads_, contacts.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const bool is_same = i > first && contacts[i].body == contacts[i - 1].body;
            ranks_[i] = is_same ? ranks_[i - 1] : rank_of(contacts[i].body);
        }
    });
    for (const int rank : ranks_) {
        if (rank >= 0) ++starts_[static_cast<size_t>(rank) + 1];
    }
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    by_body_.resize(starts_.back());
    carriers_.resize(starts_.back());
    next_.assign(starts_.begin(), starts_.end());
    places_.resize(contacts.size());
    for (size_t i = 0; i < contacts.size(); ++i) {
        if (ranks_[i] >= 0) places_[i] = next_[static_cast<size_t>(ranks_[i])]++;
    }
    for_ranges(&threads_, contacts.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            if (ranks_[i] < 0) continue;
            by_body_[places_[i]] = contacts[i];
            carriers_[places_[i]] = contacts[i].carrier;
        }
    });
}

void ContactCoupling::list_pressed_soil() {
    pressed_.clear();
    if (coupled_.size() < 2) return;
    for (const auto& [id, coupled] : coupled_) pressed_.push_back(coupled.memory.list(id));
}

void ContactCoupling::wake(CoupledBody& coupled) {
    coupled.asleep_step_count = 0;
    wake_object(world_, coupled.body);
}

void wake_object(const btCollisionWorld& world, const BodyState& body) {
    if (!is_in_world(world, body)) return;
    if (body.role == BodyRole::link) {
        static_cast<btMultiBodyLinkCollider*>(body.object)->m_multiBody->wakeUp();
    }
    body.object->activate();
}

/// Bodies that slept on the soil wake up, or they would hang in the air.
void ContactCoupling::let_go() {
    take_rows_out();
    for (auto& [id, coupled] : coupled_) wake(coupled);
    coupled_.clear();
    by_id_.clear();
    known_.clear();
}

bool ContactCoupling::update_law(CoupledBody& coupled) {
    const SurfaceFriction& surface = coupled.body.surface;
    const SurfaceFriction& known = coupled.law_surface;
    if (coupled.law && &coupled.law->soil() == soil_.get() && surface.friction == known.friction &&
        surface.adhesion_pa == known.adhesion_pa) {
        return true;
    }
    coupled.law = ContactLaw::make(soil_, surface);
    coupled.law_surface = surface;
    return false;
}

int ContactCoupling::rank_of(int id) const {
    const auto found =
        std::lower_bound(by_id_.begin(), by_id_.end(), id,
                         [](const BodyState* a, int wanted) { return a->id < wanted; });
    return found != by_id_.end() && (*found)->id == id ? static_cast<int>(found - by_id_.begin())
                                                       : -1;
}

const BodyState* ContactCoupling::state_of(int id) const {
    const int rank = rank_of(id);
    return rank < 0 ? nullptr : by_id_[static_cast<size_t>(rank)];
}

/// The law gives no force at zero depth. On stiff soil FirstContacts holds a body instead, but only
/// while it is awake. A body that fell asleep keeps the patches that held it while it touches soil.
bool ContactCoupling::stays_held(const BodyWork& work) {
    const CoupledBody& coupled = *work.coupled;
    return coupled.body.is_asleep && work.found.patches().empty() && work.contact.area_m2 > 0 &&
           !coupled.patches.empty();
}

void ContactCoupling::report_contact(const BodyWork& work) {
    CoupledBody& coupled = *work.coupled;
    coupled.report.contact_area_m2 = work.contact.area_m2;
    coupled.report.sinkage_m = sinkage_m(coupled.body, work.contact);
    coupled.report.compression_m = work.contact.compression_m;
    coupled.has_limits = true;
    coupled.limits_n = {};
    if (stays_held(work)) {
        for (const CoupledPatch& p : coupled.patches) {
            coupled.limits_n[p.patch.bin] += p.patch.normal_limit_n;
        }
        return;
    }
    coupled.report.patch_count = static_cast<int>(work.found.patches().size());
    for (const ContactPatch& p : work.found.patches()) coupled.limits_n[p.bin] += p.normal_limit_n;
}

void ContactCoupling::update_carriers(CoupledBody& coupled, std::span<const int> carriers) {
    carrier_ids_.assign(1, -1);
    for (const int carrier : carriers) {
        if (carrier != carrier_ids_.back()) carrier_ids_.push_back(carrier);
    }
    std::sort(carrier_ids_.begin(), carrier_ids_.end());
    carrier_ids_.erase(std::unique(carrier_ids_.begin(), carrier_ids_.end()), carrier_ids_.end());
    previous_carriers_.swap(coupled.carriers);
    previous_motions_.swap(coupled.motions);
    coupled.carriers.clear();
    coupled.motions.clear();
    for (const int id : carrier_ids_) {
        const BodyState* state = state_of(id);
        const BodyState body = state ? *state : BodyState{};
        Carrier& carrier = coupled.carriers.emplace_back();
        ContactMotion& motion = coupled.motions.emplace_back();
        motion.carrier = carrier.id = id;
        for (size_t i = 0; i < previous_carriers_.size(); ++i) {
            if (previous_carriers_[i].id != id) continue;
            carrier = std::move(previous_carriers_[i]);
            motion = previous_motions_[i];
            if (!is_same_object(carrier.body, body)) carrier.link_rows.reset();
        }
        carrier.body = body;
    }
}

void ContactCoupling::update_motions(CoupledBody& coupled, std::span<const ContactVoxel> voxels,
                                     double duration_s) const {
    for (size_t i = 0; i < coupled.carriers.size(); ++i) {
        const int id = coupled.carriers[i].id;
        const bool is_new = std::none_of(previous_motions_.begin(), previous_motions_.end(),
                                         [id](const ContactMotion& m) { return m.carrier == id; });
        const bool is_solved = !is_given(coupled.body);
        const bool is_averaged = is_solved && !is_new && !coupled.body.is_asleep;
        const BodyMotion* under = id >= 0 ? &coupled.carriers[i].body.motion : nullptr;
        coupled.motions[i].advance(coupled.body.motion, under, voxels, duration_s,
                                   {is_solved, is_averaged, soil_->voxel_m}, &threads_);
    }
}

/// Bullet wakes all rigid bodies of an island together. It wakes no body that rests on a driven
/// body, and no multibody. This function does.
void ContactCoupling::keep_awake_with_carriers(CoupledBody& coupled) {
    if (coupled.patches.empty()) return;
    const bool is_link = coupled.body.role == BodyRole::link;
    for (Carrier& carrier : coupled.carriers) {
        if (carrier.id < 0) continue;
        const BodyMotion& motion = carrier.body.motion;
        const bool moves = length(motion.linear_velocity_m_s) > kContactMotion.driven_rest_m_s ||
                           length(motion.angular_velocity_rad_s) > kContactMotion.driven_rest_m_s;
        if (!carrier.feels()) {
            if (moves && coupled.body.is_asleep) wake_object(world_, coupled.body);
        } else if ((is_link || carrier.is_link()) && carrier.body.is_asleep &&
                   is_in_world(world_, coupled.body) &&
                   coupled.body.object->getActivationState() == ACTIVE_TAG) {
            wake_object(world_, carrier.body);
        }
    }
}

/// A body's elements are a voxel apart, so its lowest point may lie below the deepest element, by
/// at most a voxel. A point further down belongs to a part of the body that is beside the soil.
double ContactCoupling::sinkage_m(const BodyState& body, const BodyContact& contact) const {
    if (!(contact.depth_m > 0) || !body.object) return contact.depth_m;
    const std::optional<double> lowest_m = lowest_height_m(
        *body.object->getCollisionShape(), body.object->getWorldTransform(), soil_->up);
    if (!lowest_m) return contact.depth_m;
    return contact.depth_m + std::clamp(contact.deepest_height_m - *lowest_m, 0.0, soil_->voxel_m);
}

void ContactCoupling::act(const BodyWork& work) {
    CoupledBody& coupled = *work.coupled;
    const BodyContact& contact = work.contact;
    known_.set_width(coupled.body.id, contact.width_m);
    if (is_given(coupled.body)) {
        coupled.report.force_n = contact.mobilized_force_n;
        coupled.report.torque_n_m = contact.mobilized_torque_n_m;
        coupled.pressed.clear();
        known_.set_pressure(coupled.body.id, contact.mobilized_pressure_pa);
        coupled.report.peak_force_n =
            std::max(coupled.report.peak_force_n, length(contact.mobilized_force_n));
        return;
    }
    if (coupled.body.role == BodyRole::wheel) {
        set_wheel_patches(coupled, work.found);
        return;
    }
    if (stays_held(work)) return;
    replace_patches(coupled, work.found.patches());
    const std::span<const PatchElement> elements = work.found.patch_elements();
    coupled.elements.assign(elements.begin(), elements.end());
}

void ContactCoupling::replace_patches(CoupledBody& coupled, std::span<const ContactPatch> patches) {
    note_found(coupled);
    previous_patches_.swap(coupled.patches);
    coupled.patches.clear();
    coupled.elements.clear();
    new_places_.clear();
    const Vec3 center_m = coupled.body.motion.center_of_mass_m;
    for (const ContactPatch& p : patches) {
        CoupledPatch& next = coupled.patches.emplace_back();
        next.patch = p;
        next.offset_m = p.point_m - center_m;
        next.shear_offset_m = p.shear_point_m - center_m;
        if (p.carrier >= 0) {
            const Vec3 under_m = coupled.carrier_of(next).body.motion.center_of_mass_m;
            next.carrier_offset_m = p.point_m - under_m;
            next.carrier_shear_offset_m = p.shear_point_m - under_m;
        }
        // A patch without a predecessor is a new contact, and the soil there yields.
        next.friction_normal_n = p.normal_limit_n;
        new_places_.push_back(next);
    }
    old_places_.assign(previous_patches_.begin(), previous_patches_.end());
    const std::span<const PatchHeir> heirs = patch_heirs_.find(old_places_, new_places_);
    for (size_t i = 0; i < coupled.patches.size(); ++i) {
        if (heirs[i].old < 0) continue;
        CoupledPatch& next = coupled.patches[i];
        const CoupledPatch& old = previous_patches_[static_cast<size_t>(heirs[i].old)];
        next.friction_normal_n = heirs[i].limit_share * old.friction_normal_n;
        next.applied_force_n = heirs[i].force_share * old.applied_force_n;
        next.drift_m = old.drift_m;
    }
}

void ContactCoupling::set_patches(const BodyState& body, const BodyMotion& direction,
                                  std::span<const ContactPatch> patches) {
    CoupledBody& coupled = coupled_[body.id];
    coupled.body = body;
    update_carriers(coupled, {});
    ContactMotion& on_ground = coupled.motions.front();
    on_ground.motion = body.motion;
    on_ground.direction = direction;
    on_ground.linear_m_s = body.motion.linear_velocity_m_s;
    on_ground.angular_rad_s = body.motion.angular_velocity_rad_s;
    replace_patches(coupled, patches);
}

const ContactLaw& ContactCoupling::law_for(const BodyState& body) {
    CoupledBody& coupled = coupled_[body.id];
    coupled.body = body;
    update_law(coupled);
    return *coupled.law;
}

void ContactCoupling::wake_if_changed(CoupledBody& coupled) {
    const BodyState& body = coupled.body;
    if (body.role != BodyRole::rigid && body.role != BodyRole::link) return;
    if (!body.is_asleep) {
        coupled.asleep_step_count = 0;
        return;
    }
    const std::array<double, kNormalBinCount>& limits_n = coupled.limits_n;
    const int count = coupled.asleep_step_count =
        std::min(coupled.asleep_step_count, kCoupling.wake_steps) + 1;
    // In the first step its contact is still found as that of a body in motion.
    const int mean_count = std::clamp(count - 1, 1, kCoupling.wake_steps);
    for (int bin = 0; bin < kNormalBinCount; ++bin) {
        double& mean_n = coupled.mean_limits_n[bin];
        if (mean_count == 1) mean_n = 0;
        mean_n += (limits_n[bin] - mean_n) / mean_count;
    }
    if (count <= kCoupling.wake_steps) {
        coupled.limits_at_sleep_n = coupled.mean_limits_n;
        return;
    }
    double change_n = 0, sum_n = 0;
    for (int bin = 0; bin < kNormalBinCount; ++bin) {
        change_n += std::abs(coupled.mean_limits_n[bin] - coupled.limits_at_sleep_n[bin]);
        sum_n += coupled.limits_at_sleep_n[bin];
    }
    if (change_n <= wake_limit_fraction_ * sum_n + wake_weight_fraction_ * body.weight_n) return;
    wake(coupled);
}

std::span<const ContactPatch> ContactCoupling::wheel_patches(int body_id) const {
    const auto found = coupled_.find(body_id);
    if (found == coupled_.end()) return {};
    return found->second.wheel_patches;
}

void ContactCoupling::set_wheel_forces(int body_id, std::span<const double> normal_n) {
    const auto found = coupled_.find(body_id);
    if (found == coupled_.end()) return;
    const CoupledBody& coupled = found->second;
    MeanPressure pressure;
    for (size_t i = 0; i < std::min(normal_n.size(), coupled.wheel_patches.size()); ++i) {
        pressure.add_force(normal_n[i], coupled.wheel_patches[i].area_m2);
    }
    known_.set_pressure(body_id, pressure.pa());
}

BodyReport ContactCoupling::report(int body_id) const {
    const auto found = coupled_.find(body_id);
    BodyReport out = found == coupled_.end() ? BodyReport{} : found->second.report;
    for (const auto& [id, coupled] : coupled_) {
        for (const PressedBody& pressed : coupled.pressed) {
            if (pressed.id == body_id) out.through_load_n += pressed.force_n;
        }
    }
    return out;
}

}  // namespace bsoil::bullet
