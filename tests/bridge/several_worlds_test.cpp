// Several soils in a world, several worlds in a process and in threads.
#include <array>
#include <thread>

#include "test_box.h"

namespace bsoil::bullet::several_worlds_test {
namespace {

TEST(SeveralSoils, side_by_side_each_carries_what_stands_on_it) {
    BulletScene scene;
    // Some ten patches of each soil hold the box over the seam, as rigid rows. Those of its sole
    // stand at a quarter and at three quarters of its halves, so that any part of the weight from a
    // quarter to three is in equilibrium: in a fixed order the rows move it to one of the soils.
    scene.world->getSolverInfo().m_solverMode |= SOLVER_RANDMIZE_ORDER;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    auto a = sand_bed(*scene.world, left);
    const auto b = sand_bed(*scene.world, right);
    btRigidBody& on_a = scene.add_box(kMassKg, kHalfBox, kAbove - btVector3(1, 0, 0));
    btRigidBody& on_b = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(1, 0, 0));
    btRigidBody& on_both = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(3);
    EXPECT_NEAR(a->body_report(on_a).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_NEAR(b->body_report(on_b).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_EQ(b->body_id(on_a), -1);
    const double lift_n = a->body_report(on_both).force_n.y + b->body_report(on_both).force_n.y;
    EXPECT_NEAR(lift_n, kWeightN, 0.05 * kWeightN);
    EXPECT_NEAR(a->body_report(on_both).force_n.y, kWeightN / 2, 0.15 * kWeightN);
    // The first goes, the second stays whole.
    a.reset();
    scene.run(0.3);
    EXPECT_LT(height_of(on_a), kBedTopM - 0.1);
    EXPECT_NEAR(b->body_report(on_b).force_n.y, kWeightN, 0.05 * kWeightN);
}

TEST(SeveralSoils, do_not_see_one_another) {
    constexpr auto kOutside = static_cast<uint32_t>(StatusBit::body_outside_grid);
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    const auto a = sand_bed(*scene.world, left);
    auto b = sand_bed(*scene.world, right);
    // Its middle is in the right soil, a part of it in the left one.
    btRigidBody& seam = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(0.1f, 0, 0));
    scene.run(1);
    for (const auto* soil : {a.get(), b.get()}) {
        EXPECT_TRUE(soil->refused().empty()) << soil->refused()[0].reason;
        EXPECT_EQ(soil->soil().status_bits(), 0u);
    }
    // Where there is no other soil it is outside.
    b.reset();
    scene.run(0.1);
    EXPECT_EQ(a->soil().status_bits(), kOutside);
    EXPECT_TRUE(a->refused().empty());
    EXPECT_GE(a->body_id(seam), 0);
}

// Rows of the soil that was made first counted as joints: the other one left the body to its next
// step, and it went in deeper there.
TEST(SeveralSoils, body_that_one_holds_meets_the_other_as_it_comes_down) {
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    const auto a = sand_bed(*scene.world, left);
    const auto b = sand_bed(*scene.world, right);
    // A voxel higher: at 2 m/s the box is on it a substep or two before it meets the other one.
    ASSERT_TRUE(a->fill(BoxFill{{{-2, kBedTopM, -1}, {0, kBedTopM + 0.05, 1}}, {}}));
    const btRigidBody& box =
        scene.add_box(kMassKg, kHalfBox,
                      btVector3(btScalar(0.1), btScalar(kBedTopM) + kHalf + btScalar(0.25), 0));
    double lowest_m = 0;
    for (int frame = 0; frame < 30 && !(b->body_report(box).force_n.y > 0); ++frame) {
        btVector3 low, high;
        box.getAabb(low, high);
        lowest_m = static_cast<double>(low.y());
        scene.run(1.0 / 60);
    }
    EXPECT_GT(a->body_report(box).force_n.y, 0) << "else it met no rows of another soil";
    EXPECT_GT(b->body_report(box).force_n.y, 0);
    EXPECT_GT(lowest_m, kBedTopM) << "before the substep in which the second soil met it";
}

TEST(SeveralSoils, load_of_both_leaves_the_body_its_own_mass) {
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    const auto a = sand_bed(*scene.world, left);
    const auto b = sand_bed(*scene.world, right);
    // A board under soil of both grids.
    btRigidBody& board = scene.add_box(kMassKg, btVector3(0.4f, 0.1f, 0.2f), btVector3(0, 0.2f, 0));
    const btScalar inverse_mass = board.getInvMass();
    const btVector3 inverse_inertia = board.getInvInertiaDiagLocal();
    bool was_loaded_by_both = false;
    for (int frame = 0; frame < 120; ++frame) {
        scene.run(1.0 / 60);
        was_loaded_by_both |=
            a->body_report(board).load_kg > 0.1 && b->body_report(board).load_kg > 0.1;
        ASSERT_EQ(board.getInvMass(), inverse_mass) << frame;
        for (int i = 0; i < 3; ++i) {
            ASSERT_NEAR(board.getInvInertiaDiagLocal()[i], inverse_inertia[i],
                        1e-5 * inverse_inertia[i])
                << frame;
        }
    }
    EXPECT_TRUE(was_loaded_by_both) << "else nothing is tested";
}

/// A box falls on sand, is pushed along it; returns the soil's checksum.
uint64_t run_world(int seed) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.thread_count = 1 + seed % 2;
    const auto soil = sand_bed(*scene.world, def);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setLinearVelocity(btVector3(0.2f * btScalar(seed), -1, 0.3f));
    scene.run(1);
    return soil->soil().checksum();
}

TEST(SeveralWorlds, in_one_process_and_in_threads_are_as_alone) {
    constexpr int kCount = 4;
    std::array<uint64_t, kCount> alone{}, together{};
    for (int i = 0; i < kCount; ++i) alone[i] = run_world(i);
    std::vector<std::thread> threads;
    for (int i = 0; i < kCount; ++i) {
        threads.emplace_back([&together, i] { together[i] = run_world(i); });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(alone, together);
    for (int i = 1; i < kCount; ++i) EXPECT_NE(alone[i], alone[0]) << "they differ by their seeds";
}

TEST(SeveralWorlds, stepped_in_turns_are_as_alone) {
    const auto build = [](BulletScene& scene, int seed) {
        auto soil = sand_bed(*scene.world);
        scene.add_box(kMassKg, kHalfBox, kAbove)
            .setLinearVelocity(btVector3(0.2f * btScalar(seed), -1, 0.3f));
        return soil;
    };
    BulletScene first, second;
    const auto a = build(first, 1);
    const auto b = build(second, 2);
    for (int frame = 0; frame < 60; ++frame) {
        first.run(1.0 / 60);
        second.run(1.0 / 60);
    }
    EXPECT_EQ(a->soil().checksum(), run_world(1));
    EXPECT_EQ(b->soil().checksum(), run_world(2));
}

}  // namespace
}  // namespace bsoil::bullet::several_worlds_test
