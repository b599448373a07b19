#include "built_world.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bullet_types.h"
#include "world_hash.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;
using bullet::SoilAction;
using bullet::to_bullet;
using bullet::transform_to_bullet;

namespace {

/// Frames of a variable world, as shares of the longest.
constexpr double kFrameShares[] = {1, 0.4, 0.75, 1, 1.0 / 3, 0.9, 0.5};
/// Of a chain that hangs from a fixed base, once it is left alone [1/s]: clear of all soil it would
/// swing for good. It kept awake what was in its island, as far as 4 cm away: Bullet's broadphase
/// widens the boxes of what moves by 5 cm. A swing is down to a hundredth in 5 s.
constexpr btScalar kHingeDamping = 2;
/// Below the lowest soil by so many grid heights lies a floor.
constexpr double kFloorBelow = 0.5;

}  // namespace

/// Looks before any soil acts: one that renews the surface that Bullet sees drops its contacts.
class BuiltWorld::ContactWatch final : public btActionInterface {
  public:
    explicit ContactWatch(BuiltWorld& built) : built_(built) {}
    void updateAction(btCollisionWorld* world, btScalar) override {
        built_.add_contact_work();
        btDispatcher& dispatcher = *world->getDispatcher();
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold.getNumContacts(); ++k) {
                const double apart_m =
                    static_cast<double>(manifold.getContactPoint(k).getDistance());
                built_.deepest_overlap_m_ = std::max(built_.deepest_overlap_m_, -apart_m);
            }
        }
    }
    void debugDraw(btIDebugDraw*) override {}

  private:
    BuiltWorld& built_;
};

BuiltWorld::BuiltWorld(const WorldPlan& plan, const BuildOptions& options, int start_step)
    : plan_(plan), up_(plan.soils[0].def.up == UpAxis::y ? Vec3{0, 1, 0} : Vec3{0, 0, 1}) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_ = std::make_unique<btMultiBodyDynamicsWorld>(&dispatcher_, &broadphase_, &solver_,
                                                        &configuration_);
    world_->setInternalTickCallback(
        [](btDynamicsWorld* world, btScalar substep_s) {
            auto& of = *static_cast<BuiltWorld*>(world->getWorldUserInfo());
            of.add_joint_work(static_cast<double>(substep_s));
            of.add_poured_work(static_cast<double>(substep_s));
            if (of.on_substep) of.on_substep();
        },
        this);
    world_->setInternalTickCallback(
        [](btDynamicsWorld* world, btScalar) {
            static_cast<BuiltWorld*>(world->getWorldUserInfo())->note_motion();
        },
        this, true);
    world_->getSolverInfo().m_numIterations = plan_.solver_iterations;
    contact_watch_ = std::make_unique<ContactWatch>(*this);
    world_->addAction(contact_watch_.get());
    world_->setGravity(to_bullet(-gravity_m_s2() * up_));
    for (const SoilPlan& soil : plan_.soils) {
        add_soil(soil, options);
        if (!error_.empty()) return;
    }
    filled_.resize(soils_.size());
    filled_water_.resize(soils_.size());
    add_floor();
    build_bodies();
    for (const JointPlan& joint : plan_.joints) {
        if (!joint.dropped) add_joint(joint);
    }
    for (const ChainPlan& chain : plan_.chains) {
        if (!chain.dropped) add_chain(chain);
    }
    for (const CarPlan& car : plan_.cars) {
        if (!car.dropped) add_car(car);
    }
    for (; step_ < start_step; ++step_) apply_step(step_, true);
}

BuiltWorld::~BuiltWorld() {
    cars_.clear();
    soils_.clear();
    for (const Joint& joint : joints_) world_->removeConstraint(joint.bullet.get());
    for (const Chain& chain : chains_) {
        if (chain.motor) world_->removeMultiBodyConstraint(chain.motor.get());
        for (const auto& collider : chain.colliders) world_->removeCollisionObject(collider.get());
        world_->removeMultiBody(chain.multibody.get());
    }
    for (const auto& chassis : chassis_) world_->removeRigidBody(chassis.get());
    for (const Body& body : bodies_) {
        if (body.is_in) world_->removeRigidBody(body.bullet.get());
    }
    if (floor_) world_->removeRigidBody(floor_.get());
}

