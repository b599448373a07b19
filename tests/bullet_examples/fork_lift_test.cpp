// ForkLift: a raycast vehicle with a mast on a hinge and a fork on a slider, and a load to lift.
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include "bsoil/bullet/soil_raycaster.h"
#include "example.h"

namespace bsoil::bullet::fork_lift_test {
namespace {

class ForkLiftTruck : public Example {
  public:
    explicit ForkLiftTruck(Ground ground)
        : Example(ground, {.side_m = 16, .depth_m = 0.5, .voxel_m = 0.1}) {
        build();
    }
    ~ForkLiftTruck() override {
        scene_.world->removeVehicle(vehicle_.get());
        vehicle_.reset();
        raycaster_.reset();
    }

    void build() {
        auto& chassis_shape = static_cast<btCompoundShape&>(scene_.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        at.setOrigin(btVector3(0, 1, 0));
        chassis_shape.addChildShape(at, &scene_.shape<btBoxShape>(btVector3(1, 0.5f, 2)));
        chassis_ = &scene_.add(800, chassis_shape, btVector3(0, 0.9f, 0));
        chassis_->setActivationState(DISABLE_DEACTIVATION);
        if (has_soil()) {
            auto caster = std::make_unique<SoilRaycaster>(*soil_);
            caster_ = caster.get();
            raycaster_ = std::move(caster);
        } else {
            raycaster_ = std::make_unique<btDefaultVehicleRaycaster>(scene_.world.get());
        }
        btRaycastVehicle::btVehicleTuning tuning;
        vehicle_ = std::make_unique<btRaycastVehicle>(tuning, chassis_, raycaster_.get());
        vehicle_->setCoordinateSystem(0, 1, 2);
        scene_.world->addVehicle(vehicle_.get());
        for (int i = 0; i < 4; ++i) {
            btWheelInfo& wheel = vehicle_->addWheel(
                btVector3(i % 2 == 0 ? 0.7f : -0.7f, 1.2f, i < 2 ? 1.5f : -1.5f), {0, -1, 0},
                {-1, 0, 0}, btScalar(0.6), btScalar(0.5), tuning, i < 2);
            wheel.m_suspensionStiffness = 20;
            wheel.m_wheelsDampingRelaxation = btScalar(2.3);
            wheel.m_wheelsDampingCompression = btScalar(4.4);
            wheel.m_frictionSlip = 1000;
            wheel.m_rollInfluence = btScalar(0.1);
        }
        if (caster_) {
            const Status attached = caster_->attach(*vehicle_, kWheel);
            EXPECT_TRUE(attached) << attached.error();
        }
        add_fork();
    }
    void add_fork() {
        const btVector3 place = chassis_->getWorldTransform().getOrigin();
        mast_ = &scene_.add(10, scene_.shape<btBoxShape>(btVector3(0.5f, 1, 0.05f)),
                            place + btVector3(0, 1.4f, 2.1f));
        btTransform in_chassis(btQuaternion(0, SIMD_HALF_PI, 0), btVector3(0, 0.4f, 2.1f));
        btTransform in_mast(btQuaternion(0, SIMD_HALF_PI, 0), btVector3(0, -1, 0));
        hinge_ = &join(std::make_unique<btHingeConstraint>(*chassis_, *mast_, in_chassis, in_mast));
        hinge_->setLimit(0, 0);
        auto& fork_shape = static_cast<btCompoundShape&>(scene_.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        fork_shape.addChildShape(at, &scene_.shape<btBoxShape>(btVector3(0.6f, 0.1f, 0.1f)));
        for (const float side : {-0.45f, 0.45f}) {
            at.setOrigin(btVector3(side, -0.08f, 0.7f));
            fork_shape.addChildShape(at, &scene_.shape<btBoxShape>(btVector3(0.1f, 0.05f, 0.7f)));
        }
        fork_ = &scene_.add(5, fork_shape, place + btVector3(0, 0.6f, 2.3f));
        in_mast.setIdentity();
        in_mast.setRotation(btQuaternion(0, 0, SIMD_HALF_PI));
        in_mast.setOrigin(btVector3(0, -0.8f, 0.1f));
        btTransform in_fork(btQuaternion(0, 0, SIMD_HALF_PI), btVector3(0, 0, -0.1f));
        slider_ =
            &join(std::make_unique<btSliderConstraint>(*mast_, *fork_, in_mast, in_fork, true));
        slider_->setLowerLinLimit(btScalar(0));
        slider_->setUpperLinLimit(btScalar(1.2));
        slider_->setLowerAngLimit(0);
        slider_->setUpperAngLimit(0);
        slider_->setMaxLinMotorForce(2000);
        slider_->setPoweredLinMotor(true);
    }
    void brake(double force_n) {
        for (int i = 0; i < 4; ++i) vehicle_->setBrake(btScalar(force_n), i);
    }
    /// Of each wheel.
    void push(double force_n) {
        for (int i = 0; i < 4; ++i) vehicle_->applyEngineForce(btScalar(force_n), i);
    }
    void lift(double speed_m_s) { slider_->setTargetLinMotorVelocity(btScalar(speed_m_s)); }
    double wheel_force_n() const {
        double sum = 0;
        for (int i = 0; i < 4; ++i) sum += caster_->wheel_report(i).normal_force_n;
        return sum;
    }
    /// An engine's force acts at the rim, and a rim turns at least as fast as its truck goes.
    double drive_work_j() const override {
        double sum = 0;
        for (int i = 0; i < 4; ++i) {
            const btWheelInfo& wheel = vehicle_->getWheelInfo(i);
            const btVector3 forward = vehicle_->getForwardVector();
            double rim_m_s = static_cast<double>(chassis_->getLinearVelocity().dot(forward));
            if (caster_) {
                rim_m_s = std::max(rim_m_s, caster_->wheel_report(i).spin_rad_s *
                                                static_cast<double>(wheel.m_wheelsRadius));
            }
            sum += static_cast<double>(wheel.m_engineForce) * rim_m_s / kFramesPerS;
        }
        return sum;
    }
    double stored_j() const override {
        double sum = 0;
        for (int i = 0; i < 4; ++i) {
            const btWheelInfo& wheel = vehicle_->getWheelInfo(i);
            const auto& ray = wheel.m_raycastInfo;
            const auto short_m =
                static_cast<double>(wheel.m_suspensionRestLength1 - ray.m_suspensionLength);
            sum += static_cast<double>(wheel.m_suspensionStiffness / chassis_->getInvMass()) *
                       short_m * short_m / 2 -
                   ahead_j(wheel);
            if (!caster_) continue;  // there a wheel has no mass
            const double rim_m_s =
                caster_->wheel_report(i).spin_rad_s * static_cast<double>(wheel.m_wheelsRadius);
            // Its world transform still has the strut's length of the frame before.
            const btVector3 at =
                ray.m_hardPointWS + ray.m_suspensionLength * ray.m_wheelDirectionWS;
            sum += kWheel.mass_kg *
                   (rim_m_s * rim_m_s / 4 + kGravity_m_s2 * static_cast<double>(at.y()));
        }
        return sum;
    }
    double fork_m() const { return height_m(*fork_); }
    double chassis_m() const { return height_m(*chassis_); }
    const btHingeConstraint& hinge() const { return *hinge_; }
    /// How far it gets in so many seconds.
    double way_m(double seconds) {
        const btVector3 from = chassis_->getWorldTransform().getOrigin();
        run(seconds);
        return static_cast<double>((chassis_->getWorldTransform().getOrigin() - from).length());
    }

  private:
    static constexpr SoilWheelDef kWheel{.width_m = 0.4};

    /// Of a wheel's strut: it pushes after its chassis has moved, which leaves F dt v / 2 too much
    /// on the way up, as gravity does on the way down.
    double ahead_j(const btWheelInfo& wheel) const {
        const auto& ray = wheel.m_raycastInfo;
        if (!ray.m_isInContact) return 0;
        const btVector3 arm = ray.m_contactPointWS - chassis_->getCenterOfMassPosition();
        const btScalar rise_m_s = chassis_->getVelocityInLocalPoint(arm).dot(ray.m_contactNormalWS);
        const btScalar strut_n =
            std::min(wheel.m_wheelsSuspensionForce, wheel.m_maxSuspensionForce);
        return static_cast<double>(strut_n * rise_m_s) / (2 * kFramesPerS);
    }

    btRigidBody *chassis_ = nullptr, *mast_ = nullptr, *fork_ = nullptr;
    btHingeConstraint* hinge_ = nullptr;
    btSliderConstraint* slider_ = nullptr;
    std::unique_ptr<btVehicleRaycaster> raycaster_;
    SoilRaycaster* caster_ = nullptr;
    std::unique_ptr<btRaycastVehicle> vehicle_;
};

TEST(ForkLift, drives_on_sand_and_lifts_its_fork) {
    ForkLiftTruck rigid(Ground::rigid), sand(Ground::sand);
    for (ForkLiftTruck* truck : {&rigid, &sand}) {
        truck->brake(30);
        truck->run(2);
        const double low_m = truck->fork_m(), chassis_m = truck->chassis_m();
        truck->lift(0.5);
        truck->run(2);
        EXPECT_NEAR(truck->fork_m() - low_m, 1, 0.01) << "half a metre a second for two";
        EXPECT_NEAR(truck->chassis_m(), chassis_m, 0.001) << "it stands still meanwhile";
        truck->lift(0);
        truck->brake(0);
    }
    EXPECT_NEAR(sand.wheel_force_n(), sand.weight_n(), 0.02 * sand.weight_n());
    // Wheels of 1 m that have sunk by z roll with a resistance of 3/4 sqrt(z / 1 m) of their load,
    // Bekker's for a pressure that grows with depth: 940 N at 25 mm.
    sand.push(150);
    EXPECT_LT(sand.way_m(2), 0.05) << "600 N do not move it";
    sand.push(600);
    rigid.push(600);
    const double on_sand_m = sand.way_m(2), on_rigid_m = rigid.way_m(2);
    EXPECT_NEAR(on_rigid_m, 2400 * 2.0 / rigid.mass_kg(), 0.5) << "F t^2 / 2m";
    EXPECT_GT(on_sand_m, 1);
    EXPECT_LT(on_sand_m, on_rigid_m - 940 * 2.0 / sand.mass_kg() + 1);
    // Braked it stands after a second. Sand gives way by a millimetre more in the next three: its
    // speed would not say so, for its struts push half a frame ahead.
    for (ForkLiftTruck* truck : {&rigid, &sand}) {
        truck->push(0);
        truck->brake(300);
        truck->run(2);
        const double stood_m = truck->chassis_m();
        const Course stands = truck->watch(3);
        EXPECT_LT(stands.drift_m, 0.005) << truck->has_soil();
        EXPECT_NEAR(truck->chassis_m(), stood_m, 0.002) << truck->has_soil();
        if (truck->has_soil()) sand.expect_work(stands, 900, 0.4);  // measured: 716 and 0.32
    }
    EXPECT_LT(sand.gap_m(sand.hinge()), 0.02);
    EXPECT_LT(rigid.unpaid_j(), rigid.millimetre_j());
    EXPECT_LT(sand.unpaid_j(), sand.millimetre_j());
}

}  // namespace
}  // namespace bsoil::bullet::fork_lift_test
