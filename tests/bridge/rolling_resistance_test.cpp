// Wheels that roll on sand, at several rates of the soil.
#include <cmath>

#include "sand_bed.h"

namespace bsoil::bullet::rolling_resistance_test {
namespace {

constexpr double kRadiusM = 0.36, kWheelKg = 20, kLoadN = 2011, kBulletHz = 240;

struct Towed {
    double speed_m_s = 1, voxel_m = 0.03;
};

/// A light wheel under a heavy load that is towed at a speed and turns freely.
struct TowedWheel {
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    btRigidBody* wheel = nullptr;
    Towed towed;
    double pulled_n_s = 0, borne_n_s = 0, height_m_s = 0, time_s = 0;

    TowedWheel(const Towed& by, double soil_hz) : towed(by) {
        SoilDef def = small_bed();
        def.size_m = {4, 0.75, 0.75};
        def.voxel_m = towed.voxel_m;
        def.step_s = 1 / soil_hz;
        soil = sand_bed(*scene.world, def);
        const auto r = btScalar(kRadiusM);
        wheel = &scene.add(btScalar(kWheelKg),
                           scene.shape<btCylinderShapeZ>(btVector3(r, r, btScalar(0.13))),
                           btVector3(btScalar(-1.4), btScalar(kBedTopM + kRadiusM), 0));
        wheel->setActivationState(DISABLE_DEACTIVATION);
        wheel->setLinearFactor(btVector3(1, 1, 0));
        wheel->setAngularFactor(btVector3(0, 0, 1));
        wheel->setAngularVelocity(btVector3(0, 0, btScalar(-towed.speed_m_s / kRadiusM)));
        while (place_m() < 1.4) step(place_m() > -0.8);
    }
    double place_m() const {
        return static_cast<double>(wheel->getWorldTransform().getOrigin().x());
    }
    void step(bool counts) {
        btVector3 velocity = wheel->getLinearVelocity();
        velocity.setX(btScalar(towed.speed_m_s));
        wheel->setLinearVelocity(velocity);
        wheel->applyCentralForce(btVector3(0, btScalar(-kLoadN), 0));
        scene.world->stepSimulation(btScalar(1 / kBulletHz), 1, btScalar(1 / kBulletHz));
        if (!counts) return;
        const Vec3 force_n = soil->body_report(*wheel).force_n;
        pulled_n_s -= force_n.x / kBulletHz;
        borne_n_s += force_n.y / kBulletHz;
        height_m_s += (height_of(*wheel) - kRadiusM - kBedTopM) / kBulletHz;
        time_s += 1 / kBulletHz;
    }
    double resistance() const { return pulled_n_s / borne_n_s; }
    double sinkage_m() const { return -height_m_s / time_s; }
};

class RollingResistance : public testing::TestWithParam<Towed> {};

// By hand, with a pressure in proportion to depth z under the front of the wheel alone:
// R / W = 3/4 z / sqrt(2 r z). What soil behind the axle bears makes it less.
TEST_P(RollingResistance, does_not_depend_on_the_soils_step) {
    const TowedWheel slow(GetParam(), 60), fast(GetParam(), 240);
    for (const TowedWheel* wheel : {&slow, &fast}) {
        EXPECT_NEAR(wheel->borne_n_s / wheel->time_s / (kLoadN + kWheelKg * kGravity_m_s2), 1,
                    0.02);
        const double z = wheel->sinkage_m();
        const double front_alone = 0.75 * z / std::sqrt(2 * kRadiusM * z);
        EXPECT_LT(wheel->resistance(), 1.15 * front_alone);
        EXPECT_GT(wheel->resistance(), 0.6 * front_alone);
    }
    EXPECT_NEAR(slow.resistance(), fast.resistance(), 0.15 * fast.resistance());
    EXPECT_NEAR(slow.sinkage_m(), fast.sinkage_m(), 0.15 * fast.sinkage_m());
}

INSTANTIATE_TEST_SUITE_P(Speeds, RollingResistance, testing::Values(Towed{1}, Towed{2.5}));
INSTANTIATE_TEST_SUITE_P(SlowSpeeds, RollingResistance, testing::Values(Towed{0.5}));

}  // namespace
}  // namespace bsoil::bullet::rolling_resistance_test
