#include "carried_load.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <utility>

#include "bullet_types.h"
#include "coupling_def.h"
#include "expose.h"
#include "lent_force.h"
#include "substep_rows.h"
#include "world_anchor.h"

namespace bsoil::bullet {
namespace {

BSOIL_EXPOSE(OwnWeight, &btRigidBody::m_gravity);

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
    btRigidBody* rigid() const { return rigid_; }
    btScalar mass_kg() const {
        if (rigid_) return 1 / rigid_->getInvMass();
        return is_base() ? multibody().getBaseMass() : link().m_mass;
    }
    /// What moves with it: of a link all of its multibody, but for a fixed base.
    double moved_kg() const {
        if (rigid_) return static_cast<double>(mass_kg());
        btScalar sum_kg = multibody().hasFixedBase() ? 0 : multibody().getBaseMass();
        for (int i = 0; i < multibody().getNumLinks(); ++i) {
            sum_kg += multibody().getLink(i).m_mass;
        }
        return static_cast<double>(sum_kg);
    }
    /// Whether these were set. Bullet keeps a rigid body's inverses.
    bool has(const MassProps& props) const {
        if (!rigid_) return mass_kg() == props.mass_kg && inertia_kg_m2() == props.inertia_kg_m2;
        bool same = rigid_->getInvMass() == 1 / props.mass_kg;
        for (int i = 0; i < 3; ++i) {
            const btScalar own = props.inertia_kg_m2[i];
            same = same && rigid_->getInvInertiaDiagLocal()[i] == (own > 0 ? 1 / own : 0);
        }
        return same;
    }
    btVector3 inertia_kg_m2() const {
        if (!rigid_) return is_base() ? multibody().getBaseInertia() : link().m_inertiaLocal;
        const btVector3& inverse = rigid_->getInvInertiaDiagLocal();
        btVector3 out(0, 0, 0);
        for (int i = 0; i < 3; ++i) out[i] = inverse[i] > 0 ? 1 / inverse[i] : 0;
        return out;
    }
    /// keeps_weight: Bullet would take it to be that of the mass. For its own weight a host may ask
    /// while its load is with a rigid body (btRigidBody::applyGravity).
    void set(const MassProps& props, bool keeps_weight = false) {
        if (rigid_) {
            const btVector3 weight_n = rigid_->*member(OwnWeight{});
            rigid_->setMassProps(props.mass_kg, props.inertia_kg_m2);
            rigid_->updateInertiaTensor();
            if (keeps_weight) rigid_->*member(OwnWeight{}) = weight_n;
        } else if (is_base()) {
            multibody().setBaseMass(props.mass_kg);
            multibody().setBaseInertia(props.inertia_kg_m2);
        } else {
            link().m_mass = props.mass_kg;
            link().m_inertiaLocal = props.inertia_kg_m2;
        }
    }
    /// Applies it until take_off.
    void lend(const btVector3& force_n, const btVector3& torque_n_m) {
        apply(force_n, torque_n_m);
        LentForce::lend(torque_sum());
    }
    /// Nothing, where its host has cleared its forces since.
    void take_off(const btVector3& force_n, const btVector3& torque_n_m) {
        if (LentForce::take(torque_sum())) apply(-force_n, -torque_n_m);
    }
    /// Of a rigid body. Its change of speed.
    btVector3 turn(const btVector3& impulse_n_m_s) {
        const btVector3 before = rigid_->getAngularVelocity();
        rigid_->applyTorqueImpulse(impulse_n_m_s);
        return rigid_->getAngularVelocity() - before;
    }

  private:
    const btVector3& torque_sum() const {
        if (rigid_) return rigid_->getTotalTorque();
        return is_base() ? multibody().getBaseTorque() : link().m_appliedTorque;
    }
    void apply(const btVector3& force_n, const btVector3& torque_n_m) {
        if (rigid_) {
            rigid_->applyCentralForce(force_n);
            rigid_->applyTorque(torque_n_m);
        } else if (is_base()) {
            multibody().addBaseForce(force_n);
            multibody().addBaseTorque(torque_n_m);
        } else {
            multibody().addLinkForce(collider_->m_link, force_n);
            multibody().addLinkTorque(collider_->m_link, torque_n_m);
        }
    }
    btMultiBody& multibody() const { return *collider_->m_multiBody; }
    bool is_base() const { return collider_->m_link < 0; }
    bool is_fixed() const { return is_base() && multibody().hasFixedBase(); }
    btMultibodyLink& link() const { return multibody().getLink(collider_->m_link); }

