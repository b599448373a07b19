#include "oracle/walls.h"

#include <algorithm>
#include <cmath>

namespace oracle {
namespace {

double largest(Vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

bool rock(const Model& model, const Field& field, int x, int y, int z) {
    return !field.inside(x, y, z) || field.at(x, y, z).terrain >= model.solid_coverage;
}

double covered(const Field& field, int x, int y, int z) {
    return std::min(1.0, field.at(x, y, z).bodies);
}

/// Into the body, per two voxels.
Vec3 gradient(const Model& model, const Field& field, int x, int y, int z) {
    const double here = covered(field, x, y, z);
    const auto along = [&](int dx, int dy, int dz) {
        const bool shut[2] = {rock(model, field, x - dx, y - dy, z - dz),
                              rock(model, field, x + dx, y + dy, z + dz)};
        double side[2] = {shut[0] ? here : covered(field, x - dx, y - dy, z - dz),
                          shut[1] ? here : covered(field, x + dx, y + dy, z + dz)};
        if (shut[0] != shut[1]) {  // rock is covered at least as much as both
            const int wall = shut[0] ? 0 : 1;
            side[wall] = std::max(here, side[1 - wall]);
        }
        return side[1] - side[0];
    };
    return {along(1, 0, 0), along(0, 1, 0), along(0, 0, 1)};
}

}  // namespace

bool is_caught(const Model& model, const Voxel& voxel) {
    return voxel.bodies >= model.solid_coverage;
}

WayOut find_way_out(const Model& model, const Field& field, std::span<const Body> bodies, int x,
                    int y, int z) {
    const Vec3 now = gradient(model, field, x, y, z);
    Vec3 before = now;
    const int owner = field.at(x, y, z).owner;
    if (owner >= 0 && bodies[static_cast<size_t>(owner)].moves) {
        const Vec3 speed = bodies[static_cast<size_t>(owner)].velocity_at(x, y, z);
        const auto at_most_one = [](double v) { return std::clamp(v, -1.0, 1.0); };
        const Vec3 move{at_most_one(speed.x), at_most_one(speed.y), at_most_one(speed.z)};
        const auto side = [](double v) { return v > 0 ? 1 : v < 0 ? -1 : 0; };
        const Vec3 free{rock(model, field, x + side(move.x), y, z) ? 0 : move.x,
                        rock(model, field, x, y + side(move.y), z) ? 0 : move.y,
                        rock(model, field, x, y, z + side(move.z)) ? 0 : move.z};
        const auto step = [&](double v) {
            return v != 0 && std::abs(v) >= largest(free) / 2 ? side(v) : 0;
        };
        const int nx = x + step(free.x), ny = y + step(free.y), nz = z + step(free.z);
        if (!rock(model, field, nx, ny, nz)) {
            before = before + (gradient(model, field, nx, ny, nz) - now) * largest(move);
        }
    }
    return {-before, dot(before, now) < 0};
}

double carried_off(const Model& model, const Voxel& voxel, const WayOut& out) {
    const double mass = voxel.total_mass();
    if (voxel.support.kind != Support::Kind::body || voxel.owner != voxel.support.body ||
        mass == 0 || dot(voxel.momentum, out.direction) <= 0) {
        return 0;
    }
    return std::min(1.0, largest(voxel.momentum) / mass / model.substeps);
}

bool is_barred(const Model& model, const Field& field, const WayOut& out, int x, int y, int z,
               int dx, int dy, int dz) {
    const int nx = x + dx, ny = y + dy, nz = z + dz;
    const Voxel& from = field.at(x, y, z);
    if (is_caught(model, from)) {
        const Vec3 step{static_cast<double>(dx), static_cast<double>(dy), static_cast<double>(dz)};
        if (dot(step, out.direction) < 0) {
            return true;
        }
        if (!rock(model, field, nx, ny, nz) && is_caught(model, field.at(nx, ny, nz)) &&
            (out.overrun || covered(field, nx, ny, nz) <= covered(field, x, y, z))) {
            return false;
        }
    }
    return field.closed(model, nx, ny, nz);
}

}  // namespace oracle
