#include "bsoil/bullet/soil_raycaster.h"

#include <string>
#include <vector>

#include "check_surface.h"
#include "vehicle_wheels.h"

namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

Status SoilWheelDef::validate() const {
    const auto check = [](const char* field, double value, double least, double most) -> Status {
        if (value >= least && value <= most) return Done{};
        return Error{std::string("SoilWheelDef::") + field + " is " + std::to_string(value) +
                     ", must be " + std::to_string(least) + ".." + std::to_string(most)};
    };
    if (Status s = check("width_m", width_m, 0.01, 10); !s) return s;
    if (Status s = check("mass_kg", mass_kg, 0.1, 1e5); !s) return s;
    if (Status s = check("rim_speed_max_m_s", rim_speed_max_m_s, 0.1, 1000); !s) return s;
    return check_surface(surface);
}

struct SoilRaycaster::Impl {
    explicit Impl(const std::shared_ptr<SoilVehicles>& soil) : wheels(soil) {}
    VehicleWheels wheels;
};

SoilRaycaster::SoilRaycaster(SoilAction& soil) : impl_(std::make_unique<Impl>(soil.vehicles())) {}

SoilRaycaster::~SoilRaycaster() = default;

Status SoilRaycaster::attach(btRaycastVehicle& vehicle, const SoilWheelDef& wheel) {
    const std::vector<SoilWheelDef> wheels(static_cast<size_t>(vehicle.getNumWheels()), wheel);
    return impl_->wheels.attach(vehicle, wheels);
}

Status SoilRaycaster::attach(btRaycastVehicle& vehicle, std::span<const SoilWheelDef> wheels) {
    return impl_->wheels.attach(vehicle, wheels);
}

void SoilRaycaster::detach() { impl_->wheels.detach(); }

SoilWheelReport SoilRaycaster::wheel_report(int wheel) const { return impl_->wheels.report(wheel); }

void* SoilRaycaster::castRay(const btVector3& from, const btVector3& to,
                             btVehicleRaycasterResult& result) {
    return impl_->wheels.cast(from, to, result);
}

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
