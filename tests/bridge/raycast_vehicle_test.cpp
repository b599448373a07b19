// A btRaycastVehicle on soil.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>

#include "bsoil/bullet/soil_raycaster.h"
#include "bullet_scene.h"
#include "bullet_types.h"
#include "cure.h"
#include "raycast_car.h"
#include "temporary_file.h"

namespace bsoil::bullet::raycast_vehicle_test {
namespace {

constexpr double kGravity_m_s2 = 9.81;
constexpr double kSurfaceM = 0.56;  // 7 voxels
constexpr btScalar kRadiusM = Car::kRadiusM, kRestM = Car::kRestM;
constexpr double kWidthM = 0.24;

SoilDef bed_def() {
    SoilDef def;
    def.size_m = {10, 1.6, 2.4};
    def.voxel_m = 0.08;
    def.backend = Backend::cpu;
    return def;
}

/// Sand up to kSurfaceM, where it does not rise towards +x, from x = 0 on.
std::unique_ptr<SoilAction> make_bed(BulletScene& scene, double slope_rad = 0,
                                     const SoilDef& def = bed_def()) {
    auto soil = SoilAction::create(*scene.world, def);
    EXPECT_TRUE(soil) << soil.error();
    const auto surface = [slope_rad](Vec3 p) {
        return kSurfaceM + std::max(0.0, p.x) * std::tan(slope_rad) - p.y;
    };
    const Status filled =
        slope_rad > 0 ? (*soil)->fill(FunctionFill{surface, "dry_sand"})
                      : (*soil)->fill(BoxFill{{{-9, -1, -9}, {9, kSurfaceM, 9}}, "dry_sand"});
    EXPECT_TRUE(filled) << filled.error();
    return std::move(*soil);
}

btVector3 above_soil(double x) {
    return {btScalar(x), btScalar(kSurfaceM) + kRadiusM + kRestM + 0.2f, 0};
}

/// A car whose wheels meet the sand of a bed.
struct CarOnSand {
    BulletScene scene;
    std::unique_ptr<SoilAction> soil = make_bed(scene);
    SoilRaycaster caster{*soil};
    Car car;

    CarOnSand(double mass_kg, double x_m, const SoilWheelDef& wheels = {.width_m = kWidthM})
        : car(scene, caster, mass_kg, above_soil(x_m)) {
        const Status attached = caster.attach(*car.vehicle, wheels);
        EXPECT_TRUE(attached) << attached.error();
    }
};

TEST(RaycastVehicle, attach_names_what_is_wrong) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 800, above_soil(0));
    const auto refuses = [&](const SoilWheelDef& def, const char* field) {
        const Status attached = caster.attach(*car.vehicle, def);
        ASSERT_FALSE(attached) << field;
        EXPECT_NE(attached.error().find(field), std::string::npos) << attached.error();
        EXPECT_TRUE(says_what_to_do(attached.error())) << attached.error();
    };
    refuses({.width_m = 0}, "width_m");
    refuses({.width_m = std::numeric_limits<double>::quiet_NaN()}, "width_m");
    refuses({.mass_kg = -1}, "mass_kg");
    refuses({.rim_speed_max_m_s = std::numeric_limits<double>::infinity()}, "rim_speed_max_m_s");
    refuses({.surface = {.friction = 3}}, "friction");
    const std::vector<SoilWheelDef> three(3);
    const Status few = caster.attach(*car.vehicle, three);
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().find("3 wheels"), std::string::npos) << few.error();
    EXPECT_TRUE(says_what_to_do(few.error())) << few.error();
    car.vehicle->getWheelInfo(2).m_wheelsRadius = 0;
    refuses({}, "m_wheelsRadius");
    btRaycastVehicle none(car.tuning, &car.chassis, &caster);
    const Status without_wheels = caster.attach(none, SoilWheelDef{});
    ASSERT_FALSE(without_wheels);
    EXPECT_TRUE(says_what_to_do(without_wheels.error())) << without_wheels.error();
    scene.run(0.1);  // attached to nothing, it still answers
    EXPECT_FALSE(caster.wheel_report(0).is_on_soil);
    EXPECT_EQ(caster.wheel_report(-1).normal_force_n, 0);
}

