#include "oracle/walls.h"

#include <algorithm>
#include <cmath>

namespace oracle {
namespace {

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

double carried_off(const Model& model, const Field& field, const WayOut& out, int x, int y, int z) {
    const Voxel& voxel = field.at(x, y, z);
    const double mass = voxel.total_mass(), most = largest(voxel.momentum);
    if (voxel.support.kind != Support::Kind::body || voxel.owner != voxel.support.body ||
        mass == 0 || dot(voxel.momentum, out.direction) <= 0) {
        return 0;
    }
    const auto step = [&](double v) { return std::abs(v) < most / 2 ? 0 : v > 0 ? 1 : -1; };
    const int nx = x + step(voxel.momentum.x), ny = y + step(voxel.momentum.y),
              nz = z + step(voxel.momentum.z);
    const bool makes_room = field.inside(nx, ny, nz) && !is_caught(model, field.at(nx, ny, nz)) &&
                            field.at(nx, ny, nz).support.kind == Support::Kind::body &&
                            field.at(nx, ny, nz).support.body == voxel.support.body;
    return makes_room ? std::min(1.0, most / mass / model.substeps) : 0;
}

bool recedes(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
             int z) {
    if (!field.inside(x, y, z) || !is_caught(model, field.at(x, y, z)) ||
        field.at(x, y, z).owner < 0) {
        return false;
    }
    const auto side = [&](int nx, int ny, int nz) {
        return field.inside(nx, ny, nz) ? covered(field, nx, ny, nz) : 0;
    };
    const Vec3 inwards{side(x + 1, y, z) - side(x - 1, y, z), side(x, y + 1, z) - side(x, y - 1, z),
                       side(x, y, z + 1) - side(x, y, z - 1)};
    const Vec3 velocity = bodies[static_cast<size_t>(field.at(x, y, z).owner)].velocity_at(x, y, z);
    const double along = dot(velocity, inwards);
    return along > 0 && along >= 0.5 * length(velocity) * length(inwards) &&
           largest(velocity) <= model.follow_most;
}

double room_at_face(const Model& model, const Field& field, std::span<const Body> bodies,
                    const Voxel& from, int x, int y, int z) {
    if (from.support.kind != Support::Kind::body || is_caught(model, from) ||
        !recedes(model, field, bodies, x, y, z) || field.at(x, y, z).owner != from.support.body) {
        return 0;
    }
    const Voxel& to = field.at(x, y, z);
    return std::max(0.0, 1 - to.psi() - to.soil);
}

bool is_barred(const Model& model, const Field& field, const WayOut& out, int x, int y, int z,
               int dx, int dy, int dz) {
    const int nx = x + dx, ny = y + dy, nz = z + dz;
    const Voxel& from = field.at(x, y, z);
    if (is_caught(model, from)) {
        const Vec3 step{static_cast<double>(dx), static_cast<double>(dy), static_cast<double>(dz)};
        if (dot(step, out.direction) < 0) return true;
        if (!rock(model, field, nx, ny, nz) && is_caught(model, field.at(nx, ny, nz)) &&
            (out.overrun || covered(field, nx, ny, nz) <= covered(field, x, y, z))) {
            return false;
        }
    }
    return field.closed(model, nx, ny, nz);
}

}  // namespace oracle
