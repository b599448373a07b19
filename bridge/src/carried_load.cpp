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

}  // namespace

void apply_carried_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                         Vec3 up, double gravity_m_s2, double duration_s) {
    for (const BodyLoad& load : loads) {
        const auto body = std::find_if(bodies.begin(), bodies.end(),
                                       [&](const BodyState& b) { return b.id == load.body; });
        if (body == bodies.end() || body->is_asleep) continue;
        const double impulse_n_s = load.mass_kg * gravity_m_s2 * duration_s;
        if (body->role == BodyRole::rigid) {
            auto& rigid = *btRigidBody::upcast(body->object);
            rigid.applyImpulse(to_bullet(-impulse_n_s * up),
                               to_bullet(load.center_m) - rigid.getCenterOfMassPosition());
        } else if (body->role == BodyRole::link) {
            push_link(*btMultiBodyLinkCollider::upcast(body->object), load.center_m, -up,
                      impulse_n_s);
        }
    }
}

}  // namespace bsoil::bullet