TEST(RaycastVehicle, parked_it_stands_on_its_weight_and_does_not_move) {
    uint64_t checksum = 0;
    for (int round = 0; round < 2; ++round) {
        BulletScene scene;
        const auto soil = make_bed(scene);
        SoilRaycaster caster(*soil);
        Car car(scene, caster, 800, above_soil(0));
        ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
        car.brake(50);
        scene.run(3);
        const double weight_n = 800 * kGravity_m_s2;
        EXPECT_NEAR(car.suspension_n(), weight_n, 0.01 * weight_n);
        EXPECT_NEAR(sum_of(caster, &SoilWheelReport::normal_force_n), weight_n, 0.01 * weight_n);
        const btVector3 at = car.chassis.getWorldTransform().getOrigin();
        scene.run(1);
        EXPECT_LT((car.chassis.getWorldTransform().getOrigin() - at).length(), 1e-3f);
        for (int i = 0; i < 4; ++i) {
            EXPECT_TRUE(caster.wheel_report(i).is_on_soil);
            // What the soil borrowed for a substep is the host's again.
            EXPECT_EQ(car.vehicle->getWheelInfo(i).m_brake, 50);
            EXPECT_EQ(car.vehicle->getWheelInfo(i).m_frictionSlip, 1.5f);
            EXPECT_EQ(car.vehicle->getWheelInfo(i).m_maxSuspensionForce, 1e6f);
        }
        if (round == 0) checksum = soil->soil().checksum();
        EXPECT_EQ(soil->soil().checksum(), checksum);
    }
}

// Struts push the chassis between substeps, when Bullet's solver has no load with it.
TEST(RaycastVehicle, wheels_bear_what_the_chassis_carries) {
    CarOnSand on(200, 0);
    on.car.brake(50);
    on.scene.run(2);
    const double top_m =
        static_cast<double>(on.car.chassis.getWorldTransform().getOrigin().y()) + 0.2 + 0.04;
    ASSERT_TRUE((*on.soil).fill(BoxFill{{{-0.8, top_m, -0.3}, {0.8, top_m + 0.16, 0.3}}, {}}));
    on.scene.run(3);
    const double load_kg = on.soil->body_report(on.car.chassis).load_kg;
    EXPECT_GT(load_kg, 100);
    const double weight_n = (200 + load_kg) * kGravity_m_s2;
    EXPECT_NEAR(sum_of(on.caster, &SoilWheelReport::normal_force_n), weight_n, 0.01 * weight_n);
}

TEST(RaycastVehicle, sinks_as_deep_as_coupled_wheels_of_its_load) {
    const double mass_kg = 8000;
    // Gravity comes on slowly, so that nothing falls into the soil.
    const auto settle = [](BulletScene& scene) {
        for (int frame = 1; frame <= 240; ++frame) {
            const double g = kGravity_m_s2 * std::min(1.0, frame / 120.0);
            for (const auto& body : scene.bodies) body->setGravity(btVector3(0, btScalar(-g), 0));
            scene.world->stepSimulation(btScalar(1) / 60, 1);
        }
    };
    // Sinkage scatters with where in the grid the wheels stand: 10.2 to 14.7 mm, on rays 11.9 to
    // 16.6 mm, and is 11.7 and 14.0 mm in the mean.
    double coupled_m = 0, ray_m = 0;
    for (const btScalar x_m : {0.0f, 0.013f, 0.025f, 0.038f}) {
        BulletScene scene;
        const auto soil = make_bed(scene);
        btCollisionShape& shape =
            scene.shape<btCylinderShapeZ>(btVector3(kRadiusM, kRadiusM, btScalar(kWidthM / 2)));
        for (int i = 0; i < 4; ++i) {
            scene.add(btScalar(mass_kg / 4), shape,
                      {x_m + (i < 2 ? 0.9f : -0.9f), btScalar(kSurfaceM) + kRadiusM,
                       i % 2 == 0 ? 0.6f : -0.6f});
        }
        settle(scene);
        for (const auto& body : scene.bodies) {
            coupled_m += kSurfaceM +
                         static_cast<double>(kRadiusM - body->getWorldTransform().getOrigin().y());
        }
    }
    for (const double x_m : {0.0, 0.013, 0.025, 0.038}) {
        BulletScene scene;
        const auto soil = make_bed(scene);
        SoilRaycaster caster(*soil);
        Car car(scene, caster, mass_kg, above_soil(x_m));
        ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
        car.brake(500);
        settle(scene);
        for (int i = 0; i < 4; ++i) {
            ray_m += kSurfaceM + static_cast<double>(kRadiusM) - car.wheel_height_m(i);
        }
    }
    EXPECT_GT(coupled_m / 16, 0.005);
    EXPECT_NEAR(ray_m, coupled_m, 0.25 * coupled_m);
}

