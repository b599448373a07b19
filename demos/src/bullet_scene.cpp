#include "bullet_scene.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "convex_hull.h"

namespace bsoil::scene {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// Share of a joint's position error that its motor takes back in one substep. All of it at once
/// makes a blocked joint jump when it comes free; this closes 99 % within 20 substeps.
constexpr double kMotorCorrection = 0.2;
/// A motor commanded slower than this (rad/s, m/s) lets its bodies fall asleep.
constexpr double kMotorRest = 1e-3;
/// Collision margin of hulls and cones [m], which Bullet adds on the outside.
constexpr double kMargin = 0.002;
/// Hulls with more points than this are replaced by Bullet's own simplification of them.
constexpr int kHullPointCapacity = 100;

btScalar scalar(double value) { return static_cast<btScalar>(value); }

double volume_m3(const ShapeItem& s) {
    if (s.shape == "box") return s.size_m.x * s.size_m.y * s.size_m.z;
    const double disc = kPi * s.radius_m * s.radius_m;
    if (s.shape == "sphere") return disc * s.radius_m * 4 / 3;
    if (s.shape == "capsule") return disc * (s.height_m + s.radius_m * 4 / 3);
    if (s.shape == "cylinder") return disc * s.height_m;
    if (s.shape == "cone") return disc * s.height_m / 3;
    return convex_hull(s.points_m).volume_m3;
}

std::unique_ptr<btConvexShape> make_hull(const ShapeItem& s) {
    const ConvexHull hull = convex_hull(s.points_m);
    if (hull.surface.vertices.empty()) return nullptr;
    auto shape = std::make_unique<btConvexHullShape>();
    for (const Vec3 p : hull.surface.vertices) shape->addPoint(to_bullet(p), false);
    shape->recalcLocalAabb();
    shape->setMargin(scalar(kMargin));
    if (shape->getNumPoints() <= kHullPointCapacity) return shape;
    btShapeHull simple(shape.get());
    simple.buildHull(scalar(kMargin));
    auto smaller = std::make_unique<btConvexHullShape>(&simple.getVertexPointer()->x(),
                                                       simple.numVertices(), sizeof(btVector3));
    smaller->setMargin(scalar(kMargin));
    return smaller;
}

/// The Bullet shape of a solid; null where a hull has no volume.
std::unique_ptr<btConvexShape> make_shape(const ShapeItem& s) {
    const btScalar r = scalar(s.radius_m), h = scalar(s.height_m);
    if (s.shape == "box") return std::make_unique<btBoxShape>(to_bullet(s.size_m * 0.5));
    if (s.shape == "sphere") return std::make_unique<btSphereShape>(r);
    if (s.shape == "capsule") {
        if (s.axis == "x") return std::make_unique<btCapsuleShapeX>(r, h);
        if (s.axis == "y") return std::make_unique<btCapsuleShape>(r, h);
        return std::make_unique<btCapsuleShapeZ>(r, h);
    }
    if (s.shape == "cylinder") {
        if (s.axis == "x") return std::make_unique<btCylinderShapeX>(btVector3(h / 2, r, r));
        if (s.axis == "y") return std::make_unique<btCylinderShape>(btVector3(r, h / 2, r));
        return std::make_unique<btCylinderShapeZ>(btVector3(r, r, h / 2));
    }
    if (s.shape == "cone") {
        std::unique_ptr<btConvexShape> cone;
        if (s.axis == "x")
            cone = std::make_unique<btConeShapeX>(r, h);
        else if (s.axis == "y")
            cone = std::make_unique<btConeShape>(r, h);
        else
            cone = std::make_unique<btConeShapeZ>(r, h);
        cone->setMargin(scalar(kMargin));
        return cone;
    }
    return make_hull(s);
}

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

btVector3 to_bullet(Vec3 v) { return {scalar(v.x), scalar(v.y), scalar(v.z)}; }
btTransform to_bullet(const Pose& p) {
    const Quat q = p.rotation;
    return btTransform(btQuaternion(scalar(q.x), scalar(q.y), scalar(q.z), scalar(q.w)),
                       to_bullet(p.position));
}
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
Pose from_bullet(const btTransform& t) {
    const btQuaternion q = t.getRotation();
    return {from_bullet(t.getOrigin()), {q.x(), q.y(), q.z(), q.w()}};
}

Pose SceneBody::pose() const {
    return from_bullet(body->getWorldTransform()) * inverse(frame_to_center);
}

BulletScene::BulletScene(const Scene& scene)
    : scene_(scene),
      substep_s_(scene.world.substep_s),
      dispatcher_(&configuration_),
      world_(std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, &solver_,
                                                       &configuration_)) {
    world_->setGravity(up() * scalar(-scene.world.gravity_m_s2));
    world_->getSolverInfo().m_numIterations = scene.world.solver_iterations;
}

