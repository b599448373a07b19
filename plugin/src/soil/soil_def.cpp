#include "bsoil/soil_def.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "bsoil/limits.h"
#include "soil/def_fields.h"

namespace bsoil {

std::vector<MaterialDef> SoilDef::material_list() const {
    return materials.empty() ? std::vector<MaterialDef>{material} : materials;
}

Status SoilDef::validate() const {
    const double up_m = up == UpAxis::y ? size_m.y : size_m.z;
    const double side_a = size_m.x, side_b = up == UpAxis::y ? size_m.z : size_m.y;
    if (Status status = check_numbers(*this); !status) return status;
    for (const Status& status :
         {check_range("size_m across / voxel_m", std::ceil(side_a / voxel_m - 1e-9), 1,
                      limits::kGridSideMax),
          check_range("size_m along / voxel_m", std::ceil(side_b / voxel_m - 1e-9), 1,
                      limits::kGridSideMax),
          check_range("size_m up / voxel_m", std::ceil(up_m / voxel_m - 1e-9), 1,
                      limits::kGridHeightMax)}) {
        if (!status) return status;
    }
    const auto across = static_cast<int64_t>(std::ceil(side_a / voxel_m - 1e-9)),
               along = static_cast<int64_t>(std::ceil(side_b / voxel_m - 1e-9));
    if (across * along > limits::kGridColumnsMax) {
        return Error{fmt::format(
            "size_m / voxel_m is {} x {} columns, {:.3g} together; must be at most {:.3g}: take "
            "larger voxels or a smaller box",
            across, along, static_cast<double>(across * along),
            static_cast<double>(limits::kGridColumnsMax))};
    }
    const int along_up = up == UpAxis::y ? kOpenLowY | kOpenHighY : kOpenLowZ | kOpenHighZ;
    if ((open_sides & along_up) != 0) {
        return Error{
            fmt::format("open_sides is {}, which opens the grid's bottom or top: must be "
                        "made of the bits of its four sides",
                        open_sides)};
    }
    const std::vector<MaterialDef> list = material_list();
    if (list.size() > limits::kMaterialCapacity) {
        return Error{fmt::format("materials has {} entries, at most {} are possible", list.size(),
                                 limits::kMaterialCapacity)};
    }
    if (Status status = contact_law.validate(static_cast<int>(list.size())); !status) return status;
    std::set<std::string> names;
    for (const MaterialDef& entry : list) {
        if (Status status = entry.validate(); !status) return status;
        if (!names.insert(entry.name).second) {
            return Error{"materials has two entries named '" + entry.name + "'; rename one"};
        }
    }
    return Done{};
}

}  // namespace bsoil
