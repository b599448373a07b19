#include "carried_load.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

void push_link(btMultiBodyLinkCollider& link, Vec3 point_m, Vec3 direction, double impulse_n_s) {
    btMultiBody& multibody = *link.m_multiBody;
    const int size = multibody.getNumDofs() + 6;
    btAlignedObjectArray<btScalar> jacobian, change, scratch;
    btAlignedObjectArray<btVector3> scratch_vectors;
    btAlignedObjectArray<btMatrix3x3> scratch_matrices;
    jacobian.resize(size);
    change.resize(size);
    multibody.fillContactJacobianMultiDof(link.m_link, to_bullet(point_m), to_bullet(direction),
                                          &jacobian[0], scratch, scratch_vectors, scratch_matrices);
    multibody.calcAccelerationDeltasMultiDof(&jacobian[0], &change[0], scratch, scratch_vectors);
    multibody.applyDeltaVeeMultiDof(&change[0], static_cast<btScalar>(impulse_n_s));
}

/// Moments of inertia of a body about its own axes; 0 where it cannot turn.
btVector3 inertia_of(const btRigidBody& body) {
    const btVector3& inverse = body.getInvInertiaDiagLocal();
    btVector3 out(0, 0, 0);
    for (int i = 0; i < 3; ++i) out[i] = inverse[i] > 0 ? 1 / inverse[i] : 0;
    return out;
}

}  // namespace

CarriedLoads::CarriedLoads(btDiscreteDynamicsWorld& world, Vec3 up, double gravity_m_s2)
    : world_(world), up_(up), gravity_m_s2_(gravity_m_s2) {}

void CarriedLoads::set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                             double duration_s) {
    std::map<int, Loaded> before;
    before.swap(loaded_);
    for (const BodyLoad& load : loads) {
        const auto body = std::find_if(bodies.begin(), bodies.end(),
                                       [&](const BodyState& b) { return b.id == load.body; });
        if (body == bodies.end() || body->is_asleep) continue;
        if (body->role == BodyRole::rigid) {
            Loaded& loaded = loaded_[load.body];
            if (const auto old = before.find(load.body); old != before.end()) loaded = old->second;
            loaded.body = *body;
            loaded.load = load;
        } else if (body->role == BodyRole::link) {
            push_link(*btMultiBodyLinkCollider::upcast(body->object), load.center_m, -up_,
                      load.mass_kg * gravity_m_s2_ * duration_s);
        }
    }
}

void CarriedLoads::open_substep() {
    for (auto& [id, loaded] : loaded_)
        if (is_in_world(world_, loaded.body)) open(loaded);
}

void CarriedLoads::open(Loaded& loaded) {
    btRigidBody& body = *btRigidBody::upcast(loaded.body.object);
    if (loaded.open || !body.isActive() || body.isStaticOrKinematicObject()) return;
    // Bullet keeps inverses: read back, the host's mass would drift by a rounding a substep.
    if (loaded.own_mass_kg <= 0 || body.getInvMass() != 1 / loaded.own_mass_kg) {
        loaded.own_mass_kg = 1 / body.getInvMass();
        loaded.own_inertia = inertia_of(body);
    }
    const auto mass_kg = static_cast<btScalar>(loaded.load.mass_kg);
    loaded.arm_m = to_bullet(loaded.load.center_m) - body.getCenterOfMassPosition();
    loaded.weight_n = to_bullet(-loaded.load.mass_kg * gravity_m_s2_ * up_);
    const btVector3 arm = body.getWorldTransform().getBasis().transpose() * loaded.arm_m;
    btVector3 inertia = loaded.own_inertia;
    for (int i = 0; i < 3; ++i)
        if (inertia[i] > 0) inertia[i] += mass_kg * (arm.length2() - arm[i] * arm[i]);
    body.setMassProps(loaded.own_mass_kg + mass_kg, inertia);
    body.updateInertiaTensor();
    body.applyForce(loaded.weight_n, loaded.arm_m);
    loaded.open = true;
}

void CarriedLoads::close_substep() {
    for (auto& [id, loaded] : loaded_) {
        if (!loaded.open) continue;
        loaded.open = false;
        if (!is_in_world(world_, loaded.body)) continue;
        btRigidBody& body = *btRigidBody::upcast(loaded.body.object);
        // Forces outlive a substep: what was given for it is taken back.
        body.applyForce(-loaded.weight_n, loaded.arm_m);
        // Another soil of this world may have loaded it too, and the one that came first has taken
        // both loads off already.
        const btScalar mass_kg = 1 / body.getInvMass();
        if (mass_kg < loaded.own_mass_kg + static_cast<btScalar>(loaded.load.mass_kg) / 2) continue;
        body.setMassProps(loaded.own_mass_kg, loaded.own_inertia);
        body.updateInertiaTensor();
    }
}

void CarriedLoads::let_go() {
    close_substep();
    loaded_.clear();
}

}  // namespace bsoil::bullet