TEST(RaycastVehicle, leaves_ruts_and_stands_lower_in_them) {
    BulletScene scene;
    SoilDef def = bed_def();
    def.size_m = {6, 1.2, 2};
    def.voxel_m = 0.05;
    const auto soil = make_bed(scene, 0, def);
    const int64_t units = soil->soil().totals().units[0];
    SoilRaycaster caster(*soil);
    double fresh_m = 0;
    {
        Car car(scene, caster, 8000, above_soil(-1.6));
        ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
        scene.run(0.7);
        for (int wheel = 0; wheel < 4; ++wheel) fresh_m += car.wheel_height_m(wheel) / 4;
        car.drive(24000);
        scene.run(2.8);
        EXPECT_GT(car.x(), 0);
        caster.detach();
        scene.remove(car.chassis);
    }
    scene.run(0.2);
    const auto height_m = [&](double x, double z) {
        return soil->surface_at({x, 0, z})->position_m.y;
    };
    // Where the rear wheels were last. Before them lies what the front ones have thrown back.
    double rut_m = 0, beside_m = 0;
    for (int i = 0; i < 5; ++i) {
        rut_m += (height_m(-1 + 0.1 * i, 0.6) + height_m(-1 + 0.1 * i, -0.6)) / 10;
        beside_m += height_m(-1 + 0.1 * i, 0) / 5;
    }
    EXPECT_LT(rut_m, beside_m - 0.02);
    EXPECT_NEAR(beside_m, kSurfaceM, 0.01);
    EXPECT_EQ(soil->soil().totals().units[0], units);
    Car second(scene, caster, 8000, above_soil(-0.8));
    ASSERT_TRUE(caster.attach(*second.vehicle, SoilWheelDef{.width_m = kWidthM}));
    scene.run(1.5);
    double second_m = 0;
    for (int wheel = 0; wheel < 4; ++wheel) second_m += second.wheel_height_m(wheel) / 4;
    EXPECT_LT(second_m, fresh_m - 0.005);
}

TEST(RaycastVehicle, pulls_as_hard_as_the_soil_lets_it_and_no_harder) {
    const double mass_kg = 800, weight_n = mass_kg * kGravity_m_s2;
    const auto run = [&](double force_n) {
        BulletScene scene;
        const auto soil = make_bed(scene);
        SoilRaycaster caster(*soil);
        Car car(scene, caster, mass_kg, above_soil(-3.5));
        const SoilWheelDef wheel{.width_m = kWidthM, .rim_speed_max_m_s = 10};
        EXPECT_TRUE(caster.attach(*car.vehicle, wheel));
        scene.run(1);
        car.drive(force_n);
        double most_n = 0, slip = 0;
        for (int frame = 0; frame < 75; ++frame) {
            scene.run(1.0 / 60);
            most_n = std::max(most_n, std::abs(sum_of(caster, &SoilWheelReport::traction_n)));
            slip = sum_of(caster, &SoilWheelReport::slip) / 4;
            for (int i = 0; i < 4; ++i) {
                EXPECT_LE(std::abs(caster.wheel_report(i).spin_rad_s) * 0.4, 10.01);
            }
        }
        EXPECT_EQ(car.vehicle->getWheelInfo(0).m_engineForce, btScalar(force_n / 4));
        return std::tuple(car.speed(), slip, most_n);
    };
    const auto [idle_speed, idle_slip, idle_n] = run(200);
    const auto [slow_speed, slow_slip, slow_n] = run(1600);
    const auto [fast_speed, fast_slip, fast_n] = run(2600);
    const auto [spin_speed, spin_slip, spin_n] = run(40000);
    EXPECT_LT(idle_speed, 0.1);  // less than the sand's resistance to motion
    EXPECT_GT(slow_speed, 0.3);
    EXPECT_GT(fast_speed, slow_speed);
    EXPECT_LT(slow_slip, 0.4);
    EXPECT_GT(spin_slip, 0.5);
    // Coulomb: the sand's friction with the wheels is 0.4; what more there is, is the push against
    // the rut's rear, momentum of the sand thrown back, and the load that bounces.
    EXPECT_LT(spin_n, 0.8 * weight_n);
    EXPECT_LT(spin_speed, 0.5 * kGravity_m_s2 * 1.25);
}

