/// A fork lift of rigid bodies, as a host would write it: wheels on hinge motors, the fork on a
/// slider. It drives over sand with ruts behind it, lifts a load and carries it away.
#include <bsoil/bullet/soil_action.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

namespace {

constexpr btScalar kStep = btScalar(1.0 / 240);
constexpr btScalar kGround = 0.4f, kRadius = 0.35f;  // [m]
constexpr btScalar kDriveImpulse = 900 * kStep;      // [N m s] a step: 900 N m a wheel
constexpr btScalar kLiftForce = 15e3f;               // [N]

class Bodies {
  public:
    explicit Bodies(btDiscreteDynamicsWorld& world) : world_(world) {}
    ~Bodies() {
        for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    }
    btRigidBody& add(std::unique_ptr<btCollisionShape> shape, float mass_kg, const btVector3& at) {
        btVector3 inertia;
        shape->calculateLocalInertia(mass_kg, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape.get(), inertia);
        info.m_startWorldTransform.setOrigin(at);
        info.m_friction = 0.8f;
        shapes_.push_back(std::move(shape));
        bodies_.push_back(std::make_unique<btRigidBody>(info));
        bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
        world_.addRigidBody(bodies_.back().get());
        return *bodies_.back();
    }

  private:
    btDiscreteDynamicsWorld& world_;
    std::vector<std::unique_ptr<btCollisionShape>> shapes_;
    std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

std::unique_ptr<btCollisionShape> box(float x, float y, float z) {
    return std::make_unique<btBoxShape>(btVector3(x / 2, y / 2, z / 2));
}

}  // namespace

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, btScalar(-9.81)});
    world.getSolverInfo().m_numIterations = 50;

    bsoil::SoilDef def;
    def.up = bsoil::UpAxis::z;
    def.size_m = {8, 3, 1};
    auto soil = bsoil::bullet::SoilAction::create(world, def);
    if (!soil) {
        std::printf("%s\n", soil.error().c_str());
        return 2;
    }
    if (!(*soil)->fill(bsoil::BoxFill{{{-4, -1.5, 0}, {4, 1.5, kGround}}, ""})) return 2;

    Bodies bodies(world);
    btRigidBody& chassis = bodies.add(box(1.8f, 0.9f, 0.5f), 2500, {-2.5f, 0, kGround + 0.75f});
    std::vector<std::unique_ptr<btHingeConstraint>> axles;
    for (const float x : {-3.1f, -1.9f}) {
        for (const float y : {-0.65f, 0.65f}) {
            const btVector3 at(x, y, kGround + kRadius), axis(0, 1, 0);
            btRigidBody& wheel = bodies.add(
                std::make_unique<btCylinderShape>(btVector3(kRadius, 0.10f, kRadius)), 60, at);
            const btVector3 in_chassis = chassis.getWorldTransform().inverse() * at;
            axles.push_back(std::make_unique<btHingeConstraint>(
                chassis, wheel, in_chassis, btVector3(0, 0, 0), axis, axis, true));
            world.addConstraint(axles.back().get(), true);
        }
    }
    // The fork: one plate before the wheels that slides up along the chassis.
    btRigidBody& fork = bodies.add(box(0.9f, 0.8f, 0.1f), 80, {-1.0f, 0, kGround + 0.25f});
    const btQuaternion x_is_up(btVector3(0, 1, 0), btScalar(-SIMD_HALF_PI));
    const btTransform mast(x_is_up, fork.getWorldTransform().getOrigin());
    btSliderConstraint lift(chassis, fork, chassis.getWorldTransform().inverse() * mast,
                            fork.getWorldTransform().inverse() * mast, true);
    lift.setLowerLinLimit(-0.1f), lift.setUpperLinLimit(1.2f);
    lift.setLowerAngLimit(0), lift.setUpperAngLimit(0);
    lift.setPoweredLinMotor(true), lift.setMaxLinMotorForce(kLiftForce);
    world.addConstraint(&lift, true);
    // The load stands on two fixed posts, so that the fork fits below it.
    for (const float y : {-0.55f, 0.55f}) bodies.add(box(0.6f, 0.2f, 0.4f), 0, {1, y, 0.6f});
    btRigidBody& load = bodies.add(box(0.6f, 1.3f, 0.5f), 300, {1, 0, kGround + 0.66f});

    double deepest_rut_m = 0;
    const double load_start_m = load.getWorldTransform().getOrigin().z();
    for (int step = 0; step < 14 * 240; ++step) {
        const double t_s = step * double(kStep);
        const double way_m = chassis.getWorldTransform().getOrigin().x();
        // Drive up to the load, lift it, drive back.
        const double speed_m_s = t_s < 1 ? 0 : t_s < 8 && way_m < -0.55 ? 0.5 : t_s > 10 ? -0.5 : 0;
        const btScalar target_rad_s = btScalar(speed_m_s / kRadius);
        for (const auto& axle : axles) axle->enableAngularMotor(true, target_rad_s, kDriveImpulse);
        lift.setTargetLinMotorVelocity(t_s > 8 && t_s < 10 ? 0.4f : 0);
        world.stepSimulation(kStep, 0);
        if (step % 480 == 479) {
            std::printf("%4.1f s: at %5.2f m, fork %.2f m up, load at %.2f m\n", t_s, way_m,
                        double(lift.getLinearPos()),
                        double(load.getWorldTransform().getOrigin().z()));
        }
    }
    for (double x_m = -3; x_m < 0; x_m += def.voxel_m) {  // where the left wheels went
        const bsoil::Vec3 column = (*soil)->soil().frame().to_grid({x_m, 0.65, 0});
        const double left_m = (*soil)->soil().surface_height_m(int(column.x), int(column.y));
        deepest_rut_m = std::max(deepest_rut_m, kGround - left_m);
    }
    const btVector3 end = load.getWorldTransform().getOrigin();
    std::printf("ruts %.3f m deep; the load rose %.2f m and went %.2f m\n", deepest_rut_m,
                double(end.z()) - load_start_m, double(end.x()) - 1);
    for (const auto& axle : axles) world.removeConstraint(axle.get());
    world.removeConstraint(&lift);
    return deepest_rut_m > 0.01 && end.z() - load_start_m > 0.4 && end.x() < 0.5 ? 0 : 1;
}
