#include "carried_load.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// Mass and moments of inertia about the centre of mass, in the body's axes.
struct MassProps {
    btScalar mass_kg = 0;
    btVector3 inertia_kg_m2{0, 0, 0};  ///< 0 where a rigid body cannot turn
};

/// A rigid body, or the base or a link of a multibody.
class LoadedBody {
  public:
    explicit LoadedBody(const BodyState& body)
        : rigid_(body.role == BodyRole::rigid ? btRigidBody::upcast(body.object) : nullptr),
          collider_(body.role == BodyRole::link ? btMultiBodyLinkCollider::upcast(body.object)
                                                : nullptr),
          axes_(body.object->getWorldTransform()) {}

    /// Whether it moves at all now.
    bool is_active() const {
        if (rigid_) return rigid_->isActive() && !rigid_->isStaticOrKinematicObject();
        return collider_ && collider_->m_multiBody->isAwake() && !is_fixed();
    }
    const btTransform& axes() const { return axes_; }
    /// Bullet keeps a rigid body's inverses.
    btScalar mass_kg() const {
        if (rigid_) return 1 / rigid_->getInvMass();
        return is_base() ? multibody().getBaseMass() : link().m_mass;
    }
    bool has_mass(btScalar mass_kg) const {
        return rigid_ ? rigid_->getInvMass() == 1 / mass_kg : this->mass_kg() == mass_kg;
    }
    btVector3 inertia_kg_m2() const {
        if (!rigid_) return is_base() ? multibody().getBaseInertia() : link().m_inertiaLocal;
        const btVector3& inverse = rigid_->getInvInertiaDiagLocal();
        btVector3 out(0, 0, 0);
        for (int i = 0; i < 3; ++i) out[i] = inverse[i] > 0 ? 1 / inverse[i] : 0;
        return out;
    }
    void set(const MassProps& props) {
        if (rigid_) {
            rigid_->setMassProps(props.mass_kg, props.inertia_kg_m2);
            rigid_->updateInertiaTensor();
        } else if (is_base()) {
            multibody().setBaseMass(props.mass_kg);
            multibody().setBaseInertia(props.inertia_kg_m2);
        } else {
            link().m_mass = props.mass_kg;
            link().m_inertiaLocal = props.inertia_kg_m2;
        }
    }
    void apply_force(const btVector3& force_n, const btVector3& arm_m) {
        if (rigid_) {
            rigid_->applyForce(force_n, arm_m);
        } else if (is_base()) {
            multibody().addBaseForce(force_n);
            multibody().addBaseTorque(arm_m.cross(force_n));
        } else {
            multibody().addLinkForce(collider_->m_link, force_n);
            multibody().addLinkTorque(collider_->m_link, arm_m.cross(force_n));
        }
    }

  private:
    btMultiBody& multibody() const { return *collider_->m_multiBody; }
    bool is_base() const { return collider_->m_link < 0; }
    bool is_fixed() const { return is_base() && multibody().hasFixedBase(); }
    btMultibodyLink& link() const { return multibody().getLink(collider_->m_link); }

    btRigidBody* rigid_;
    btMultiBodyLinkCollider* collider_;
    const btTransform& axes_;
};

}  // namespace

CarriedLoads::CarriedLoads(btDiscreteDynamicsWorld& world, Vec3 up, double gravity_m_s2)
    : world_(world), up_(up), gravity_m_s2_(gravity_m_s2) {}

void CarriedLoads::set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads) {
    std::map<int, Loaded> before;
    before.swap(loaded_);
    for (const BodyLoad& load : loads) {
        const auto body = std::find_if(bodies.begin(), bodies.end(),
                                       [&](const BodyState& b) { return b.id == load.body; });
        if (body == bodies.end() || body->is_asleep) continue;
        if (body->role != BodyRole::rigid && body->role != BodyRole::link) continue;
        Loaded& loaded = loaded_[load.body];
        if (const auto old = before.find(load.body); old != before.end()) loaded = old->second;
        loaded.body = *body;
        loaded.load = load;
    }
}

void CarriedLoads::open_substep() {
    for (auto& [id, loaded] : loaded_) {
        if (is_in_world(world_, loaded.body)) open(loaded);
    }
}

void CarriedLoads::open(Loaded& loaded) {
    LoadedBody body(loaded.body);
    if (loaded.open || !body.is_active()) return;
    // Bullet keeps inverses: read back, the host's mass would drift by a rounding a substep.
    if (loaded.own_mass_kg <= 0 || !body.has_mass(loaded.own_mass_kg)) {
        loaded.own_mass_kg = body.mass_kg();
        loaded.own_inertia = body.inertia_kg_m2();
    }
    const auto mass_kg = static_cast<btScalar>(loaded.load.mass_kg);
    loaded.arm_m = to_bullet(loaded.load.center_m) - body.axes().getOrigin();
    loaded.weight_n = to_bullet(-loaded.load.mass_kg * gravity_m_s2_ * up_);
    const btVector3 arm = body.axes().getBasis().transpose() * loaded.arm_m;
    btVector3 inertia = loaded.own_inertia;
    for (int i = 0; i < 3; ++i) {
        if (inertia[i] > 0) inertia[i] += mass_kg * (arm.length2() - arm[i] * arm[i]);
    }
    body.set({loaded.own_mass_kg + mass_kg, inertia});
    body.apply_force(loaded.weight_n, loaded.arm_m);
    loaded.open = true;
}

void CarriedLoads::close_substep() {
    for (auto& [id, loaded] : loaded_) {
        if (!loaded.open) continue;
        loaded.open = false;
        if (!is_in_world(world_, loaded.body)) continue;
        LoadedBody body(loaded.body);
        // Forces outlive a substep: what was given for it is taken back.
        body.apply_force(-loaded.weight_n, loaded.arm_m);
        // Another soil of this world may have loaded it too, and the one that came first has taken
        // both loads off already.
        if (body.mass_kg() < loaded.own_mass_kg + static_cast<btScalar>(loaded.load.mass_kg) / 2) {
            continue;
        }
        body.set({loaded.own_mass_kg, loaded.own_inertia});
    }
}

void CarriedLoads::let_go() {
    close_substep();
    loaded_.clear();
}

}  // namespace bsoil::bullet
