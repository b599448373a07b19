// Soil on a body is taken along by Coulomb friction, however short the step is.
#include "soil_fixture.h"

namespace bsoil::body_friction_test {
namespace {

constexpr double kGravity = 9.81;
constexpr double kFriction = 0.5;

struct Case {
    double voxel_m;
    double steps_per_s;
    bool is_of_the_body;  ///< its own friction, or the material's with bodies
};

class BodyFriction : public testing::TestWithParam<Case> {};

// As whole 1/1024 voxel a step it was none in voxels of 5 cm at 500 Hz, and in 20 cm at 240 Hz.
TEST_P(BodyFriction, takes_soil_along_by_mu_g) {
    const Case& c = GetParam();
    SoilDef def = grid_def(48, 24, 16, c.voxel_m);
    def.step_s = 1 / c.steps_per_s;
    def.material.tool_friction = c.is_of_the_body ? 0 : kFriction;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    // A plate in the air, with a layer of one voxel on it.
    Mover plate(1, box_shape(Vec3{10, 8, 1} * c.voxel_m), Vec3{14, 12, 7} * c.voxel_m);
    if (c.is_of_the_body) plate.body.surface.friction = kFriction;
    soil->step({&plate.body, 1});
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 8, 8}, {20, 16, 9})));
    plate.set_velocity({3, 0, 0});  // no speed that the soil gets to
    const auto speed_after = [&](int steps) {
        for (int i = 0; i < steps; ++i) {
            plate.advance(def.step_s);
            soil->step({&plate.body, 1});
        }
        return soil->sample(13, 12, 8).velocity_m_s.x;
    };
    const double before = speed_after(2);
    const int steps = static_cast<int>(c.steps_per_s / 20);
    const double gain = speed_after(steps) - before, wanted = kFriction * kGravity / 20;
    // To a unit of 2^-16 voxel a step in each step.
    const double unit = c.voxel_m * c.steps_per_s / 65536;
    EXPECT_NEAR(gain, wanted, steps * unit / 2 + 0.002 * wanted);
}

INSTANTIATE_TEST_SUITE_P(Steps, BodyFriction,
                         testing::Values(Case{0.05, 60, false}, Case{0.05, 60, true},
                                         Case{0.05, 500, false}, Case{0.05, 500, true},
                                         Case{0.2, 240, false}, Case{0.2, 240, true}));

// A unit of 2^-16 voxel a step, in each step: its parts along two axes were rounded to none, and
// soil crept on for good.
TEST(BodyFriction, of_a_unit_a_step_acts_aslant_too) {
    SoilDef def = grid_def(32, 32, 16, 0.25);
    def.step_s = 1.0 / 240;
    const double unit = def.voxel_m / def.step_s / 65536;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    Mover plate(1, box_shape(Vec3{10, 10, 1} * def.voxel_m), Vec3{16, 16, 7} * def.voxel_m);
    plate.body.surface.friction = unit / (kGravity * def.step_s);
    soil->step({&plate.body, 1});
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {12, 12, 8}, {20, 20, 9})));
    plate.set_velocity({0.3, 0.4, 0});
    constexpr int kSteps = 100;
    for (int i = 0; i < kSteps; ++i) {
        plate.advance(def.step_s);
        soil->step({&plate.body, 1});
    }
    const Vec3 speed = soil->sample(16, 16, 8).velocity_m_s;
    EXPECT_GT(length(speed), 0.7 * kSteps * unit);
    EXPECT_LT(length(speed), 1.1 * kSteps * unit);
}

}  // namespace
}  // namespace bsoil::body_friction_test
