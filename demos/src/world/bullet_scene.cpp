#include "bullet_scene.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "joint_resistance.h"
#include "robots/bullet_vectors.h"

namespace bsoil::scene {
namespace {

/// Share of a joint's position error that its motor takes back in one substep. All of it at once
/// makes a blocked joint jump when it comes free; this closes 99 % within 20 substeps.
constexpr double kMotorCorrection = 0.2;
/// A motor commanded slower than this (rad/s, m/s) lets its bodies fall asleep.
constexpr double kMotorRest = 1e-3;

/// A frame at `point` whose column `main` (0: x, 2: z) is `axis`; the next one is near `second`,
/// where given.
btTransform joint_frame(Vec3 point, Vec3 axis, int main, const Vec3* second = nullptr) {
    const btVector3 a = to_bullet(axis).normalized();
    btVector3 b = second ? to_bullet(*second) : btVector3(0, 0, 0);
    b -= a * a.dot(b);
    if (b.length2() < SIMD_EPSILON) {
        btVector3 unused;
        btPlaneSpace1(a, b, unused);
    }
    b.normalize();
    const btVector3 c = a.cross(b);
    // columns: the main axis, then the other two in right-handed order
    const btMatrix3x3 basis =
        main == 0 ? btMatrix3x3(a.x(), b.x(), c.x(), a.y(), b.y(), c.y(), a.z(), b.z(), c.z())
                  : btMatrix3x3(b.x(), c.x(), a.x(), b.y(), c.y(), a.y(), b.z(), c.z(), a.z());
    return btTransform(basis, to_bullet(point));
}

/// Angle of `child` against `parent` about the parent frame's axis `main`, right-handed, -pi..pi.
double relative_angle(const btTransform& parent, const btTransform& child, int main) {
    const btMatrix3x3 turn = parent.getBasis().transpose() * child.getBasis();
    const int a = (main + 1) % 3, b = (main + 2) % 3;
    return std::atan2(static_cast<double>(turn[b][a] - turn[a][b]),
                      static_cast<double>(turn[a][a] + turn[b][b]));
}

}  // namespace

BulletScene::BulletScene(const Scene& scene)
    : scene_(scene), substep_s_(scene.world.substep_s), dispatcher_(&configuration_) {
    const bool has_multibody = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                           [](const BodyItem& b) { return !b.multibody.empty(); });
    const bool has_files_multibody =
        std::any_of(scene.bullet_files.begin(), scene.bullet_files.end(),
                    [](const BulletFileItem& f) { return f.has_multibodies; });
    if (has_multibody || has_files_multibody) {
        solver_ = std::make_unique<btMultiBodyConstraintSolver>();
        auto world = std::make_unique<btMultiBodyDynamicsWorld>(
            &dispatcher_, &broadphase_, static_cast<btMultiBodyConstraintSolver*>(solver_.get()),
            &configuration_);
        multibody_world_ = world.get();
        world_ = std::move(world);
        world_->getPairCache()->setOverlapFilterCallback(&group_filter_);
    } else {
        solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
        world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_,
                                                           solver_.get(), &configuration_);
    }
    world_->setGravity(up() * scalar(-scene.world.gravity_m_s2));
    world_->getSolverInfo().m_numIterations = scene.world.solver_iterations;
}

BulletScene::~BulletScene() {
    multibodies_.clear();
    for (const auto& constraint : constraints_) world_->removeConstraint(constraint.get());
    bullet_files_.clear();
    for (const auto& body : owned_bodies_) world_->removeRigidBody(body.get());
}

Result<std::unique_ptr<BulletScene>> BulletScene::create(const Scene& scene) {
    std::unique_ptr<BulletScene> made(new BulletScene(scene));
    const Status built = made->build();
    if (!built) return Error{built.error()};
    return made;
}

