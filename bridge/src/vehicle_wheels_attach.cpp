// A vehicle comes to its wheels on soil, and goes.
#include <string>
#include <utility>

#include "vehicle_wheels.h"

namespace bsoil::bullet {

VehicleWheels::VehicleWheels(const std::shared_ptr<SoilVehicles>& soil)
    : soil_(soil), world_(soil->world()), ground_(0, nullptr, nullptr) {
    soil->add(*this);
}

VehicleWheels::~VehicleWheels() {
    forget();  // the vehicle may be gone
    if (const auto vehicles = soil_.lock()) vehicles->remove(*this);
}

Status VehicleWheels::attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> defs) {
    const auto vehicles = soil_.lock();
    if (!vehicles) return Error{"SoilRaycaster::attach: the SoilAction is gone; make both anew"};
    const int count = vehicle.getNumWheels();
    if (count == 0) {
        return Error{"SoilRaycaster::attach: the vehicle has no wheels yet; add them first"};
    }
    if (static_cast<int>(defs.size()) != count) {
        return Error{"SoilRaycaster::attach: " + std::to_string(defs.size()) +
                     " wheels are described, the vehicle has " + std::to_string(count) +
                     "; give one SoilWheelDef for each"};
    }
    if (!vehicles->is_action(&vehicle)) {
        return Error{
            "SoilRaycaster::attach: the vehicle is no action of the soil's world: addVehicle() it "
            "first, and let the world update it"};
    }
    if (vehicle_ && vehicle_ != &vehicle && !has_left()) {
        return Error{
            "SoilRaycaster::attach: another vehicle is attached, and a raycaster is for one: make "
            "one for each vehicle, or detach() first"};
    }
    if (!asks_here(vehicle)) {
        return Error{
            "SoilRaycaster::attach: the vehicle asks another raycaster: hand this one to its "
            "constructor"};
    }
    std::vector<Wheel> wheels;
    for (int i = 0; i < count; ++i) {
        const std::string where = "wheel " + std::to_string(i) + ": ";
        if (Status s = defs[i].validate(); !s) return Error{where + s.error()};
        const auto radius_m = static_cast<double>(vehicle.getWheelInfo(i).m_wheelsRadius);
        if (!(radius_m >= 1e-3 && radius_m <= 100)) {
            return Error{where + "m_wheelsRadius is " + std::to_string(radius_m) +
                         ", must be 0.001..100"};
        }
        ConvexShape shape;
        shape.kind = ConvexShape::Kind::cylinder;
        shape.radius_m = radius_m;
        shape.half_height_m = defs[i].width_m / 2;
        Wheel& wheel = wheels.emplace_back();
        wheel.def = defs[i];
        wheel.radius_m = radius_m;
        wheel.shapes = std::make_shared<const std::vector<ConvexShape>>(1, shape);
    }
    detach();
    for (Wheel& wheel : wheels) {
        wheel.id = vehicles->collector().take_id();
        if (wheel.id >= 0) continue;
        for (const Wheel& other : wheels) {
            if (other.id >= 0) vehicles->collector().give_back_id(other.id);
        }
        return Error{
            "SoilRaycaster::attach: more bodies than there are ids, 65535; let the soil ignore "
            "those that need none"};
    }
    wheels_ = std::move(wheels);
    vehicle_ = &vehicle;
    return Done{};
}

/// Bullet does not tell which raycaster a vehicle has, so it is made to ask.
bool VehicleWheels::asks_here(btRaycastVehicle& vehicle) {
    btWheelInfo wheel = vehicle.getWheelInfo(0);  // the answer is written to it
    was_asked_ = false;
    vehicle.rayCast(wheel);
    return *std::exchange(was_asked_, std::nullopt);
}

/// Whether the vehicle is no action of the world any more: it may have been deleted.
bool VehicleWheels::has_left() const {
    const auto vehicles = soil_.lock();
    return vehicle_ && !(vehicles && vehicles->is_action(vehicle_));
}

void VehicleWheels::meet_anew() {
    BodyCollector& collector = soil_.lock()->collector();
    for (Wheel& wheel : wheels_) {
        collector.give_back_id(wheel.id);
        wheel.id = collector.take_id();
        wheel.was_in_grid = false;
    }
}

void VehicleWheels::detach() {
    for (size_t i = 0; i < wheels_.size() && !has_left(); ++i) {
        if (!wheels_[i].is_pending || !wheels_[i].is_on_soil) continue;
        give_back(wheels_[i], vehicle_->getWheelInfo(static_cast<int>(i)));
    }
    forget();
}

void VehicleWheels::forget() {
    if (const auto vehicles = soil_.lock()) {
        for (const Wheel& wheel : wheels_) vehicles->collector().give_back_id(wheel.id);
    }
    wheels_.clear();
    vehicle_ = nullptr;
}

}  // namespace bsoil::bullet
