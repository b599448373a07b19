#include "oracle/projectile.h"

#include <algorithm>

#include "oracle/arches.h"
#include "oracle/held_load.h"
#include "oracle/overlap.h"
#include "oracle/roofs.h"
#include "oracle/walls.h"
#include "oracle/wind.h"

namespace oracle {

namespace {

/// Shares of a voxel along the axes: the drift; for soil carried by the body that covers the voxel
/// in part no less, along the way out of that body, than what the body has left no room for.
Vec3 spread_of(const Field& field, int x, int y, int z, Vec3 drift) {
    const Voxel& voxel = field.at(x, y, z);
    const double over = voxel.soil + std::min(1.0, voxel.bodies) - 1;
    const double fastest = std::max({std::abs(drift.x), std::abs(drift.y), std::abs(drift.z)});
    if (voxel.support.kind != Support::Kind::body || voxel.owner != voxel.support.body ||
        over <= 0 || fastest == 0) {
        return drift;
    }
    const double swept = std::min(1.0, over / voxel.soil) / fastest;
    const auto along = [&](double d, int dx, int dy, int dz) {
        const auto covered = [&](int side) {
            const int nx = x + side * dx, ny = y + side * dy, nz = z + side * dz;
            return field.inside(nx, ny, nz) ? std::min(1.0, field.at(nx, ny, nz).bodies) : 0;
        };
        return d * (covered(1) - covered(-1)) < 0 ? d * std::max(1.0, swept) : d;
    };
    return {along(drift.x, 1, 0, 0), along(drift.y, 0, 1, 0), along(drift.z, 0, 0, 1)};
}

/// The part of `value` from 0 to `bound`.
Vec3 towards(Vec3 value, Vec3 bound) {
    const auto part = [](double v, double b) {
        return std::clamp(v, std::min(0.0, b), std::max(0.0, b));
    };
    return {part(value.x, bound.x), part(value.y, bound.y), part(value.z, bound.z)};
}

/// Momentum of soil that comes to lie on the ground: none; where slides keep it what goes along,
/// less by friction with what the fall has pressed on the ground.
Vec3 landed(const Model& model, const Voxel& voxel) {
    const Vec3 along{voxel.momentum.x, voxel.momentum.y, 0};
    if (!model.slides || length(along) == 0) return {};
    std::vector<double> frictions;
    for (const double phi : model.friction_angle_rad) frictions.push_back(std::tan(phi));
    const double lost = std::max(0.0, -voxel.momentum.z) * voxel.mean(frictions);
    return along * std::max(0.0, 1 - lost / length(along));
}

/// A drift by whole voxels, as often as it is long, each axis by a chance of its own: the voxel's,
/// and those of places that no grid has.
Vec3 whole_voxels(const Model& model, Vec3 drift, int x, int y, int z) {
    constexpr int kBeyond = 16384;
    const auto whole = [](double length, double chance) {
        return std::abs(length) > chance ? std::copysign(1.0, length) : 0.0;
    };
    return {whole(drift.x, chance(x, y, z, model.pass)),
            whole(drift.y, chance(x + kBeyond, y, z, model.pass)),
            whole(drift.z, chance(x, y + kBeyond, z, model.pass))};
}

}  // namespace

Field find_support(const Model& model, const Field& before, std::span<const Body> bodies,
                   double strength) {
    Field after = before;
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            Support below{Support::Kind::ground, -1};
            for (int z = 0; z < before.nz; ++z) {
                const Voxel& voxel = before.at(x, y, z);
                Support own = below;
                if (voxel.psi() >= model.solid_coverage) {
                    const bool on_mover = voxel.bodies > voxel.terrain && voxel.owner >= 0 &&
                                          bodies[static_cast<size_t>(voxel.owner)].moves;
                    below = on_mover ? Support{Support::Kind::body, voxel.owner}
                                     : Support{Support::Kind::ground, -1};
                    // Under a face that looks down lies what the body stands on.
                    const bool looks_down =
                        z + 1 < before.nz &&
                        before.at(x, y, z + 1).bodies > (z > 0 ? before.at(x, y, z - 1).bodies : 0);
                    if (!on_mover || !looks_down) own = below;
                }
                if (own.kind == Support::Kind::falling && voxel.psi() < model.solid_coverage &&
                    voxel.soil > 0 && !model.cohesion_height.empty() &&
                    is_held_roof(model, before, x, y, z, strength)) {
                    own = below = {Support::Kind::ground, -1};
                }
                after.at(x, y, z).support = voxel.soil > 0 ? own : Support{};
                const double slack =
                    below.kind == Support::Kind::body ? model.carry_slack : model.support_slack;
                const bool solid = voxel.psi() >= model.solid_coverage;
                if (!solid && voxel.soil + voxel.psi() < 1 - slack) below = {};
            }
        }
    }
    return after;
}