Status BulletScene::build() {
    if (scene_.world.ground_plane) add_ground();
    std::vector<MultibodyItem> multibodies;
    for (const BodyItem& item : scene_.bodies) {
        if (!item.bullet_file.empty()) {
            bodies_.push_back({item.name, &item, Pose{}});
            continue;
        }
        auto shape = shapes_.make(scene_, item);
        if (!shape) return Error{shape.error()};
        bodies_.push_back({item.name, &item, from_bullet(shape->center)});
        if (item.multibody.empty()) {
            add_body(item, *shape);
        } else {
            add_to_multibody(item, *shape, multibodies);
        }
    }
    if (shapes_.has_gimpact()) btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    for (const BulletFileItem& item : scene_.bullet_files) {
        const Status added = add_bullet_file(item);
        if (!added) return added;
    }
    for (const MultibodyItem& item : multibodies) add_multibody(item);
    separate_groups();
    for (const JointItem& item : scene_.joints) add_joint(item);
    for (const MotionItem& item : scene_.motions) {
        Drive drive{Motion(item)};
        for (size_t i = 0; i < joints_.size(); ++i) {
            if (joints_[i].name == item.joint) drive.joint = static_cast<int>(i);
        }
        for (size_t i = 0; i < bodies_.size(); ++i) {
            if (bodies_[i].name == item.body) drive.body = static_cast<int>(i);
        }
        drives_.push_back(std::move(drive));
    }
    return Done{};
}

btVector3 BulletScene::up() const {
    return scene_.world.up == "y" ? btVector3(0, 1, 0) : btVector3(0, 0, 1);
}

void BulletScene::add_ground() {
    btRigidBody::btRigidBodyConstructionInfo info(
        0, nullptr, shapes_.make_plane(up(), scene_.world.ground_height_m));
    info.m_friction = 1;  // Bullet multiplies both bodies' friction
    owned_bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_->addRigidBody(owned_bodies_.back().get());
    ground_ = owned_bodies_.back().get();
}

Status BulletScene::add_bullet_file(const BulletFileItem& item) {
    auto file = BulletFile::load(item.path, *world_, to_bullet(item.pose));
    if (!file) return Error{scene_.message(item.where("file"), file.error())};
    for (SceneBody& body : bodies_) {
        if (body.item->bullet_file != item.name) continue;
        for (const BulletFile::Body& found : (*file)->bodies()) {
            if (item.name + '/' + found.name == body.name) body.object = body.body = found.body;
        }
        if (!body.object) {
            return Error{scene_.message(item.where("file"),
                                        "the file has changed meanwhile; load the scene anew")};
        }
    }
    bullet_files_.push_back(std::move(*file));
    return Done{};
}

std::vector<const btCollisionObject*> BulletScene::apart_from_soil() const {
    std::vector<const btCollisionObject*> objects;
    if (ground_) objects.push_back(ground_);
    for (const SceneBody& body : bodies_) {
        if (body.item->ignore_soil) objects.push_back(body.object);
    }
    return objects;
}

void BulletScene::add_body(const BodyItem& item, const SceneShapes::BodyShape& shape) {
    const bool moves = item.mass_kg > 0 && !item.kinematic;
    motion_states_.push_back(
        std::make_unique<btDefaultMotionState>(to_bullet(item.pose) * shape.center));
    btRigidBody::btRigidBodyConstructionInfo info(
        moves ? scalar(item.mass_kg) : 0, motion_states_.back().get(), shape.shape, shape.inertia);
    info.m_friction = scalar(item.friction);
    info.m_restitution = scalar(item.restitution);
    info.m_linearDamping = scalar(item.linear_damping);
    info.m_angularDamping = scalar(item.angular_damping);
    info.m_angularSleepingThreshold = scalar(item.sleep_rad_s);
    owned_bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = owned_bodies_.back().get();
    if (item.is_ghost) {
        body->setCollisionFlags(body->getCollisionFlags() |
                                btCollisionObject::CF_NO_CONTACT_RESPONSE);
    }
    if (item.kinematic) {
        body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        body->setActivationState(DISABLE_DEACTIVATION);
    }
    if (moves) {
        const btVector3 omega = to_bullet(item.angular_velocity_rad_s);
        const btVector3 arm = to_bullet(item.pose).getBasis() * shape.center.getOrigin();
        body->setLinearVelocity(to_bullet(item.velocity_m_s) + omega.cross(arm));
        body->setAngularVelocity(omega);
    }
    group_filter_.add(*body, item.group);
    if (item.is_ghost && item.kinematic) {
        world_->addRigidBody(body, 0, 0);  // rays pass through it as well
    } else {
        world_->addRigidBody(body);
    }
    bodies_.back().body = body;
    bodies_.back().object = body;
}

