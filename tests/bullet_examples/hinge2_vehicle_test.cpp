// Hinge2Vehicle: a chassis on four wheels with btHinge2Constraint, driven by its motors.
#include "example.h"

namespace bsoil::bullet::hinge2_vehicle_test {
namespace {

class Vehicle : public Example {
  public:
    explicit Vehicle(Ground ground)
        : Example(ground, {.side_m = 8, .depth_m = 0.5, .voxel_m = 0.1}) {
        build();
    }

    void build() {
        btCollisionShape& chassis = scene_.shape<btBoxShape>(btVector3(1, 0.25f, 0.5f));
        btCollisionShape& wheel = scene_.shape<btCylinderShapeZ>(btVector3(0.35f, 0.35f, 0.12f));
        chassis_ = &scene_.add(400, chassis, btVector3(-1.5f, 0.85f, 0));
        for (int i = 0; i < 4; ++i) {
            const btVector3 at(i < 2 ? -0.7f : -2.3f, 0.45f, i % 2 == 0 ? 0.75f : -0.75f);
            btRigidBody& body = scene_.add(25, wheel, at);
            btVector3 up(0, 1, 0), axle(0, 0, 1), anchor = at;
            auto joint = std::make_unique<btHinge2Constraint>(*chassis_, body, anchor, up, axle);
            // Steered wheels of the demo; here they go straight.
            joint->setLowerLimit(0);
            joint->setUpperLimit(0);
            joint->setStiffness(2, btScalar(4 * 9.81 * 9.81 * 25));
            joint->setDamping(2, btScalar(1000));  // half of critical: else it bounces
            wheels_.push_back(&join(std::move(joint)));
        }
    }
    void drive(double rad_s, double torque_n_m) {
        for (const auto& body : bodies()) body->activate();
        for (btHinge2Constraint* wheel : wheels_) {
            wheel->enableMotor(3, true);
            wheel->setTargetVelocity(3, btScalar(rad_s));
            wheel->setMaxMotorForce(3, btScalar(torque_n_m));
        }
    }
    double x() const { return static_cast<double>(chassis_->getWorldTransform().getOrigin().x()); }

    double z() const { return static_cast<double>(chassis_->getWorldTransform().getOrigin().z()); }

    btRigidBody* chassis_ = nullptr;
    std::vector<btHinge2Constraint*> wheels_;
};

TEST(Hinge2Vehicle, drives_over_sand_and_stands_when_it_is_braked) {
    Vehicle rigid(Ground::rigid), sand(Ground::sand);
    double way_m[2] = {};
    for (Vehicle* vehicle : {&rigid, &sand}) {
        vehicle->run(3);
        EXPECT_EQ(vehicle->awake_count(), 0) << "it stands";
        const double from_m = vehicle->x();
        vehicle->drive(4, 120);
        const Course driven = vehicle->watch(2);
        way_m[vehicle->has_soil() ? 1 : 0] = std::abs(vehicle->x() - from_m);
        vehicle->drive(0, 1000);
        const Course braked = vehicle->watch(10);
        EXPECT_LT(braked.slept_s, 10) << vehicle->has_soil();
        EXPECT_LT(std::abs(vehicle->z()), 0.05) << "wheels alike go straight on";
        if (!vehicle->has_soil()) continue;
        EXPECT_LT(driven.unbalanced_n, 0.02 * sand.weight_n());
        sand.expect_work(driven, 470, 1.5);  // measured: 336 and 1.16
        EXPECT_LT(braked.unbalanced_n, 0.02 * sand.weight_n());
        EXPECT_NEAR(sand.soil_force_n(), sand.weight_n(), 0.02 * sand.weight_n());
    }
    // Six-axis joints with springs and motors of their own give Bullet more to correct.
    EXPECT_LT(sand.unpaid_j(), sand.millimetre_j());
    EXPECT_LT(sand.unpaid_j(), rigid.unpaid_j()) << "Bullet's joints make some, sand takes it";
    EXPECT_LT(way_m[0], 4 * 0.35 * 2) << "no farther than its rims turn";
    EXPECT_LT(way_m[1], way_m[0]) << "sand slips and resists";
    EXPECT_GT(way_m[1], 0.3 * way_m[0]);
}

}  // namespace
}  // namespace bsoil::bullet::hinge2_vehicle_test
