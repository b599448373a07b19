// What a vehicle's wheels remember, for snapshots.
#include "vehicle_wheels.h"

namespace bsoil::bullet {

VehicleMemory VehicleWheels::memory() const {
    return {{wheels_.begin(), wheels_.end()}, across_struts_n_, normal_n_};
}

void VehicleWheels::set_memory(const VehicleMemory& memory) {
    for (size_t i = 0; i < wheels_.size(); ++i) {
        static_cast<WheelMemory&>(wheels_[i]) = memory.wheels[i];
        wheels_[i].is_pending = false;
    }
    across_struts_n_ = memory.across_struts_n;
    normal_n_ = memory.normal_n;
}

}  // namespace bsoil::bullet