    btRigidBody* rigid_;
    btMultiBodyLinkCollider* collider_;
    const btTransform& axes_;
};

/// Moments of inertia of a mass at `arm`, a vector in a body's axes, about the body's centre.
btVector3 point_inertia(btScalar mass_kg, const btVector3& arm) {
    btVector3 out(0, 0, 0);
    for (int i = 0; i < 3; ++i) out[i] = mass_kg * (arm.length2() - arm[i] * arm[i]);
    return out;
}

Vec3 arm_of(const BodyState& body, const BodyLoad& load) {
    return load.center_m - body.motion.center_of_mass_m;
}

/// What walls hold of a load, times its arm about a body's centre.
btVector3 held_arm_kg_m(const BodyLoad& load, const btVector3& center_m) {
    return to_bullet(load.held_kg_m - load.held_kg * from_bullet(center_m));
}

bool is_jointed(const btDiscreteDynamicsWorld& world, const btRigidBody& body) {
    for (int i = 0; i < world.getNumConstraints(); ++i) {
        const btTypedConstraint& joint = *world.getConstraint(i);
        if (SubstepRows::is_row(joint)) continue;  // of another soil of this world
        if (&joint.getRigidBodyA() == &body || &joint.getRigidBodyB() == &body) return true;
    }
    return false;
}

struct Momentum {
    Vec3 linear_n_s, angular_n_m_s;
};

/// What a load gets that Bullet's solver takes along while its body's motion changes by so much.
Momentum momentum_of_load(const BodyState& before, const BodyLoad& load, Vec3 faster_m_s,
                          Vec3 faster_rad_s) {
    const Quat axes = before.motion.pose.rotation;
    const auto to_body = [&axes](Vec3 v) { return to_bullet(rotate(conjugate(axes), v)); };
    const btVector3 inertia =
        point_inertia(static_cast<btScalar>(load.mass_kg), to_body(arm_of(before, load)));
    return {load.mass_kg * faster_m_s, rotate(axes, from_bullet(inertia * to_body(faster_rad_s)))};
}

}  // namespace

CarriedLoads::CarriedLoads(btDiscreteDynamicsWorld& world, Vec3 up, double gravity_m_s2)
    : world_(world), up_(up), gravity_m_s2_(gravity_m_s2) {}

void CarriedLoads::note_given(std::span<const BodyLoad> loads) {
    for (const BodyLoad& load : loads) given_[load.body] += load.impulse_n_s;
}

CarriedLoads::Share CarriedLoads::share_of(const Loaded& loaded) {
    const Quat axes = loaded.body.motion.pose.rotation;
    const Vec3 arm_m = rotate(conjugate(axes), arm_of(loaded.body, loaded.load));
    const double mass_kg = loaded.load.mass_kg;
    return {mass_kg, point_inertia(static_cast<btScalar>(mass_kg), to_bullet(arm_m))};
}

/// A body and its load owe together: soil that has left takes its share of the debt along, by mass
/// of what shifts the body and by moment of inertia of what turns it. Else a light body would pay
/// alone for what its heavy load got, and fly off.
void CarriedLoads::share_debt(Loaded& loaded, const Share& before) {
    const Share now = share_of(loaded);
    const double left_kg = before.mass_kg - now.mass_kg;
    if (!(left_kg > 0)) return;
    const LoadedBody body(loaded.body);
    const double kept = 1 - left_kg / (static_cast<double>(body.mass_kg()) + before.mass_kg);
    loaded.debt_n_s = kept * loaded.debt_n_s;
    const btVector3 own = body.inertia_kg_m2();
    const Quat axes = loaded.body.motion.pose.rotation;
    btVector3 turning = to_bullet(rotate(conjugate(axes), loaded.debt_n_m_s));
    for (int i = 0; i < 3; ++i) {
        const btScalar then = own[i] + before.inertia_kg_m2[i];
        // What has slid outwards meanwhile owes no more than it did.
        if (then > 0) turning[i] *= std::min(btScalar(1), (own[i] + now.inertia_kg_m2[i]) / then);
    }
    loaded.debt_n_m_s = rotate(axes, from_bullet(turning));
}