Pose BuiltWorld::to_world(int soil, const Pose& pose) const {
    return soils_[static_cast<size_t>(soil)]->soil().frame().grid_to_world * pose;
}

std::vector<SoilAction*> BuiltWorld::soils() const {
    std::vector<SoilAction*> out;
    for (const auto& soil : soils_) out.push_back(soil.get());
    return out;
}

btRigidBody* BuiltWorld::body(int index) const {
    const Body& body = bodies_[static_cast<size_t>(index)];
    return body.is_in ? body.bullet.get() : nullptr;
}

// --- soils

void BuiltWorld::add_soil(const SoilPlan& plan, const BuildOptions& options) {
    SoilDef def = plan.def;
    def.backend = options.backend;
    def.thread_count = options.thread_count;
    // Grid x and y run along the world's Z and X where Y is up.
    const Vec3 s = plan.def.size_m;
    if (def.up == UpAxis::y) def.size_m = {s.y, s.z, s.x};
    auto made = SoilAction::create(*world_, def);
    if (!made) {
        error_ = "soil: " + made.error();
        return;
    }
    soils_.push_back(std::move(*made));
    Soil& soil = soils_.back()->soil();
    const GridFrame& frame = soil.frame();
    const double voxel_m = def.voxel_m;
    if (plan.terrain_m > 0) {
        const Status done = soil.add_terrain([&](Vec3 world_m) {
            const Vec3 at = frame.to_grid(world_m) * voxel_m;
            return plan.terrain_m + plan.terrain_slope * (at.x - s.x / 2) - at.z;
        });
        if (!done) error_ = "terrain: " + done.error();
    }
    for (const FillPlan& f : plan.fills) {
        if (f.dropped) continue;
        const Status done = fill(static_cast<int>(soils_.size()) - 1, f);
        // All of its room may be another fill's or the terrain's.
        if (!done && done.error().find("holds no soil") == std::string::npos) {
            error_ = "fill: " + done.error();
            return;
        }
    }
    add_flows(static_cast<int>(soils_.size()) - 1);
}

Status BuiltWorld::fill(int index, const FillPlan& f) {
    Soil& soil = soils_[static_cast<size_t>(index)]->soil();
    const GridFrame& frame = soil.frame();
    const double voxel_m = frame.voxel_m;
    const std::string& material = soil.materials()[static_cast<size_t>(f.material)].name;
    if (f.kind == FillPlan::Kind::noise) {
        NoiseFill noise;
        noise.base_m = 0.75 * f.high_m.z;
        noise.amplitude_m = 0.2 * f.high_m.z;
        noise.wavelength_m = 0.5 * f.high_m.x;
        noise.seed = static_cast<unsigned>(f.seed);
        noise.material = material;
        return soil.fill(noise);
    }
    const Vec3 middle = 0.5 * (f.low_m + f.high_m), half = 0.5 * (f.high_m - f.low_m);
    return soil.fill(
        FunctionFill{[&](Vec3 world_m) {
                         const Vec3 at = frame.to_grid(world_m) * voxel_m;
                         const Vec3 d{(at.x - middle.x) / half.x, (at.y - middle.y) / half.y, 0};
                         const double out = f.kind == FillPlan::Kind::box
                                                ? std::max(std::abs(d.x), std::abs(d.y))
                                                : std::hypot(d.x, d.y);
                         const double top = f.kind == FillPlan::Kind::hill
                                                ? f.low_m.z + (1 - out) * (f.high_m.z - f.low_m.z)
                                                : f.high_m.z;
                         return std::min({1 - out, at.z - f.low_m.z, top - at.z});
                     },
                     material});
}

// --- bodies

