#include "contact_coupling.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "bullet_types.h"
#include "lowest_point.h"

namespace bsoil::bullet {
namespace {

/// A tangential force below this fraction of the normal limit gives no direction to the tangential
/// rows.
constexpr double kNoDirectionFraction = 1e-6;
/// A row that gives this part of its limit has yielded: the solver clamps in single precision.
constexpr double kYieldedFraction = 0.999;
/// A patch slides when it goes this share of the way that its body goes.
constexpr double kSliding = 0.01;
/// And when it gives this part of its friction against that way.
constexpr double kMostlyYielded = 0.95;
/// Part of its limit that it may then give across it, at least: a body pushed aside turns that
/// fast.
constexpr double kAcross = 0.1;
/// More drift than this is not the solver's remainder but the contact's own motion.
constexpr double kDriftMaxM = 0.01;
/// Part of last substep's force that is given as a preload. The whole of it rings after an impact.
constexpr double kPreloadFraction = 0.85;
/// Time over which a body's motion is averaged, and the speed in voxels a second much below which
/// it rests. Shorter or lower, and a parked machine's jitter picks the direction of yield; longer,
/// and a wheel that starts to slip meets the resistance of rolling.
constexpr double kYieldMemoryS = 0.1;
constexpr double kRestVoxelsPerS = 0.5;
/// A driven body much slower than this rests.
constexpr double kDrivenRestMS = 1e-6;
/// Soil steps over which the limits of a sleeping body are averaged before they are compared. The
/// soil beside it settles for some steps more, and a voxel of it caught between bodies may go to
/// and fro for good.
constexpr int kWakeSteps = 16;
/// Patches whose normals differ by more than this cosine are not the same contact.
constexpr double kSamePatchCosine = 0.5;

Vec3 tangential(Vec3 v, Vec3 normal) { return v - dot(v, normal) * normal; }

/// A unit vector across the normal: along the friction that sticks, else any.
Vec3 along_friction(Vec3 normal, Vec3 friction_n, double limit_n) {
    const double size_n = length(friction_n);
    if (size_n > kNoDirectionFraction * limit_n) return friction_n * (1 / size_n);
    const Vec3 axis = std::abs(normal.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 t = tangential(axis, normal);
    return t * (1 / length(t));
}

/// Takes constraints out of the world, given in the order they were put in. Bullet looks for one
/// from the front and fills its gap with the last: in this order each of them is found right behind
/// the host's, however many there are, and the host's keep theirs.
template <typename Rows, typename Remove>
void take_out(std::vector<Rows*>& rows, const Remove& remove) {
    if (rows.empty()) return;
    remove(rows.front());
    for (size_t i = rows.size(); i-- > 1;) remove(rows[i]);
    rows.clear();
}

}  // namespace

ContactCoupling::ContactCoupling(btDiscreteDynamicsWorld& world, ContactSoil soil,
                                 const SoilActionDef& options, const WorkThreads& threads)
    : world_(world),
      multibody_world_(dynamic_cast<btMultiBodyDynamicsWorld*>(&world)),
      soil_(std::make_shared<const ContactSoil>(std::move(soil))),
      threads_(threads),
      wake_limit_fraction_(options.wake_limit_fraction),
      wake_weight_fraction_(options.wake_weight_fraction) {}

ContactCoupling::~ContactCoupling() = default;

void ContactCoupling::set_contacts(std::span<const BodyState> bodies,
                                   std::span<const ContactVoxel> contacts, double duration_s,
                                   bool are_unchanged) {
    gather_pressed_soil();
    // Contacts that stay stay sorted, by bodies that stay.
    by_id_.clear();
    for (const BodyState& body : bodies) by_id_.push_back(&body);
    std::sort(by_id_.begin(), by_id_.end(),
              [](const BodyState* a, const BodyState* b) { return a->id < b->id; });
    are_unchanged = are_unchanged && contact_count_ == contacts.size();
    sort_by_body(contacts);
    const auto voxels_of = [this](int id) {
        const auto rank = static_cast<size_t>(rank_of(id));
        return std::span(by_body_).subspan(starts_[rank], starts_[rank + 1] - starts_[rank]);
    };
    for (auto& [id, coupled] : coupled_) coupled.seen = false;
    size_t count = 0;
    for (const BodyState& body : bodies) {
        const std::span<const ContactVoxel> voxels = voxels_of(body.id);
        if (voxels.empty() && !coupled_.contains(body.id)) continue;
        if (count == works_.size()) works_.emplace_back();
        prepare(works_[count++], body, voxels, duration_s, are_unchanged);
    }
    const std::span works = std::span(works_).first(count);
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

void ContactCoupling::prepare(BodyWork& work, const BodyState& body,
                              std::span<const ContactVoxel> voxels, double duration_s,
                              bool are_unchanged) {
    Coupled& coupled = coupled_[body.id];
    coupled.seen = true;
    if (coupled.body.role != body.role) {  // the host has turned it kinematic or back
        wake(coupled);
        coupled.rigid_rows.clear();
        coupled.carriers.clear();
        coupled.motions.clear();
        coupled.patches.clear();
    }
    coupled.body = body;
    work.coupled = &coupled;
    work.voxels = voxels;
    const bool is_sleeper =
        body.is_asleep && coupled.asleep_step_count > 0 && !coupled.carriers.empty();
    if (!is_sleeper) {
        work.kind = BodyWork::Kind::moved;
        update_law(coupled);
        update_carriers(coupled, voxels);
        update_motions(coupled, voxels, duration_s);
        return;
    }
    for (Carrier& carrier : coupled.carriers)
        if (const BodyState* state = state_of(carrier.id);
            state && is_same_object(*state, carrier.body))
            carrier.body = *state;
    if (are_unchanged && coupled.has_limits) {
        work.kind = BodyWork::Kind::kept;
        return;
    }
    work.kind = BodyWork::Kind::slept;
    update_law(coupled);
}

void ContactCoupling::find_contact(BodyWork& work, double duration_s) const {
    if (work.kind == BodyWork::Kind::kept) return;
    Coupled& coupled = *work.coupled;
    const ContactLaw& law = *coupled.law;
    std::span<const ContactHistory> history;
    if (work.kind == BodyWork::Kind::slept) {
        history = coupled.memory.recall(work.voxels, law, &threads_);
    } else {
        ContactMemory::near(pressed_soil_, work.voxels, coupled.body.id, law, work.pressed_around);
        history = coupled.memory.advance(work.voxels, coupled.body.motion, law, duration_s,
                                         work.pressed_around, coupled.motions, &threads_);
    }
    work.contact = work.found.find(work.voxels, coupled.motions, law, history, &threads_);
}

/// The soil sorts contacts by voxel; within a body they keep that order.
void ContactCoupling::sort_by_body(std::span<const ContactVoxel> contacts) {
    contact_count_ = contacts.size();
    starts_.assign(by_id_.size() + 1, 0);
    ranks_.resize(contacts.size());
    for (size_t i = 0; i < contacts.size(); ++i) {
        const bool is_same = i > 0 && contacts[i].body == contacts[i - 1].body;
        ranks_[i] = is_same ? ranks_[i - 1] : rank_of(contacts[i].body);
        if (ranks_[i] >= 0) ++starts_[static_cast<size_t>(ranks_[i]) + 1];
    }
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    by_body_.resize(starts_.back());
    next_.assign(starts_.begin(), starts_.end());
    for (size_t i = 0; i < contacts.size(); ++i)
        if (ranks_[i] >= 0) by_body_[next_[static_cast<size_t>(ranks_[i])]++] = contacts[i];
}

void ContactCoupling::gather_pressed_soil() {
    pressed_soil_.clear();
    if (coupled_.size() < 2) return;
    for (const auto& [id, coupled] : coupled_)
        for (const PressedSoil& soil : coupled.memory.soil())
            pressed_soil_.emplace_back(soil).body = id;
    std::stable_sort(pressed_soil_.begin(), pressed_soil_.end(), lies_before);
}

void ContactCoupling::wake(Coupled& coupled) {
    coupled.asleep_step_count = 0;
    wake(coupled.body);
}

void ContactCoupling::wake(const BodyState& body) {
    if (!is_in_world(world_, body)) return;
    if (body.role == BodyRole::link)
        static_cast<btMultiBodyLinkCollider*>(body.object)->m_multiBody->wakeUp();
    body.object->activate();
}

/// A body that the soil does not hold any more must not stay asleep in the air.
void ContactCoupling::let_go() {
    take_rows_out();
    for (auto& [id, coupled] : coupled_) wake(coupled);
    coupled_.clear();
}

void ContactCoupling::update_law(Coupled& coupled) {
    const SurfaceFriction& surface = coupled.body.surface;
    const SurfaceFriction& known = coupled.law_surface;
    if (coupled.law && surface.friction == known.friction &&
        surface.adhesion_pa == known.adhesion_pa)
        return;
    coupled.law = ContactLaw::make(soil_, surface);
    coupled.law_surface = surface;
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

void ContactCoupling::report_contact(const BodyWork& work) {
    Coupled& coupled = *work.coupled;
    coupled.report.contact_area_m2 = work.contact.area_m2;
    coupled.report.sinkage_m = sinkage_m(coupled.body, work.contact);
    coupled.report.compression_m = work.contact.compression_m;
    coupled.report.patch_count = static_cast<int>(work.found.patches().size());
    coupled.has_limits = true;
    coupled.limits_n = {};
    for (const ContactPatch& p : work.found.patches()) coupled.limits_n[p.bin] += p.normal_limit_n;
}

void ContactCoupling::update_carriers(Coupled& coupled, std::span<const ContactVoxel> voxels) {
    carrier_ids_.assign(1, -1);
    for (const ContactVoxel& v : voxels)
        if (v.carrier != carrier_ids_.back()) carrier_ids_.push_back(v.carrier);
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

void ContactCoupling::update_motions(Coupled& coupled, std::span<const ContactVoxel> voxels,
                                     double duration_s) const {
    for (size_t i = 0; i < coupled.carriers.size(); ++i) {
        const int id = coupled.carriers[i].id;
        const bool is_new = std::none_of(previous_motions_.begin(), previous_motions_.end(),
                                         [id](const ContactMotion& m) { return m.carrier == id; });
        update_motion(coupled, coupled.carriers[i], coupled.motions[i], voxels, duration_s, is_new);
    }
}

/// The body's motion as the soil's yield sees it: relative to what carries the soil, as a share of
/// the largest speed of their contact, so that it does not depend on speed, and without what the
/// solver leaves of a body at rest.
void ContactCoupling::update_motion(const Coupled& coupled, const Carrier& carrier,
                                    ContactMotion& motion, std::span<const ContactVoxel> voxels,
                                    double duration_s, bool is_new) const {
    BodyMotion& now = motion.motion = coupled.body.motion;
    if (carrier.id >= 0) {
        const BodyMotion& under = carrier.body.motion;
        now.linear_velocity_m_s = now.linear_velocity_m_s - under.velocity_at(now.center_of_mass_m);
        now.angular_velocity_rad_s = now.angular_velocity_rad_s - under.angular_velocity_rad_s;
    }
    const bool is_solved =
        coupled.body.role != BodyRole::driven && coupled.body.role != BodyRole::fixed;
    // A body that has fallen asleep stands still at once: a limit that still crept would wake it.
    const bool averages = is_solved && !is_new && !coupled.body.is_asleep;
    const double share = averages ? -std::expm1(-duration_s / kYieldMemoryS) : 1;
    motion.linear_m_s += share * (now.linear_velocity_m_s - motion.linear_m_s);
    motion.angular_rad_s += share * (now.angular_velocity_rad_s - motion.angular_rad_s);
    double extent_m = 0;
    for (const ContactVoxel& v : voxels)
        if (v.carrier == carrier.id)
            extent_m = std::max(extent_m, length(v.position_m - now.center_of_mass_m));
    const double speed_m_s = length(motion.linear_m_s) + extent_m * length(motion.angular_rad_s) +
                             (is_solved ? kRestVoxelsPerS * soil_->voxel_m : kDrivenRestMS);
    motion.direction = now;
    motion.direction.linear_velocity_m_s = motion.linear_m_s * (1 / speed_m_s);
    motion.direction.angular_velocity_rad_s = motion.angular_rad_s * (1 / speed_m_s);
}

/// Bullet's islands wake rigid bodies with each other, but neither what rests on a driven body nor
/// a multibody.
void ContactCoupling::keep_awake_with_carriers(Coupled& coupled) {
    if (coupled.patches.empty()) return;
    const bool is_link = coupled.body.role == BodyRole::link;
    for (Carrier& carrier : coupled.carriers) {
        if (carrier.id < 0) continue;
        const BodyMotion& motion = carrier.body.motion;
        const bool moves = length(motion.linear_velocity_m_s) > kDrivenRestMS ||
                           length(motion.angular_velocity_rad_s) > kDrivenRestMS;
        if (!carrier.feels()) {
            if (moves && coupled.body.is_asleep) wake(coupled.body);
        } else if ((is_link || carrier.is_link()) && carrier.body.is_asleep &&
                   is_in_world(world_, coupled.body) &&
                   coupled.body.object->getActivationState() == ACTIVE_TAG) {
            wake(carrier.body);
        }
    }
}

/// Elements sample a body's surface once a voxel: its lowest point may lie between them, below the
/// deepest by no more than a voxel (further down it is not what stands in the soil).
double ContactCoupling::sinkage_m(const BodyState& body, const BodyContact& contact) const {
    if (!(contact.depth_m > 0) || !body.object) return contact.depth_m;
    const std::optional<double> lowest_m = lowest_height_m(
        *body.object->getCollisionShape(), body.object->getWorldTransform(), soil_->up);
    if (!lowest_m) return contact.depth_m;
    return contact.depth_m + std::clamp(contact.deepest_height_m - *lowest_m, 0.0, soil_->voxel_m);
}

void ContactCoupling::act(const BodyWork& work) {
    Coupled& coupled = *work.coupled;
    const BodyContact& contact = work.contact;
    coupled.width_m = contact.width_m;
    if (coupled.body.role == BodyRole::driven || coupled.body.role == BodyRole::fixed) {
        coupled.report.force_n = contact.mobilized_force_n;
        coupled.report.torque_n_m = contact.mobilized_torque_n_m;
        coupled.pressure_pa = contact.mobilized_pressure_pa;
        coupled.report.peak_force_n =
            std::max(coupled.report.peak_force_n, length(contact.mobilized_force_n));
        return;
    }
    if (coupled.body.role == BodyRole::wheel) {
        coupled.wheel_patches.assign(work.found.patches().begin(), work.found.patches().end());
        return;
    }
    take_over_patches(coupled, work.found.patches());
}

void ContactCoupling::set_patches(const BodyState& body, const BodyMotion& direction,
                                  std::span<const ContactPatch> patches) {
    Coupled& coupled = coupled_[body.id];
    coupled.body = body;
    update_carriers(coupled, {});
    ContactMotion& on_ground = coupled.motions.front();
    on_ground.motion = body.motion;
    on_ground.direction = direction;
    on_ground.linear_m_s = body.motion.linear_velocity_m_s;
    on_ground.angular_rad_s = body.motion.angular_velocity_rad_s;
    take_over_patches(coupled, patches);
}

const ContactLaw& ContactCoupling::law_for(const BodyState& body) {
    Coupled& coupled = coupled_[body.id];
    coupled.body = body;
    update_law(coupled);
    return *coupled.law;
}

void ContactCoupling::as_direction(BodyMotion& motion, double extent_m) const {
    const double speed_m_s = length(motion.linear_velocity_m_s) +
                             extent_m * length(motion.angular_velocity_rad_s) +
                             kRestVoxelsPerS * soil_->voxel_m;
    motion.linear_velocity_m_s = motion.linear_velocity_m_s * (1 / speed_m_s);
    motion.angular_velocity_rad_s = motion.angular_velocity_rad_s * (1 / speed_m_s);
}

/// A new patch takes over how much of its limit the nearest old one was using. Patches are numbered
/// in the body's frame, so on a spinning wheel the number says nothing about the place. Where
/// several have the same nearest one they share its force: taken over by each it would throw the
/// body up.
void ContactCoupling::take_over_patches(Coupled& coupled, std::span<const ContactPatch> patches) {
    previous_.swap(coupled.patches);
    coupled.patches.clear();
    double extent_m = 0;
    for (const ContactPatch& p : patches)
        extent_m = std::max(extent_m, length(p.point_m - coupled.body.motion.center_of_mass_m));
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
        next.friction_normal_n =
            p.normal_limit_n;  // where there was none: it yields while it comes in
        int nearest = -1;
        double least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < previous_.size(); ++i) {
            const CoupledPatch& old = previous_[i];
            const double cosine = dot(old.patch.normal, p.normal);
            const Vec3 apart = old.offset_m - next.offset_m;
            const double distance = dot(apart, apart) + (1 - cosine) * extent_m * extent_m;
            if (cosine < kSamePatchCosine || distance >= least || old.patch.carrier != p.carrier)
                continue;
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

void ContactCoupling::wake_if_changed(Coupled& coupled) {
    const BodyState& body = coupled.body;
    if (body.role != BodyRole::rigid && body.role != BodyRole::link) return;
    if (!body.is_asleep) {
        coupled.asleep_step_count = 0;
        return;
    }
    const std::array<double, kNormalBinCount>& limits_n = coupled.limits_n;
    const int count = coupled.asleep_step_count =
        std::min(coupled.asleep_step_count, kWakeSteps) + 1;
    for (int bin = 0; bin < kNormalBinCount; ++bin) {
        double& mean_n = coupled.mean_limits_n[bin];
        if (count == 1) mean_n = 0;
        mean_n += (limits_n[bin] - mean_n) / std::min(count, kWakeSteps);
    }
    if (count <= kWakeSteps) {
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

/// The limits of two rows make a box where Coulomb's make a circle. A patch that slides has its
/// first row along the sliding and little of the second: patches of a wheel whose rows no motion of
/// the wheel satisfies all at once would brace against each other across it, with up to half as
/// much again as their friction.
ContactCoupling::TangentialRows ContactCoupling::tangential_rows(const ContactMotion& motion,
                                                                 const CoupledPatch& patch) {
    const ContactPatch& p = patch.patch;
    const Vec3 friction_n = tangential(patch.applied_force_n, p.normal);
    const double limit_n = patch.shear_limit_n();
    const Vec3 slide = tangential(motion.direction.velocity_at(p.shear_point_m), p.normal);
    const double sliding = length(slide);
    if (sliding <= kSliding || -dot(friction_n, slide) <= kMostlyYielded * limit_n * sliding)
        return {along_friction(p.normal, friction_n, limit_n), 1};
    const Vec3 first = slide * (1 / sliding);
    const Vec3 now = tangential(motion.motion.velocity_at(p.shear_point_m), p.normal);
    const double speed = length(now);
    const double aside = length(now - dot(now, first) * first);
    return {first, speed > 0 ? std::clamp(aside / speed, kAcross, 1.0) : 1};
}

PatchRow ContactCoupling::row_of(const Coupled& coupled, const CoupledPatch& patch) const {
    const ContactPatch& p = patch.patch;
    const double limit_n = patch.shear_limit_n();
    const auto [t, across] = tangential_rows(motion_for(coupled.motions, p.carrier), patch);
    const Carrier& carrier = coupled.carrier_of(patch);
    const bool is_driven = p.carrier >= 0 && !carrier.feels();
    PatchRow row;
    row.drift_m = to_bullet(patch.drift_m);
    const Vec3 directions[PatchRow::kCount] = {-p.normal, t, cross(p.normal, t)};
    for (int i = 0; i < PatchRow::kCount; ++i) {
        const double most_n = i == 0 ? p.normal_limit_n : i == 1 ? limit_n : across * limit_n;
        const double least_n = i == 0 ? 0 : -most_n;
        const double preload_n = dot(patch.preload_n, directions[i]);
        row.direction[i] = to_bullet(directions[i]);
        row.offset_m[i] = to_bullet(i == 0 ? patch.offset_m : patch.shear_offset_m);
        row.carrier_offset_m[i] =
            to_bullet(i == 0 ? patch.carrier_offset_m : patch.carrier_shear_offset_m);
        if (is_driven)
            row.carrier_velocity_m_s[i] = static_cast<btScalar>(
                dot(carrier.body.motion.velocity_at(i == 0 ? p.point_m : p.shear_point_m),
                    directions[i]));
        row.lower_n[i] = static_cast<btScalar>(least_n - preload_n);
        row.upper_n[i] = static_cast<btScalar>(most_n - preload_n);
    }
    return row;
}

/// Bodies that move count as touching where their boxes overlap: a contact that rocks comes and
/// goes. Static ground may lie anywhere below.
void ContactCoupling::find_touched() {
    touched_.clear();
    btDispatcher& dispatcher = *world_.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
        if (manifold.getNumContacts() == 0 && (a->isStaticObject() || b->isStaticObject()))
            continue;
        touched_.push_back(a);
        touched_.push_back(b);
    }
    std::sort(touched_.begin(), touched_.end(), std::less<>());
}

bool ContactCoupling::is_touched(const btCollisionObject* object) const {
    return std::binary_search(touched_.begin(), touched_.end(), object, std::less<>());
}

/// Gives last substep's forces to the body before the solve, within this substep's limits, and
/// their opposites to the carrier; the rows then find the change. Bullet starts its joints from
/// nothing, and ten iterations from there do not reach a heavy chassis through light wheels.
/// Friction with other bodies sees a torque only as a row.
void ContactCoupling::preload(Coupled& coupled) {
    btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
    coupled.is_touched = is_touched(&body);
    for (Carrier& carrier : coupled.carriers)
        carrier.is_touched = carrier.is_rigid() && is_touched(carrier.body.object);
    Vec3 torque_n_m;
    for (CoupledPatch& patch : coupled.patches) {
        patch.preload_n = {};
        const Carrier& carrier = coupled.carrier_of(patch);
        if (!body.isActive() || carrier.is_link()) continue;
        if (carrier.is_rigid() && !carrier.body.object->isActive()) continue;
        const ContactPatch& p = patch.patch;
        const double normal_n =
            std::clamp(-dot(patch.applied_force_n, p.normal), 0.0, p.normal_limit_n);
        Vec3 along = tangential(patch.applied_force_n, p.normal);
        const double most_n = patch.shear_limit_n();
        if (length(along) > most_n) along = along * (most_n / length(along));
        patch.preload_n = kPreloadFraction * (along - normal_n * p.normal);
        apply_preload(coupled, patch, 1);
        torque_n_m += patch.torque_n_m(patch.preload_n);
        if (carrier.is_touched)
            add_preload_torque(carrier.body, patch.carrier_torque_n_m(patch.preload_n));
    }
    if (coupled.is_touched) add_preload_torque(coupled.body, torque_n_m);
}

void ContactCoupling::add_preload_torque(const BodyState& body, Vec3 torque_n_m) {
    PreloadTorque& sum = preload_torques_[body.id];
    auto* rigid = static_cast<btRigidBody*>(body.object);
    if (!sum.row || sum.body != rigid) {
        sum.body = rigid;
        sum.row = std::make_unique<TorqueConstraint>(*rigid);
    }
    if (!sum.is_used) sum.torque_n_m = {};
    sum.is_used = true;
    sum.torque_n_m += torque_n_m;
}

void ContactCoupling::put_in_preload_torque(PreloadTorque& torque) {
    if (!torque.is_used || torque.is_in) return;
    torque.is_in = true;
    torque.row->torque_n_m = to_bullet(torque.torque_n_m);
    world_.addConstraint(torque.row.get());
    rigid_rows_in_.push_back(torque.row.get());
}

void ContactCoupling::apply_preload(Coupled& coupled, const CoupledPatch& patch, double sign) {
    btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
    const Vec3 force_n = sign * patch.preload_n;
    body.applyCentralForce(to_bullet(force_n));
    if (!coupled.is_touched) body.applyTorque(to_bullet(patch.torque_n_m(force_n)));
    const Carrier& carrier = coupled.carrier_of(patch);
    if (!carrier.is_rigid()) return;
    btRigidBody& under = *static_cast<btRigidBody*>(carrier.body.object);
    under.applyCentralForce(to_bullet(-1.0 * force_n));
    if (!carrier.is_touched) under.applyTorque(to_bullet(patch.carrier_torque_n_m(force_n)));
}

void ContactCoupling::open_substep() {
    take_rows_out();
    find_touched();
    for (auto& [id, coupled] : coupled_) {
        const bool feels =
            coupled.body.role == BodyRole::rigid || coupled.body.role == BodyRole::link;
        // Only now: what held it in the last substep its report has said until here.
        if (coupled.patches.empty() && feels)
            coupled.report.force_n = coupled.report.torque_n_m = {};
        if (coupled.patches.empty() || !is_in_world(world_, coupled.body)) continue;
        // Until the soil has stepped without it, soil on a body that has gone stands where it was.
        for (Carrier& carrier : coupled.carriers) {
            if (!carrier.feels() || is_in_world(world_, carrier.body)) continue;
            carrier.body = {};
            carrier.link_rows.reset();
        }
        opened_.push_back(id);
        if (coupled.body.role == BodyRole::rigid) preload(coupled);
    }
    for (const int id : opened_) open(coupled_.at(id));
    for (auto it = preload_torques_.begin(); it != preload_torques_.end();) {
        put_in_preload_torque(it->second);
        it = it->second.is_used ? std::next(it) : preload_torques_.erase(it);
    }
}

void ContactCoupling::open(Coupled& coupled) {
    coupled.pose_at_open = from_bullet(coupled.body.object->getWorldTransform());
    for (Carrier& carrier : coupled.carriers)
        if (carrier.feels())
            carrier.pose_at_open = from_bullet(carrier.body.object->getWorldTransform());
    if (const auto torque = preload_torques_.find(coupled.body.id);
        torque != preload_torques_.end())
        put_in_preload_torque(torque->second);
    for (size_t i = 0; i < coupled.patches.size(); ++i)
        if (!coupled.is_link_row(coupled.patches[i])) open_rigid_row(coupled, i);
    for (Carrier& carrier : coupled.carriers) open_link_rows(coupled, carrier);
}

void ContactCoupling::open_rigid_row(Coupled& coupled, size_t index) {
    const CoupledPatch& patch = coupled.patches[index];
    const Carrier& carrier = coupled.carrier_of(patch);
    auto* under = carrier.is_rigid() ? static_cast<btRigidBody*>(carrier.body.object) : nullptr;
    if (index >= coupled.rigid_rows.size()) coupled.rigid_rows.resize(index + 1);
    std::unique_ptr<RigidPatchConstraint>& rows = coupled.rigid_rows[index];
    if (!rows || !rows->acts_on(under))
        rows = std::make_unique<RigidPatchConstraint>(
            *static_cast<btRigidBody*>(coupled.body.object), under);
    rows->set(row_of(coupled, patch));
    world_.addConstraint(rows.get());
    rigid_rows_in_.push_back(rows.get());
}

void ContactCoupling::open_link_rows(Coupled& coupled, Carrier& carrier) {
    bool is_any = false;
    for (const CoupledPatch& patch : coupled.patches) {
        if (patch.patch.carrier != carrier.id || !coupled.is_link_row(patch)) continue;
        if (!carrier.link_rows)
            carrier.link_rows = std::make_unique<LinkPatchConstraint>(
                *coupled.body.object, carrier.feels() ? carrier.body.object : nullptr);
        if (!is_any) carrier.link_rows->clear();
        carrier.link_rows->add(row_of(coupled, patch));
        is_any = true;
    }
    if (!is_any) return;
    multibody_world_->addMultiBodyConstraint(carrier.link_rows.get());
    link_rows_in_.push_back(carrier.link_rows.get());
}

void ContactCoupling::take_rows_out() {
    for (const int id : opened_) {
        Coupled& coupled = coupled_.at(id);
        if (coupled.body.role != BodyRole::rigid) continue;
        for (const CoupledPatch& patch : coupled.patches) apply_preload(coupled, patch, -1);
    }
    opened_.clear();
    for (auto& [id, torque] : preload_torques_) torque.is_used = torque.is_in = false;
    take_out(rigid_rows_in_, [this](auto* rows) { world_.removeConstraint(rows); });
    take_out(link_rows_in_,
             [this](auto* rows) { multibody_world_->removeMultiBodyConstraint(rows); });
}

void ContactCoupling::close_substep(btScalar substep_s) {
    for (const int id : opened_) {
        Coupled& coupled = coupled_.at(id);
        Vec3 torque;
        // Not solved: asleep. What held it when it fell asleep still does.
        if (!read_forces(coupled, substep_s, torque)) continue;
        Vec3 force;
        for (const CoupledPatch& patch : coupled.patches) force += patch.applied_force_n;
        coupled.report.force_n = force;
        coupled.report.torque_n_m = torque;
        coupled.report.peak_force_n = std::max(coupled.report.peak_force_n, length(force));
        add_drift(coupled, static_cast<double>(substep_s));
        double normal_n = 0, squares = 0;
        for (CoupledPatch& patch : coupled.patches) {
            patch.friction_normal_n =
                std::max(0.0, -dot(patch.applied_force_n, patch.patch.normal));
            normal_n += patch.friction_normal_n;
            squares += patch.friction_normal_n * patch.friction_normal_n / patch.patch.area_m2;
        }
        coupled.pressure_pa = normal_n > 0 ? squares / normal_n : 0;
    }
    take_rows_out();
}

bool ContactCoupling::read_forces(Coupled& coupled, btScalar substep_s, Vec3& torque_n_m) {
    for (const CoupledPatch& patch : coupled.patches)
        if (coupled.is_link_row(patch)) {
            if (!coupled.carrier_of(patch).link_rows->is_solved()) return false;
        } else if (!coupled.rigid_rows[&patch - coupled.patches.data()]->is_solved()) {
            return false;
        }
    int in_carrier = 0;
    for (size_t i = 0; i < coupled.patches.size(); ++i) {
        CoupledPatch& patch = coupled.patches[i];
        const bool is_first = i == 0 || coupled.patches[i - 1].patch.carrier != patch.patch.carrier;
        in_carrier = is_first ? 0 : in_carrier + 1;
        if (coupled.is_link_row(patch)) {
            patch.applied_force_n = from_bullet(
                coupled.carrier_of(patch).link_rows->applied_force_n(in_carrier, substep_s));
        } else {
            patch.applied_force_n =
                patch.preload_n + from_bullet(coupled.rigid_rows[i]->applied_force_n());
        }
        torque_n_m += patch.torque_n_m(patch.applied_force_n);
    }
    return true;
}

Vec3 ContactCoupling::Carrier::motion_in(double substep_s, Vec3 offset_m) const {
    if (!feels())
        return substep_s * body.motion.velocity_at(body.motion.center_of_mass_m + offset_m);
    const Pose pose = from_bullet(body.object->getWorldTransform());
    const Quat turn = pose.rotation * conjugate(pose_at_open.rotation);
    return pose.position - pose_at_open.position + rotate(turn, offset_m) - offset_m;
}

/// Adds this substep's motion to the drift of each patch that did not yield.
void ContactCoupling::add_drift(Coupled& coupled, double substep_s) {
    const Pose pose = from_bullet(coupled.body.object->getWorldTransform());
    const Quat turn = pose.rotation * conjugate(coupled.pose_at_open.rotation);
    for (CoupledPatch& patch : coupled.patches) {
        const Vec3 n = patch.patch.normal;
        const Vec3 shift = pose.position - coupled.pose_at_open.position;
        Vec3 moved = shift + rotate(turn, patch.offset_m) - patch.offset_m;
        Vec3 sheared = shift + rotate(turn, patch.shear_offset_m) - patch.shear_offset_m;
        if (patch.patch.carrier >= 0) {
            const Carrier& carrier = coupled.carrier_of(patch);
            moved = moved - carrier.motion_in(substep_s, patch.carrier_offset_m);
            sheared = sheared - carrier.motion_in(substep_s, patch.carrier_shear_offset_m);
        }
        double into = dot(patch.drift_m, n);
        const double approach = dot(moved, n);
        const double normal_n = -dot(patch.applied_force_n, n);
        if (approach < 0 || normal_n < kYieldedFraction * patch.patch.normal_limit_n)
            into = std::clamp(into + approach, 0.0, kDriftMaxM);
        const bool slides = length(tangential(patch.applied_force_n, n)) >=
                            kYieldedFraction * patch.shear_limit_n();
        Vec3 along = slides ? Vec3{} : tangential(patch.drift_m, n) + tangential(sheared, n);
        if (length(along) > kDriftMaxM) along = along * (kDriftMaxM / length(along));
        patch.drift_m = into * n + along;
    }
}

std::span<const ContactPatch> ContactCoupling::wheel_patches(int body_id) const {
    const auto found = coupled_.find(body_id);
    if (found == coupled_.end()) return {};
    return found->second.wheel_patches;
}

void ContactCoupling::set_wheel_forces(int body_id, std::span<const double> normal_n) {
    const auto found = coupled_.find(body_id);
    if (found == coupled_.end()) return;
    Coupled& coupled = found->second;
    double sum_n = 0, squares = 0;
    for (size_t i = 0; i < std::min(normal_n.size(), coupled.wheel_patches.size()); ++i) {
        sum_n += normal_n[i];
        squares += normal_n[i] * normal_n[i] / coupled.wheel_patches[i].area_m2;
    }
    coupled.pressure_pa = sum_n > 0 ? squares / sum_n : 0;
}

double ContactCoupling::contact_pressure_pa(int body_id) const {
    const auto found = coupled_.find(body_id);
    return found == coupled_.end() ? 0 : found->second.pressure_pa;
}

double ContactCoupling::contact_width_m(int body_id) const {
    const auto found = coupled_.find(body_id);
    return found == coupled_.end() ? 0 : found->second.width_m;
}

BodyReport ContactCoupling::report(int body_id) const {
    const auto found = coupled_.find(body_id);
    return found == coupled_.end() ? BodyReport{} : found->second.report;
}

}  // namespace bsoil::bullet
