/// A btRaycastVehicle drives over sand: Bullet's usual set-up, and the soil.
#include <bsoil/bullet/soil_raycaster.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

constexpr btScalar kWheelRadius = 0.4f, kRestLength = 0.3f;

/// Front wheels first.
void add_wheels(btRaycastVehicle& vehicle, const btRaycastVehicle::btVehicleTuning& tuning) {
    const btVector3 down(0, -1, 0), axle(0, 0, 1);
    for (const btScalar x : {1.1f, -1.1f}) {
        for (const btScalar z : {0.7f, -0.7f}) {
            vehicle.addWheel({x, -0.2f, z}, down, axle, kRestLength, kWheelRadius, tuning, x > 0);
        }
    }
}

/// Depth of the ruts below the soil between them, mean from x0 to x1 [m].
double rut_depth_m(const bsoil::bullet::SoilAction& soil, double x0, double x1) {
    constexpr int kCount = 20;
    double depth_m = 0;
    for (int i = 0; i < kCount; ++i) {
        const double x = x0 + (x1 - x0) * i / kCount;
        const auto height_m = [&](double z) {
            const auto point = soil.surface_at({x, 0, z});
            return point ? point->position_m.y : 0;
        };
        depth_m += (height_m(0) - (height_m(0.7) + height_m(-0.7)) / 2) / kCount;
    }
    return depth_m;
}

}  // namespace

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, btScalar(-9.81), 0});

    bsoil::SoilDef def;
    def.size_m = {12, 1.5, 3};
    auto soil = bsoil::bullet::SoilAction::create(world, def);
    if (!soil) {
        std::printf("%s\n", soil.error().c_str());
        return 2;
    }
    if (!(*soil)->fill(bsoil::BoxFill{{{-6, 0, -2}, {6, 0.5, 2}}, "dry_sand"})) return 2;

    btBoxShape shape({1.5f, 0.25f, 0.55f});
    const btScalar mass_kg = 5000;
    btVector3 inertia;
    shape.calculateLocalInertia(mass_kg, inertia);
    btTransform pose = btTransform::getIdentity();
    pose.setOrigin({-4, 0.5f + kWheelRadius + kRestLength + 0.2f, 0});
    btDefaultMotionState start(pose);
    btRigidBody chassis(btRigidBody::btRigidBodyConstructionInfo(mass_kg, &start, &shape, inertia));
    chassis.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&chassis);

    btRaycastVehicle::btVehicleTuning tuning;
    tuning.m_suspensionStiffness = 40;
    tuning.m_suspensionCompression = 4.4f;
    tuning.m_suspensionDamping = 4.6f;
    tuning.m_maxSuspensionForce = 1e5f;
    tuning.m_maxSuspensionTravelCm = 25;
    bsoil::bullet::SoilRaycaster raycaster(**soil);  // instead of btDefaultVehicleRaycaster
    btRaycastVehicle vehicle(tuning, &chassis, &raycaster);
    vehicle.setCoordinateSystem(2, 1, 0);
    world.addVehicle(&vehicle);
    add_wheels(vehicle, tuning);
    const bsoil::Status attached =
        raycaster.attach(vehicle, bsoil::bullet::SoilWheelDef{.width_m = 0.3, .mass_kg = 50});
    if (!attached) {
        std::printf("%s\n", attached.error().c_str());
        return 2;
    }

    double slip_most = 0;
    for (int frame = 0; frame < 240; ++frame) {
        for (int i = 0; i < 4; ++i) vehicle.applyEngineForce(frame < 60 ? 0 : 3500.0f, i);
        world.stepSimulation(btScalar(1.0 / 60));
        for (int i = 0; i < 4; ++i) slip_most = std::max(slip_most, raycaster.wheel_report(i).slip);
        if (frame % 30 != 29) continue;
        const auto wheel = raycaster.wheel_report(0);
        std::printf("%.1f s  x %6.2f m  %5.2f m/s  wheel: load %5.0f N, pull %5.0f N, slip %4.2f\n",
                    (frame + 1) / 60.0, chassis.getWorldTransform().getOrigin().x(),
                    chassis.getLinearVelocity().x(), wheel.normal_force_n, wheel.traction_n,
                    wheel.slip);
    }
    const double moved_m = chassis.getWorldTransform().getOrigin().x() + 4;
    const double rut_m = rut_depth_m(**soil, -4, -4 + moved_m - 1.5);
    std::printf("moved %.2f m, ruts %.0f mm deep, largest slip %.2f\n", moved_m, 1000 * rut_m,
                slip_most);
    world.removeVehicle(&vehicle);
    world.removeRigidBody(&chassis);
    return moved_m > 2 && rut_m > 0.005 ? 0 : 1;
}
