#include "oracle/contacts.h"

#include <algorithm>

#include "oracle/held_load.h"

namespace oracle {

namespace {

/// Soil of several voxels.
struct Sum {
    double volume = 0, bond = 0;
    /// Of those with most of one material: their volume, and what it is loose and compacted, each
    /// by its own mixture.
    double held = 0, loose = 0, compacted = 0;

    void add_density(const Model& model, const Voxel& voxel) {
        const auto [loose_of_mass, compacted_of_mass] = volume_range(model, voxel);
        held += voxel.soil;
        loose += loose_of_mass * voxel.total_mass();
        compacted += compacted_of_mass * voxel.total_mass();
    }
};

/// Of the voxels (x, y, z) + k (dx, dy, dz), k = 0..reach.
Sum sum_outwards(const Model& model, const Field& field, int material, int x, int y, int z, int dx,
                 int dy, int dz, int reach) {
    Sum sum;
    for (int k = 0; k <= reach; ++k) {
        if (field.inside(x + k * dx, y + k * dy, z + k * dz)) {
            const Voxel& voxel = field.at(x + k * dx, y + k * dy, z + k * dz);
            sum.volume += voxel.soil;
            sum.bond += voxel.bond;
            const bool is_other = voxel.total_mass() > 0 && voxel.main_material() != material;
            if (!is_other) sum.add_density(model, voxel);
        }
    }
    return sum;
}

/// Where such soil stands between loose (0) and compacted (1); -1 where density is fixed. Of the
/// soil that the body meets, where there is none with most of that material.
double relative_density(const Model& model, const Voxel& soil, Sum sum) {
    if (model.loose_volume[static_cast<size_t>(soil.main_material())] == 0) return -1;
    if (sum.loose == 0) sum.add_density(model, soil);
    const double range = sum.loose - sum.compacted;
    return range > 0 ? std::clamp((sum.loose - sum.held) / range, 0.0, 1.0) : 0;
}

/// What lies behind a load that is full from its body to there, along the level part of the
/// coverage's gradient; null where nothing holds the load back, or the face is as good as level.
const Voxel* soil_behind_load(const Model& model, const Field& field, int x, int y, int z, Vec3 g,
                              int body) {
    const double wide = std::max(std::abs(g.x), std::abs(g.y));
    if (4 * wide < std::abs(g.z)) return nullptr;
    const bool along_x = std::abs(g.x) == wide;
    const int dx = along_x ? (g.x > 0 ? -1 : 1) : 0, dy = along_x ? 0 : (g.y > 0 ? -1 : 1);
    for (int k = 0; k <= 8; ++k) {
        if (!field.inside(x + k * dx, y + k * dy, z)) return nullptr;
        const Voxel& v = field.at(x + k * dx, y + k * dy, z);
        if (k > 0 && v.soil + v.psi() < 1 - model.carry_slack) return nullptr;
        const bool is_load = v.support.kind == Support::Kind::body && v.support.body == body;
        if (v.soil > 0 && !is_load) return v.support.kind == Support::Kind::falling ? nullptr : &v;
    }
    return nullptr;
}

/// Contact::load_above and load_ends.
void look_at_load(const Model& model, const Field& field, Contact& contact) {
    for (int k = 0; k <= 2 && field.inside(contact.x, contact.y, contact.z + k); ++k) {
        const int z = contact.z + k;
        const Voxel& over = field.at(contact.x, contact.y, z);
        if (over.bodies >= model.solid_coverage || over.soil == 0) continue;
        if (over.support.kind != Support::Kind::body || over.support.body != contact.body) return;
        contact.load_above = k;
        constexpr int kSides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        for (size_t i = 0; i < 4; ++i) {
            const int x = contact.x + kSides[i][0], y = contact.y + kSides[i][1];
            if (!field.inside(x, y, z)) continue;
            const Voxel& beside = field.at(x, y, z);
            contact.load_ends[i] = beside.support.kind == Support::Kind::ground &&
                                   beside.soil > 0 &&
                                   beside.soil + beside.psi() >= 1 - model.carry_slack;
        }
        return;
    }
}

/// Whether another body's load before a face fills all up to a wall of the face's body.
bool is_between_walls(const Model& model, const Field& field, int body, RowStart row) {
    for (int n = 0; n < 2 && field.closed(model, row.x, row.y, row.z); ++n) {
        row.x += row.dx, row.y += row.dy;
        if (!field.inside(row.x, row.y, row.z)) return false;
    }
    const std::optional<int> wall = wall_of_row(model, field, row);
    return wall && *wall == body;
}

}  // namespace

std::vector<Contact> find_contacts(const Model& model, const Field& field,
                                   std::span<const Body> bodies) {
    const auto psi = [&](int x, int y, int z) {
        return field.inside(x, y, z) ? std::min(1.0, field.at(x, y, z).bodies) : 0.0;
    };
    std::vector<Contact> contacts;
    field.for_each([&](int x, int y, int z) {
        const Vec3 g{psi(x + 1, y, z) - psi(x - 1, y, z), psi(x, y + 1, z) - psi(x, y - 1, z),
                     psi(x, y, z + 1) - psi(x, y, z - 1)};
        const double steepest = std::max({std::abs(g.x), std::abs(g.y), std::abs(g.z)});
        if (steepest == 0) return;
        int in[3] = {0, 0, 0};
        if (std::abs(g.z) == steepest) {
            in[2] = g.z > 0 ? 1 : -1;
        } else if (std::abs(g.x) == steepest) {
            in[0] = g.x > 0 ? 1 : -1;
        } else {
            in[1] = g.y > 0 ? 1 : -1;
        }
        const Voxel& voxel = field.at(x, y, z);
        const auto neighbour = [&](int side) -> const Voxel* {
            const int nx = x + side * in[0], ny = y + side * in[1], nz = z + side * in[2];
            return field.inside(nx, ny, nz) ? &field.at(nx, ny, nz) : nullptr;
        };
        const Voxel* inner = neighbour(1);
        const int body = voxel.owner >= 0 || !inner ? voxel.owner : inner->owner;
        if (body < 0) return;
        // The fullest of three voxels on the way out that are not mostly body.
        Voxel none;
        const Voxel* fullest = &none;
        for (int k = 0; k <= 2; ++k) {
            const Voxel* beside = neighbour(-k);
            if (beside && beside->bodies < model.solid_coverage && beside->soil > fullest->soil) {
                fullest = beside;
            }
        }
        const auto outer_soil = neighbour(-1) ? neighbour(-1)->soil : 0;
        if (voxel.soil + outer_soil == 0 || fullest->support.kind == Support::Kind::falling) return;
        const bool on_other =
            fullest->support.kind == Support::Kind::body && fullest->support.body != body;
        const bool is_between = on_other && in[2] == 0 &&
                                is_between_walls(model, field, body, {x, y, z, -in[0], -in[1]});
        if (fullest->support.kind == Support::Kind::body && fullest->support.body == body) {
            fullest = soil_behind_load(model, field, x, y, z, g, body);
            if (!fullest) return;
        }
        const Voxel& soil = *fullest;
        const bool on_body = soil.support.kind == Support::Kind::body;
        const auto gap_beside = [&](int dx, int dy, int dz) {
            double gap = 1 - voxel.psi() - voxel.soil;
            if (field.inside(x - dx, y - dy, z - dz)) {
                const Voxel& outer = field.at(x - dx, y - dy, z - dz);
                gap += 1 - outer.psi() - outer.soil;
            }
            return std::max(0.0, gap);
        };
        const double gap = gap_beside(in[0], in[1], in[2]);
        const int material = soil.main_material();
        const Vec3 gaps{g.x == 0 ? gap : gap_beside(g.x > 0 ? 1 : -1, 0, 0),
                        g.y == 0 ? gap : gap_beside(0, g.y > 0 ? 1 : -1, 0),
                        g.z == 0 ? gap : gap_beside(0, 0, g.z > 0 ? 1 : -1)};
        const Sum sum = sum_outwards(model, field, material, x, y, z, -in[0], -in[1], -in[2],
                                     bodies[static_cast<size_t>(body)].reach);
        contacts.push_back({x, y, z, body, g, gaps, std::max(0.0, voxel.soil + voxel.psi() - 1),
                            material, relative_density(model, soil, sum),
                            on_body ? soil.support.body : -1, sum.bond / sum.volume, is_between});
        look_at_load(model, field, contacts.back());
    });
    return contacts;
}

}  // namespace oracle
