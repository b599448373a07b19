// A car on rays for tests.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <memory>

#include "bsoil/bullet/soil_raycaster.h"
#include "bullet_scene.h"

namespace bsoil::bullet {

/// A car of four wheels that heads for +x. `at`: of its chassis, whose wheels are at rest
/// 0.2 m + kRestM below it.
struct Car {
    static constexpr btScalar kRadiusM = 0.4f, kRestM = 0.35f;

    BulletScene& scene;
    btRaycastVehicle::btVehicleTuning tuning;
    btRigidBody& chassis;
    std::unique_ptr<btRaycastVehicle> vehicle;

    Car(BulletScene& in, btVehicleRaycaster& caster, double mass_kg, const btVector3& at)
        : scene(in),
          chassis(scene.add(static_cast<btScalar>(mass_kg),
                            scene.shape<btBoxShape>(btVector3(1.2f, 0.2f, 0.5f)), at)) {
        chassis.setActivationState(DISABLE_DEACTIVATION);
        tuning.m_suspensionStiffness = 40;
        tuning.m_suspensionCompression = 4.4f;
        tuning.m_suspensionDamping = 4.6f;
        tuning.m_maxSuspensionForce = 1e6f;
        tuning.m_maxSuspensionTravelCm = 30;
        tuning.m_frictionSlip = 1.5f;
        vehicle = std::make_unique<btRaycastVehicle>(tuning, &chassis, &caster);
        vehicle->setCoordinateSystem(2, 1, 0);
        for (int i = 0; i < 4; ++i) {
            vehicle->addWheel({i < 2 ? 0.9f : -0.9f, -0.2f, i % 2 == 0 ? 0.6f : -0.6f}, {0, -1, 0},
                              {0, 0, 1}, kRestM, kRadiusM, tuning, i < 2);
        }
        scene.world->addVehicle(vehicle.get());
    }
    ~Car() { scene.world->removeVehicle(vehicle.get()); }

    void drive(double force_n) {
        for (int i = 0; i < 4; ++i) vehicle->applyEngineForce(btScalar(force_n / 4), i);
    }
    void brake(double impulse_n_s) {
        for (int i = 0; i < 4; ++i) vehicle->setBrake(btScalar(impulse_n_s), i);
    }
    double suspension_n() const {
        double sum = 0;
        for (int i = 0; i < 4; ++i) {
            sum += static_cast<double>(vehicle->getWheelInfo(i).m_wheelsSuspensionForce);
        }
        return sum;
    }
    double wheel_height_m(int i) const {
        vehicle->updateWheelTransform(i, false);
        return static_cast<double>(vehicle->getWheelTransformWS(i).getOrigin().y());
    }
    double x() const { return static_cast<double>(chassis.getWorldTransform().getOrigin().x()); }
    double speed() const { return static_cast<double>(chassis.getLinearVelocity().x()); }
};

/// Over a car's wheels.
inline double sum_of(const SoilRaycaster& caster, double SoilWheelReport::*field) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += caster.wheel_report(i).*field;
    return sum;
}

}  // namespace bsoil::bullet
