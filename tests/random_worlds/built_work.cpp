// What does work on the bodies of a world besides gravity: Bullet itself, and soil that sources
// pour or wind blows.
#include <algorithm>
#include <limits>
#include <set>

#include "built_world.h"
#include "bullet_types.h"
#include "mechanics.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;
using bullet::to_bullet;

namespace {

/// As of the last soil step. Where there is none its place is the body's.
BodyLoad load_of(const bullet::SoilAction& soil, const btCollisionObject& object) {
    BodyLoad none;
    none.center_m = from_bullet(object.getWorldTransform().getOrigin());
    if (soil.options(object).coverage_only) return none;  // what it reports does not act on it
    const std::span<const BodyLoad> loads = soil.last_report().loads;
    const int id = soil.body_id(object);
    const auto found =
        std::find_if(loads.begin(), loads.end(), [id](const BodyLoad& l) { return l.body == id; });
    return found == loads.end() ? none : *found;
}

/// Whether wind does work on soil, as much as it takes. World 940057: at 11.7 m/s, upwards, it
/// carries soil that falls at 0.22 m/s against a ball of 483 kg. That rises by a metre and turns,
/// at its rim no faster than the wind: 15 kJ, all of it by what hits it.
bool blows_soil(const SoilDef& def) {
    return length(def.wind_m_s) > 0 &&
           std::any_of(def.materials.begin(), def.materials.end(),
                       [](const MaterialDef& m) { return m.fall_speed_m_s > 0; });
}

}  // namespace

BuiltWorld::Motion BuiltWorld::motion_of(const btCollisionObject& object) {
    if (const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object)) {
        if (!link->m_multiBody->isAwake()) return {};
        const LinkMotion motion =
            link_motions(*link->m_multiBody)[static_cast<size_t>(link->m_link + 1)];
        return {motion.velocity, motion.spin};
    }
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (!body || !body->isActive()) return {};
    return {body->getLinearVelocity(), body->getAngularVelocity()};
}

void BuiltWorld::note_motion() {
    const btCollisionObjectArray& objects = world_->getCollisionObjectArray();
    before_.clear();
    for (int i = 0; i < objects.size(); ++i) {
        Before& before = before_[objects[i]];
        before.motion = motion_of(*objects[i]);
        for (const auto& soil : soils_) before.loads.push_back(load_of(*soil, *objects[i]));
    }
}

/// The work of an impulse is that along the mean of the velocities before and after all impulses.
BuiltWorld::Motion BuiltWorld::mean_motion_of(const btCollisionObject& object) const {
    const Motion now = motion_of(object);
    const auto found = before_.find(&object);
    if (found == before_.end()) return now;
    const Motion& then = found->second.motion;
    return {(then.velocity + now.velocity) / 2, (then.spin + now.spin) / 2};
}

void BuiltWorld::add_joint_work(double substep_s) {
    if (joints_.empty()) return;
    std::set<const btCollisionObject*> at_soil;
    for (const MovingPart& part : parts_at_soil(*this)) at_soil.insert(part.object);
    for (const Joint& joint : joints_) {
        const btRigidBody *a = &joint.bullet->getRigidBodyA(), *b = &joint.bullet->getRigidBodyB();
        if (!a->isActive() || !b->isActive()) continue;
        if (!at_soil.contains(a) && !at_soil.contains(b)) continue;
        const auto power_w = [this](const btVector3& force, const btVector3& torque,
                                    const btRigidBody& body) {
            const Motion mean = mean_motion_of(body);
            return static_cast<double>(force.dot(mean.velocity) + torque.dot(mean.spin));
        };
        const btJointFeedback& f = *joint.feedback;
        joint_work_j_ += substep_s * (power_w(f.m_appliedForceBodyA, f.m_appliedTorqueBodyA, *a) +
                                      power_w(f.m_appliedForceBodyB, f.m_appliedTorqueBodyB, *b));
    }
}

