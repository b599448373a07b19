// A btRaycastVehicle on soil among other actions of its world.
#include <memory>
#include <set>
#include <string>

#include "bsoil/bullet/soil_raycaster.h"
#include "host_action.h"
#include "raycast_car.h"
#include "sand_bed.h"

namespace bsoil::bullet::vehicle_actions_test {
namespace {

constexpr btScalar kBrakeNs = 2;
constexpr double kDriveN = 2000;

/// Large enough for one car, on voxels of 10 cm.
SoilDef car_bed() {
    SoilDef def = small_bed();
    def.size_m = {4, 1, 2};
    def.voxel_m = 0.1;
    return def;
}

/// A car that stands on the bed and drives.
std::unique_ptr<Car> add_car(BulletScene& scene, SoilRaycaster& caster) {
    auto car = std::make_unique<Car>(
        scene, caster, 800,
        btVector3(0, btScalar(kBedTopM) + btScalar(0.2) + Car::kRestM + Car::kRadiusM, 0));
    EXPECT_TRUE(caster.attach(*car->vehicle, SoilWheelDef{.width_m = 0.24}));
    car->drive(kDriveN);
    car->brake(static_cast<double>(kBrakeNs));
    return car;
}

/// What the soil takes for a substep is as the host has set it.
void expect_own_fields(const Car& car, double drive_n, const char* when) {
    for (int i = 0; i < 4; ++i) {
        const btWheelInfo& wheel = car.vehicle->getWheelInfo(i);
        EXPECT_EQ(wheel.m_engineForce, btScalar(drive_n / 4)) << when << ", wheel " << i;
        EXPECT_EQ(wheel.m_brake, kBrakeNs) << when << ", wheel " << i;
        EXPECT_EQ(wheel.m_frictionSlip, car.tuning.m_frictionSlip) << when << ", wheel " << i;
        EXPECT_EQ(wheel.m_maxSuspensionForce, car.tuning.m_maxSuspensionForce)
            << when << ", wheel " << i;
    }
}

// Bullet puts its last action in the place of one that is taken out.
TEST(VehicleActions, vehicle_has_its_fields_after_an_earlier_action_has_gone) {
    BulletScene scene;
    HostAction first([] {});
    scene.world->addAction(&first);
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    auto car = add_car(scene, caster);
    scene.run(0.5);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(caster.wheel_report(i).is_on_soil) << i;
    expect_own_fields(*car, kDriveN, "before");
    scene.world->removeAction(&first);
    scene.run(1.0 / 60);
    expect_own_fields(*car, kDriveN, "after");
    car->drive(0);
    scene.run(1.0 / 60);
    expect_own_fields(*car, 0, "engine off");
    EXPECT_TRUE(caster.wheel_report(0).is_on_soil);
    // Nothing looks at a vehicle that is gone.
    car.reset();
    scene.run(1.0 / 60);
}

TEST(VehicleActions, second_vehicle_has_its_fields_after_the_first_has_gone) {
    BulletScene scene;
    SoilDef def = car_bed();
    def.size_m = {7, 1, 2};
    const auto soil = sand_bed(*scene.world, def);
    auto gone = std::make_unique<SoilRaycaster>(*soil);
    SoilRaycaster caster(*soil);
    auto first = add_car(scene, *gone), second = add_car(scene, caster);
    place(first->chassis, first->chassis.getWorldTransform().getOrigin() - btVector3(1.7f, 0, 0));
    place(second->chassis, second->chassis.getWorldTransform().getOrigin() + btVector3(1.7f, 0, 0));
    scene.run(0.5);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(caster.wheel_report(i).is_on_soil) << i;
    first.reset();
    gone.reset();
    scene.run(1.0 / 60);
    expect_own_fields(*second, kDriveN, "after");
}

TEST(VehicleActions, vehicle_that_is_detached_behind_its_action_has_its_fields) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const auto car = add_car(scene, caster);
    bool detaches = false;
    HostAction host([&] {
        if (detaches) caster.detach();
    });
    scene.world->addAction(&host);
    scene.run(0.5);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(caster.wheel_report(i).is_on_soil) << i;
    detaches = true;
    scene.run(1.0 / 60);
    expect_own_fields(*car, kDriveN, "detached");
}

// A driver that lets go in an action of its own, behind the vehicle's: 0 was taken for what the
// soil had put there, and the throttle and the brake came back in every step.
TEST(VehicleActions, engine_and_brake_that_an_action_behind_lets_go_stay_so) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const auto car = add_car(scene, caster);
    bool lets_go = false;
    HostAction driver([&] {
        if (!lets_go) return;
        car->drive(0);
        car->brake(0);
    });
    scene.world->addAction(&driver);
    scene.run(0.5);
    ASSERT_TRUE(caster.wheel_report(0).is_on_soil);
    expect_own_fields(*car, kDriveN, "driving");
    lets_go = true;
    scene.run(2.0 / 60);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(car->vehicle->getWheelInfo(i).m_engineForce, 0) << i;
        EXPECT_EQ(car->vehicle->getWheelInfo(i).m_brake, 0) << i;
    }
}