BulletScene::~BulletScene() {
    for (const auto& constraint : constraints_) world_->removeConstraint(constraint.get());
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
    bodies_.reserve(scene_.bodies.size());
    for (const BodyItem& item : scene_.bodies) {
        const Status added = add_body(item);
        if (!added) return added;
    }
    separate_groups();
    for (const JointItem& item : scene_.joints) {
        const Status added = add_joint(item);
        if (!added) return added;
    }
    for (const MotionItem& item : scene_.motions) {
        Drive drive{Motion(item)};
        for (size_t i = 0; i < joints_.size(); ++i)
            if (joints_[i].name == item.joint) drive.joint = static_cast<int>(i);
        for (size_t i = 0; i < bodies_.size(); ++i)
            if (bodies_[i].name == item.body) drive.body = static_cast<int>(i);
        drives_.push_back(std::move(drive));
    }
    return Done{};
}

btVector3 BulletScene::up() const {
    return scene_.world.up == "y" ? btVector3(0, 1, 0) : btVector3(0, 0, 1);
}

void BulletScene::add_ground() {
    shapes_.push_back(
        std::make_unique<btStaticPlaneShape>(up(), scalar(scene_.world.ground_height_m)));
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes_.back().get());
    info.m_friction = 1;  // Bullet multiplies both bodies' friction
    owned_bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_->addRigidBody(owned_bodies_.back().get());
    ground_ = owned_bodies_.back().get();
}

std::vector<const btCollisionObject*> BulletScene::apart_from_soil() const {
    std::vector<const btCollisionObject*> objects;
    if (ground_) objects.push_back(ground_);
    for (const SceneBody& body : bodies_)
        if (body.item->ignore_soil) objects.push_back(body.body);
    return objects;
}