void BulletScene::add_to_multibody(const BodyItem& item, const SceneShapes::BodyShape& shape,
                                   std::vector<MultibodyItem>& multibodies) const {
    MultibodyLink link{&item, nullptr, -1, bodies_.size() - 1, shape};
    for (const JointItem& joint : scene_.joints) {
        if (joint.child == item.name) link.joint = &joint;
    }
    if (multibodies.empty() || multibodies.back().name != item.multibody) {
        multibodies.push_back({item.multibody, {}});
    }
    std::vector<MultibodyLink>& links = multibodies.back().links;
    for (size_t i = 0; link.joint && i < links.size(); ++i) {
        if (links[i].item->name == link.joint->parent) link.parent = static_cast<int>(i);
    }
    links.push_back(link);
}

void BulletScene::add_multibody(const MultibodyItem& item) {
    multibodies_.push_back(
        std::make_unique<SceneMultibody>(*multibody_world_, group_filter_, item, substep_s_));
    const SceneMultibody& made = *multibodies_.back();
    for (size_t i = 0; i < item.links.size(); ++i) {
        SceneBody& body = bodies_[item.links[i].body_index];
        body.multibody = &made.multibody();
        body.link = made.link_index(i);
        body.object = made.collider(i);
        if (!item.links[i].joint) continue;
        SceneJoint joint;
        joint.name = item.links[i].joint->name;
        joint.item = item.links[i].joint;
        joint.multibody = &made.multibody();
        joint.link = body.link;
        joint.link_motor = made.motor(i);
        joint.position = joint.item->start;
        joints_.push_back(joint);
    }
}

void BulletScene::separate_groups() {
    for (const SceneBody& a : bodies_) {
        for (const SceneBody& b : bodies_) {
            if (&a != &b && !a.item->group.empty() && a.item->group == b.item->group) {
                a.object->setIgnoreCollisionCheck(b.object, true);
            }
        }
    }
}