Field advect(const Model& model, const Field& before, std::span<const Body> bodies) {
    const double dt = 1.0 / model.substeps;
    const auto locked = [&](const WayOut& out, int x, int y, int z, const Overlap& part) {
        if (is_barred(model, before, out, x, y, z, part.dx, part.dy, part.dz)) return true;
        const Voxel& voxel = before.at(x + part.dx, y + part.dy, z + part.dz);
        return voxel.support.kind == Support::Kind::ground &&
               voxel.soil + voxel.psi() >= 1;  // (24)
    };
    // What the ground gives back: it goes off faster than gravity brings it back, the way is open.
    const auto leaves_ground = [&](const Voxel& voxel, int x, int y, int z) {
        const Vec3 velocity = voxel.momentum * (1 / voxel.total_mass());
        if (velocity.z <= model.gravity * dt || is_caught(model, voxel)) return false;
        const Vec3 way =
            velocity * ((1 + 1e-5) / largest(velocity));  // a half as the kernel sees it
        return !locked({}, x, y, z, {nearest(way.x), nearest(way.y), nearest(way.z), 1});
    };
    Field after = before;
    before.for_each([&](int x, int y, int z) {
        const Voxel& voxel = before.at(x, y, z);
        Voxel& origin = after.at(x, y, z);
        const double mass = voxel.total_mass();
        if (voxel.soil == 0 || mass == 0) return;
        const bool rests =
            voxel.support.kind == Support::Kind::ground && !leaves_ground(voxel, x, y, z);
        if (rests) {
            origin.momentum += landed(model, voxel) - voxel.momentum;
            return;
        }
        const Vec3 velocity = voxel.momentum * (1 / mass);
        Vec3 accelerated = velocity;
        Vec3 drift = velocity;
        if (voxel.support.kind != Support::Kind::body) {
            accelerated.z -= model.gravity * dt;  // (29)
            drift.z -= model.gravity * dt / 2;
            if (const double rate = model.air.empty() ? 0 : voxel.mean(model.air); rate > 0) {
                const Vec3 air = air_velocity(model, before, x, y, z);
                accelerated = fall_in_air(model, velocity, air, rate, dt);
                drift = 0.5 * (velocity + accelerated);
            }
            const double most = arch_speed(model, before, x, y, z);
            accelerated.z = std::max(accelerated.z, -most);
            drift.z = std::max(drift.z, -most);
        } else {
            const Body& body = bodies[static_cast<size_t>(voxel.support.body)];
            const Vec3 goal = body.velocity_at(x, y, z);
            const double grip = dt * (body.friction_speed >= 0 ? body.friction_speed
                                                               : voxel.mean(model.friction_speed));
            const double missing = std::hypot(goal.x - velocity.x, goal.y - velocity.y);
            const double taken = missing > grip ? grip / missing : 1;
            accelerated.x += taken * (goal.x - velocity.x);
            accelerated.y += taken * (goal.y - velocity.y);
            accelerated.z = std::max(goal.z, velocity.z - model.gravity * dt);
            accelerated = held_back(model, before, bodies, x, y, z, accelerated);
            drift = accelerated;
        }
        const auto displacement = [&](double speed) { return std::clamp(speed * dt, -1.0, 1.0); };
        drift = {displacement(drift.x), displacement(drift.y), displacement(drift.z)};
        Vec3 momentum = accelerated * mass;
        origin.momentum += momentum - voxel.momentum;
        const WayOut out =
            is_caught(model, voxel) ? find_way_out(model, before, bodies, x, y, z) : WayOut{};
        const auto is_speck = [&](const Overlap& part) {
            return voxel.soil > model.crumb && part.share < 1 &&
                   (voxel.soil * part.share < model.speck || mass * part.share < model.mass_speck);
        };
        // What falls and cannot leave in shares goes whole, by chance, as crumbs do. Thick soil
        // that a wall bars gets on once it is faster, where no air slows it down.
        const bool goes_no_faster =
            voxel.soil <= model.thin || (!model.air.empty() && voxel.mean(model.air) > 0);
        const Vec3 spread = spread_of(before, x, y, z, drift);
        std::vector<Overlap> parts = overlaps(spread);
        // Of the corners that it could give, one has an eighth of a drift. Less than the kernels'
        // words tell is none.
        constexpr double kLeastDrift = 1.0 / 65536;
        const auto is_scant = [&](double part) {
            return std::abs(part) >= kLeastDrift &&
                   (voxel.soil * std::abs(part) / 8 < model.speck ||
                    mass * std::abs(part) / 8 < model.mass_speck);
        };
        const bool may_hang = is_scant(spread.x) || is_scant(spread.y) || is_scant(spread.z);
        const bool hangs =
            may_hang && std::all_of(parts.begin(), parts.end(), [&](const Overlap& part) {
                return is_speck(part) || (goes_no_faster && locked(out, x, y, z, part));
            });
        const bool falls = voxel.support.kind != Support::Kind::body;
        const bool goes_whole = voxel.soil <= model.crumb || (falls && hangs);
        // Where shares go aside and none comes down the vertical goes so alone.
        const bool comes_down = std::any_of(parts.begin(), parts.end(), [&](const Overlap& part) {
            return part.dz != 0 && !is_speck(part);
        });
        const bool falls_whole = goes_whole || (falls && may_hang && goes_no_faster && !comes_down);
        // What bars a step of whole voxels takes the momentum along these axes. Whether it does.
        const auto stops = [&](Vec3 step, Vec3 axes) {
            const Overlap part{nearest(step.x), nearest(step.y), nearest(step.z), 1};
            if (!falls || length(step) == 0 || !locked(out, x, y, z, part)) return false;
            const int nx = x + part.dx, ny = y + part.dy, nz = z + part.dz;
            Vec3 with_wall;
            if (recedes(model, before, bodies, nx, ny, nz)) {
                const int owner = before.at(nx, ny, nz).owner;
                with_wall = mass * bodies[static_cast<size_t>(owner)].velocity_at(x, y, z);
            }
            const Vec3 kept = towards(momentum, with_wall);
            const Vec3 taken{axes.x * (momentum.x - kept.x), axes.y * (momentum.y - kept.y),
                             axes.z * (momentum.z - kept.z)};
            origin.momentum += -taken;
            momentum += -taken;
            return true;
        };
        const Vec3 drawn = whole_voxels(model, drift, x, y, z);
        Vec3 step{goes_whole ? drawn.x : 0, goes_whole ? drawn.y : 0, falls_whole ? drawn.z : 0};
        if (stops({step.x, 0, 0}, {1, 0, 0})) step.x = 0;
        if (stops({0, step.y, 0}, {0, 1, 0})) step.y = 0;
        if (stops({0, 0, step.z}, {0, 0, 1})) step.z = 0;
        // Before an edge it comes down.
        if (step.z != 0 && stops(step, {std::abs(step.x), std::abs(step.y), 0})) {
            step = {0, 0, step.z};
        }
        if (falls_whole) {
            parts =
                overlaps({goes_whole ? step.x : spread.x, goes_whole ? step.y : spread.y, step.z});
        }
        for (const Overlap& part : parts) {
            if (is_speck(part)) continue;
            double share = part.share;
            if (locked(out, x, y, z, part)) {
                const int nx = x + part.dx, ny = y + part.dy, nz = z + part.dz;
                Vec3 with_wall;
                share =
                    std::min(part.share,
                             room_at_face(model, before, bodies, voxel, nx, ny, nz) / voxel.soil);
                if (recedes(model, before, bodies, nx, ny, nz)) {
                    const int owner = before.at(nx, ny, nz).owner;
                    with_wall = mass * bodies[static_cast<size_t>(owner)].velocity_at(x, y, z);
                }
                // (24): backflow, with zero velocity; with the wall's where that recedes.
                origin.momentum += (part.share - share) * (towards(momentum, with_wall) - momentum);
                if (share == 0) continue;
            }
            origin.momentum += -share * momentum;
            Voxel& target = after.at(x + part.dx, y + part.dy, z + part.dz);
            target.momentum += share * momentum;  // (28)
            origin.soil -= share * voxel.soil;    // (23), (27)
            origin.bond -= share * voxel.bond;
            target.soil += share * (voxel.soil + swelling(model, voxel));
            for (size_t m = 0; m < voxel.mass.size(); ++m) {
                origin.mass[m] -= share * voxel.mass[m];
                target.mass[m] += share * voxel.mass[m];
            }
        }
    });
    return after;
}

