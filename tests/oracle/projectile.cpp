#include "oracle/projectile.h"

#include <algorithm>

#include "oracle/overlap.h"
#include "oracle/walls.h"

namespace oracle {

Field find_support(const Model& model, const Field& before, std::span<const Body> bodies) {
    Field after = before;
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            Support below{Support::Kind::ground, -1};
            for (int z = 0; z < before.nz; ++z) {
                const Voxel& voxel = before.at(x, y, z);
                if (voxel.psi() >= model.solid_coverage) {
                    const bool on_mover = voxel.bodies > voxel.terrain && voxel.owner >= 0 &&
                                          bodies[static_cast<size_t>(voxel.owner)].moves;
                    below = on_mover ? Support{Support::Kind::body, voxel.owner}
                                     : Support{Support::Kind::ground, -1};
                }
                after.at(x, y, z).support = voxel.soil > 0 ? below : Support{};
                const double slack =
                    below.kind == Support::Kind::body ? model.carry_slack : model.support_slack;
                if (voxel.soil + voxel.psi() < 1 - slack) {
                    below = {};
                }
            }
        }
    }
    return after;
}

Field advect(const Model& model, const Field& before, std::span<const Body> bodies) {
    const double dt = 1.0 / model.substeps;
    const auto locked = [&](const WayOut& out, int x, int y, int z, const Overlap& part) {
        if (is_barred(model, before, out, x, y, z, part.dx, part.dy, part.dz)) {
            return true;
        }
        const Voxel& voxel = before.at(x + part.dx, y + part.dy, z + part.dz);
        return voxel.support.kind == Support::Kind::ground &&
               voxel.soil + voxel.psi() >= 1;  // (24)
    };
    Field after = before;
    before.for_each([&](int x, int y, int z) {
        const Voxel& voxel = before.at(x, y, z);
        Voxel& origin = after.at(x, y, z);
        const double mass = voxel.total_mass();
        if (voxel.soil == 0 || mass == 0) {
            return;
        }
        if (voxel.support.kind == Support::Kind::ground) {
            origin.momentum += -voxel.momentum;
            return;
        }
        const Vec3 velocity = voxel.momentum * (1 / mass);
        Vec3 accelerated = velocity;
        Vec3 drift = velocity;
        if (voxel.support.kind == Support::Kind::falling) {
            accelerated.z -= model.gravity * dt;  // (29)
            drift.z -= model.gravity * dt / 2;
        } else {
            const Body& body = bodies[static_cast<size_t>(voxel.support.body)];
            const Vec3 goal = body.velocity_at(x, y, z);
            const double grip = body.friction_speed * dt;
            accelerated.x += std::clamp(goal.x - velocity.x, -grip, grip);
            accelerated.y += std::clamp(goal.y - velocity.y, -grip, grip);
            accelerated.z = std::max(goal.z, velocity.z - model.gravity * dt);
            drift = accelerated;
        }
        const auto displacement = [&](double speed) { return std::clamp(speed * dt, -1.0, 1.0); };
        drift = {displacement(drift.x), displacement(drift.y), displacement(drift.z)};
        const Vec3 momentum = accelerated * mass;
        origin.momentum += momentum - voxel.momentum;
        const WayOut out =
            is_caught(model, voxel) ? find_way_out(model, before, bodies, x, y, z) : WayOut{};
        for (const Overlap& part : overlaps(drift)) {
            if (voxel.soil * part.share < model.speck) {
                continue;
            }
            origin.momentum += -part.share * momentum;
            if (locked(out, x, y, z, part)) {
                continue;  // (24): backflow, with zero velocity
            }
            Voxel& target = after.at(x + part.dx, y + part.dy, z + part.dz);
            target.momentum += part.share * momentum;  // (28)
            origin.soil -= part.share * voxel.soil;    // (23), (27)
            origin.bond -= part.share * voxel.bond;
            target.soil += part.share * (voxel.soil + swelling(model, voxel));
            for (size_t m = 0; m < voxel.mass.size(); ++m) {
                origin.mass[m] -= part.share * voxel.mass[m];
                target.mass[m] += part.share * voxel.mass[m];
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
        if (leaving <= 0 || (pushed && voxel.soil <= model.pushed_most)) {
            return;
        }
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
