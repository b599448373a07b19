/// A robot arm that digs, as a host would write it: a btMultiBody with joint motors in a
/// btMultiBodyDynamicsWorld, and soil. Prints the soil's force on the scoop and what it carries.
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <bsoil/bullet/soil_action.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <deque>

namespace {

constexpr btScalar kStep = btScalar(1.0 / 240);
constexpr int kLinks = 3;                                            // boom, stick, scoop
constexpr std::array<btScalar, kLinks> kLength{1.2f, 0.9f, 0.5f};    // [m] from joint to joint
constexpr std::array<btScalar, kLinks> kMass{120, 70, 40};           // [kg]
constexpr std::array<btScalar, kLinks> kTorque{18000, 10000, 6000};  // [N m]

/// Joint angles over time [s; rad against the parent, positive lowers the tip].
struct Pose {
    double t_s;
    std::array<double, kLinks> angle;
};
constexpr std::array kDig{
    Pose{0.0, {-0.61, 1.10, 0.74}}, Pose{1.0, {-0.47, 1.15, 0.63}},   // ready, on the ground
    Pose{2.0, {-0.38, 1.14, 0.84}}, Pose{3.2, {-0.45, 1.55, 0.86}},   // in, dragged
    Pose{4.2, {-0.35, 1.48, 1.49}}, Pose{5.0, {-0.37, 1.48, 2.07}},   // curled, full
    Pose{6.0, {-0.63, 1.65, 2.33}}, Pose{7.0, {-0.63, 1.65, 2.33}}};  // lifted, held

std::array<double, kLinks> angles_at(double t_s) {
    size_t i = 1;
    while (i + 1 < kDig.size() && kDig[i].t_s < t_s) ++i;
    const double u =
        std::clamp((t_s - kDig[i - 1].t_s) / (kDig[i].t_s - kDig[i - 1].t_s), 0.0, 1.0);
    std::array<double, kLinks> out{};
    for (size_t j = 0; j < out.size(); ++j) {
        out[j] = kDig[i - 1].angle[j] + (kDig[i].angle[j] - kDig[i - 1].angle[j]) * u;
    }
    return out;
}

}  // namespace

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, btScalar(-9.81)});
    bsoil::SoilDef def;
    def.up = bsoil::UpAxis::z;
    def.size_m = {3.5, 2, 1.2};
    def.voxel_m = 0.03;
    def.floor_center_m = {1.6, 0, 0};
    auto soil = bsoil::bullet::SoilAction::create(world, def);
    if (!soil) {
        std::printf("%s\n", soil.error().c_str());
        return 2;
    }
    if (!(*soil)->fill(bsoil::BoxFill{{{0, -1, 0}, {3.4, 1, 0.6}}, ""})) return 2;

    // Bars along x, and at the end a scoop of four plates, 0.06 m thick: open towards -z.
    btBoxShape boom({kLength[0] / 2, 0.06f, 0.06f}), stick({kLength[1] / 2, 0.05f, 0.05f}),
        top({0.25f, 0.30f, 0.03f}), back({0.03f, 0.30f, 0.20f}), side({0.25f, 0.03f, 0.20f});
    btCompoundShape scoop;
    const auto at = [](float x, float y, float z) {
        return btTransform(btQuaternion::getIdentity(), btVector3(x, y, z));
    };
    scoop.addChildShape(at(0, 0, 0.23f), &top);
    scoop.addChildShape(at(-0.22f, 0, 0.06f), &back);
    scoop.addChildShape(at(0, 0.27f, 0.06f), &side);
    scoop.addChildShape(at(0, -0.27f, 0.06f), &side);
    const std::array<btCollisionShape*, kLinks> shapes{&boom, &stick, &scoop};

    btMultiBody arm(kLinks, 0, {0, 0, 0}, true, false);  // fixed base, never asleep
    arm.setBaseWorldTransform(at(0, 0, 1.1f));
    for (int i = 0; i < kLinks; ++i) {
        btVector3 inertia;
        shapes[i]->calculateLocalInertia(kMass[i], inertia);
        const btVector3 to_joint(i ? kLength[i - 1] / 2 : 0, 0, 0), to_center(kLength[i] / 2, 0, 0);
        arm.setupRevolute(i, kMass[i], inertia, i - 1, btQuaternion::getIdentity(), {0, 1, 0},
                          to_joint, to_center, true);
        arm.setJointPos(i, btScalar(angles_at(0)[size_t(i)]));
    }
    arm.finalizeMultiDof();
    arm.setHasSelfCollision(false);
    world.addMultiBody(&arm);
    std::deque<btMultiBodyLinkCollider> colliders;
    std::deque<btMultiBodyJointMotor> motors;
    for (int i = 0; i < kLinks; ++i) {
        colliders.emplace_back(&arm, i);
        colliders.back().setCollisionShape(shapes[i]);
        arm.getLink(i).m_collider = &colliders.back();
        world.addCollisionObject(&colliders.back());
        motors.emplace_back(&arm, i, btScalar(0), kTorque[i] * kStep);  // the limit is an impulse
        world.addMultiBodyConstraint(&motors.back());
    }

    bsoil::bullet::BodyReport report;
    double peak_n = 0;
    for (int step = 0; step < 7 * 240; ++step) {
        const double end_s = (step + 1) * double(kStep);
        for (int i = 0; i < kLinks; ++i) {
            motors[size_t(i)].setVelocityTarget(
                btScalar((angles_at(end_s)[size_t(i)] - arm.getJointPos(i)) * 60));
        }
        world.stepSimulation(kStep, 0);
        report = (*soil)->body_report(colliders[2]);
        peak_n = std::max(peak_n, bsoil::length(report.force_n));
        if (step % 120 == 119) {
            std::printf("%4.1f s: force on the scoop (%6.0f, %6.0f) N, carried %5.1f kg\n", end_s,
                        report.force_n.x, report.force_n.z, report.load_kg);
        }
    }
    std::printf("largest force %.0f N, lifted %.1f kg\n", peak_n, report.load_kg);
    for (auto& motor : motors) world.removeMultiBodyConstraint(&motor);
    for (auto& collider : colliders) world.removeCollisionObject(&collider);
    world.removeMultiBody(&arm);
    return report.load_kg > 20 && peak_n > 200 ? 0 : 1;  // the scoop holds 0.07 m3, about 100 kg
}
