// What soil does to bodies that sleep under it: a load that comes or goes wakes them.
#include "bsoil/bullet/world_snapshot.h"
#include "sand_bed.h"
#include "temporary_file.h"

namespace bsoil::bullet::sleeping_load_test {
namespace {

/// For a second.
SourceDef pour(Vec3 center_m, double mass_kg, double start_s) {
    SourceDef source;
    source.center_m = center_m;
    source.rate_kg_s = mass_kg;
    source.start_s = start_s;
    source.end_s = start_s + 1;
    return source;
}

/// 20 kg asleep on the sand get a heap of 4 kg, none of which falls beside them.
struct HeapOnPlate {
    static constexpr double kMassKg = 20, kHeapKg = 4;
    BulletScene scene;
    std::unique_ptr<SoilAction> soil = sand_bed(*scene.world);
    btRigidBody& plate = scene.add_box(kMassKg, btVector3(0.3f, 0.05f, 0.3f),
                                       btVector3(0, btScalar(kBedTopM + 0.05), 0));

    HeapOnPlate() { EXPECT_TRUE(soil->soil().add_source(pour({0, 0.7, 0}, kHeapKg, 6))); }
};

TEST(SleepingLoad, weighs_on_what_it_lies_on) {
    HeapOnPlate heap;
    heap.scene.run(5);
    ASSERT_FALSE(heap.plate.isActive());
    heap.scene.run(8);
    const BodyReport report = heap.soil->body_report(heap.plate);
    EXPECT_FALSE(heap.plate.isActive());
    EXPECT_NEAR(report.load_kg, HeapOnPlate::kHeapKg, 0.1);
    const double weight_n = (HeapOnPlate::kMassKg + report.load_kg) * kGravity_m_s2;
    EXPECT_NEAR(report.force_n.y, weight_n, 0.02 * weight_n);
}

// Saved while the first of it lies there: the other world's plate wakes in the same frame.
TEST(SleepingLoad, wakes_its_carrier_in_a_restored_world_as_soon) {
    const TemporaryFile file("heap_on_plate.snapshot");
    HeapOnPlate one, two;
    one.scene.run(6.4);
    ASSERT_FALSE(one.plate.isActive());
    ASSERT_GT(one.soil->body_report(one.plate).load_kg, 0);
    SoilAction *saved[] = {one.soil.get()}, *restored[] = {two.soil.get()};
    ASSERT_TRUE(save_world(*one.scene.world, saved, file.path()));
    const Status loaded = load_world(*two.scene.world, restored, file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    bool has_woken = false;
    for (int frame = 0; frame < 60; ++frame) {
        one.scene.run(1.0 / 60);
        two.scene.run(1.0 / 60);
        ASSERT_EQ(one.plate.isActive(), two.plate.isActive()) << "frame " << frame;
        has_woken = has_woken || one.plate.isActive();
    }
    EXPECT_TRUE(has_woken);
    EXPECT_EQ(one.soil->soil().checksum(), two.soil->soil().checksum());
}

// A tray asleep on a spring comes down by what is poured onto it, by hand: m g / k.
TEST(SleepingLoad, presses_its_carriers_spring) {
    constexpr double kMassKg = 40, kStiffness_n_m = 20000, kHeight_m = 0.6;
    const double damping_n_s_m = std::sqrt(kStiffness_n_m * kMassKg);  // half of the critical one
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {2, 1.5, 2};
    const auto soil = SoilAction::create(*scene.world, def);
    ASSERT_TRUE(soil) << soil.error();
    btRigidBody& tray =
        scene.add_box(kMassKg, btVector3(0.6f, 0.05f, 0.6f), btVector3(0, btScalar(kHeight_m), 0));
    tray.setLinearFactor(btVector3(0, 1, 0));
    tray.setAngularFactor(btVector3(0, 0, 0));
    const auto run = [&](double seconds) {
        for (int frame = 0; frame < 60 * seconds; ++frame) {
            const auto speed_m_s = static_cast<double>(tray.getLinearVelocity().y());
            const double up_n =
                kStiffness_n_m * (kHeight_m - height_of(tray)) - damping_n_s_m * speed_m_s;
            if (tray.isActive()) tray.applyCentralForce(btVector3(0, btScalar(up_n), 0));
            scene.run(1.0 / 60);
        }
    };
    run(5);
    ASSERT_FALSE(tray.isActive());
    const double before_m = height_of(tray);
    EXPECT_NEAR(before_m, kHeight_m - kMassKg * kGravity_m_s2 / kStiffness_n_m, 5e-4);
    ASSERT_TRUE((*soil)->soil().add_source(pour({0, 1.2, 0}, 60, 6)));
    run(10);
    const double load_kg = (*soil)->body_report(tray).load_kg;
    EXPECT_GT(load_kg, 20);  // what does not run off it
    const double sag_m = load_kg * kGravity_m_s2 / kStiffness_n_m;
    EXPECT_NEAR(before_m - height_of(tray), sag_m, 0.03 * sag_m);
    EXPECT_FALSE(tray.isActive());
}

// A body falls asleep under a jet, which ends: it bears its own weight and what lies on it.
TEST(SleepingLoad, that_ends_is_felt_no_more) {
    constexpr double kMassKg = 2;
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& plate = scene.add_box(kMassKg, btVector3(0.1f, 0.05f, 0.1f),
                                       btVector3(0, btScalar(kBedTopM + 0.05), 0));
    SourceDef jet = pour({0, 0.8, 0}, 3, 0);
    jet.end_s = 6;
    ASSERT_TRUE(soil->soil().add_source(jet));
    scene.run(6);
    const bool slept_under_it = !plate.isActive();
    scene.run(6);
    const BodyReport report = soil->body_report(plate);
    EXPECT_FALSE(plate.isActive());
    EXPECT_TRUE(slept_under_it);
    const double weight_n = kMassKg * kGravity_m_s2 - report.load_n.y;
    EXPECT_NEAR(report.force_n.y, weight_n, 0.02 * weight_n);
}

}  // namespace
}  // namespace bsoil::bullet::sleeping_load_test
