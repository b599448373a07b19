/// Triangle meshes that tests make solids of.
#pragma once

#include <cmath>
#include <numbers>

#include "bsoil/distance_lattice.h"
#include "soil_fixture.h"

namespace bsoil {

inline void add_quad(TriangleMesh& mesh, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Vec3 p : {a, b, c, d}) mesh.vertices.push_back(p);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
}

/// A closed box, faces outwards, no corner shared between faces.
inline void add_box(TriangleMesh& mesh, Vec3 low, Vec3 high) {
    const auto at = [&](int i) {
        return Vec3{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    };
    add_quad(mesh, at(0), at(2), at(3), at(1));
    add_quad(mesh, at(4), at(5), at(7), at(6));
    add_quad(mesh, at(0), at(1), at(5), at(4));
    add_quad(mesh, at(2), at(6), at(7), at(3));
    add_quad(mesh, at(0), at(4), at(6), at(2));
    add_quad(mesh, at(1), at(3), at(7), at(5));
}

inline TriangleMesh box_mesh(Vec3 half) {
    TriangleMesh mesh;
    add_box(mesh, -half, half);
    return mesh;
}

/// The four sides and the bottom of a box without a lid, as sheets.
inline TriangleMesh open_bucket(Vec3 half) {
    TriangleMesh mesh = box_mesh(half);
    mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);
    return mesh;
}

/// A bucket as one closed surface: outer box with a hollow from its top, walls and floor of
/// `plate_m`.
inline TriangleMesh thick_bucket(Vec3 half, double plate_m) {
    TriangleMesh mesh = open_bucket(half);
    const Vec3 in = half - Vec3{plate_m, plate_m, 0};
    const double floor = -half.z + plate_m;
    const auto inner = [&](double sx, double sy, double z) {
        return Vec3{sx * in.x, sy * in.y, z};
    };
    const auto outer = [&](double sx, double sy) { return Vec3{sx * half.x, sy * half.y, half.z}; };
    add_quad(mesh, inner(-1, -1, floor), inner(1, -1, floor), inner(1, 1, floor),
             inner(-1, 1, floor));
    const double corners[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    for (int i = 0; i < 4; ++i) {
        const double *a = corners[i], *b = corners[i + 1];
        add_quad(mesh, inner(a[0], a[1], half.z), inner(b[0], b[1], half.z),
                 inner(b[0], b[1], floor), inner(a[0], a[1], floor));
        add_quad(mesh, outer(a[0], a[1]), outer(b[0], b[1]), inner(b[0], b[1], half.z),
                 inner(a[0], a[1], half.z));
    }
    return mesh;
}

/// A sphere of triangles whose corners lie on it.
inline TriangleMesh ball_mesh(double radius, int rings) {
    TriangleMesh mesh;
    const auto at = [&](int ring, int step) {
        const double polar = std::numbers::pi * ring / rings,
                     round = std::numbers::pi * (step % (2 * rings)) / rings;
        const double r = ring == 0 || ring == rings ? 0 : std::sin(polar);
        return Vec3{r * std::cos(round), r * std::sin(round), std::cos(polar)} * radius;
    };
    for (int ring = 0; ring < rings; ++ring) {
        for (int step = 0; step < 2 * rings; ++step) {
            add_quad(mesh, at(ring, step), at(ring + 1, step), at(ring + 1, step + 1),
                     at(ring, step + 1));
        }
    }
    return mesh;
}

inline ConvexShape lattice_shape(const TriangleMesh& mesh, double voxel_m, double margin_m = 0) {
    const auto lattice = DistanceLattice::from_mesh(mesh, {voxel_m, margin_m});
    EXPECT_TRUE(lattice) << lattice.error();
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::lattice;
    if (lattice) shape.lattice = *lattice;
    return shape;
}

}  // namespace bsoil
