/// VehicleWheels: the wheels of one btRaycastVehicle on soil.
#pragma once

#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <memory>
#include <optional>
#include <vector>

#include "soil_vehicles.h"

namespace bsoil::bullet {

/// Answers the vehicle's rays and acts for it on chassis and soil. The vehicle is followed only
/// from its own ray to the end of that substep's actions, and while it is one of them.
class VehicleWheels final : public VehicleOnSoil {
  public:
    explicit VehicleWheels(const std::shared_ptr<SoilVehicles>& soil);
    ~VehicleWheels() override;
    VehicleWheels(const VehicleWheels&) = delete;
    VehicleWheels& operator=(const VehicleWheels&) = delete;

    Status attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> defs);
    void detach();
    SoilWheelReport report(int wheel) const {
        const bool is_there = wheel >= 0 && wheel < static_cast<int>(wheels_.size());
        return is_there ? wheels_[wheel].report : SoilWheelReport{};
    }
    void* cast(const btVector3& from, const btVector3& to,
               btVehicleRaycaster::btVehicleRaycasterResult& result);

    void close_substep() override;
    bool is_attached() const override { return !wheels_.empty(); }
    VehicleMemory memory() const override;
    void set_memory(const VehicleMemory& memory) override;
    void show(BodyCollector& collector) override;
    void take_contacts(bool fresh) override;
    void meet_anew() override;
    void keep_stepped() override {
        for (Wheel& wheel : wheels_) wheel.stepped_center_m = wheel.motion.center_of_mass_m;
    }

  private:
    /// Fields of a btWheelInfo that are the host's and are taken for a substep.
    struct Lent {
        btScalar engine_force = 0, brake = 0, friction_slip = 0, force_most = 0;
        btScalar force_most_given = 0;
    };
    struct Wheel : WheelMemory {
        std::shared_ptr<const std::vector<ConvexShape>> shapes;
        bool was_shown = false;  ///< to the soil, in its last step
        Vec3 stepped_center_m;   ///< as the step in progress sees it
        std::vector<double> patch_normal_n;
        // From the ray to close_substep.
        bool is_pending = false;
        Vec3 up, forward, axle, contact_point_m;
        double substep_s = 0;
        btScalar rotation_before = 0;
        Lent lent;
    };

    /// Without a look at the vehicle.
    void forget();
    bool has_left() const;
    bool asks_here(btRaycastVehicle& vehicle);
    int find(const btVector3& from, const btVector3& to) const;
    WheelState state_of(const Wheel& wheel, const btWheelInfo& info, double substep_s) const;
    bool is_put_elsewhere(const Wheel& wheel, const btVector3& from, double substep_s) const;
    void put_down(Wheel& wheel, const btWheelInfo& info) const;
    double touching_length_m(const Wheel& wheel, const btWheelInfo& info) const;
    void hold(Wheel& wheel, const btWheelInfo& info, double substep_s) const;
    void rest(Wheel& wheel) const;
    void solve(Wheel& wheel, const btWheelInfo& info, double substep_s);
    void place(Wheel& wheel, const btVector3& from, double length_m, double substep_s);
    void stand_on_rigid(Wheel& wheel, const btWheelInfo& info, double length_m, double substep_s);
    void lend(Wheel& wheel, btWheelInfo& info);
    static void give_back(const Wheel& wheel, btWheelInfo& info);
    /// Its share of the last substep's force across the struts.
    Vec3 share_of_last_n(const Wheel& wheel) const;
    void push_chassis(const Wheel& wheel, const btWheelInfo& info);

    std::weak_ptr<SoilVehicles> soil_;
    btDiscreteDynamicsWorld* world_;  ///< of the vehicle, which may outlive the soil in it
    btRigidBody ground_;  ///< what a ray on soil has hit: a vehicle may take it for a body
    btRaycastVehicle* vehicle_ = nullptr;
    /// While attach() looks who answers a vehicle's rays: whether this was asked.
    std::optional<bool> was_asked_;
    std::vector<Wheel> wheels_;
    Vec3 across_struts_n_;  ///< as in VehicleMemory
    double normal_n_ = 0;
};

}  // namespace bsoil::bullet