Field resolve_overflow(const Model& model, const Field& before, std::span<const Body> bodies,
                       Heuristic heuristic) {
    Field after = before;
    before.for_each([&](int x, int y, int z) {
        const Voxel& voxel = before.at(x, y, z);
        const double leaving = excess(model, voxel);
        const bool pushed = length(voxel.force) > 0;
        if (leaving <= 0 || (pushed && voxel.soil <= model.pushed_most)) return;
        const double share = leaving / voxel.soil;
        const auto give = [&](int dx, int dy, int dz, double part) {
            move_share(voxel, after.at(x, y, z), after.at(x + dx, y + dy, z + dz), part);
        };
        const bool shut_above = before.closed(model, x, y, z + 1);
        const bool caught = is_caught(model, voxel);
        if (heuristic == Heuristic::even || caught || shut_above) {
            const WayOut out = caught ? find_way_out(model, before, bodies, x, y, z) : WayOut{};
            std::vector<Overlap> open;
            for (int dz = -1; dz <= 1; ++dz) {
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx) {
                        const Vec3 step{static_cast<double>(dx), static_cast<double>(dy),
                                        static_cast<double>(dz)};
                        if ((dx != 0 || dy != 0 || dz != 0) && dot(step, out.direction) >= 0 &&
                            !before.closed(model, x + dx, y + dy, z + dz)) {
                            open.push_back({dx, dy, dz, 0});
                        }
                    }
                }
            }
            for (const Overlap& to : open) {
                give(to.dx, to.dy, to.dz, share / static_cast<double>(open.size()));
            }
        } else if (heuristic == Heuristic::up) {
            give(0, 0, 1, share);
        } else {
            // A tent of weights, most in the middle, over the nine voxels above; Fig. 30 shows its
            // plane section 1 2 1. What is barred goes straight up.
            double straight = share;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const double part = share * (2 - std::abs(dx)) * (2 - std::abs(dy)) / 16;
                    if ((dx != 0 || dy != 0) && !before.closed(model, x + dx, y + dy, z + 1)) {
                        give(dx, dy, 1, part);
                        straight -= part;
                    }
                }
            }
            give(0, 0, 1, straight);
        }
    });
    return after;
}

}  // namespace oracle
