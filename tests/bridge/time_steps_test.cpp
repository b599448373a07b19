// Worlds that are stepped in any way: fixed, variable, too long, too short.
#include <limits>

#include "test_box.h"

namespace bsoil::bullet::time_steps_test {
namespace {

/// How a host steps its world: stepSimulation(dt, max_substeps, fixed_s).
struct Stepping {
    const char* name;
    double dt_s;
    int max_substeps;
    double fixed_s;
    double soil_step_s;
};

class SteppedWorlds : public testing::TestWithParam<Stepping> {};

TEST_P(SteppedWorlds, a_body_at_rest_is_carried_with_its_weight) {
    const Stepping& p = GetParam();
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {1, 1, 1};
    def.step_s = p.soil_step_s;
    const auto soil = sand_bed(*scene.world, def);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setActivationState(DISABLE_DEACTIVATION);
    double time_s = 0, impulse_n_s = 0;
    // The report is that of the last substep: asked after each.
    struct Probe {
        SoilAction* soil;
        btRigidBody* box;
        double impulse_n_s = 0, time_s = 0;
        bool counts = false;
    } probe{soil.get(), &box};
    scene.world->setInternalTickCallback(
        [](btDynamicsWorld* world, btScalar dt) {
            auto* seen = static_cast<Probe*>(world->getWorldUserInfo());
            if (!seen->counts) return;
            const BodyReport report = seen->soil->body_report(*seen->box);
            seen->impulse_n_s +=
                (report.force_n.y - report.load_kg * kGravity_m_s2) * static_cast<double>(dt);
            seen->time_s += static_cast<double>(dt);
        },
        &probe);
    const auto run = [&](double seconds) {
        for (double t = 0; t < seconds - 1e-9; t += p.dt_s) {
            scene.world->stepSimulation(static_cast<btScalar>(p.dt_s), p.max_substeps,
                                        static_cast<btScalar>(p.fixed_s));
        }
    };
    run(1);
    const btScalar from = box.getLinearVelocity().y();
    probe.counts = true;
    run(1);
    time_s = probe.time_s;
    // What changed its speed was not its weight.
    impulse_n_s = probe.impulse_n_s - 50 * static_cast<double>(box.getLinearVelocity().y() - from);
    ASSERT_GT(time_s, 0.1);
    EXPECT_NEAR(impulse_n_s / time_s, kWeightN, 0.01 * kWeightN);
    EXPECT_LT(std::abs(static_cast<double>(box.getLinearVelocity().y())), 0.02);
    EXPECT_GT(height_of(box), kBedTopM + 0.1);
}

INSTANTIATE_TEST_SUITE_P(
    Steps, SteppedWorlds,
    testing::Values(Stepping{"variable", 1.0 / 60, 0, 1.0 / 60, 1.0 / 60},
                    Stepping{"variable_long", 1.0 / 30, 0, 1.0 / 60, 1.0 / 60},
                    Stepping{"one_of_60", 1.0 / 60, 1, 1.0 / 60, 1.0 / 60},
                    Stepping{"one_of_240", 1.0 / 60, 1, 1.0 / 240, 1.0 / 60},
                    Stepping{"ten_of_240", 1.0 / 60, 10, 1.0 / 240, 1.0 / 60},
                    Stepping{"ten_of_1000", 1.0 / 100, 10, 1.0 / 1000, 1.0 / 60},
                    Stepping{"soil_shorter", 1.0 / 60, 10, 1.0 / 60, 1.0 / 240},
                    Stepping{"soil_longer", 1.0 / 60, 10, 1.0 / 240, 1.0 / 30},
                    Stepping{"soil_out_of_step", 1.0 / 60, 10, 1.0 / 60, 1.0 / 100},
                    Stepping{"frame_of_a_third", 1.0 / 20, 10, 1.0 / 60, 1.0 / 60}),
    [](const auto& named) { return std::string(named.param.name); });

TEST(Time, changing_steps_and_none_at_all_do_no_harm) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const int64_t before = units_of(*soil);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    double passed_s = 0;
    for (int i = 0; i < 200; ++i) {
        const double dt_s = (1 + i % 7) / 240.0;
        scene.world->stepSimulation(static_cast<btScalar>(dt_s), 0);
        passed_s += dt_s;
        const uint64_t checksum = soil->soil().checksum();
        const long long steps = soil->step_count();
        const btTransform pose = box.getWorldTransform();
        scene.world->stepSimulation(0, i % 2);
        scene.world->stepSimulation(-1, 1);
        EXPECT_EQ(soil->soil().checksum(), checksum);
        EXPECT_EQ(soil->step_count(), steps);
        EXPECT_EQ(box.getWorldTransform().getOrigin(), pose.getOrigin());
    }
    EXPECT_NEAR(static_cast<double>(soil->step_count()), 60 * passed_s, 1);
    EXPECT_NEAR(soil->body_report(box).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_EQ(units_of(*soil), before);
}

TEST(Time, negative_variable_step_is_no_step_of_the_soil) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(0.5);
    const uint64_t checksum = soil->soil().checksum();
    scene.world->stepSimulation(btScalar(-1) / 60, 0);
    EXPECT_EQ(soil->soil().checksum(), checksum);
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    scene.run(0.1);
    EXPECT_TRUE(is_finite(*scene.bodies[0]));
}

}  // namespace
}  // namespace bsoil::bullet::time_steps_test
