/// SoilVehicles: the raycast vehicles that drive on one soil.
#pragma once

#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "body_collector.h"
#include "contact_coupling.h"
#include "soil_ground.h"
#include "wheel_memory.h"

namespace bsoil::bullet {

/// The wheels of one vehicle, as the soil knows them.
class VehicleOnSoil {
  public:
    virtual ~VehicleOnSoil() = default;
    virtual bool is_attached() const = 0;
    /// The vehicle's action is through: forces across the strut reach the chassis, and the vehicle
    /// gets back what it was deprived of. One that has left the world may have been deleted, and is
    /// not looked at.
    virtual void close_substep() = 0;
    /// Before and after the soil's step.
    virtual void show(BodyCollector& collector) = 0;
    /// fresh: of the wheels as they were shown last; else as they were when keep_stepped() was
    /// called.
    virtual void take_contacts(bool fresh) = 0;
    /// The soil's step in progress sees them as they were shown last.
    virtual void keep_stepped() = 0;
    /// The soil takes its wheels for new bodies.
    virtual void meet_anew() = 0;
    /// Between substeps. A memory that is put back is that of as many wheels, of the same defs.
    virtual VehicleMemory memory() const = 0;
    virtual void set_memory(const VehicleMemory& memory) = 0;
};

/// Stands between SoilAction, whose soil sees the wheels, and the wheels, which cast rays from
/// within their vehicles' actions.
class SoilVehicles {
  public:
    /// world: gives null once it is gone. The references must outlive this.
    SoilVehicles(std::function<btDiscreteDynamicsWorld*()> world, BodyCollector& collector,
                 ContactCoupling& coupling, const std::unique_ptr<SoilGround>& ground,
                 double voxel_m, std::function<std::optional<SurfacePoint>(Vec3)> surface_at);
    ~SoilVehicles();
    SoilVehicles(const SoilVehicles&) = delete;
    SoilVehicles& operator=(const SoilVehicles&) = delete;

    void add(VehicleOnSoil& wheels) { wheels_.push_back(&wheels); }
    void remove(VehicleOnSoil& wheels);

    /// Called by SoilAction: at the start of a substep, in its own action, before and after the
    /// soil's step, and when the world goes. close_substep is called once more behind all actions
    /// of the world: vehicles may be added in any order.
    void open_substep();
    void close_substep();
    /// Whether it is a substep whose actions are not through. Only then does the soil answer rays:
    /// between two steps nobody would give back what it takes of a vehicle.
    bool is_in_substep() const { return is_in_substep_; }
    void show_wheels();
    void take_contacts(bool fresh);
    void keep_stepped();
    void leave_world();
    /// The soil was off: what its wheels did meanwhile it has not seen.
    void meet_anew();

    /// Wheels of the vehicles that are attached, in the order their raycasters were made.
    std::vector<VehicleOnSoil*> attached() const;

    /// Null once it is gone.
    btDiscreteDynamicsWorld* world() const { return world_(); }
    /// Whether Bullet calls it; it is not looked at.
    bool is_action(const btActionInterface* action) const;
    BodyCollector& collector() { return collector_; }
    ContactCoupling& coupling() { return coupling_; }
    /// The soil's surface in the world, or null.
    const btCollisionObject* ground() const { return ground_ ? ground_->object() : nullptr; }
    double voxel_m() const { return voxel_m_; }
    std::optional<SurfacePoint> surface_at(Vec3 world_m) const { return surface_at_(world_m); }

  private:
    class Closer;
    void put_closer_last();

    std::function<btDiscreteDynamicsWorld*()> world_;
    BodyCollector& collector_;
    ContactCoupling& coupling_;
    const std::unique_ptr<SoilGround>& ground_;
    double voxel_m_;
    std::function<std::optional<SurfacePoint>(Vec3)> surface_at_;
    std::vector<VehicleOnSoil*> wheels_;
    bool is_in_substep_ = false;
    std::unique_ptr<Closer> closer_;  ///< the last of the world's actions; null: no vehicle yet
};

}  // namespace bsoil::bullet
