#include "oracle/field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace oracle {

double chance(int x, int y, int z, uint32_t pass) {
    uint32_t bits = static_cast<uint32_t>(x) * 73856093u ^ static_cast<uint32_t>(y) * 19349663u ^
                    static_cast<uint32_t>(z) * 83492791u ^ pass * 2654435761u;
    bits = (bits ^ bits >> 15) * 2246822519u;
    return (bits >> 13 & 0xffff) / 65536.0;
}

double Voxel::total_mass() const { return std::accumulate(mass.begin(), mass.end(), 0.0); }

int Voxel::main_material() const {
    return static_cast<int>(std::max_element(mass.begin(), mass.end()) - mass.begin());
}

bool Voxel::is_mixed() const {
    return std::count_if(mass.begin(), mass.end(), [](double m) { return m > 0; }) > 1;
}

double Voxel::mean(const std::vector<double>& of_materials) const {
    const double total = total_mass();
    double sum = 0;
    for (size_t m = 0; m < of_materials.size(); ++m) sum += mass[m] * of_materials[m];
    return total > 0 ? sum / total : of_materials.front();
}

Vec3 Body::velocity_at(int x, int y, int z) const {
    const Vec3 arm = Vec3{x + 0.5, y + 0.5, z + 0.5} - center;
    return velocity + cross(angular_velocity, arm);
}

bool is_bonded(const Model& model, const Voxel& voxel) {
    return voxel.soil > model.crumb && 2 * voxel.bond >= voxel.soil;
}

double excess(const Model& model, const Voxel& voxel) {
    if (voxel.bodies >= model.solid_coverage) {
        return std::clamp(voxel.soil + voxel.psi() - 1, 0.0, voxel.soil);
    }
    const double over =
        voxel.soil + voxel.psi() - 1 - (voxel.bodies > 0 ? model.elastic_excess : 0);
    return over > model.excess_tolerance ? std::min(voxel.soil, over) : 0;
}

void move_share(const Voxel& from_before, Voxel& from, Voxel& to, double share) {
    from.soil -= share * from_before.soil;
    from.bond -= share * from_before.bond;
    to.soil += share * from_before.soil;
    from.water -= share * from_before.water;
    to.water += share * from_before.water;
    from.momentum += -share * from_before.momentum;
    to.momentum += share * from_before.momentum;
    for (size_t m = 0; m < from.mass.size(); ++m) {
        from.mass[m] -= share * from_before.mass[m];
        to.mass[m] += share * from_before.mass[m];
    }
}

VolumeRange volume_range(const Model& model, const Voxel& voxel) {
    std::vector<double> loose = model.loose_volume, compacted = model.compacted_volume;
    bool changes = false;
    for (size_t m = 0; m < loose.size(); ++m) {
        changes = changes || (loose[m] > 0 && voxel.mass[m] > 0);
        if (loose[m] == 0) loose[m] = compacted[m] = model.placed_volume[m];
    }
    return changes ? VolumeRange{voxel.mean(loose), voxel.mean(compacted)} : VolumeRange{};
}

double swelling(const Model& model, const Voxel& voxel) {
    return std::max(0.0, voxel.total_mass() * volume_range(model, voxel).loose - voxel.soil);
}

double dilation(const Model& model, const Voxel& voxel) {
    if (model.critical_density.empty()) return swelling(model, voxel);
    const VolumeRange range = volume_range(model, voxel);
    const double volume =
        std::lerp(range.loose, range.compacted, voxel.mean(model.critical_density));
    return std::max(0.0, voxel.total_mass() * volume - voxel.soil);
}

}  // namespace oracle