/// For what leaves the grid; the soil does not see it.
void BuiltWorld::add_floor() {
    double lowest = std::numeric_limits<double>::infinity(), reach = 0;
    for (const auto& soil : soils_) {
        const GridFrame& frame = soil->soil().frame();
        lowest = std::min(lowest, dot(frame.to_world({0, 0, 0}), up_));
        reach = std::max(reach, frame.voxel_m * frame.size[2]);
    }
    ShapePlan plane;
    plane.kind = ShapePlan::Kind::plane;
    plane.half_m = up_;
    floor_ = std::make_unique<btRigidBody>(scalar(0), nullptr, &shapes_.make(plane));
    floor_->setWorldTransform(transform_to_bullet({(lowest - kFloorBelow * reach) * up_, Quat{}}));
    // What has left rolls no farther than soil would let it.
    floor_->setFriction(1);
    floor_->setRollingFriction(scalar(reach));
    floor_->setSpinningFriction(scalar(reach));
    world_->addRigidBody(floor_.get());
    for (const auto& soil : soils_) {
        if (const Status done = soil->set_options(*floor_, {.ignored = true}); !done) {
            error_ = done.error();
        }
    }
}

void BuiltWorld::build_bodies() {
    bodies_.resize(plan_.bodies.size());
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const BodyPlan& plan = plan_.bodies[i];
        if (plan.dropped) continue;
        btCollisionShape& shape = shapes_.make(plan.shape);
        btVector3 inertia(0, 0, 0);
        if (plan.kind == BodyPlan::Kind::moving) {
            shape.calculateLocalInertia(scalar(plan.mass_kg), inertia);
        }
        const btTransform pose = transform_to_bullet(to_world(plan.soil, plan.pose));
        Body& body = bodies_[i];
        body.motion = std::make_unique<btDefaultMotionState>(pose);
        btRigidBody::btRigidBodyConstructionInfo info(
            scalar(plan.kind == BodyPlan::Kind::moving ? plan.mass_kg : 0), body.motion.get(),
            &shape, inertia);
        info.m_friction = scalar(plan.friction);
        body.bullet = std::make_unique<btRigidBody>(info);
        body.bullet->setUserIndex(static_cast<int>(i));
        if (plan.kind == BodyPlan::Kind::driven) {
            body.bullet->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            body.bullet->setActivationState(DISABLE_DEACTIVATION);
        }
        const Quat frame =
            soils_[static_cast<size_t>(plan.soil)]->soil().frame().grid_to_world.rotation;
        if (plan.kind == BodyPlan::Kind::moving) {
            body.bullet->setLinearVelocity(to_bullet(rotate(frame, plan.velocity_m_s)));
            body.bullet->setAngularVelocity(to_bullet(rotate(frame, plan.spin_rad_s)));
        }
        if (plan.enters_step == 0) enter(static_cast<int>(i));
    }
}

void BuiltWorld::enter(int index) {
    Body& body = bodies_[static_cast<size_t>(index)];
    const BodyPlan& plan = plan_.bodies[static_cast<size_t>(index)];
    if (!body.bullet || body.is_in) return;
    body.is_in = true;
    if (plan.kind == BodyPlan::Kind::driven) {  // it comes in where it is, it does not jump there
        const btTransform here = transform_to_bullet(driven_pose(plan));
        body.motion->setWorldTransform(here);
        body.bullet->setWorldTransform(here);
        body.bullet->setInterpolationWorldTransform(here);
    }
    world_->addRigidBody(body.bullet.get());
    const bullet::BodyOptions options{.ignored = plan.is_ignored,
                                      .coverage_only = plan.is_coverage_only,
                                      .surface = {.friction = plan.surface_friction}};
    for (const auto& soil : soils_) {
        if (const Status done = soil->set_options(*body.bullet, options); !done) {
            error_ = done.error();
        }
    }
}

void BuiltWorld::leave(int index) {
    Body& body = bodies_[static_cast<size_t>(index)];
    if (!body.is_in) return;
    body.is_in = false;
    // What slept on it would hang in the air: Bullet does not wake it, its host has to.
    btDispatcher& dispatcher = *world_->getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        if (manifold.getNumContacts() == 0) continue;
        for (const auto& [one, other] : {std::pair{manifold.getBody0(), manifold.getBody1()},
                                         std::pair{manifold.getBody1(), manifold.getBody0()}}) {
            if (one == body.bullet.get()) other->activate();
        }
    }
    world_->removeRigidBody(body.bullet.get());
}