/// The entry of a load's body, with what it has paid for meanwhile; null where it bears none.
CarriedLoads::Loaded* CarriedLoads::find_loaded(std::span<const BodyState> bodies,
                                                std::map<int, Loaded>& before,
                                                const BodyLoad& load) {
    const auto body = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const BodyState& b) { return b.id == load.body; });
    if (body == bodies.end() || body->is_asleep) return nullptr;
    if (body->role != BodyRole::rigid && body->role != BodyRole::link) return nullptr;
    Loaded& loaded = loaded_[load.body];
    if (const auto old = before.find(load.body); old != before.end()) {
        loaded = old->second;
        const BodyMotion &then = loaded.body.motion, &now = body->motion;
        const Momentum solved = momentum_of_load(
            loaded.body, loaded.load, now.linear_velocity_m_s - then.linear_velocity_m_s,
            now.angular_velocity_rad_s - then.angular_velocity_rad_s);
        loaded.debt_n_s = loaded.debt_n_s - solved.linear_n_s;
        loaded.debt_n_m_s = loaded.debt_n_m_s - solved.angular_n_m_s;
        before.erase(old);
    } else {
        note_left(*body, loaded);
    }
    loaded.body = *body;
    loaded.load = load;
    return &loaded;
}

/// For the kernels a body has no end of mass. Theirs is a light one between soil above and below it
/// that it takes along by turns, each time with more momentum: a push has to end where the body is
/// as fast as the fastest soil. What is more is forgiven. What carries soil that it can hold has
/// that one's mass in the solver, and debts that it gets back.
void CarriedLoads::forgive_excess(std::span<const BodyState> bodies, double soil_speed_m_s,
                                  Loaded& loaded) const {
    const double debt_n_s = length(loaded.debt_n_s);
    const LoadedBody body(loaded.body);
    if (!body.rigid() || !(debt_n_s > 0)) return;
    const double own_kg = body.moved_kg(), load_kg = loaded.load.mass_kg;
    if (load_kg > 0 && load_kg <= kCoupling.load_most * own_kg) return;
    const Vec3 push = loaded.debt_n_s * (-1 / debt_n_s);
    const double speed_m_s = dot(loaded.body.motion.linear_velocity_m_s, push);
    const auto most_n_s = [&](double fastest_m_s) {
        return (own_kg + load_kg) * std::max(0.0, fastest_m_s - speed_m_s);
    };
    if (debt_n_s <= most_n_s(soil_speed_m_s)) return;
    double fastest_m_s = soil_speed_m_s;  // and what other bodies take along
    for (const BodyState& other : bodies) {
        if (other.id == loaded.body.id) continue;
        fastest_m_s = std::max(fastest_m_s, length(other.motion.linear_velocity_m_s));
    }
    const double kept = most_n_s(fastest_m_s) / debt_n_s;
    // Others may hold what is jointed to them: it bears all of a push, however light it is.
    if (kept >= 1 || is_jointed(world_, *body.rigid())) return;
    loaded.debt_n_s = kept * loaded.debt_n_s;
    loaded.debt_n_m_s = kept * loaded.debt_n_m_s;
}

