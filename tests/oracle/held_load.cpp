#include "oracle/held_load.h"

#include <limits>
#include <optional>

namespace oracle {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

/// How fast soil may be along a row; nothing where the row is open.
std::optional<double> most_along(const Model& model, const Field& field,
                                 std::span<const Body> bodies, int carrier, int x, int y, int z,
                                 int dx, int dy) {
    for (int n = 1; n <= model.held_reach; ++n) {
        const int nx = x + n * dx, ny = y + n * dy;
        if (!field.inside(nx, ny, z)) return 0;
        const Voxel& voxel = field.at(nx, ny, z);
        if (field.closed(model, nx, ny, z)) {
            if (voxel.bodies <= voxel.terrain || voxel.owner < 0) return 0;
            if (voxel.owner == carrier) return kFree;
            const Vec3 wall = bodies[static_cast<size_t>(voxel.owner)].velocity_at(nx, ny, z);
            return std::max(0.0, wall.x * dx + wall.y * dy);
        }
        if (voxel.soil + voxel.psi() < 1 - model.push_room ||
            voxel.support.kind != Support::Kind::body) {
            return {};
        }
    }
    return {};
}

double left_of(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
               int z, bool along_x, double speed) {
    if (std::abs(speed) <= model.still_speed) return speed;
    const int sign = speed > 0 ? 1 : -1, carrier = field.at(x, y, z).support.body;
    for (int level = z; level >= 0; --level) {
        const Voxel& voxel = field.at(x, y, level);
        const bool is_load =
            voxel.support.kind == Support::Kind::body && voxel.support.body == carrier;
        if (level < z && (!is_load || field.closed(model, x, y, level))) break;
        const auto most = most_along(model, field, bodies, carrier, x, y, level, along_x ? sign : 0,
                                     along_x ? 0 : sign);
        if (most) return sign * std::min(std::abs(speed), *most);
    }
    return speed;
}

}  // namespace

Vec3 held_back(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
               int z, Vec3 velocity) {
    return {left_of(model, field, bodies, x, y, z, true, velocity.x),
            left_of(model, field, bodies, x, y, z, false, velocity.y), velocity.z};
}

}  // namespace oracle
