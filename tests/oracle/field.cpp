#include "oracle/field.h"

#include <algorithm>
#include <numeric>

namespace oracle {

double Voxel::total_mass() const { return std::accumulate(mass.begin(), mass.end(), 0.0); }

int Voxel::main_material() const {
    return static_cast<int>(std::max_element(mass.begin(), mass.end()) - mass.begin());
}

Vec3 Body::velocity_at(int x, int y, int z) const {
    const Vec3 arm = Vec3{x + 0.5, y + 0.5, z + 0.5} - center;
    return velocity + cross(angular_velocity, arm);
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
    from.momentum += -share * from_before.momentum;
    to.momentum += share * from_before.momentum;
    for (size_t m = 0; m < from.mass.size(); ++m) {
        from.mass[m] -= share * from_before.mass[m];
        to.mass[m] += share * from_before.mass[m];
    }
}

double swelling(const Model& model, const Voxel& voxel) {
    const double loose = model.loose_volume[static_cast<size_t>(voxel.main_material())];
    return std::max(0.0, voxel.total_mass() * loose - voxel.soil);
}

}  // namespace oracle
