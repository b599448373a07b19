#include "substep_rows.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bsoil/contact/mean_pressure.h"
#include "bsoil/contact/orientation.h"
#include "bullet_types.h"
#include "coupling_def.h"
#include "lent_force.h"

namespace bsoil::bullet {
namespace {

/// Gives a body a force for the substep; sign -1 takes it off where it still has it.
/// is_touched: it has the torque as a row.
void lend(btRigidBody& body, double sign, Vec3 force_n, Vec3 torque_n_m, bool is_touched) {
    const btVector3& sum = body.getTotalTorque();
    if (sign < 0 && !LentForce::take(sum)) return;
    body.applyCentralForce(to_bullet(force_n));
    if (!is_touched) body.applyTorque(to_bullet(torque_n_m));
    if (sign > 0) LentForce::lend(sum);
}

Vec3 tangential(Vec3 v, Vec3 normal) { return v - dot(v, normal) * normal; }

/// A unit vector across the normal: along the friction that sticks, else any.
Vec3 along_friction(Vec3 normal, Vec3 friction_n, double force_n) {
    const double size_n = length(friction_n);
    if (size_n > kCoupling.no_direction_share * force_n) return friction_n * (1 / size_n);
    return unit_across(normal);
}

/// The constraints of a world, which it shows to worlds alone.
struct WorldConstraints : btDiscreteDynamicsWorld {
    static btAlignedObjectArray<btTypedConstraint*>& of(btDiscreteDynamicsWorld& world) {
        return world.*(&WorldConstraints::m_constraints);
    }
};

/// Takes constraints out of the world, given in the order they were put in. Bullet looks for one
/// from the front and fills its gap with the last: in this order each of them is found right behind
/// the host's, however many there are, and the host's keep theirs.
template <typename Rows, typename Remove>
void take_out_of_world(std::vector<Rows*>& rows, const Remove& remove) {
    if (rows.empty()) return;
    remove(rows.front());
    for (size_t i = rows.size(); i-- > 1;) remove(rows[i]);
    rows.clear();
}

}  // namespace

SubstepRows::SubstepRows(btDiscreteDynamicsWorld& world, std::map<int, CoupledBody>& bodies,
                         KnownContacts& known, double voxel_m)
    : world_(world),
      multibody_world_(dynamic_cast<btMultiBodyDynamicsWorld*>(&world)),
      bodies_(bodies),
      known_(known),
      voxel_m_(voxel_m) {}

bool SubstepRows::is_row(const btTypedConstraint& constraint) {
    return dynamic_cast<const RigidPatchConstraint*>(&constraint) ||
           dynamic_cast<const TorqueConstraint*>(&constraint);
}

/// The limits of two rows make a box where Coulomb's make a circle. A patch that slides has its
/// first row along the sliding and little of the second: patches of a wheel whose rows no motion of
/// the wheel satisfies all at once would brace against each other across it, with up to half as
/// much again as their friction.
SubstepRows::TangentialRows SubstepRows::tangential_rows(const ContactMotion& motion,
                                                         const CoupledPatch& patch) {
    const ContactPatch& p = patch.patch;
    const Vec3 friction_n = tangential(patch.applied_force_n, p.normal);
    const double limit_n = patch.shear_limit_n();
    const Vec3 slide = tangential(motion.direction.velocity_at(p.shear_point_m), p.normal);
    const double sliding = length(slide);
    if (sliding <= kCoupling.sliding_share ||
        -dot(friction_n, slide) <= kCoupling.mostly_yielded_share * limit_n * sliding) {
        return {along_friction(p.normal, friction_n, length(patch.applied_force_n)), 1};
    }
    const Vec3 first = slide * (1 / sliding);
    const Vec3 now = tangential(motion.motion.velocity_at(p.shear_point_m), p.normal);
    const double speed = length(now);
    const double aside = length(now - dot(now, first) * first);
    return {first, speed > 0 ? std::clamp(aside / speed, kCoupling.across_share, 1.0) : 1};
}

PatchRow SubstepRows::row_of(const CoupledBody& coupled, const CoupledPatch& patch) const {
    const ContactPatch& p = patch.patch;
    const double limit_n = patch.shear_limit_n();
    const auto [t, across] = tangential_rows(motion_for(coupled.motions, p.carrier), patch);
    const Carrier& carrier = coupled.carrier_of(patch);
    const bool is_driven = p.carrier >= 0 && !carrier.feels();
    PatchRow row;
    row.drift_m = to_bullet(patch.drift_m);
    row.preload_n = to_bullet(patch.preload_n);
    const Vec3 directions[PatchRow::kCount] = {-p.normal, t, cross(p.normal, t)};
    for (int i = 0; i < PatchRow::kCount; ++i) {
        const double most_n = i == 0 ? p.normal_limit_n : i == 1 ? limit_n : across * limit_n;
        const double least_n = i == 0 ? 0 : -most_n;
        const double preload_n = dot(patch.preload_n, directions[i]);
        row.direction[i] = to_bullet(directions[i]);
        row.offset_m[i] = to_bullet(i == 0 ? patch.offset_m : patch.shear_offset_m);
        row.carrier_offset_m[i] =
            to_bullet(i == 0 ? patch.carrier_offset_m : patch.carrier_shear_offset_m);
        if (is_driven) {
            row.carrier_velocity_m_s[i] = static_cast<btScalar>(
                dot(carrier.body.motion.velocity_at(i == 0 ? p.point_m : p.shear_point_m),
                    directions[i]));
        }
        row.lower_n[i] = static_cast<btScalar>(least_n - preload_n);
        row.upper_n[i] = static_cast<btScalar>(most_n - preload_n);
    }
    return row;
}

/// Bodies that move count as touching where their boxes overlap: a contact that rocks comes and
/// goes. Static ground may lie anywhere below. A sensor pushes nobody.
void SubstepRows::find_touched() {
    touched_.clear();
    btDispatcher& dispatcher = *world_.getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
        if (!a->hasContactResponse() || !b->hasContactResponse()) continue;
        if (manifold.getNumContacts() == 0 && (a->isStaticObject() || b->isStaticObject())) {
            continue;
        }
        touched_.push_back(a);
        touched_.push_back(b);
    }
    std::sort(touched_.begin(), touched_.end(), std::less<>());
}

