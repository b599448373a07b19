/// SoilRaycaster: lets a btRaycastVehicle drive on soil. See docs/vehicles.md.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <memory>
#include <span>

#include "bsoil/bullet/precision.h"
#include "bsoil/bullet/soil_action.h"
#include "bsoil/bullet/soil_wheel.h"

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

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
/// btDefaultVehicleRaycaster does, but past the soil's surface: a vehicle that is not attached
/// falls through.
///
/// The vehicle must be an action of the soil's world, in any order; one vehicle for each raycaster.
/// A host that calls updateVehicle or rayCast itself, between steps, gets what is rigid alone.
/// What the wheels remember is in the soil's snapshots; attach before loading one.
/// Raycaster, vehicle and SoilAction may be destroyed in any order between steps. A vehicle that is
/// taken out of the world is not looked at any more, and may be deleted without detach(); put back,
/// it goes on. Another one may then be attached in its place. Cost: some 0.1 ms a wheel and
/// substep.
class SoilRaycaster final : public btVehicleRaycaster {
  public:
    /// Rays meet this soil and its world; vehicles are attach()ed to it.
    explicit SoilRaycaster(SoilAction& soil);
    ~SoilRaycaster() override;
    SoilRaycaster(const SoilRaycaster&) = delete;
    SoilRaycaster& operator=(const SoilRaycaster&) = delete;

    /// From now on the soil sees the vehicle's wheels, all alike. Error: a field out of range, a
    /// wheel whose radius is not between 1 mm and 100 m, a vehicle without wheels or made with
    /// another raycaster. Error as well: it is no action of the soil's world, or another vehicle is
    /// attached and has not left that world.
    Status attach(btRaycastVehicle& vehicle, const SoilWheelDef& wheel);
    /// One def for each wheel, in the vehicle's order.
    Status attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> wheels);
    /// The soil forgets the wheels. The vehicle may have been deleted, if it has left the world.
    void detach();

    /// Of the last substep in which the wheel was cast. All zero for an index out of range.
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
