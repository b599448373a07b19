#include "contact_coupling.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bullet_types.h"

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

ContactCoupling::ContactCoupling(btDiscreteDynamicsWorld& world, CoupledSoil soil,
                                 const SoilActionDef& options)
    : world_(world),
      multibody_world_(dynamic_cast<btMultiBodyDynamicsWorld*>(&world)),
      soil_(std::move(soil)),
      wake_limit_fraction_(options.wake_limit_fraction),
      wake_weight_fraction_(options.wake_weight_fraction) {}

ContactCoupling::~ContactCoupling() = default;

void ContactCoupling::set_contacts(std::span<const BodyState> bodies,
                                   std::span<const ContactVoxel> contacts, double duration_s) {
    // The soil sorts contacts by voxel; a stable sort by body keeps that order within a body.
    by_body_.assign(contacts.begin(), contacts.end());
    std::stable_sort(by_body_.begin(), by_body_.end(),
                     [](const ContactVoxel& a, const ContactVoxel& b) { return a.body < b.body; });
    const auto voxels_of = [this](int id) {
        const auto first = std::partition_point(
            by_body_.begin(), by_body_.end(), [id](const ContactVoxel& v) { return v.body < id; });
        const auto last = std::partition_point(
            first, by_body_.end(), [id](const ContactVoxel& v) { return v.body == id; });
        return std::span<const ContactVoxel>(first, last);
    };

    gather_pressed_soil();
    for (auto& [id, coupled] : coupled_) coupled.seen = false;
    for (const BodyState& body : bodies) {
        const std::span<const ContactVoxel> voxels = voxels_of(body.id);
        if (voxels.empty() && !coupled_.contains(body.id)) continue;
        Coupled& coupled = coupled_[body.id];
        coupled.seen = true;
        if (coupled.body.role != body.role) {  // the host has turned it kinematic or back
            wake(coupled);
            coupled.rigid_rows.clear();
            coupled.preload_torque.reset();
            coupled.link_rows.reset();
            coupled.patches.clear();
        }
        coupled.body = body;
        set_body_contacts(coupled, voxels, duration_s);
        wake_if_changed(coupled);
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

void ContactCoupling::gather_pressed_soil() {
    pressed_soil_.clear();
    if (coupled_.size() < 2) return;
    for (const auto& [id, coupled] : coupled_)
        for (const PressedSoil& soil : coupled.memory.soil())
            pressed_soil_.emplace_back(soil).body = id;
    std::stable_sort(pressed_soil_.begin(), pressed_soil_.end(), lies_before);
}

void ContactCoupling::wake(Coupled& coupled) {
    const BodyState& body = coupled.body;
    coupled.asleep_step_count = 0;
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

void ContactCoupling::update_strengths(Coupled& coupled) {
    const SurfaceFriction& surface = coupled.body.surface;
    const SurfaceFriction& known = coupled.strengths_surface;
    if (coupled.strengths.size() == soil_.materials.size() && surface.friction == known.friction &&
        surface.adhesion_pa == known.adhesion_pa)
        return;
    coupled.strengths.clear();
    for (const MaterialDef& material : soil_.materials)
        coupled.strengths.push_back(strength_of(material, soil_.gravity_m_s2, surface));
    coupled.strengths_surface = surface;
}

/// The body's motion as the soil's yield sees it: as a share of the largest speed of its contact,
/// so that it does not depend on speed, and without what the solver leaves of a body at rest.
BodyMotion ContactCoupling::yield_direction(Coupled& coupled, std::span<const ContactVoxel> voxels,
                                            double duration_s) {
    const BodyMotion& now = coupled.body.motion;
    const bool is_solved =
        coupled.body.role != BodyRole::driven && coupled.body.role != BodyRole::fixed;
    // A body that has fallen asleep stands still at once: a limit that still crept would wake it.
    const bool averages = is_solved && coupled.has_motion && !coupled.body.is_asleep;
    const double share = averages ? -std::expm1(-duration_s / kYieldMemoryS) : 1;
    coupled.has_motion = true;
    coupled.linear_m_s += share * (now.linear_velocity_m_s - coupled.linear_m_s);
    coupled.angular_rad_s += share * (now.angular_velocity_rad_s - coupled.angular_rad_s);
    double extent_m = 0;
    for (const ContactVoxel& v : voxels)
        extent_m = std::max(extent_m, length(v.position_m - now.center_of_mass_m));
    const double speed_m_s = length(coupled.linear_m_s) + extent_m * length(coupled.angular_rad_s) +
                             (is_solved ? kRestVoxelsPerS * soil_.voxel_m : kDrivenRestMS);
    BodyMotion direction = now;
    direction.linear_velocity_m_s = coupled.linear_m_s * (1 / speed_m_s);
    direction.angular_velocity_rad_s = coupled.angular_rad_s * (1 / speed_m_s);
    return direction;
}

void ContactCoupling::set_body_contacts(Coupled& coupled, std::span<const ContactVoxel> voxels,
                                        double duration_s) {
    const BodyMotion& motion = coupled.body.motion;
    update_strengths(coupled);
    coupled.direction = yield_direction(coupled, voxels, duration_s);
    ContactMemory::near(pressed_soil_, voxels, coupled.body.id, soil_.voxel_m, pressed_around_);
    const std::span<const ContactHistory> history = coupled.memory.advance(
        voxels, motion, soil_.up, soil_.voxel_m, duration_s, pressed_around_);
    const BodyContact contact = group_contacts(voxels, motion, coupled.direction, soil_.up,
                                               soil_.voxel_m, coupled.strengths, history, patches_);
    coupled.width_m = contact.width_m;
    coupled.report.contact_area_m2 = contact.area_m2;
    coupled.report.sinkage_m = contact.depth_m;
    coupled.report.compression_m = contact.compression_m;
    coupled.report.patch_count = static_cast<int>(patches_.size());
    if (coupled.body.role == BodyRole::driven || coupled.body.role == BodyRole::fixed) {
        coupled.report.force_n = contact.mobilized_force_n;
        coupled.report.torque_n_m = contact.mobilized_torque_n_m;
        coupled.pressure_pa = contact.mobilized_pressure_pa;
        coupled.report.peak_force_n =
            std::max(coupled.report.peak_force_n, length(contact.mobilized_force_n));
        return;
    }
    if (coupled.body.role == BodyRole::wheel) {
        coupled.wheel_patches = patches_;
        return;
    }
    if (patches_.empty()) coupled.report.force_n = coupled.report.torque_n_m = {};

    take_over_patches(coupled);
}

/// A new patch takes over how much of its limit the nearest old one was using. Patches are numbered
/// in the body's frame, so on a spinning wheel the number says nothing about the place. Where
/// several have the same nearest one they share its force: taken over by each it would throw the
/// body up.
void ContactCoupling::take_over_patches(Coupled& coupled) {
    previous_.swap(coupled.patches);
    coupled.patches.clear();
    double extent_m = 0;
    for (const ContactPatch& p : patches_)
        extent_m = std::max(extent_m, length(p.point_m - coupled.body.motion.center_of_mass_m));
    heirs_.assign(previous_.size(), 0);
    nearest_.clear();
    for (const ContactPatch& p : patches_) {
        CoupledPatch next;
        next.patch = p;
        next.offset_m = p.point_m - coupled.body.motion.center_of_mass_m;
        next.shear_offset_m = p.shear_point_m - coupled.body.motion.center_of_mass_m;
        next.friction_normal_n =
            p.normal_limit_n;  // where there was none: it yields while it comes in
        int nearest = -1;
        double least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < previous_.size(); ++i) {
            const CoupledPatch& old = previous_[i];
            const double cosine = dot(old.patch.normal, p.normal);
            const Vec3 apart = old.offset_m - next.offset_m;
            const double distance = dot(apart, apart) + (1 - cosine) * extent_m * extent_m;
            if (cosine < kSamePatchCosine || distance >= least) continue;
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
    std::array<double, kNormalBinCount> limits_n{};
    for (const CoupledPatch& p : coupled.patches) limits_n[p.patch.bin] += p.patch.normal_limit_n;
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
ContactCoupling::TangentialRows ContactCoupling::tangential_rows(const Coupled& coupled,
                                                                 const CoupledPatch& patch) {
    const ContactPatch& p = patch.patch;
    const Vec3 friction_n = tangential(patch.applied_force_n, p.normal);
    const double limit_n = patch.shear_limit_n();
    const Vec3 slide = tangential(coupled.direction.velocity_at(p.shear_point_m), p.normal);
    const double sliding = length(slide);
    if (sliding <= kSliding || -dot(friction_n, slide) <= kMostlyYielded * limit_n * sliding)
        return {along_friction(p.normal, friction_n, limit_n), 1};
    const Vec3 first = slide * (1 / sliding);
    const Vec3 now = tangential(coupled.body.motion.velocity_at(p.shear_point_m), p.normal);
    const double speed = length(now);
    const double aside = length(now - dot(now, first) * first);
    return {first, speed > 0 ? std::clamp(aside / speed, kAcross, 1.0) : 1};
}

PatchRow ContactCoupling::row_of(const Coupled& coupled, const CoupledPatch& patch) const {
    const ContactPatch& p = patch.patch;
    const double limit_n = patch.shear_limit_n();
    const auto [t, across] = tangential_rows(coupled, patch);
    PatchRow row;
    row.drift_m = to_bullet(patch.drift_m);
    const Vec3 directions[PatchRow::kCount] = {-p.normal, t, cross(p.normal, t)};
    for (int i = 0; i < PatchRow::kCount; ++i) {
        const double most_n = i == 0 ? p.normal_limit_n : i == 1 ? limit_n : across * limit_n;
        const double least_n = i == 0 ? 0 : -most_n;
        const double preload_n = dot(patch.preload_n, directions[i]);
        row.direction[i] = to_bullet(directions[i]);
        row.offset_m[i] = to_bullet(i == 0 ? patch.offset_m : patch.shear_offset_m);
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

/// Gives last substep's forces to the body before the solve, within this substep's limits; the rows
/// then find the change. Bullet starts its joints from nothing, and ten iterations from there do
/// not reach a heavy chassis through light wheels. Friction with other bodies sees a torque only as
/// a row.
void ContactCoupling::preload(Coupled& coupled) {
    btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
    coupled.is_touched =
        std::binary_search(touched_.begin(), touched_.end(), coupled.body.object, std::less<>());
    Vec3 torque_n_m;
    for (CoupledPatch& patch : coupled.patches) {
        patch.preload_n = {};
        if (!body.isActive()) continue;
        const ContactPatch& p = patch.patch;
        const double normal_n =
            std::clamp(-dot(patch.applied_force_n, p.normal), 0.0, p.normal_limit_n);
        Vec3 along = tangential(patch.applied_force_n, p.normal);
        const double most_n = patch.shear_limit_n();
        if (length(along) > most_n) along = along * (most_n / length(along));
        patch.preload_n = kPreloadFraction * (along - normal_n * p.normal);
        apply_preload(coupled, patch, 1);
        torque_n_m += patch.torque_n_m(patch.preload_n);
    }
    if (!coupled.is_touched) return;
    if (!coupled.preload_torque) coupled.preload_torque = std::make_unique<TorqueConstraint>(body);
    coupled.preload_torque->torque_n_m = to_bullet(torque_n_m);
    world_.addConstraint(coupled.preload_torque.get());
    rigid_rows_in_.push_back(coupled.preload_torque.get());
}

void ContactCoupling::apply_preload(const Coupled& coupled, const CoupledPatch& patch,
                                    double sign) {
    btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
    const btVector3 force_n = to_bullet(sign * patch.preload_n);
    body.applyCentralForce(force_n);
    if (!coupled.is_touched) body.applyTorque(to_bullet(patch.torque_n_m(sign * patch.preload_n)));
}

void ContactCoupling::open_substep() {
    take_rows_out();
    find_touched();
    for (auto& [id, coupled] : coupled_) {
        if (coupled.patches.empty() || !is_in_world(world_, coupled.body)) continue;
        open(coupled);
        opened_.push_back(id);
    }
}

void ContactCoupling::open(Coupled& coupled) {
    coupled.pose_at_open = from_bullet(coupled.body.object->getWorldTransform());
    if (coupled.body.role == BodyRole::rigid) {
        btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
        preload(coupled);
        for (size_t i = 0; i < coupled.patches.size(); ++i) {
            if (i == coupled.rigid_rows.size())
                coupled.rigid_rows.push_back(std::make_unique<RigidPatchConstraint>(body));
            coupled.rigid_rows[i]->row = row_of(coupled, coupled.patches[i]);
            world_.addConstraint(coupled.rigid_rows[i].get());
            rigid_rows_in_.push_back(coupled.rigid_rows[i].get());
        }
    } else {
        auto& collider = *static_cast<btMultiBodyLinkCollider*>(coupled.body.object);
        if (!coupled.link_rows) coupled.link_rows = std::make_unique<LinkPatchConstraint>(collider);
        coupled.link_rows->rows.clear();
        for (const CoupledPatch& patch : coupled.patches)
            coupled.link_rows->rows.push_back(row_of(coupled, patch));
        multibody_world_->addMultiBodyConstraint(coupled.link_rows.get());
        link_rows_in_.push_back(coupled.link_rows.get());
    }
}

void ContactCoupling::take_rows_out() {
    for (const int id : opened_) {
        const Coupled& coupled = coupled_.at(id);
        if (coupled.body.role != BodyRole::rigid) continue;
        for (const CoupledPatch& patch : coupled.patches) apply_preload(coupled, patch, -1);
    }
    opened_.clear();
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
        add_drift(coupled);
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
    if (coupled.body.role == BodyRole::link && !coupled.link_rows->take_solved()) return false;
    for (size_t i = 0; i < coupled.patches.size(); ++i) {
        CoupledPatch& patch = coupled.patches[i];
        if (coupled.body.role == BodyRole::rigid) {
            RigidPatchConstraint& rows = *coupled.rigid_rows[i];
            if (!rows.take_solved()) return false;
            patch.applied_force_n = patch.preload_n + from_bullet(rows.applied_force_n());
        } else {
            const int index = static_cast<int>(i);
            patch.applied_force_n =
                from_bullet(coupled.link_rows->applied_force_n(index, substep_s));
        }
        torque_n_m += patch.torque_n_m(patch.applied_force_n);
    }
    return true;
}

/// Adds this substep's motion to the drift of each patch that did not yield.
void ContactCoupling::add_drift(Coupled& coupled) {
    const Pose pose = from_bullet(coupled.body.object->getWorldTransform());
    const Quat turn = pose.rotation * conjugate(coupled.pose_at_open.rotation);
    for (CoupledPatch& patch : coupled.patches) {
        const Vec3 n = patch.patch.normal;
        const Vec3 shift = pose.position - coupled.pose_at_open.position;
        const Vec3 moved = shift + rotate(turn, patch.offset_m) - patch.offset_m;
        const Vec3 sheared = shift + rotate(turn, patch.shear_offset_m) - patch.shear_offset_m;
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