TEST(RaycastVehicle, climbs_a_gentle_slope_and_gets_stuck_on_a_steep_one) {
    const auto climb = [](double slope_deg) {
        BulletScene scene;
        SoilDef def = bed_def();
        def.size_m = {7, 2.8, 2.4};
        const auto soil = make_bed(scene, slope_deg * std::numbers::pi / 180, def);
        SoilRaycaster caster(*soil);
        Car car(scene, caster, 800, above_soil(-2));
        EXPECT_TRUE(
            caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM, .rim_speed_max_m_s = 2}));
        scene.run(0.5);
        car.drive(8000);
        scene.run(2.5);
        return car.x();
    };
    EXPECT_GT(climb(4), 1.5);
    EXPECT_LT(climb(28), 1.0);  // steeper than the friction angle of wheels on sand, 22 deg
}

TEST(RaycastVehicle, braked_it_holds_on_a_slope) {
    BulletScene scene;
    SoilDef def = bed_def();
    def.size_m.y = 2.4;
    const auto soil = make_bed(scene, 10 * std::numbers::pi / 180, def);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 800, above_soil(2) + btVector3(0, 0.45f, 0));
    btTransform pose = car.chassis.getWorldTransform();
    pose.setRotation(btQuaternion({0, 0, 1}, btScalar(10 * std::numbers::pi / 180)));
    car.chassis.setWorldTransform(pose);
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
    car.brake(100);
    scene.run(2);
    const double x = car.x();
    scene.run(2);
    EXPECT_NEAR(car.x(), x, 0.01);
}

TEST(RaycastVehicle, falls_when_the_soil_below_it_is_gone) {
    for (const bool sleeps : {false, true}) {
        BulletScene scene;
        auto made = SoilAction::create(*scene.world, bed_def());
        ASSERT_TRUE(made);
        const auto soil = std::move(*made);
        const TemporaryFile file("raycast_vehicle_empty.snapshot");
        ASSERT_TRUE(soil->soil().save(file.path()));
        ASSERT_TRUE(soil->fill(BoxFill{{{-9, -1, -9}, {9, kSurfaceM, 9}}, "dry_sand"}));
        SoilRaycaster caster(*soil);
        Car car(scene, caster, 800, above_soil(0));
        ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
        car.brake(50);
        scene.run(2);
        if (sleeps) car.chassis.forceActivationState(ISLAND_SLEEPING);
        ASSERT_TRUE(soil->soil().load(file.path()));
        const btScalar before_m = car.chassis.getWorldTransform().getOrigin().y();
        scene.run(0.5);
        // Free fall but for a few substeps: g t2 / 2 is 1.2 m.
        EXPECT_LT(car.chassis.getWorldTransform().getOrigin().y(), before_m - 0.9f);
        EXPECT_EQ(car.suspension_n(), 0);
    }
}

