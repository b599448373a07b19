/// SoilRaycaster: lets a btRaycastVehicle drive on soil. See docs/vehicles.md.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <memory>
#include <span>

#include "bsoil/bullet/precision.h"
#include "bsoil/bullet/soil_action.h"

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

/// A wheel as the soil meets it: a cylinder of the radius that btRaycastVehicle::addWheel was
/// given.
struct SoilWheelDef {
    double width_m = 0.3;  ///< 0.01..10
    /// Of wheel and tyre, 0.1..1e5. Only for its motion along the strut and its spin, as a disc's:
    /// its weight is in the chassis.
    double mass_kg = 20;
    double rim_speed_max_m_s = 20;  ///< that the engine drives the rim to, 0.1..1000
    SurfaceFriction surface{};      ///< between wheel and soil
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// What soil and wheel did to each other in the last substep.
struct SoilWheelReport {
    bool is_on_soil =
        false;  ///< the soil carries it; else it stands on something rigid or on nothing
    double normal_force_n = 0;  ///< of the soil on the wheel, along the strut
    double traction_n = 0;      ///< forward: thrust less motion resistance
    double side_force_n = 0;    ///< along the axle
    double sinkage_m = 0;       ///< of the deepest contact below the local surface
    double spin_rad_s = 0;      ///< positive: rolls forward
    /// Of the rim against the ground: 1 - v / (R spin) when driven, R spin / v - 1 when braked;
    /// -1..1, positive: spins
    double slip = 0;
};

/// A btVehicleRaycaster that finds the height at which the soil carries each wheel. Hand it to the
/// constructor of the btRaycastVehicle, add wheels as usual, then attach the vehicle:
///
///     SoilRaycaster raycaster(*soil);
///     btRaycastVehicle vehicle(tuning, &chassis, &raycaster);
///     world.addVehicle(&vehicle);
///     vehicle.addWheel(...);  // as usual
///     raycaster.attach(vehicle, SoilWheelDef{.width_m = 0.25});
///
/// Engine force, brake, steering and the tuning of the suspension stay the host's; friction is the
/// soil's. Where something rigid lies above the soil, and before attach, it answers as
/// btDefaultVehicleRaycaster does (which does not see the soil's surface).
///
/// The vehicle must be an action of the soil's world, in any order; one vehicle for each raycaster.
/// What the wheels remember is in the soil's snapshots; attach before loading one.
/// Raycaster, vehicle and SoilAction may be destroyed in any order between steps. Cost: some 0.1 ms
/// a wheel and substep.
class SoilRaycaster final : public btVehicleRaycaster {
  public:
    /// Rays meet this soil and its world; vehicles are attach()ed to it.
    explicit SoilRaycaster(SoilAction& soil);
    ~SoilRaycaster() override;
    SoilRaycaster(const SoilRaycaster&) = delete;
    SoilRaycaster& operator=(const SoilRaycaster&) = delete;

    /// From now on the soil sees the vehicle's wheels, all alike. Error: a field out of range, a
    /// wheel whose radius is not between 1 mm and 100 m, a vehicle without wheels.
    Status attach(btRaycastVehicle& vehicle, const SoilWheelDef& wheel);
    /// One def for each wheel, in the vehicle's order.
    Status attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> wheels);
    /// The soil forgets the wheels.
    void detach();

    /// All zero for an index out of range.
    SoilWheelReport wheel_report(int wheel) const;

    /// Called by btRaycastVehicle.
    void* castRay(const btVector3& from, const btVector3& to,
                  btVehicleRaycasterResult& result) override;

    struct Impl;

  private:
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
#pragma GCC visibility pop