// The raycaster looked at the one that is gone whenever the other asked it.
TEST(VehicleActions, raycaster_of_a_vehicle_that_is_deleted_serves_the_next_one) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    auto gone = add_car(scene, caster);
    scene.run(0.1);
    scene.world->removeRigidBody(&gone->chassis);
    gone.reset();
    scene.bodies.clear();
    Car car(scene, caster, 800, btVector3(0, btScalar(kBedTopM) + btScalar(0.95), 0));
    scene.run(1.0 / 60);
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.24}));
    scene.run(0.5);
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(caster.wheel_report(i).is_on_soil) << i;
}

TEST(VehicleActions, raycaster_is_for_one_vehicle_that_asks_it) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    btDefaultVehicleRaycaster other(scene.world.get());
    const auto first = add_car(scene, caster);
    Car second(scene, caster, 800, btVector3(0, 5, 0)), deaf(scene, other, 800, {0, 8, 0});
    const auto refuses = [&](const Car& car, const char* words) {
        const Status attached = caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.24});
        ASSERT_FALSE(attached) << words;
        EXPECT_NE(attached.error().find(words), std::string::npos) << attached.error();
    };
    refuses(second, "another vehicle is attached");
    scene.run(0.5);
    EXPECT_TRUE(caster.wheel_report(0).is_on_soil) << "the first is";
    EXPECT_TRUE(caster.attach(*first->vehicle, SoilWheelDef{.width_m = 0.3})) << "anew";
    caster.detach();
    refuses(deaf, "asks another raycaster");
    EXPECT_TRUE(caster.attach(*second.vehicle, SoilWheelDef{.width_m = 0.24}));
}

// Nothing told when such an update was through: a throttle that the host let go stayed open, and a
// vehicle that was deleted was looked at.
TEST(VehicleActions, vehicle_that_its_host_updates_is_refused) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const Car car(scene, caster, 800, btVector3(0, btScalar(kBedTopM) + btScalar(0.95), 0));
    scene.world->removeVehicle(car.vehicle.get());
    const Status attached = caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.24});
    ASSERT_FALSE(attached);
    EXPECT_NE(attached.error().find("no action of the soil's world"), std::string::npos)
        << attached.error();
    scene.world->addVehicle(car.vehicle.get());
    EXPECT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.24}));
}

TEST(VehicleActions, ray_between_two_steps_meets_no_soil_and_changes_nothing) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const auto car = add_car(scene, caster);
    scene.run(0.5);
    ASSERT_TRUE(caster.wheel_report(0).is_on_soil);
    const btVector3 velocity = car->chassis.getLinearVelocity();
    car->vehicle->updateVehicle(btScalar(1) / 60);
    expect_own_fields(*car, kDriveN, "updated by its host");
    EXPECT_EQ((car->chassis.getLinearVelocity() - velocity).length(), 0);
    EXPECT_FALSE(car->vehicle->getWheelInfo(0).m_raycastInfo.m_isInContact);
    scene.run(1.0 / 60);
    EXPECT_TRUE(caster.wheel_report(0).is_on_soil);
}

// It wrote to the vehicle, whose wheels were gone.
TEST(VehicleActions, deleted_behind_its_action_it_is_detached_without_a_look) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const auto car = add_car(scene, caster);
    bool goes = false;
    HostAction host([&] {
        if (!std::exchange(goes, false)) return;
        scene.world->removeVehicle(car->vehicle.get());
        car->vehicle.reset();
        caster.detach();
    });
    scene.world->addAction(&host);
    scene.run(0.5);
    ASSERT_TRUE(caster.wheel_report(0).is_on_soil);
    goes = true;
    scene.run(0.1);
    EXPECT_FALSE(caster.wheel_report(0).is_on_soil);
}

// They had their ids still, and the soil swept them from where it had seen them last.
TEST(VehicleActions, wheels_are_new_to_a_soil_that_was_off) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    const auto car = add_car(scene, caster);
    scene.run(0.5);
    std::set<int> before;
    for (const ContactVoxel& voxel : soil->last_report().contacts) before.insert(voxel.body);
    ASSERT_GE(before.size(), 4u);
    soil->set_enabled(false);
    scene.run(2.0 / 60);
    soil->set_enabled(true);
    scene.run(2.0 / 60);
    ASSERT_FALSE(soil->last_report().contacts.empty());
    for (const ContactVoxel& voxel : soil->last_report().contacts) {
        EXPECT_FALSE(before.contains(voxel.body)) << voxel.body;
    }
}

TEST(VehicleActions, of_the_host_keep_their_order) {
    BulletScene scene;
    std::string order;
    HostAction a([&] { order += 'a'; }), b([&] { order += 'b'; }), c([&] { order += 'c'; }),
        d([&] { order += 'd'; });
    scene.world->addAction(&a);
    const auto soil = sand_bed(*scene.world, car_bed());
    SoilRaycaster caster(*soil);
    scene.world->addAction(&b);
    const auto car = add_car(scene, caster);
    scene.world->addAction(&c);
    scene.run(2.0 / 60);
    EXPECT_EQ(order, "abcabc");
    order.clear();
    scene.world->addAction(&d);
    scene.run(2.0 / 60);
    EXPECT_EQ(order, "abcdabcd");
    // What was last, the soil's own, comes back to the end.
    order.clear();
    scene.world->removeAction(&a);
    scene.run(2.0 / 60);
    EXPECT_EQ(order, "bcdbcd");
}

}  // namespace
}  // namespace bsoil::bullet::vehicle_actions_test
