/// A [[raycast_vehicle]] of a scene, with soil and without.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <memory>
#include <optional>
#include <vector>

#include "bsoil/bullet/soil_raycaster.h"
#include "scene/scene.h"
#include "world/bullet_scene.h"
#include "world/motion.h"

namespace bsoil::scene {

/// What a driver does.
struct DriveCommand {
    double throttle = 0, steering = 0;  ///< -1..1; steering to the left
    double brake = 0;                   ///< 0..1
    bool operator==(const DriveCommand&) const = default;
};

class RaycastVehicle {
  public:
    /// item and scene must outlive it, and so must the soil. Its actions are the world's from now
    /// on. The error says what is wrong with the wheels.
    static Result<std::unique_ptr<RaycastVehicle>> create(const RaycastVehicleItem& item,
                                                          BulletScene& scene,
                                                          bullet::SoilAction* soil);
    ~RaycastVehicle();
    RaycastVehicle(const RaycastVehicle&) = delete;
    RaycastVehicle& operator=(const RaycastVehicle&) = delete;

    const std::string& name() const { return item_.name; }
    /// From now on this drives it, whatever its keys say; none: they do again.
    void set_drive(std::optional<DriveCommand> command) { command_ = command; }
    /// Before a substep that begins at this time.
    void begin_substep(double time_s, double substep_s);
    /// After it: the wheels' bodies go where the wheels are.
    void place_wheels();

    /// The wheel that this body of the scene shows; none: none of its wheels.
    std::optional<int> wheel_of(const btCollisionObject* body) const;
    /// What the soil did to a wheel in the last substep: its force in the world's axes, its
    /// sinkage. The rest is 0: a raycast wheel reports no torque, and carries no soil.
    bullet::BodyReport wheel_report(int wheel) const;

  private:
    RaycastVehicle(const RaycastVehicleItem& item, BulletScene& scene);
    DriveCommand drive_at(double time_s) const;

    const RaycastVehicleItem& item_;
    btDiscreteDynamicsWorld& world_;
    std::optional<DriveCommand> command_;
    std::optional<Curve> throttle_, steering_, brake_;  ///< of its keys; none: it has none
    std::vector<btRigidBody*> wheels_;                  ///< of the scene
    std::unique_ptr<btVehicleRaycaster> raycaster_;
    const bullet::SoilRaycaster* on_soil_ = nullptr;  ///< the same one, where there is soil
    std::unique_ptr<btRaycastVehicle> vehicle_;
};

}  // namespace bsoil::scene
