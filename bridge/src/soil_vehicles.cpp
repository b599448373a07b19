#include "soil_vehicles.h"

#include <utility>

namespace bsoil::bullet {

namespace {

/// The actions of a world in the order in which Bullet calls them, which it shows to worlds alone.
struct WorldActions : btDiscreteDynamicsWorld {
    static btAlignedObjectArray<btActionInterface*>& of(btDiscreteDynamicsWorld& world) {
        return world.*(&WorldActions::m_actions);
    }
};

}  // namespace

class SoilVehicles::Closer final : public btActionInterface {
  public:
    explicit Closer(SoilVehicles& vehicles) : vehicles_(vehicles) {}
    void updateAction(btCollisionWorld*, btScalar) override {
        vehicles_.close_substep();
        vehicles_.is_in_substep_ = false;
    }
    void debugDraw(btIDebugDraw*) override {}

  private:
    SoilVehicles& vehicles_;
};

SoilVehicles::SoilVehicles(std::function<btDiscreteDynamicsWorld*()> world,
                           BodyCollector& collector, ContactCoupling& coupling,
                           const std::unique_ptr<SoilGround>& ground, double voxel_m,
                           std::function<std::optional<SurfacePoint>(Vec3)> surface_at)
    : world_(std::move(world)),
      collector_(collector),
      coupling_(coupling),
      ground_(ground),
      voxel_m_(voxel_m),
      surface_at_(std::move(surface_at)) {}

SoilVehicles::~SoilVehicles() = default;

void SoilVehicles::remove(VehicleOnSoil& wheels) { std::erase(wheels_, &wheels); }

std::vector<VehicleOnSoil*> SoilVehicles::attached() const {
    std::vector<VehicleOnSoil*> out;
    for (VehicleOnSoil* wheels : wheels_) {
        if (wheels->is_attached()) out.push_back(wheels);
    }
    return out;
}

void SoilVehicles::open_substep() {
    close_substep();  // an action that took another out has put the closer in a place passed
    is_in_substep_ = !wheels_.empty();
    if (is_in_substep_) put_closer_last();
}

void SoilVehicles::close_substep() {
    for (VehicleOnSoil* wheels : wheels_) wheels->close_substep();
}

/// Vehicles may have been added behind the closer. And where an action is taken out Bullet puts the
/// last one in its place. The host's actions keep their order.
void SoilVehicles::put_closer_last() {
    if (!closer_) {
        closer_ = std::make_unique<Closer>(*this);
        world()->addAction(closer_.get());
    }
    btAlignedObjectArray<btActionInterface*>& actions = WorldActions::of(*world());
    for (int i = actions.findLinearSearch(closer_.get()); i + 1 < actions.size(); ++i) {
        actions.swap(i, i + 1);
    }
}

void SoilVehicles::show_wheels() {
    for (VehicleOnSoil* wheels : wheels_) wheels->show(collector_);
}

void SoilVehicles::take_contacts(bool fresh) {
    for (VehicleOnSoil* wheels : wheels_) wheels->take_contacts(fresh);
}

void SoilVehicles::keep_stepped() {
    for (VehicleOnSoil* wheels : wheels_) wheels->keep_stepped();
}

void SoilVehicles::meet_anew() {
    for (VehicleOnSoil* wheels : wheels_) wheels->meet_anew();
}

bool SoilVehicles::is_action(const btActionInterface* action) const {
    btDiscreteDynamicsWorld* there = world();
    if (!there) return false;
    const btAlignedObjectArray<btActionInterface*>& actions = WorldActions::of(*there);
    for (int i = 0; i < actions.size(); ++i) {
        if (actions[i] == action) return true;
    }
    return false;
}

void SoilVehicles::leave_world() {
    close_substep();
    is_in_substep_ = false;
    if (closer_) world()->removeAction(closer_.get());
    closer_.reset();
}

}  // namespace bsoil::bullet