Status BulletScene::add_body(const BodyItem& item) {
    const std::vector<ShapeItem> solids = item.solids();
    const bool moves = item.mass_kg > 0 && !item.kinematic;
    std::vector<btConvexShape*> children;
    std::vector<btScalar> masses;
    for (const ShapeItem& solid : solids) {
        std::unique_ptr<btConvexShape> shape = make_shape(solid);
        if (!shape)
            return Error{
                scene_.message(solid.where("points_m"),
                               fmt::format("the hull of body \"{}\" has no volume", item.name))};
        children.push_back(shape.get());
        shapes_.push_back(std::move(shape));
        masses.push_back(scalar(solid.mass_kg.value_or(volume_m3(solid))));
    }
    const bool plain = item.shape.shape != "compound";
    btTransform center = btTransform::getIdentity();  // of mass, in the body's frame
    btVector3 inertia(0, 0, 0);
    btCollisionShape* shape = children[0];
    if (plain) {
        if (moves) shape->calculateLocalInertia(scalar(item.mass_kg), inertia);
    } else {
        btCompoundShape unweighted;
        for (size_t i = 0; i < children.size(); ++i)
            unweighted.addChildShape(to_bullet(solids[i].pose), children[i]);
        if (item.inertial) {
            center = to_bullet(item.inertial->frame);
            inertia = to_bullet(item.inertial->moments_kg_m2);
        } else if (moves) {
            btScalar total = 0;
            for (const btScalar mass : masses) total += mass;
            for (btScalar& mass : masses) mass *= scalar(item.mass_kg) / total;
            unweighted.calculatePrincipalAxisTransform(masses.data(), center, inertia);
        }
        auto compound = std::make_unique<btCompoundShape>();
        for (size_t i = 0; i < children.size(); ++i)
            compound->addChildShape(center.inverse() * to_bullet(solids[i].pose), children[i]);
        shape = compound.get();
        shapes_.push_back(std::move(compound));
    }
    motion_states_.push_back(std::make_unique<btDefaultMotionState>(to_bullet(item.pose) * center));
    btRigidBody::btRigidBodyConstructionInfo info(moves ? scalar(item.mass_kg) : 0,
                                                  motion_states_.back().get(), shape, inertia);
    info.m_friction = scalar(item.friction);
    info.m_restitution = scalar(item.restitution);
    info.m_linearDamping = scalar(item.linear_damping);
    info.m_angularDamping = scalar(item.angular_damping);
    owned_bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = owned_bodies_.back().get();
    if (item.kinematic) {
        body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        body->setActivationState(DISABLE_DEACTIVATION);
    }
    if (moves) {
        const btVector3 omega = to_bullet(item.angular_velocity_rad_s);
        const btVector3 arm = to_bullet(item.pose).getBasis() * center.getOrigin();
        body->setLinearVelocity(to_bullet(item.velocity_m_s) + omega.cross(arm));
        body->setAngularVelocity(omega);
    }
    world_->addRigidBody(body);
    bodies_.push_back({item.name, body, from_bullet(center), &item});
    return Done{};
}

void BulletScene::separate_groups() {
    for (const SceneBody& a : bodies_)
        for (const SceneBody& b : bodies_)
            if (&a != &b && !a.item->group.empty() && a.item->group == b.item->group)
                a.body->setIgnoreCollisionCheck(b.body, true);
}

Status BulletScene::add_joint(const JointItem& item) {
    SceneJoint joint;
    joint.name = item.name;
    joint.item = &item;
    const SceneBody* parent = find_body(item.parent);
    joint.parent = parent ? parent->body : &btTypedConstraint::getFixedBody();
    joint.child = find_body(item.child)->body;
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
        if (item.lower_rad) hinge->setLimit(scalar(*item.lower_rad), scalar(*item.upper_rad));
        if (item.motor_torque_n_m > 0)  // Bullet's limit of a hinge motor is an impulse
            hinge->enableAngularMotor(true, 0, scalar(item.motor_torque_n_m * substep_s_));
        made = std::move(hinge);
    } else if (item.kind == "slider") {
        auto slider = std::make_unique<btSliderConstraint>(
            *joint.parent, *joint.child, joint.parent_frame, joint.child_frame, true);
        slider->setLowerLinLimit(scalar(item.lower_m.value_or(1)));
        slider->setUpperLinLimit(scalar(item.upper_m.value_or(-1)));
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
    joints_.push_back(joint);
    return Done{};
}

const SceneBody* BulletScene::find_body(const std::string& name) const {
    const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                    [&](const SceneBody& b) { return b.name == name; });
    return found == bodies_.end() ? nullptr : &*found;
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
        const btTransform parent = joint.parent->getWorldTransform() * joint.parent_frame;
        const btTransform child = joint.child->getWorldTransform() * joint.child_frame;
        if (joint.item->kind == "slider") {
            joint.position =
                parent.getBasis().getColumn(0).dot(child.getOrigin() - parent.getOrigin());
            continue;
        }
        const double angle =
            relative_angle(parent, child, joint.item->kind == "suspension" ? 0 : 2);
        joint.position += std::remainder(angle - joint.position, 2 * kPi);
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
    for (const Drive& d : drives_) drive(d);
    world_->stepSimulation(scalar(substep_s_), 0);  // 0: one step of exactly this length
    ++substep_count_;
    update_joint_positions();
}

}  // namespace bsoil::scene