// --- time

void BuiltWorld::happen(const EventPlan& event, bool only_structure) {
    const auto index = static_cast<size_t>(event.body);
    switch (event.kind) {
        case EventPlan::Kind::teleport:
        case EventPlan::Kind::push: {
            btRigidBody* moved = body(event.body);
            if (!moved || only_structure) return;
            const int soil = plan_.bodies[index].soil;
            if (event.kind == EventPlan::Kind::teleport) {
                btTransform pose = moved->getWorldTransform();
                pose.setOrigin(to_bullet(to_world(soil, {event.vector, Quat{}}).position));
                moved->setWorldTransform(pose);
                moved->setInterpolationWorldTransform(pose);
            } else {
                const Quat frame = to_world(soil, {}).rotation;
                moved->setLinearVelocity(moved->getLinearVelocity() +
                                         to_bullet(rotate(frame, event.vector)));
            }
            moved->activate();
            return;
        }
        case EventPlan::Kind::set_ignored:
        case EventPlan::Kind::set_coupled:
            if (btRigidBody* object = body(event.body)) {
                for (const auto& soil : soils_) {
                    bullet::BodyOptions options = soil->options(*object);
                    options.ignored = event.kind == EventPlan::Kind::set_ignored;
                    if (const Status done = soil->set_options(*object, options); !done) {
                        error_ = done.error();
                    }
                }
            }
            return;
        case EventPlan::Kind::fill: {
            if (only_structure) return;
            const double v = plan_.soils[index].def.voxel_m;
            const Vec3 half{3 * v, 3 * v, 2 * v};
            const SoilTotals before = soils_[index]->soil().totals();
            if (const Status done =
                    fill(event.body, {.low_m = event.vector - half, .high_m = event.vector + half});
                !done && done.error().find("all its room is taken") == std::string::npos) {
                error_ = "fill: " + done.error();
            }
            const SoilTotals now = soils_[index]->soil().totals();
            filled_[index] = now.units;
            for (size_t m = 0; m < before.units.size(); ++m) filled_[index][m] -= before.units[m];
            filled_water_[index] = now.water_units - before.water_units;
            return;
        }
        case EventPlan::Kind::disable:
        case EventPlan::Kind::enable:
            if (!only_structure) soils_[index]->set_enabled(event.kind == EventPlan::Kind::enable);
            return;
    }
}

void BuiltWorld::apply_step(int step, bool only_structure) {
    for (auto& units : filled_) units.clear();
    std::fill(filled_water_.begin(), filled_water_.end(), 0);
    touched_ = false;
    for (size_t i = 0; i < plan_.bodies.size(); ++i) {
        const BodyPlan& plan = plan_.bodies[i];
        if (plan.dropped || step == 0) continue;
        if (plan.enters_step == step) enter(static_cast<int>(i)), touched_ = true;
        if (plan.leaves_step == step) leave(static_cast<int>(i)), touched_ = true;
    }
    for (const EventPlan& event : plan_.events) {
        if (event.dropped || event.step != step) continue;
        happen(event, only_structure);
        touched_ = true;
    }
    if (!only_structure) change_flows(step);  // a snapshot knows where they are
    const double share =
        plan_.is_variable ? kFrameShares[static_cast<size_t>(step) % std::size(kFrameShares)] : 1;
    frame_s_ = plan_.frame_s * share;
    if (step < plan_.action_steps) driven_s_ += frame_s_;
    if (only_structure) time_s_ += frame_s_;
    if (step == plan_.action_steps) end_action();
}

Pose BuiltWorld::driven_pose(const BodyPlan& plan) const {
    const double rate = length(plan.spin_rad_s);
    Pose pose = plan.pose;
    pose.position += driven_s_ * plan.velocity_m_s;
    if (rate > 0) {
        const Vec3 axis = plan.spin_rad_s * (1 / rate), v = axis * std::sin(rate * driven_s_ / 2);
        pose.rotation = Quat{v.x, v.y, v.z, std::cos(rate * driven_s_ / 2)} * pose.rotation;
    }
    return to_world(plan.soil, pose);
}