// Its wheels kept the speeds that it fell asleep with: they turned for good, and in frames longer
// than a soil step the soil had them a step back and here again.
TEST(RaycastVehicle, asleep_its_wheels_stand_and_so_does_the_soil) {
    CarOnSand on(800, 0);
    on.car.brake(50);
    on.scene.run(2);
    on.car.brake(0);
    on.car.drive(800);
    on.scene.run(0.2);
    EXPECT_GT(on.caster.wheel_report(0).spin_rad_s, 0.1);
    on.car.chassis.forceActivationState(ISLAND_SLEEPING);
    const auto run = [&](double seconds) {
        for (double s = 0; s < seconds; s += 0.03) on.scene.world->stepSimulation(0.03f, 0);
    };
    run(1);
    EXPECT_FALSE(on.car.chassis.isActive());
    EXPECT_EQ(on.soil->last_report().block_active_count, 0);
    const btScalar rotation = on.car.vehicle->getWheelInfo(0).m_rotation;
    const uint64_t checksum = on.soil->soil().checksum();
    run(1);
    EXPECT_EQ(on.car.vehicle->getWheelInfo(0).m_rotation, rotation);
    EXPECT_EQ(on.caster.wheel_report(0).spin_rad_s, 0);
    EXPECT_EQ(on.soil->soil().checksum(), checksum);
    EXPECT_EQ(on.soil->last_report().block_active_count, 0);
    // Its engine turns them. Wheels of 0.8 m that have sunk by z = 17 mm roll with a resistance of
    // 3/4 sqrt(z / 0.8 m) of their load, Bekker's for a pressure that grows with depth: 860 N.
    on.car.drive(1700);
    on.car.chassis.activate();
    run(1);
    EXPECT_GT(on.caster.wheel_report(0).spin_rad_s, 0.5);
}

TEST(RaycastVehicle, driven_wheels_report_their_engines_torque) {
    CarOnSand on(800, -3);
    on.car.drive(2500);
    on.scene.run(1);
    double mean_n_m = 0;
    const double spin_rad_s = sum_of(on.caster, &SoilWheelReport::spin_rad_s);
    for (int i = 0; i < 60; ++i, on.scene.run(1.0 / 60)) {
        mean_n_m += sum_of(on.caster, &SoilWheelReport::torque_n_m) / 60;
    }
    // Less what spins the wheels up, discs of 20 kg.
    const double gained_rad_s = sum_of(on.caster, &SoilWheelReport::spin_rad_s) - spin_rad_s;
    EXPECT_NEAR(mean_n_m, kRadiusM * (10 * kRadiusM * gained_rad_s - 2500), 0.03 * 1000);
}

TEST(RaycastVehicle, falls_through_soil_that_is_off) {
    CarOnSand on(800, 0);
    on.scene.run(1);
    on.soil->set_enabled(false);
    const btScalar before_m = on.car.chassis.getWorldTransform().getOrigin().y();
    on.scene.run(0.3);
    EXPECT_LT(on.car.chassis.getWorldTransform().getOrigin().y(),
              before_m - 0.25f);  // g t2 / 2: 0.44
    EXPECT_EQ(on.car.suspension_n(), 0);
}

// Struts too stiff for the step, wheels as heavy as the chassis: turning in the air they threw it
// about, with 24 times its energy after two steps and a million times after 30.
TEST(RaycastVehicle, gains_no_energy_in_the_air) {
    BulletScene scene;
    scene.world->setGravity({0, 0, 0});
    SoilDef def = bed_def();
    def.gravity_m_s2 = 0;
    const auto soil = make_bed(scene, 0, def);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 20, {0, 3, 0});
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM, .mass_kg = 20}));
    for (int i = 0; i < 4; ++i) {
        btWheelInfo& wheel = car.vehicle->getWheelInfo(i);
        wheel.m_suspensionStiffness = 3000;
        wheel.m_wheelsDampingCompression = wheel.m_wheelsDampingRelaxation = 40;
    }
    car.chassis.setAngularVelocity({3, 0, 5});
    const auto energy_j = [&] {
        const btVector3 spin =
            car.chassis.getAngularVelocity() * car.chassis.getWorldTransform().getBasis();
        const btScalar twice = 20 * car.chassis.getLinearVelocity().length2() +
                               spin.dot(car.chassis.getLocalInertia() * spin);
        return static_cast<double>(twice / 2);
    };
    const double start_j = energy_j();
    for (int i = 0; i < 120; ++i) {
        scene.run(1.0 / 60);
        ASSERT_LE(energy_j(), start_j * (1 + 1e-5)) << "step " << i;
    }
}

