// Soil takes energy from bodies and gives none back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "bsoil/bullet/soil_action.h"
#include "bullet_scene.h"
#include "bullet_types.h"

namespace bsoil::bullet::energy_test {
namespace {

constexpr double kSurfaceM = 0.6;
/// What counts as no rise: lifting the body by this much in one step. Single precision keeps its
/// height to 6e-8 m; the rest is the drift that the solver's ten iterations leave at the end of an
/// impact and that the contact takes back while the body comes to rest.
constexpr double kDriftOfStepM = 3e-5;
/// Share of the energy lost that all such rises together may give back.
constexpr double kReturnedFraction = 1e-3;

/// Kinetic energy, and potential energy above the soil's surface [J].
double energy_j(const btRigidBody& body, const btVector3& gravity) {
    const btMatrix3x3& axes = body.getWorldTransform().getBasis();
    const btVector3 omega = body.getAngularVelocity() * axes;  // in the body's axes
    const double mass_kg = 1 / static_cast<double>(body.getInvMass());
    const double height_m =
        static_cast<double>(body.getWorldTransform().getOrigin().y()) - kSurfaceM;
    return 0.5 * mass_kg * static_cast<double>(body.getLinearVelocity().length2()) +
           0.5 * static_cast<double>(omega.dot(body.getLocalInertia() * omega)) -
           mass_kg * static_cast<double>(gravity.y()) * height_m;
}

/// The soil's surface at a distance x from the middle [m].
using Surface = double (*)(double x_m);
double level(double) { return kSurfaceM; }
/// 20 deg: below the angle of repose, so that the bed itself rests.
double slope(double x_m) { return kSurfaceM - std::tan(0.349) * x_m; }

/// One body on sand, watched Bullet step by Bullet step. What soil it carries is not counted: none
/// of these bodies is lifted by what it carries.
class Energy : public testing::TestWithParam<double> {
  protected:
    /// Steps per second of Bullet.
    double rate_hz() const { return GetParam(); }

    void make_bed(Surface surface) {
        SoilDef def;
        def.size_m = {3, 1.5, 1.5};
        def.voxel_m = 0.05;
        def.backend = Backend::cpu;
        auto made = SoilAction::create(*scene_.world, def);
        ASSERT_TRUE(made) << made.error();
        soil_ = std::move(*made);
        const Status filled = soil_->fill(
            FunctionFill{[surface](Vec3 p) { return surface(p.x) - p.y; }, def.material.name});
        ASSERT_TRUE(filled) << filled.error();
    }

    void expect_no_rise(btRigidBody& body, double seconds) {
        const btVector3 gravity = scene_.world->getGravity();
        const double start_j = energy_j(body, gravity);
        const double weight_n =
            -static_cast<double>(gravity.y()) / static_cast<double>(body.getInvMass());
        double before_j = start_j, sum_j = 0, force_n = 0;
        const int count = static_cast<int>(seconds * rate_hz());
        for (int i = 1; i <= count; ++i) {
            scene_.world->stepSimulation(static_cast<btScalar>(1 / rate_hz()), 0);
            const double after_j = energy_j(body, gravity);
            const double rise_j = after_j - before_j;
            ASSERT_LE(rise_j, kDriftOfStepM * weight_n) << "at " << i / rate_hz() << " s";
            sum_j += std::max(0.0, rise_j);
            before_j = after_j;
            force_n = std::max(force_n, soil_->body_report(body).peak_force_n);
        }
        EXPECT_LE(sum_j, kReturnedFraction * (start_j - before_j));
        EXPECT_GT(force_n, weight_n) << "it has not met the soil";
        EXPECT_LT(before_j, 0.9 * start_j) << "the soil has not taken its energy";
    }

    BulletScene scene_;
    std::unique_ptr<SoilAction> soil_;
};

TEST_P(Energy, of_a_dropped_box_never_rises) {
    make_bed(level);
    expect_no_rise(scene_.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 1.1f, 0)), 2);
}

TEST_P(Energy, of_a_box_dropped_on_a_corner_never_rises) {
    make_bed(level);
    btRigidBody& box = scene_.add_box(50, btVector3(0.2f, 0.15f, 0.2f), btVector3(0, 1.2f, 0));
    box.getWorldTransform().setRotation(
        btQuaternion(btVector3(1, 0, 1).normalized(), btScalar(0.6)));
    expect_no_rise(box, 2);
}

TEST_P(Energy, of_a_sliding_block_never_rises) {
    make_bed(level);
    btRigidBody& block =
        scene_.add_box(50, btVector3(0.25f, 0.15f, 0.2f), btVector3(-0.8f, 0.75f, 0));
    block.setLinearVelocity(btVector3(2, 0, 0));
    expect_no_rise(block, 2);
}

TEST_P(Energy, of_a_rolling_wheel_never_rises) {
    make_bed(level);
    btRigidBody& wheel =
        scene_.add(30, scene_.shape<btCylinderShapeZ>(btVector3(0.25f, 0.25f, 0.1f)),
                   btVector3(-0.9f, 0.85f, 0));
    wheel.setLinearVelocity(btVector3(2, 0, 0));
    wheel.setAngularVelocity(btVector3(0, 0, -8));
    expect_no_rise(wheel, 1);  // then it nears the end of the bed
}

TEST_P(Energy, of_a_cylinder_tumbling_down_a_slope_never_rises) {
    make_bed(slope);
    btRigidBody& cylinder =
        scene_.add(30, scene_.shape<btCylinderShapeZ>(btVector3(0.15f, 0.15f, 0.25f)),
                   btVector3(-0.8f, 1.3f, 0));
    cylinder.getWorldTransform().setRotation(
        btQuaternion(btVector3(1, 0.3f, 0.5f).normalized(), btScalar(0.9)));
    cylinder.setLinearVelocity(btVector3(1, 0, 0));
    cylinder.setAngularVelocity(btVector3(1, 0.5f, -6));
    expect_no_rise(cylinder, 2);
}

TEST_P(Energy, momentum_changes_by_what_is_reported) {
    make_bed(level);
    btRigidBody& box = scene_.add_box(40, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 1, 0));
    box.setLinearVelocity(btVector3(1, -1, 0.3f));
    box.setAngularVelocity(btVector3(2, -1, 3));
    const double step_s = 1 / rate_hz();
    double most_n = 0;
    for (int i = 0; i < static_cast<int>(1.5 * rate_hz()); ++i) {
        // What the body carries is accelerated with it.
        const double mass_kg = 40 + soil_->body_report(box).load_kg;
        const Vec3 before = from_bullet(box.getLinearVelocity());
        scene_.world->stepSimulation(static_cast<btScalar>(step_s), 0);
        const BodyReport report = soil_->body_report(box);
        const Vec3 force_n = report.force_n;
        const Vec3 change = mass_kg * (from_bullet(box.getLinearVelocity()) - before);
        const Vec3 impulse = step_s * (force_n + report.load_n + 40 * Vec3{0, -9.81, 0});
        // Single precision keeps a momentum of 100 N s to 1e-5.
        ASSERT_LT(length(change - impulse), 1e-6 * std::max(100.0, length(impulse))) << i;
        most_n = std::max(most_n, length(force_n));
    }
    EXPECT_GT(most_n, 1000) << "it has met the soil";
}

INSTANTIATE_TEST_SUITE_P(BulletSteps, Energy, testing::Values(240.0, 60.0),
                         [](const testing::TestParamInfo<double>& rate) {
                             return std::to_string(static_cast<int>(rate.param)) + "_hz";
                         });

}  // namespace
}  // namespace bsoil::bullet::energy_test