void BulletScene::add_joint(const JointItem& item) {
    SceneJoint joint;
    joint.name = item.name;
    joint.item = &item;
    joint.position = item.start;
    const SceneBody* parent = find_body(item.parent);
    joint.parent = parent ? parent->body : &btTypedConstraint::getFixedBody();
    joint.child = find_body(item.child)->body;
    if (!joint.child) return;  // a joint within a multibody
    const bool suspension = item.kind == "suspension";
    const btTransform frame =
        suspension ? joint_frame(item.point_m, item.axis, 0, &item.spring_axis)
                   : joint_frame(item.point_m, item.axis, item.kind == "slider" ? 0 : 2);
    joint.parent_frame = joint.parent->getWorldTransform().inverse() * frame;
    joint.child_frame = joint.child->getWorldTransform().inverse() * frame;

    std::unique_ptr<btTypedConstraint> made;
    if (item.kind == "hinge") {
        auto hinge = std::make_unique<btHingeConstraint>(
            *joint.parent, *joint.child, joint.parent_frame, joint.child_frame, true);
        if (item.lower_rad && *item.upper_rad - *item.lower_rad < 2 * std::numbers::pi) {
            hinge->setLimit(scalar(*item.lower_rad - item.start),
                            scalar(*item.upper_rad - item.start));
        }
        if (item.motor_torque_n_m > 0) {  // Bullet's limit of a hinge motor is an impulse
            hinge->enableAngularMotor(true, 0, scalar(item.motor_torque_n_m * substep_s_));
        }
        made = std::move(hinge);
    } else if (item.kind == "slider") {
        auto slider = std::make_unique<btSliderConstraint>(
            *joint.parent, *joint.child, joint.parent_frame, joint.child_frame, true);
        const bool is_limited = item.lower_m.has_value();
        slider->setLowerLinLimit(is_limited ? scalar(*item.lower_m - item.start) : 1);
        slider->setUpperLinLimit(is_limited ? scalar(*item.upper_m - item.start) : -1);
        slider->setLowerAngLimit(0);
        slider->setUpperAngLimit(0);
        if (item.motor_force_n > 0) {
            slider->setPoweredLinMotor(true);
            slider->setMaxLinMotorForce(scalar(item.motor_force_n));
        }
        made = std::move(slider);
    } else if (item.kind == "fixed") {
        made = std::make_unique<btFixedConstraint>(*joint.parent, *joint.child, joint.parent_frame,
                                                   joint.child_frame);
    } else if (item.kind == "point") {
        made = std::make_unique<btPoint2PointConstraint>(*joint.parent, *joint.child,
                                                         joint.parent_frame.getOrigin(),
                                                         joint.child_frame.getOrigin());
    } else if (item.kind == "planar") {
        auto plane = std::make_unique<btGeneric6DofSpring2Constraint>(
            *joint.parent, *joint.child, joint.parent_frame, joint.child_frame);
        plane->setLinearLowerLimit(btVector3(1, 1, 0));
        plane->setLinearUpperLimit(btVector3(-1, -1, 0));
        plane->setAngularLowerLimit(btVector3(0, 0, 1));
        plane->setAngularUpperLimit(btVector3(0, 0, -1));
        made = std::move(plane);
    } else {
        auto wheel = std::make_unique<btGeneric6DofSpring2Constraint>(
            *joint.parent, *joint.child, joint.parent_frame, joint.child_frame);
        // x: the axle, free to turn; y: the spring; everything else held
        const btScalar travel = scalar(item.travel_m);
        wheel->setLinearLowerLimit(btVector3(0, -travel, 0));
        wheel->setLinearUpperLimit(btVector3(0, travel, 0));
        wheel->setAngularLowerLimit(btVector3(1, 0, 0));
        wheel->setAngularUpperLimit(btVector3(-1, 0, 0));
        wheel->enableSpring(1, true);
        wheel->setStiffness(1, scalar(item.stiffness_n_m));
        wheel->setDamping(1, scalar(item.damping_n_s_m));
        wheel->setEquilibriumPoint(1, 0);
        if (item.motor_torque_n_m > 0) {
            wheel->enableMotor(3, true);
            wheel->setMaxMotorForce(3, scalar(item.motor_torque_n_m));
        }
        made = std::move(wheel);
    }
    world_->addConstraint(made.get(), !item.collide);
    joint.constraint = made.get();
    constraints_.push_back(std::move(made));
    if (item.resisting_friction > 0 || item.resisting_damping > 0) {
        const bool slides = item.kind == "slider";
        auto resistance =
            std::make_unique<JointResistance>(*joint.parent, *joint.child, joint.parent_frame,
                                              joint.child_frame, slides ? 0 : 2, slides);
        resistance->friction = scalar(item.resisting_friction);
        resistance->damping = scalar(item.resisting_damping);
        world_->addConstraint(resistance.get());
        constraints_.push_back(std::move(resistance));
    }
    joints_.push_back(joint);
}

const SceneBody* BulletScene::find_body(const std::string& name) const {
    const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                    [&](const SceneBody& b) { return b.name == name; });
    return found == bodies_.end() ? nullptr : &*found;
}

void BulletScene::set_lever(size_t joint, std::optional<double> velocity) {
    if (joint >= joints_.size() || !joints_[joint].has_motor()) return;
    levers_.resize(joints_.size());
    // Without a motion nobody else would stop it.
    if (levers_[joint] && !velocity) set_motor(joints_[joint], 0);
    levers_[joint] = velocity;
}

BulletScene::Progress BulletScene::progress() const {
    Progress progress;
    progress.substep_count = substep_count_;
    for (const SceneJoint& joint : joints_) progress.joint_positions.push_back(joint.position);
    return progress;
}

void BulletScene::set_progress(const Progress& progress) {
    substep_count_ = progress.substep_count;
    for (size_t i = 0; i < joints_.size(); ++i) joints_[i].position = progress.joint_positions[i];
}