TEST(RaycastVehicle, on_rigid_ground_above_the_soil_it_drives_as_with_the_default_raycaster) {
    const auto run = [](bool with_soil) {
        BulletScene scene;
        scene.add_box(0, {5, 0.5f, 1.2f}, {0, btScalar(kSurfaceM) - 0.4f, 0});  // 0.1 m above
        std::unique_ptr<SoilAction> soil;
        std::unique_ptr<btVehicleRaycaster> caster;
        if (with_soil) {
            soil = make_bed(scene);
            caster = std::make_unique<SoilRaycaster>(*soil);
        } else {
            caster = std::make_unique<btDefaultVehicleRaycaster>(scene.world.get());
        }
        Car car(scene, *caster, 800, above_soil(-2) + btVector3(0, 0.1f, 0));
        if (with_soil) {
            auto& on_soil = static_cast<SoilRaycaster&>(*caster);
            EXPECT_TRUE(on_soil.attach(*car.vehicle, SoilWheelDef{.width_m = kWidthM}));
        }
        scene.run(1);
        car.drive(2000);
        scene.run(1);
        return from_bullet(car.chassis.getWorldTransform().getOrigin());
    };
    const Vec3 with_soil = run(true), without = run(false);
    EXPECT_GT(without.x, -1.5);  // forward, so both agree on where that is
    EXPECT_NEAR(length(with_soil - without), 0, 0.02);
}

TEST(RaycastVehicle, default_raycaster_drives_on_the_soil_as_on_rigid_ground) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btDefaultVehicleRaycaster caster(scene.world.get());
    Car car(scene, caster, 800, above_soil(-2));
    const uint64_t before = soil->soil().checksum();
    scene.run(1);
    EXPECT_NEAR(car.wheel_height_m(0), kSurfaceM + static_cast<double>(kRadiusM), 1e-3);
    car.drive(2000);
    scene.run(1);
    EXPECT_GT(car.x(), -1.5);
    EXPECT_EQ(soil->soil().checksum(), before);
}

TEST(RaycastVehicle, steers) {
    CarOnSand on(800, -3.5, {.width_m = kWidthM, .rim_speed_max_m_s = 3});
    for (int i = 0; i < 2; ++i) on.car.vehicle->setSteeringValue(0.25f, i);
    on.scene.run(0.5);
    on.car.drive(2500);
    on.scene.run(2);
    const btVector3 heading = on.car.chassis.getWorldTransform().getBasis().getColumn(0);
    EXPECT_GT(on.car.x(), -3);
    EXPECT_GT(std::atan2(-heading.z(), heading.x()), 0.1f);  // about +y, as the wheels are turned
}

TEST(RaycastVehicle, works_whatever_is_added_or_destroyed_first) {
    BulletScene scene;
    auto soil = make_bed(scene);
    auto caster = std::make_unique<SoilRaycaster>(*soil);
    auto car = std::make_unique<Car>(scene, *caster, 800, above_soil(0));
    ASSERT_TRUE(caster->attach(*car->vehicle, SoilWheelDef{.width_m = kWidthM}));
    // Behind the vehicle's action instead of before it.
    scene.world->removeAction(soil.get());
    scene.world->addAction(soil.get());
    car->drive(2000);
    scene.run(1);
    EXPECT_GT(car->x(), 0.02);
    EXPECT_EQ(car->vehicle->getWheelInfo(0).m_engineForce, 500);
    double mean_n = 0;  // it drives over uneven soil
    for (int frame = 0; frame < 30; ++frame) {
        scene.run(1.0 / 60);
        mean_n += static_cast<double>(car->suspension_n()) / 30;
    }
    EXPECT_NEAR(mean_n, 800 * kGravity_m_s2, 0.1 * 800 * kGravity_m_s2);
    soil.reset();
    scene.run(0.3);
    EXPECT_EQ(car->suspension_n(), 0);
    const Status gone = caster->attach(*car->vehicle, SoilWheelDef{});
    ASSERT_FALSE(gone);
    EXPECT_TRUE(says_what_to_do(gone.error())) << gone.error();
    car.reset();
    caster.reset();
    scene.run(0.1);
}

}  // namespace
}  // namespace bsoil::bullet::raycast_vehicle_test
