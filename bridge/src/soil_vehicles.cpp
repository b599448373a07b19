#include "soil_vehicles.h"

namespace bsoil::bullet {

class SoilVehicles::Closer final : public btActionInterface {
  public:
    explicit Closer(SoilVehicles& vehicles) : vehicles_(vehicles) {}
    void updateAction(btCollisionWorld*, btScalar) override {
        has_run = true;
        for (VehicleOnSoil* wheels : vehicles_.wheels_) wheels->close_substep();
    }
    void debugDraw(btIDebugDraw*) override {}
    bool has_run = false;

  private:
    SoilVehicles& vehicles_;
};

SoilVehicles::SoilVehicles(btDiscreteDynamicsWorld*& world, BodyCollector& collector,
                           ContactCoupling& coupling, const std::unique_ptr<SoilGround>& ground,
                           double voxel_m,
                           std::function<std::optional<SurfacePoint>(Vec3)> surface_at)
    : world_(world),
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
    closed_ = false;
    for (const auto& closer : closers_) closer->has_run = false;
}

void SoilVehicles::close_substep() {
    closed_ = true;
    for (VehicleOnSoil* wheels : wheels_) wheels->close_substep();
}

// Bullet goes through its actions by index, so one that is added meanwhile still runs. Closers stay
// where they are: taking one out would reorder the host's actions.
void SoilVehicles::expect_close() {
    if (!closed_ || !world_) return;
    if (!closers_.empty() && !closers_.back()->has_run) return;
    // More than one for each vehicle are not needed, unless it is not an action of this world.
    if (closers_.size() >= wheels_.size()) return;
    closers_.push_back(std::make_unique<Closer>(*this));
    world_->addAction(closers_.back().get());
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

void SoilVehicles::leave_world() {
    for (; !closers_.empty(); closers_.pop_back()) world_->removeAction(closers_.back().get());
}

}  // namespace bsoil::bullet
