#include "oracle/deformation.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "oracle/overlap.h"
#include "oracle/walls.h"

namespace oracle {
namespace {

constexpr int kSurfaceReach = 8;  // voxels over which pushed soil looks for the free surface

/// Slope at which confined soil of this voxel yields towards the surface.
double passive_slope(const Model& model, const Voxel& voxel) {
    std::vector<double> slopes;
    for (const double phi : model.friction_angle_rad) {
        slopes.push_back(std::tan(std::numbers::pi / 4 - phi / 2));
    }
    return voxel.mean(slopes);
}

bool has_room(const Model& model, const Field& field, int x, int y, int z) {
    return field.inside(x, y, z) &&
           field.at(x, y, z).soil + field.at(x, y, z).psi() < 1 - model.push_room;
}

Vec3 turn_to_surface(const Model& model, const Field& field, int x, int y, int z, Vec3 way,
                     double slope) {
    const double level = std::max(std::abs(way.x), std::abs(way.y));
    if (level == 0) return {0, 0, 1};
    const Vec3 flat{way.x / level, way.y / level, 0};
    const Vec3 rising{flat.x, flat.y, slope};
    for (int k = 1; k <= kSurfaceReach; ++k) {
        const int ahead_x = x + nearest(flat.x * k), ahead_y = y + nearest(flat.y * k);
        if (has_room(model, field, ahead_x, ahead_y, z)) return flat;
        if (has_room(model, field, ahead_x, ahead_y, z + nearest(slope * k))) return rising;
    }
    return rising;
}

/// Whether two directions are within 60 degrees of each other.
bool leads_along(Vec3 a, Vec3 b) { return dot(a, b) >= 0.5 * length(a) * length(b); }

/// What is left of a direction when only its largest component (or those as large) stays.
Vec3 straight(Vec3 way) {
    const double most = largest(way);
    const auto kept = [&](double v) { return std::abs(v) < most ? 0 : v; };
    return {kept(way.x), kept(way.y), kept(way.z)};
}

/// Relative density to which soil in excess here is packed: by the body that covers most of the
/// voxel, else half as far by the body of the voxel that the push comes from.
double packing(const Field& field, int x, int y, int z, Vec3 way, std::span<const Body> bodies) {
    const int here = field.at(x, y, z).owner;
    if (here >= 0) return bodies[static_cast<size_t>(here)].packing;
    const int bx = x - nearest(way.x), by = y - nearest(way.y), bz = z - nearest(way.z);
    const int behind = field.inside(bx, by, bz) ? field.at(bx, by, bz).owner : -1;
    return behind >= 0 ? bodies[static_cast<size_t>(behind)].packing / 2 : 0;
}

/// Volume that a voxel's soil gives up until it has this relative density.
double compressible(const Model& model, const Voxel& voxel, double relative_density) {
    const auto [loose, compacted] = volume_range(model, voxel);
    if (loose == 0) return 0;
    const double packed = loose - (loose - compacted) * relative_density;
    return std::max(0.0, voxel.soil - voxel.total_mass() * packed);
}

/// The largest component of a velocity along a way, of those that the way itself has largest.
double speed_along(Vec3 velocity, Vec3 way) {
    const auto component = [](double v, double w) { return std::abs(w) > 1 - 1e-6 ? v * w : 0; };
    return std::max({0.0, component(velocity.x, way.x), component(velocity.y, way.y),
                     component(velocity.z, way.z)});
}

/// Velocity of soil on the ground that a push moves: what leaves its voxel in this part of the
/// step, over the voxel's face. No faster than the body here; without one no faster than what has
/// arrived, so that what leaves takes no more momentum along than there is. None where it goes as
/// fast already.
std::optional<Vec3> pushed_velocity(const Model& model, const Voxel& voxel, int x, int y, int z,
                                    Vec3 way, double leaving, std::span<const Body> bodies) {
    const bool rests = voxel.support.kind == Support::Kind::ground;
    if (!rests || model.push_speed <= model.push_least) return {};
    const Vec3 velocity = voxel.momentum * (1 / voxel.total_mass());
    const double present = speed_along(velocity, way);
    const double most =
        voxel.owner < 0 ? present * voxel.soil / leaving
                        : largest(bodies[static_cast<size_t>(voxel.owner)].velocity_at(x, y, z));
    const double speed =
        std::min({std::min(leaving, 1.0) * model.body_substeps, most, model.push_speed});
    if (speed <= std::max(model.push_least, present)) return {};
    return way * speed;
}

}  // namespace

Field apply_force(const Model& model, const Field& before, std::span<const Body> bodies) {
    Field after = before;
    before.for_each([&](int x, int y, int z) {
        const Voxel& voxel = before.at(x, y, z);
        Vec3& force = after.at(x, y, z).force;
        const WayOut out = find_way_out(model, before, bodies, x, y, z);
        const bool overrun = is_caught(model, voxel) && out.overrun && voxel.soil > 0;
        if (excess(model, voxel) <= carried_off(model, before, out, x, y, z) && !overrun) {
            force = {};  // (33), third case
            return;
        }
        if (voxel.owner < 0) {
            return;  // (33), second case
        }
        const Body& body = bodies[static_cast<size_t>(voxel.owner)];
        Vec3 push = body.velocity_at(x, y, z);
        if (dot(push, out.direction) < 0) {
            push = out.direction;  // a surface that recedes
        } else if (push.z < 0 && !has_room(model, before, x, y, z - 1)) {
            const Vec3 aside{x + 0.5 - body.center.x, y + 0.5 - body.center.y, 0};
            // Within half a voxel of its middle the body pushes less and less to the side.
            const double reach = std::max({0.5, std::abs(aside.x), std::abs(aside.y)});
            const double down = -push.z;
            push = push + aside * (down / reach);
            push.z = down * passive_slope(model, voxel) *
                     std::max(1.0, std::hypot(aside.x, aside.y) / reach);
        }
        if (largest(push) > 0) {
            force = push * (1 / largest(push));  // (33), first case, in the scale of (34)
        }
    });
    return after;
}

Field propagate_force(const Model& model, const Field& before, std::span<const Body> bodies) {
    Field after = before;
    before.for_each([&](int x, int y, int z) { after.at(x, y, z).force = {}; });
    before.for_each([&](int x, int y, int z) {
        const Voxel& voxel = before.at(x, y, z);
        const bool caught = is_caught(model, voxel);
        const WayOut side = find_way_out(model, before, bodies, x, y, z);
        const WayOut out = caught ? side : WayOut{};
        double leaving = out.overrun
                             ? voxel.soil
                             : excess(model, voxel) - carried_off(model, before, side, x, y, z);
        if (leaving <= 0 || largest(voxel.force) == 0) return;
        Vec3 way = voxel.force * (1 / largest(voxel.force));  // (34)
        const double packed = packing(before, x, y, z, way, bodies);
        const double gone = std::min(leaving, compressible(model, voxel, packed));
        after.at(x, y, z).soil -= gone;
        after.at(x, y, z).bond -= voxel.bond * gone / voxel.soil;
        leaving -= gone;
        // Over the way's largest component.
        const double slope = std::min(1.0, passive_slope(model, voxel) * std::hypot(way.x, way.y));
        if (way.z < slope &&
            !has_room(model, before, x + nearest(way.x), y + nearest(way.y), z + nearest(way.z))) {
            way = turn_to_surface(model, before, x, y, z, way, slope);
        }
        Voxel sent = voxel;
        if (const std::optional<Vec3> velocity =
                pushed_velocity(model, voxel, x, y, z, way, leaving, bodies)) {
            sent.momentum = *velocity * voxel.total_mass();
            after.at(x, y, z).momentum += sent.momentum - voxel.momentum;
        }
        const auto push = [&](Vec3 along, Vec3 pushed, double amount) {
            double barred = amount;
            for (const Overlap& part : overlaps(along)) {
                if (!caught && voxel.soil > model.crumb && amount * part.share < model.speck) {
                    continue;
                }
                if (is_barred(model, before, out, x, y, z, part.dx, part.dy, part.dz) ||
                    (!caught &&
                     before.at(x + part.dx, y + part.dy, z + part.dz).soil > model.crowded_least)) {
                    continue;
                }
                Voxel& target = after.at(x + part.dx, y + part.dy, z + part.dz);
                const double fits =
                    model.voxel_most - before.at(x + part.dx, y + part.dy, z + part.dz).soil;
                const double moved =
                    std::min(amount * part.share, std::max(0.0, fits) / model.pushes_meet);
                move_share(sent, after.at(x, y, z), target, moved / voxel.soil);
                target.force += pushed * moved;  // (35), as a weighted sum
                barred -= moved;
            }
            return barred;
        };
        const double steep = largest(out.direction);
        double barred = leaving;
        if (steep == 0 || leads_along(way, out.direction)) barred = push(way, way, leaving);
        if (way.z > 0 && std::max(std::abs(way.x), std::abs(way.y)) == 1) {
            way.z = 0;
            barred = push(way, way, barred);
        }
        const bool driven = voxel.owner >= 0 &&
                            largest(bodies[static_cast<size_t>(voxel.owner)].velocity_at(x, y, z)) >
                                model.still_speed;
        if (steep > 0 && driven) {
            const Vec3 exit = {out.direction.x / steep, out.direction.y / steep,
                               out.direction.z / steep};
            barred = push(exit, way, barred);
            push(straight(exit), way, barred);
        }
    });
    return after;
}

}  // namespace oracle