bool SubstepRows::is_touched(const btCollisionObject* object) const {
    return std::binary_search(touched_.begin(), touched_.end(), object, std::less<>());
}

/// Gives last substep's forces to the body before the solve, within this substep's limits, and
/// their opposites to the carrier; the rows then find the change. Bullet starts its joints from
/// nothing, and ten iterations from there do not reach a heavy chassis through light wheels.
/// Friction with other bodies sees a torque only as a row.
void SubstepRows::preload(CoupledBody& coupled) {
    btRigidBody& body = *static_cast<btRigidBody*>(coupled.body.object);
    coupled.is_touched = is_touched(&body);
    for (Carrier& carrier : coupled.carriers) {
        carrier.is_touched = carrier.is_rigid() && is_touched(carrier.body.object);
    }
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
        patch.preload_n = kCoupling.preload_share * (along - normal_n * p.normal);
        apply_preload(coupled, patch, 1);
        torque_n_m += patch.torque_n_m(patch.preload_n);
        if (carrier.is_touched) {
            add_preload_torque(carrier.body, patch.carrier_torque_n_m(patch.preload_n));
        }
    }
    if (coupled.is_touched) add_preload_torque(coupled.body, torque_n_m);
}

void SubstepRows::add_preload_torque(const BodyState& body, Vec3 torque_n_m) {
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

void SubstepRows::put_in_preload_torque(PreloadTorque& torque) {
    if (!torque.is_used || torque.is_in) return;
    torque.is_in = true;
    torque.row->torque_n_m = to_bullet(torque.torque_n_m);
    world_.addConstraint(torque.row.get());
    rigid_rows_in_.push_back(torque.row.get());
}

void SubstepRows::apply_preload(CoupledBody& coupled, const CoupledPatch& patch, double sign) {
    const Vec3 force_n = sign * patch.preload_n;
    if (coupled.is_there) {
        lend(*static_cast<btRigidBody*>(coupled.body.object), sign, force_n,
             patch.torque_n_m(force_n), coupled.is_touched);
    }
    const Carrier& carrier = coupled.carrier_of(patch);
    if (!carrier.is_rigid() || !carrier.is_there) return;
    lend(*static_cast<btRigidBody*>(carrier.body.object), sign, -1.0 * force_n,
         patch.carrier_torque_n_m(force_n), carrier.is_touched);
}

void SubstepRows::open() {
    take_out();
    find_touched();
    for (auto& [id, coupled] : bodies_) {
        const bool feels =
            coupled.body.role == BodyRole::rigid || coupled.body.role == BodyRole::link;
        // Only now: what held it in the last substep its report has said until here.
        if (coupled.patches.empty() && feels) {
            coupled.report.force_n = coupled.report.torque_n_m = {};
        }
        if (coupled.patches.empty() || !is_in_world(world_, coupled.body)) continue;
        coupled.is_there = true;
        // Until the soil has stepped without it, soil on a body that has gone stands where it was.
        for (Carrier& carrier : coupled.carriers) {
            carrier.is_there = true;
            if (!carrier.feels() || is_in_world(world_, carrier.body)) continue;
            carrier.body = {};
            carrier.link_rows.reset();
        }
        opened_.push_back(id);
        if (coupled.body.role == BodyRole::rigid) preload(coupled);
    }
    for (const int id : opened_) open_body(bodies_.at(id));
    for (auto it = preload_torques_.begin(); it != preload_torques_.end();) {
        put_in_preload_torque(it->second);
        it = it->second.is_used ? std::next(it) : preload_torques_.erase(it);
    }
}

void SubstepRows::open_body(CoupledBody& coupled) {
    coupled.bullet_pose_at_open = coupled.body.object->getWorldTransform();
    coupled.pose_at_open = from_bullet(coupled.bullet_pose_at_open);
    for (Carrier& carrier : coupled.carriers) {
        if (carrier.feels()) {
            carrier.pose_at_open = from_bullet(carrier.body.object->getWorldTransform());
        }
    }
    if (const auto torque = preload_torques_.find(coupled.body.id);
        torque != preload_torques_.end()) {
        put_in_preload_torque(torque->second);
    }
    for (size_t i = 0; i < coupled.patches.size(); ++i) {
        if (!coupled.is_link_row(coupled.patches[i])) open_rigid_row(coupled, i);
    }
    for (Carrier& carrier : coupled.carriers) open_link_rows(coupled, carrier);
}

void SubstepRows::open_rigid_row(CoupledBody& coupled, size_t index) {
    const CoupledPatch& patch = coupled.patches[index];
    const Carrier& carrier = coupled.carrier_of(patch);
    auto* under = carrier.is_rigid() ? static_cast<btRigidBody*>(carrier.body.object) : nullptr;
    if (index >= coupled.rigid_rows.size()) coupled.rigid_rows.resize(index + 1);
    std::unique_ptr<RigidPatchConstraint>& rows = coupled.rigid_rows[index];
    if (!rows || !rows->acts_on(under)) {
        rows = std::make_unique<RigidPatchConstraint>(
            *static_cast<btRigidBody*>(coupled.body.object), under);
    }
    rows->set(row_of(coupled, patch));
    world_.addConstraint(rows.get());
    rigid_rows_in_.push_back(rows.get());
}

void SubstepRows::open_link_rows(CoupledBody& coupled, Carrier& carrier) {
    // The host may have turned the carrier kinematic or back.
    btCollisionObject* under = carrier.feels() ? carrier.body.object : nullptr;
    bool is_any = false;
    for (const CoupledPatch& patch : coupled.patches) {
        if (patch.patch.carrier != carrier.id || !coupled.is_link_row(patch)) continue;
        if (!carrier.link_rows || !carrier.link_rows->acts_on(under)) {
            carrier.link_rows = std::make_unique<LinkPatchConstraint>(*coupled.body.object, under);
        }
        if (!is_any) carrier.link_rows->clear();
        carrier.link_rows->add(row_of(coupled, patch));
        is_any = true;
    }
    if (!is_any) return;
    multibody_world_->addMultiBodyConstraint(carrier.link_rows.get());
    link_rows_in_.push_back(carrier.link_rows.get());
}

/// A host's action ahead of the soil's may have taken bodies out of the world and deleted them.
void SubstepRows::find_gone() {
    gone_.clear();
    const auto is_there = [this](const BodyState& body) {
        if (is_in_world(world_, body)) return true;
        gone_.push_back(body.object);
        return false;
    };
    for (const int id : opened_) {
        CoupledBody& coupled = bodies_.at(id);
        coupled.is_there = is_there(coupled.body);
        for (Carrier& carrier : coupled.carriers) {
            carrier.is_there = !carrier.feels() || is_there(carrier.body);
        }
    }
}

/// Compares only.
bool SubstepRows::is_gone(const btRigidBody& body) const {
    return std::find(gone_.begin(), gone_.end(), &body) != gone_.end();
}

void SubstepRows::take_out() {
    find_gone();
    take_out_found();
}

/// After find_gone.
void SubstepRows::take_out_found() {
    for (const int id : opened_) {
        CoupledBody& coupled = bodies_.at(id);
        if (coupled.body.role != BodyRole::rigid) continue;
        for (const CoupledPatch& patch : coupled.patches) apply_preload(coupled, patch, -1);
    }
    opened_.clear();
    for (auto& [id, torque] : preload_torques_) torque.is_used = torque.is_in = false;
    take_out_of_world(rigid_rows_in_, [this](btTypedConstraint* rows) {
        if (is_gone(rows->getRigidBodyA()) || is_gone(rows->getRigidBodyB())) {
            WorldConstraints::of(world_).remove(rows);  // Bullet would look at both bodies
        } else {
            world_.removeConstraint(rows);
        }
    });
    take_out_of_world(link_rows_in_,
                      [this](auto* rows) { multibody_world_->removeMultiBodyConstraint(rows); });
}

/// After find_gone. Where Bullet leaves a body and what carries soil below it.
void SubstepRows::note_left(CoupledBody& coupled, btScalar substep_s) const {
    const double slack_m = kCoupling.put_elsewhere_voxels * voxel_m_;
    if (coupled.is_there && coupled.body.role == BodyRole::rigid) {
        coupled.left.close(*coupled.body.object, coupled.bullet_pose_at_open, substep_s, slack_m);
    } else if (coupled.is_there) {  // Bullet keeps no speed of a link
        coupled.left.set(*coupled.body.object);
    }
    for (Carrier& carrier : coupled.carriers) {
        if (carrier.body.object && is_in_world(world_, carrier.body)) {
            carrier.left.set(*carrier.body.object);
        }
    }
}

void SubstepRows::close(btScalar substep_s) {
    find_gone();
    for (const int id : opened_) {
        CoupledBody& coupled = bodies_.at(id);
        const auto has_gone = [](const Carrier& carrier) { return !carrier.is_there; };
        note_left(coupled, substep_s);
        if (!coupled.is_there || std::ranges::any_of(coupled.carriers, has_gone)) continue;
        Vec3 torque;
        // Not solved: asleep. What held it when it fell asleep still does.
        if (!read_forces(coupled, substep_s, torque)) continue;
        Vec3 force;
        coupled.pressed.clear();
        for (const CoupledPatch& patch : coupled.patches) {
            force += patch.applied_force_n;
            const int carrier = patch.patch.carrier;
            if (carrier < 0) continue;
            if (coupled.pressed.empty() || coupled.pressed.back().id != carrier) {
                coupled.pressed.push_back({carrier, {}});
            }
            coupled.pressed.back().force_n += -patch.applied_force_n;
        }
        coupled.report.force_n = force;
        coupled.report.torque_n_m = torque;
        coupled.report.peak_force_n = std::max(coupled.report.peak_force_n, length(force));
        add_drift(coupled, static_cast<double>(substep_s));
        MeanPressure pressure;
        for (CoupledPatch& patch : coupled.patches) {
            patch.friction_normal_n =
                std::max(0.0, -dot(patch.applied_force_n, patch.patch.normal));
            pressure.add_force(patch.friction_normal_n, patch.patch.area_m2);
        }
        known_.set_pressure(id, pressure.pa());
    }
    take_out_found();
}

bool SubstepRows::read_forces(CoupledBody& coupled, btScalar substep_s, Vec3& torque_n_m) {
    for (const CoupledPatch& patch : coupled.patches) {
        if (coupled.is_link_row(patch)) {
            if (!coupled.carrier_of(patch).link_rows->is_solved()) return false;
        } else if (!coupled.rigid_rows[&patch - coupled.patches.data()]->is_solved()) {
            return false;
        }
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

Vec3 Carrier::motion_in(double substep_s, Vec3 offset_m) const {
    if (!feels()) {
        return substep_s * body.motion.velocity_at(body.motion.center_of_mass_m + offset_m);
    }
    const Pose pose = from_bullet(body.object->getWorldTransform());
    const Quat turn = pose.rotation * conjugate(pose_at_open.rotation);
    return pose.position - pose_at_open.position + rotate(turn, offset_m) - offset_m;
}

/// Adds this substep's motion to the drift of each patch that did not yield.
void SubstepRows::add_drift(CoupledBody& coupled, double substep_s) {
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
        // Soil that has rebounded has let go: what lifts further is the body's own motion.
        const double lifted_most_m = std::min(patch.patch.rebound_m, kCoupling.drift_most_m);
        double into = dot(patch.drift_m, n);
        const double approach = dot(moved, n);
        const double normal_n = -dot(patch.applied_force_n, n);
        if (approach < 0 || normal_n < kCoupling.yielded_share * patch.patch.normal_limit_n) {
            into = std::clamp(into + approach, -lifted_most_m, kCoupling.drift_most_m);
        }
        const bool slides = length(tangential(patch.applied_force_n, n)) >=
                            kCoupling.yielded_share * patch.shear_limit_n();
        Vec3 along = slides ? Vec3{} : tangential(patch.drift_m, n) + tangential(sheared, n);
        if (length(along) > kCoupling.drift_most_m) {
            along = along * (kCoupling.drift_most_m / length(along));
        }
        patch.drift_m = into * n + along;
    }
}

}  // namespace bsoil::bullet
