/// VehicleWheels: the wheels of one btRaycastVehicle on soil.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <limits>
#include <memory>
#include <vector>

#include "bsoil/bullet/soil_raycaster.h"
#include "bsoil/contact/wheel_solver.h"
#include "soil_vehicles.h"

namespace bsoil::bullet {

/// What a wheel remembers from one substep to the next.
struct WheelMemory {
    SoilWheelDef def;
    double radius_m = 0;
    int id = -1;                ///< SoilBody::id
    bool is_placed = false;     ///< it has been cast before: what follows is valid
    bool has_met_soil = false;  ///< the soil has seen it where it is
    double length_m = 0;        ///< of the strut
    double rise_m_s = 0, spin_rad_s = 0;
    BodyMotion motion;
    // The soil's side.
    bool was_cast = false;  ///< since the soil's last step
    bool was_in_grid = false;
    Vec3 contact_center_m;  ///< where it was when its patches were found
    // Of the last substep; a chassis that sleeps keeps them.
    bool is_on_soil = false;
    WheelForces forces;
    double strut_most_n = kNoLimitN;  ///< that the strut can give the chassis
    SoilWheelReport report;

    static constexpr double kNoLimitN = std::numeric_limits<btScalar>::max();
};

/// What all wheels of one vehicle remember.
struct VehicleMemory {
    std::vector<WheelMemory> wheels;
    /// Of the soil on all wheels in the last substep: across their struts, and along them.
    Vec3 across_struts_n;
    double normal_n = 0;
};

/// Answers the vehicle's rays and acts for it on chassis and soil. The vehicle is followed only
/// from its own ray to the end of that substep's actions.
class VehicleWheels {
  public:
    explicit VehicleWheels(const std::shared_ptr<SoilVehicles>& soil);
    ~VehicleWheels();
    VehicleWheels(const VehicleWheels&) = delete;
    VehicleWheels& operator=(const VehicleWheels&) = delete;

    Status attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> defs);
    void detach();
    SoilWheelReport report(int wheel) const;
    void* cast(const btVector3& from, const btVector3& to,
               btVehicleRaycaster::btVehicleRaycasterResult& result);

    /// The vehicle's action is through: forces across the strut reach the chassis, and the vehicle
    /// gets back what it was deprived of.
    void close_substep();
    /// Between substeps. A memory that is put back is that of as many wheels, of the same defs.
    bool is_attached() const { return !wheels_.empty(); }
    VehicleMemory memory() const;
    void set_memory(const VehicleMemory& memory);
    /// Before and after the soil's step.
    void show(BodyCollector& collector);
    void take_contacts();

  private:
    /// Fields of a btWheelInfo that are the host's and are taken for a substep.
    struct Lent {
        btScalar engine_force = 0, brake = 0, friction_slip = 0, force_most = 0;
        btScalar force_most_given = 0;
    };
    struct Wheel : WheelMemory {
        std::shared_ptr<const std::vector<ConvexShape>> shapes;
        bool was_shown = false;  ///< to the soil, in its last step
        std::vector<double> patch_normal_n;
        // From the ray to close_substep.
        bool is_pending = false;
        Vec3 up, forward, axle, contact_point_m;
        double substep_s = 0;
        btScalar rotation_before = 0;
        Lent lent;
    };

    int find(const btVector3& from, const btVector3& to) const;
    WheelState state_of(const Wheel& wheel, const btWheelInfo& info, double substep_s) const;
    void put_down(Wheel& wheel, const btWheelInfo& info) const;
    double touching_length_m(const Wheel& wheel, const btWheelInfo& info) const;
    void hold(Wheel& wheel, const btWheelInfo& info, double substep_s) const;
    void wake_if_weak(const Wheel& wheel) const;
    void solve(Wheel& wheel, const btWheelInfo& info, double substep_s);
    void place(Wheel& wheel, const btVector3& from, double length_m, double substep_s);
    void stand_on_rigid(Wheel& wheel, const btWheelInfo& info, double length_m, double substep_s);
    void lend(Wheel& wheel, btWheelInfo& info);
    void give_back(Wheel& wheel, btWheelInfo& info);
    /// Its share of the last substep's force across the struts.
    Vec3 share_of_last_n(const Wheel& wheel) const;
    void push_chassis(const Wheel& wheel, const btWheelInfo& info);

    std::weak_ptr<SoilVehicles> soil_;
    btDiscreteDynamicsWorld* world_;
    btRigidBody ground_;  ///< what a ray on soil has hit: a vehicle may take it for a body
    btRaycastVehicle* vehicle_ = nullptr;
    std::vector<Wheel> wheels_;
    Vec3 across_struts_n_;  ///< as in VehicleMemory
    double normal_n_ = 0;
};

}  // namespace bsoil::bullet
