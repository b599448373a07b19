#include "oracle/arches.h"

#include <limits>

namespace oracle {
namespace {

/// Voxels to soil at rest; 0: none.
int side(const Model& model, const Field& field, int x, int y, int z, int dx, int dy) {
    for (int n = 1; n <= model.arch_reach; ++n) {
        if (!field.inside(x + n * dx, y + n * dy, z)) return 0;
        const Voxel& voxel = field.at(x + n * dx, y + n * dy, z);
        if (voxel.soil < model.arch_least) return 0;
        if (voxel.support.kind == Support::Kind::ground) return n;
    }
    return 0;
}

/// Harmonic mean of the ways to the two sides of an arch, from the voxel's middle, along the axis
/// where it is less; 0: there is no arch.
double way_to_sides(const Model& model, const Field& field, int x, int y, int z) {
    double least = 0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
        const double ahead = side(model, field, x, y, z, dx, dy) - 0.5;
        const double behind = side(model, field, x, y, z, -dx, -dy) - 0.5;
        if (ahead < 0 || behind < 0) continue;
        const double mean = 2 / (1 / ahead + 1 / behind);
        least = least == 0 ? mean : std::min(least, mean);
    }
    return least;
}

}  // namespace

double arch_speed(const Model& model, const Field& field, int x, int y, int z) {
    const double d = way_to_sides(model, field, x, y, z);
    if (field.at(x, y, z).soil < model.arch_least || d == 0) {
        return std::numeric_limits<double>::infinity();
    }
    return std::sqrt(2 * model.gravity * d);
}

bool is_arched(const Model& model, const Field& field, int x, int y, const Span& span) {
    for (int z = static_cast<int>(span.bottom); z < span.top; ++z) {
        if (way_to_sides(model, field, x, y, z) > 0) return true;
    }
    return false;
}

}  // namespace oracle