void CarriedLoads::set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                             double interval_s, double soil_speed_m_s) {
    std::map<int, Loaded> before;
    before.swap(loaded_);
    const auto share_before = [&before](int body) {
        const auto old = before.find(body);
        return old == before.end() ? Share{} : share_of(old->second);
    };
    for (const BodyLoad& load : loads) {
        const Share share = share_before(load.body);
        Loaded* loaded = find_loaded(bodies, before, load);
        if (!loaded) continue;
        const Vec3 given_n_s = given_[load.body];
        loaded->debt_n_s += given_n_s;
        loaded->debt_n_m_s += cross(arm_of(loaded->body, load), given_n_s);
        share_debt(*loaded, share);
    }
    // A load that is gone may have left a debt.
    std::map<int, Loaded> gone;
    gone.swap(before);
    for (auto& [id, loaded] : gone) {
        if (loaded.load.mass_kg <= 0) continue;
        before.emplace(id, loaded);
        Loaded* empty =
            find_loaded(bodies, before, {id, 0, loaded.body.motion.center_of_mass_m, {}});
        if (empty) share_debt(*empty, share_of(loaded));
    }
    given_.clear();
    for (auto& [id, loaded] : loaded_) {
        forgive_excess(bodies, soil_speed_m_s, loaded);
        const double most_kg = kCoupling.load_most * LoadedBody(loaded.body).moved_kg();
        const double share = std::min(1.0, most_kg / std::max(most_kg, loaded.load.mass_kg));
        loaded.push_n = loaded.debt_n_s * (-share / interval_s);
        loaded.push_n_m = loaded.debt_n_m_s * (-share / interval_s);
    }
}

/// Where Bullet leaves a body, and the motion in which it leaves a rigid one.
void CarriedLoads::note_left(const BodyState& body, Loaded& loaded) {
    loaded.left_m = from_bullet(body.object->getWorldTransform().getOrigin());
    const btRigidBody* rigid = LoadedBody(body).rigid();
    if (!rigid) return;
    loaded.left_m_s = from_bullet(rigid->getLinearVelocity());
    loaded.left_rad_s = from_bullet(rigid->getAngularVelocity());
}

/// What the load has not got yet of a change of its body's motion since then.
void CarriedLoads::add_push_since_left(const btRigidBody& rigid, Loaded& loaded) const {
    const auto substep_s = static_cast<double>(world_.getDispatchInfo().m_timeStep);
    if (!(substep_s > 0)) return;
    const Vec3 faster_m_s = from_bullet(rigid.getLinearVelocity()) - loaded.left_m_s;
    const Vec3 faster_rad_s = from_bullet(rigid.getAngularVelocity()) - loaded.left_rad_s;
    const Momentum due = momentum_of_load(loaded.body, loaded.load, faster_m_s, faster_rad_s);
    loaded.force_n += to_bullet(due.linear_n_s * (-1 / substep_s));
    loaded.torque_n_m += to_bullet(due.angular_n_m_s * (-1 / substep_s));
}

/// Between substeps no time passes: only its host moves a body then.
bool CarriedLoads::is_left_behind(const Loaded& loaded, double swept_most_m) const {
    if (loaded.open || !is_in_world(world_, loaded.body)) return false;
    const Vec3 now_m = from_bullet(loaded.body.object->getWorldTransform().getOrigin());
    return length(now_m - loaded.left_m) > swept_most_m;
}

/// By an action of its host's, in the substep that ends: it is left behind in the next.
bool CarriedLoads::is_put_elsewhere(const Loaded& loaded, double substep_s) const {
    const btRigidBody* rigid = LoadedBody(loaded.body).rigid();
    if (!rigid) return false;
    const Vec3 now_m = from_bullet(rigid->getWorldTransform().getOrigin());
    const auto speed_m_s = static_cast<double>(rigid->getInterpolationLinearVelocity().length());
    return length(now_m - loaded.left_m) > swept_most_m_ + substep_s * speed_m_s;
}

void CarriedLoads::open_substep(double swept_most_m) {
    swept_most_m_ = swept_most_m;
    felt_n_.clear();
    std::erase_if(loaded_,
                  [&](const auto& entry) { return is_left_behind(entry.second, swept_most_m); });
    if (loaded_.empty()) return;
    int soil_count = 0;
    const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        soil_count += WorldAnchor::grid_of(*objects[i]) != nullptr;
    }
    for (auto& [id, loaded] : loaded_) {
        if (is_in_world(world_, loaded.body)) open(loaded, soil_count == 1);
    }
}

