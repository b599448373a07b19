#include "oracle/contacts.h"

#include <algorithm>

namespace oracle {

std::vector<Contact> find_contacts(const Field& field) {
    const auto psi = [&](int x, int y, int z) {
        return field.inside(x, y, z) ? std::min(1.0, field.at(x, y, z).bodies) : 0.0;
    };
    std::vector<Contact> contacts;
    field.for_each([&](int x, int y, int z) {
        const Vec3 g{psi(x + 1, y, z) - psi(x - 1, y, z), psi(x, y + 1, z) - psi(x, y - 1, z),
                     psi(x, y, z + 1) - psi(x, y, z - 1)};
        const double steepest = std::max({std::abs(g.x), std::abs(g.y), std::abs(g.z)});
        if (steepest == 0) {
            return;
        }
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
        const Voxel *inner = neighbour(1), *outer = neighbour(-1);
        const int body = voxel.owner >= 0 || !inner ? voxel.owner : inner->owner;
        if (body < 0) {
            return;
        }
        const Voxel& soil = outer && outer->soil > voxel.soil ? *outer : voxel;
        const double held = voxel.soil + (outer ? outer->soil : 0);
        const double room = 1 - voxel.psi() + (outer ? 1 - outer->psi() : 0);
        if (held == 0 || soil.support.kind != Support::Kind::ground) {
            return;
        }
        contacts.push_back({x, y, z, body, g, held >= room ? 1 : held / room,
                            std::max(0.0, voxel.soil + voxel.psi() - 1), soil.main_material()});
    });
    return contacts;
}

}  // namespace oracle