void BulletScene::update_joint_positions() {
    for (SceneJoint& joint : joints_) {
        const double start = joint.item->start;
        if (joint.multibody) {
            joint.position = start + joint.multibody->getJointPos(joint.link);
            continue;
        }
        const btTransform parent = joint.parent->getWorldTransform() * joint.parent_frame;
        const btTransform child = joint.child->getWorldTransform() * joint.child_frame;
        if (joint.item->kind == "slider") {
            joint.position =
                start + parent.getBasis().getColumn(0).dot(child.getOrigin() - parent.getOrigin());
            continue;
        }
        const double angle =
            start + relative_angle(parent, child, joint.item->kind == "suspension" ? 0 : 2);
        joint.position += std::remainder(angle - joint.position, 2 * std::numbers::pi);
    }
}

void BulletScene::drive(const Drive& drive) {
    const double end_s = time_s() + substep_s_;
    if (drive.body >= 0) {
        const SceneBody& body = bodies_[static_cast<size_t>(drive.body)];
        body.body->getMotionState()->setWorldTransform(
            to_bullet(drive.motion.pose(end_s) * body.frame_to_center));
        return;
    }
    const SceneJoint& joint = joints_[static_cast<size_t>(drive.joint)];
    double velocity = drive.motion.value(end_s);
    if (drive.motion.quantity() == Motion::Quantity::position) {
        const double planned = (velocity - drive.motion.value(time_s())) / substep_s_;
        const double error = drive.motion.value(time_s()) - joint.position;
        velocity = planned + kMotorCorrection * error / substep_s_;
    }
    set_motor(joint, velocity);
}

void BulletScene::drive_mimics() {
    for (const SceneJoint& joint : joints_) {
        if (!joint.item->mimic) continue;
        const JointMimic& mimic = *joint.item->mimic;
        const auto source = std::find_if(joints_.begin(), joints_.end(), [&](const SceneJoint& j) {
            return j.name == mimic.joint;
        });
        // A source that is locked stays where it was when the joint's start was reckoned.
        const double target = source == joints_.end()
                                  ? joint.item->start
                                  : mimic.multiplier * source->position + mimic.offset;
        set_motor(joint, kMotorCorrection * (target - joint.position) / substep_s_);
    }
}

void BulletScene::set_motor(const SceneJoint& joint, double velocity) {
    if (joint.item->max_velocity) {
        velocity = std::clamp(velocity, -*joint.item->max_velocity, *joint.item->max_velocity);
    }
    if (joint.multibody) {
        if (std::abs(velocity) > kMotorRest) joint.multibody->wakeUp();
        joint.link_motor->setVelocityTarget(scalar(velocity));
        return;
    }
    if (std::abs(velocity) > kMotorRest) {
        joint.parent->activate();
        joint.child->activate();
    }
    switch (joint.constraint->getConstraintType()) {
        case HINGE_CONSTRAINT_TYPE:
            static_cast<btHingeConstraint*>(joint.constraint)
                ->setMotorTargetVelocity(scalar(velocity));
            break;
        case SLIDER_CONSTRAINT_TYPE:
            static_cast<btSliderConstraint*>(joint.constraint)
                ->setTargetLinMotorVelocity(scalar(velocity));
            break;
        default:  // this constraint counts its angles from child to parent
            static_cast<btGeneric6DofSpring2Constraint*>(joint.constraint)
                ->setTargetVelocity(3, scalar(-velocity));
    }
}

void BulletScene::substep() {
    const auto lever_of = [this](size_t joint) {
        return joint < levers_.size() ? levers_[joint] : std::optional<double>();
    };
    for (const Drive& d : drives_) {
        if (d.joint < 0 || !lever_of(static_cast<size_t>(d.joint))) drive(d);
    }
    for (size_t j = 0; j < levers_.size(); ++j) {
        if (levers_[j]) set_motor(joints_[j], *levers_[j]);
    }
    drive_mimics();
    for (const auto& multibody : multibodies_) multibody->resist(substep_s_);
    world_->stepSimulation(scalar(substep_s_), 0);  // 0: one step of exactly this length
    ++substep_count_;
    update_joint_positions();
}

}  // namespace bsoil::scene