void CarriedLoads::open(Loaded& loaded, bool is_only_soil) {
    LoadedBody body(loaded.body);
    if (loaded.open || !body.is_active()) return;
    // Bullet keeps inverses: read back, the host's mass would drift by a rounding a substep.
    if (loaded.own_mass_kg <= 0 || !body.has({loaded.own_mass_kg, loaded.own_inertia})) {
        loaded.own_mass_kg = body.mass_kg();
        loaded.own_inertia = body.inertia_kg_m2();
    }
    const btVector3 arm_m = to_bullet(loaded.load.center_m) - body.axes().getOrigin();
    loaded.force_n = to_bullet(loaded.push_n);
    loaded.torque_n_m = to_bullet(loaded.push_n_m);
    loaded.felt_n = loaded.push_n;
    if (loaded.load.mass_kg > 0) {
        const btVector3 weight_n = to_bullet(-loaded.load.mass_kg * gravity_m_s2_ * up_);
        loaded.force_n += weight_n;
        loaded.torque_n_m += arm_m.cross(weight_n);
        loaded.felt_n = from_bullet(loaded.force_n);
        if (body.rigid()) add_push_since_left(*body.rigid(), loaded);
        const auto mass_kg = static_cast<btScalar>(loaded.load.mass_kg);
        const btVector3 more = point_inertia(mass_kg, body.axes().getBasis().transpose() * arm_m);
        btVector3 inertia = loaded.own_inertia;
        for (int i = 0; i < 3; ++i) {
            if (inertia[i] > 0) inertia[i] += more[i];
        }
        body.set({loaded.own_mass_kg + mass_kg, inertia}, true);
    }
    if (loaded.load.held_kg != 0) {
        const btVector3 lift_m_s2 = to_bullet(gravity_m_s2_ * up_);
        const auto held_kg = static_cast<btScalar>(loaded.load.held_kg);
        loaded.force_n += held_kg * lift_m_s2;
        loaded.torque_n_m += held_arm_kg_m(loaded.load, body.axes().getOrigin()).cross(lift_m_s2);
        loaded.felt_n += from_bullet(held_kg * lift_m_s2);
    }
    // A rigid body gets its torque at once: Bullet's friction rows leave out applied torque, and
    // what is loaded beside its middle would creep. Another soil would take it for the host's, and
    // so would what has no substep to come.
    const btScalar substep_s = world_.getDispatchInfo().m_timeStep;
    loaded.turned_rad_s.setZero();
    if (body.rigid() && is_only_soil && substep_s > 0) {
        loaded.turned_rad_s = body.turn(substep_s * loaded.torque_n_m);
        loaded.torque_n_m.setZero();
    }
    body.lend(loaded.force_n, loaded.torque_n_m);
    loaded.open = true;
}

void CarriedLoads::close_substep(double substep_s) {
    for (auto& [id, loaded] : loaded_) {
        const bool was_open = std::exchange(loaded.open, false);
        if ((!was_open && substep_s <= 0) || !is_in_world(world_, loaded.body)) continue;
        if (substep_s > 0 && !is_put_elsewhere(loaded, substep_s)) note_left(loaded.body, loaded);
        if (!was_open) continue;
        felt_n_[id] = loaded.felt_n;
        loaded.debt_n_s += loaded.push_n * substep_s;
        loaded.debt_n_m_s += loaded.push_n_m * substep_s;
        LoadedBody body(loaded.body);
        // Forces outlive a substep; a turn is a part of what Bullet has solved, if it has.
        body.take_off(loaded.force_n, loaded.torque_n_m);
        if (substep_s <= 0 && body.rigid()) {
            btRigidBody& rigid = *body.rigid();
            rigid.setAngularVelocity(rigid.getAngularVelocity() - loaded.turned_rad_s);
        }
        // Another soil of this world may have loaded it too, and the one that came first has taken
        // both loads off already.
        if (loaded.load.mass_kg <= 0 ||
            body.mass_kg() < loaded.own_mass_kg + static_cast<btScalar>(loaded.load.mass_kg) / 2) {
            continue;
        }
        body.set({loaded.own_mass_kg, loaded.own_inertia});
    }
}

Vec3 CarriedLoads::felt_n(int body) const {
    const auto felt = felt_n_.find(body);
    return felt == felt_n_.end() ? Vec3{} : felt->second;
}

void CarriedLoads::let_go() {
    close_substep(0);
    loaded_.clear();
    given_.clear();
    felt_n_.clear();
}

}  // namespace bsoil::bullet
