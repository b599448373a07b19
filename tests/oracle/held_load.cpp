#include "oracle/held_load.h"

#include <limits>
#include <optional>

namespace oracle {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

/// Where a row ends; nothing where it is open.
struct RowEnd {
    int wall = -1, x = 0, y = 0;
};
std::optional<RowEnd> end_of_row(const Model& model, const Field& field, const RowStart& row) {
    for (int n = 1; n <= model.held_reach; ++n) {
        const int nx = row.x + n * row.dx, ny = row.y + n * row.dy;
        if (!field.inside(nx, ny, row.z)) return RowEnd{-1, nx, ny};
        const Voxel& voxel = field.at(nx, ny, row.z);
        if (field.closed(model, nx, ny, row.z)) {
            return RowEnd{voxel.bodies <= voxel.terrain ? -1 : voxel.owner, nx, ny};
        }
        if (voxel.soil + voxel.psi() < 1 - model.push_room ||
            voxel.support.kind != Support::Kind::body) {
            return {};
        }
    }
    return {};
}

/// How fast soil may be along a row; nothing where the row is open.
std::optional<double> most_along(const Model& model, const Field& field,
                                 std::span<const Body> bodies, int carrier, const RowStart& row) {
    const std::optional<RowEnd> end = end_of_row(model, field, row);
    if (!end) return {};
    if (end->wall == carrier) return kFree;
    if (end->wall < 0) return 0;
    const Vec3 wall = bodies[static_cast<size_t>(end->wall)].velocity_at(end->x, end->y, row.z);
    return std::max(0.0, wall.x * row.dx + wall.y * row.dy);
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
        const auto most = most_along(model, field, bodies, carrier,
                                     {x, y, level, along_x ? sign : 0, along_x ? 0 : sign});
        if (most) return sign * std::min(std::abs(speed), *most);
    }
    return speed;
}

}  // namespace

std::optional<int> wall_of_row(const Model& model, const Field& field, const RowStart& row) {
    const std::optional<RowEnd> end = end_of_row(model, field, row);
    return end ? std::optional(end->wall) : std::nullopt;
}

Vec3 held_back(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
               int z, Vec3 velocity) {
    return {left_of(model, field, bodies, x, y, z, true, velocity.x),
            left_of(model, field, bodies, x, y, z, false, velocity.y), velocity.z};
}

}  // namespace oracle