void BuiltWorld::drive() {
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const BodyPlan& plan = plan_.bodies[i];
        if (plan.kind == BodyPlan::Kind::driven && bodies_[i].is_in) {
            bodies_[i].motion->setWorldTransform(transform_to_bullet(driven_pose(plan)));
        }
    }
}

/// Motors are left, brakes are put on.
void BuiltWorld::end_action() {
    for (const Joint& joint : joints_) {
        if (joint.plan.motor_most <= 0) continue;
        if (joint.plan.kind == JointPlan::Kind::hinge) {
            static_cast<btHingeConstraint&>(*joint.bullet).enableMotor(false);
        }
        if (joint.plan.kind == JointPlan::Kind::slider) {
            static_cast<btSliderConstraint&>(*joint.bullet).setPoweredLinMotor(false);
        }
    }
    for (const Chain& chain : chains_) {
        if (chain.motor) static_cast<btMultiBodyJointMotor&>(*chain.motor).setVelocityTarget(0);
        if (chain.multibody->hasFixedBase()) chain.multibody->setAngularDamping(kHingeDamping);
    }
    for (const Car& car : cars_) {
        for (int i = 0; i < 4; ++i) {
            car.vehicle->applyEngineForce(0, i);
            const btScalar mass = 1 / car.chassis->getInvMass();
            car.vehicle->setBrake(mass * scalar(gravity_m_s2() * plan_.frame_s), i);
        }
    }
}

void BuiltWorld::step() {
    apply_step(step_, false);
    drive();
    deepest_overlap_m_ = 0;
    if (plan_.is_variable) {
        world_->stepSimulation(scalar(frame_s_), 0);
    } else {
        const double substep_s = plan_.frame_s / plan_.substep_count;
        world_->stepSimulation(scalar(frame_s_), plan_.substep_count, scalar(substep_s));
    }
    time_s_ += frame_s_;
    ++step_;
    ++all_step_count_;
}

// --- questions

std::string BuiltWorld::name_of_object(const btCollisionObject& object) const {
    for (size_t i = 0; i < bodies_.size(); ++i) {
        if (bodies_[i].bullet.get() == &object) {
            return fmt::format("body {} ({})", i,
                               random_worlds::name_of(plan_.bodies[i].shape.kind));
        }
    }
    for (size_t i = 0; i < cars_.size(); ++i) {
        if (cars_[i].chassis == &object) return fmt::format("car {}", i);
    }
    for (size_t i = 0; i < chains_.size(); ++i) {
        for (size_t k = 0; k < chains_[i].colliders.size(); ++k) {
            if (chains_[i].colliders[k].get() == &object) {
                return fmt::format("chain {} link {}", i, static_cast<int>(k) - 1);
            }
        }
    }
    if (floor_.get() == &object) return "the floor below";
    return "an object of the soil";
}

uint64_t BuiltWorld::checksum() const {
    uint64_t hash = 0xcbf29ce484222325ull;
    for (const auto& soil : soils_) {
        const uint64_t of_soil = soil->soil().checksum();
        hash = add(hash, &of_soil, sizeof(of_soil));
    }
    hash = add_objects(hash, *world_);
    for (const Chain& chain : chains_) {
        for (int i = 0; i < chain.multibody->getNumDofs() + 6; ++i) {
            hash = add(hash, chain.multibody->getVelocityVector() + i, sizeof(btScalar));
        }
    }
    return hash;
}

bool BuiltWorld::is_all_asleep() const {
    const btCollisionObjectArray& objects = world_->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        if (!objects[i]->isStaticOrKinematicObject() && objects[i]->isActive() &&
            objects[i]->hasContactResponse()) {
            return false;
        }
    }
    for (const auto& soil : soils_) {
        if (soil->last_report().block_active_count > 0) return false;
    }
    return true;
}

}  // namespace bsoil::random_worlds
