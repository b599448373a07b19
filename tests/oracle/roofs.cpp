#include "oracle/roofs.h"

#include <optional>

namespace oracle {
namespace {

bool is_rock(const Model& model, const Voxel& voxel) {
    return voxel.terrain >= model.solid_coverage;
}

bool is_full(const Model& model, const Voxel& voxel) {
    return voxel.terrain + voxel.soil >= 1 - model.support_slack;
}

bool is_whole(const Model& model, const Voxel& voxel) {
    return is_full(model, voxel) && is_bonded(model, voxel);
}

bool stands(const Model& model, const Field& field, int x, int y, int z) {
    for (; z >= 0 && !is_rock(model, field.at(x, y, z)); --z) {
        const Voxel& voxel = field.at(x, y, z);
        if (voxel.bodies > 0 || !is_full(model, voxel)) return false;
    }
    return true;
}

/// The voxels of a roof on one side of one of them.
struct RoofSide {
    int count = 0;
    double strength = 0;  ///< sum of c / gamma by the share never moved [voxels]
};

double strength_of(const Model& model, const Voxel& voxel) {
    return voxel.mean(model.cohesion_height) * std::min(1.0, voxel.bond / voxel.soil);
}

std::optional<RoofSide> roof_side(const Model& model, const Field& field, int x, int y, int z,
                                  int dx, int dy) {
    RoofSide out;
    for (; out.count < model.roof_reach; ++out.count) {
        x += dx;
        y += dy;
        if (!field.inside(x, y, z)) return std::nullopt;
        const Voxel& voxel = field.at(x, y, z);
        if (is_rock(model, voxel)) return out;
        if (!is_whole(model, voxel)) return std::nullopt;
        if (stands(model, field, x, y, z)) return out;
        out.strength += strength_of(model, voxel);
    }
    return std::nullopt;
}

}  // namespace

bool is_held_roof(const Model& model, const Field& field, int x, int y, int z, double strength) {
    const Voxel& voxel = field.at(x, y, z);
    if (!is_whole(model, voxel)) return false;
    double whole = 0, all = 0;
    for (int above = z; above < field.nz && field.at(x, y, above).soil > 0; ++above) {
        whole += std::min(field.at(x, y, above).bond, field.at(x, y, above).soil);
        all += field.at(x, y, above).soil;
    }
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
        const auto ahead = roof_side(model, field, x, y, z, dx, dy);
        const auto behind = roof_side(model, field, x, y, z, -dx, -dy);
        if (!ahead || !behind) continue;
        const int count = ahead->count + behind->count + 1;
        const double mean =
            (ahead->strength + behind->strength + strength_of(model, voxel)) / count;
        const double span = count * std::hypot(dx, dy);
        if (span <= 2 * strength * mean * whole / all) return true;
    }
    return false;
}

}  // namespace oracle