/// Where bodies overlap Bullet gives them a velocity that takes them apart, and friction that it
/// solves in turn with it drags some on: in world 8000081 a cylinder that the soil does not see
/// creeps up 35 deg of its surface, by 0.6 voxels a second. What contacts take out is theirs.
void BuiltWorld::add_contact_work() {
    const auto multibody_of = [](const btCollisionObject& object) {
        const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object);
        return link ? link->m_multiBody : nullptr;
    };
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
        const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
        const Motion of_a = mean_motion_of(a), of_b = mean_motion_of(b);
        for (int k = 0; k < manifold.getNumContacts(); ++k) {
            const btManifoldPoint& p = manifold.getContactPoint(k);
            const btVector3 on_a = p.getPositionWorldOnA() - a.getWorldTransform().getOrigin();
            const btVector3 on_b = p.getPositionWorldOnB() - b.getWorldTransform().getOrigin();
            const btVector3 apart_m_s =
                of_a.velocity + of_a.spin.cross(on_a) - of_b.velocity - of_b.spin.cross(on_b);
            const btVector3 friction_n_s = p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                                           p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2;
            const btScalar pushed_j = p.m_appliedImpulse * apart_m_s.dot(p.m_normalWorldOnB);
            const btScalar dragged_j = friction_n_s.dot(apart_m_s);
            const double work_j = static_cast<double>(std::max(btScalar(0), pushed_j) +
                                                      std::max(btScalar(0), dragged_j));
            contact_work_j_ += work_j;
            if (!multibody_of(a) || multibody_of(a) != multibody_of(b)) continue;
            for (Chain& chain : chains_) {
                if (chain.multibody.get() == multibody_of(a)) chain.own_contact_work_j += work_j;
            }
        }
    }
}

/// What soil has done on bodies by changing its own speed, without its weight: no more than it has
/// from sources, or by falling from where it was filled into the air. What wind gives it has no
/// bound.
void BuiltWorld::add_poured_work(double substep_s) {
    double brought_j = 0;
    for (size_t i = 0; i < soils_.size(); ++i) {
        if (blows_soil(plan_.soils[i].def)) brought_j = std::numeric_limits<double>::infinity();
        double fastest_m_s = 0;
        bool has_source = false;
        for (const FlowPlan& flow : plan_.soils[i].flows) {
            if (flow.dropped || !flow.is_source) continue;
            has_source = true;
            fastest_m_s = std::max(fastest_m_s, flow.source.speed_m_s);
        }
        const Soil& soil = soils_[i]->soil();
        const double height_m = soil.frame().voxel_m * soil.frame().size[2];
        for (const FillPlan& fill : plan_.soils[i].fills) {
            if (fill.dropped || !fill.is_hanging) continue;
            const Vec3 size_m = fill.high_m - fill.low_m;
            const MaterialDef& material = plan_.soils[i].def.materials[fill.material];
            brought_j +=
                size_m.x * size_m.y * size_m.z * material.density_kg_m3 * gravity_m_s2() * height_m;
        }
        if (!has_source) continue;
        const SoilTotals totals = soil.totals();
        for (size_t m = 0; m < totals.units.size(); ++m) {
            if (totals.units[m] <= 0) continue;
            const double poured_kg = static_cast<double>(totals.units_in[m]) * totals.mass_kg[m] /
                                     static_cast<double>(totals.units[m]);
            brought_j += poured_kg * (fastest_m_s * fastest_m_s / 2 + gravity_m_s2() * height_m);
        }
    }
    if (brought_j <= 0) return;
    for (const MovingPart& part : moving_parts(*this)) {
        const auto before = before_.find(part.object);
        if (before == before_.end()) continue;
        const Motion mean = mean_motion_of(*part.object);
        double power_w = 0;
        for (size_t i = 0; i < soils_.size(); ++i) {
            if (soils_[i]->options(*part.object).coverage_only) continue;  // nothing acts on it
            // The push turns the body too: it acts where the soil is that it is of.
            const BodyLoad& load = before->second.loads[i];
            const Vec3 arm_m = load.center_m - part.pose.position;
            const Vec3 push_n =
                soils_[i]->body_report(*part.object).load_n + load.mass_kg * gravity_m_s2() * up_;
            power_w += dot(push_n, from_bullet(mean.velocity)) +
                       dot(cross(arm_m, push_n), from_bullet(mean.spin));
        }
        poured_work_j_ += std::max(0.0, substep_s * power_w);
    }
    poured_work_j_ = std::min(poured_work_j_, brought_j);
}

}  // namespace bsoil::random_worlds
