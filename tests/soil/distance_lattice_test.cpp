// Solids from meshes and from distance functions against solids known exactly.
#include "bsoil/distance_lattice.h"

#include <limits>
#include <random>

#include "bsoil/limits.h"
#include "mesh_solids.h"
#include "stage_scenario.h"

namespace bsoil::distance_lattice_test {
namespace {

using namespace layout;

constexpr double kVoxel = 0.05;

Vec3 point_in(std::mt19937& random, Vec3 half) {
    std::uniform_real_distribution<double> u(-1, 1);
    return {half.x * u(random), half.y * u(random), half.z * u(random)};
}

double box_distance(Vec3 half, Vec3 p) {
    const Vec3 q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
    return length(Vec3{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)}) +
           std::min(0.0, std::max({q.x, q.y, q.z}));
}

Quat random_turn(std::mt19937& random) {
    std::normal_distribution<double> g;
    const Vec3 axis{g(random), g(random), g(random)};
    return turn(axis * (1 / length(axis)), std::uniform_real_distribution(0.0, 3.0)(random));
}

TEST(DistanceLattice, of_a_box_mesh_is_the_distance_to_the_box) {
    const Vec3 half{0.31, 0.22, 0.43};
    const auto lattice = DistanceLattice::from_mesh(box_mesh(half), {kVoxel});
    ASSERT_TRUE(lattice) << lattice.error();
    std::mt19937 random(1);
    double worst_flat = 0, worst = 0;
    for (int i = 0; i < 40000; ++i) {
        const Vec3 p = point_in(random, 1.4 * half);
        const double expected =
            std::clamp(box_distance(half, p), -(*lattice)->far_m(), (*lattice)->far_m());
        const double off = std::abs((*lattice)->distance_m(p) - expected);
        worst = std::max(worst, off);
        // All corners of the cell see one face alone and are near enough to it.
        const double s = (*lattice)->spacing_m();
        const bool is_flat = (std::abs(p.x) < half.x - 4 * s) + (std::abs(p.y) < half.y - 4 * s) +
                                     (std::abs(p.z) < half.z - 4 * s) ==
                                 2 &&
                             std::abs(expected) < 0.5 * s;
        if (is_flat) worst_flat = std::max(worst_flat, off);
    }
    EXPECT_LT(worst_flat, 1e-4 * kVoxel);
    EXPECT_LT(worst, 0.5 * (*lattice)->spacing_m());
}

TEST(DistanceLattice, thick_solids_do_not_grow) {
    const auto ball = DistanceLattice::from_mesh(ball_mesh(0.3, 24), {kVoxel});
    ASSERT_TRUE(ball) << ball.error();
    std::mt19937 random(2);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = point_in(random, {0.36, 0.36, 0.36});
        const double expected = length(p) - 0.3;
        if (std::abs(expected) < 0.5 * kVoxel) {
            // The facets cut up to 2 r (1 - cos(pi / 48)) = 1.3 mm off, interpolation of a sphere's
            // distance adds spacing^2 / (4 r) = 0.5 mm.
            ASSERT_NEAR((*ball)->distance_m(p), expected, 0.0018) << p.x << " " << p.y;
        }
    }
}

TEST(DistanceLattice, winding_of_triangles_does_not_matter) {
    const Vec3 half{0.31, 0.22, 0.43};
    TriangleMesh mesh = box_mesh(half);
    TriangleMesh inside_out = mesh, mixed = mesh;
    for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
    for (size_t i = 0; i < mixed.triangles.size(); i += 3) {
        std::swap(mixed.triangles[i][0], mixed.triangles[i][1]);
    }
    const auto expected = DistanceLattice::from_mesh(mesh, {kVoxel});
    ASSERT_TRUE(expected);
    for (const TriangleMesh& turned : {inside_out, mixed}) {
        const auto lattice = DistanceLattice::from_mesh(turned, {kVoxel});
        ASSERT_TRUE(lattice);
        ASSERT_EQ((*lattice)->words().size(), (*expected)->words().size());
        EXPECT_TRUE(std::equal((*lattice)->words().begin(), (*lattice)->words().end(),
                               (*expected)->words().begin()));
    }
}

TEST(DistanceLattice, cavities_are_hollow_and_overlapping_parts_one_solid) {
    TriangleMesh hollow = box_mesh({0.5, 0.5, 0.5});
    TriangleMesh inner = box_mesh({0.3, 0.3, 0.3});
    for (auto& t : inner.triangles) std::swap(t[0], t[1]);
    const int first = static_cast<int>(hollow.vertices.size());
    for (const Vec3 v : inner.vertices) hollow.vertices.push_back(v);
    for (const auto& t : inner.triangles) {
        hollow.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    TriangleMesh cross;
    add_box(cross, {-0.5, -0.2, -0.2}, {0.5, 0.2, 0.2});
    add_box(cross, {-0.2, -0.5, -0.2}, {0.2, 0.5, 0.2});
    const auto shell = DistanceLattice::from_mesh(hollow, {kVoxel});
    const auto plus = DistanceLattice::from_mesh(cross, {kVoxel});
    ASSERT_TRUE(shell);
    ASSERT_TRUE(plus);
    std::mt19937 random(3);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = point_in(random, {0.6, 0.6, 0.6});
        const double in_shell =
            std::max(box_distance({0.5, 0.5, 0.5}, p), -box_distance({0.3, 0.3, 0.3}, p));
        const double in_plus =
            std::min(box_distance({0.5, 0.2, 0.2}, p), box_distance({0.2, 0.5, 0.2}, p));
        // Edges are rounded by up to a quarter of the spacing of half a voxel.
        constexpr double kEdge = 0.15 * kVoxel;
        if (std::abs(in_shell) > kEdge) {
            ASSERT_EQ((*shell)->distance_m(p) < 0, in_shell < 0);
        }
        if (std::abs(in_plus) > kEdge) {
            ASSERT_EQ((*plus)->distance_m(p) < 0, in_plus < 0) << p.x << " " << p.y << " " << p.z;
        }
    }
    // Buried faces are no surface: no voxel inside is covered in part.
    EXPECT_NEAR((*plus)->distance_m({0.2, 0.01, 0.02}), -(*plus)->far_m(), 1e-9);
}

TEST(DistanceLattice, of_a_thin_box_is_thickened_to_a_wall_between_its_rims) {
    const double half_wall = 0.5 * limits::kThinnestWallVoxels * kVoxel;
    for (const double thin : {0.0, 0.002, 0.005, 0.02, half_wall - 1e-3}) {
        const Vec3 half{0.4, 0.3, thin};
        const auto lattice = DistanceLattice::from_mesh(box_mesh(half), {kVoxel});
        ASSERT_TRUE(lattice) << lattice.error();
        const Vec3 grown{0.4, 0.3, half_wall};
        std::mt19937 random(4);
        int judged = 0;
        for (int i = 0; i < 40000; ++i) {
            const Vec3 p = point_in(random, {0.5, 0.4, 0.12});
            const double expected = box_distance(grown, p);
            // Without thickness there is no rim face: the sheet's two faces meet, and the rim is
            // rounded, half a wall beyond them.
            const bool at_rim = std::abs(p.x) > half.x - 0.03 || std::abs(p.y) > half.y - 0.03;
            if ((thin == 0 && at_rim) ||
                std::abs(expected) < (at_rim ? 0.3 * kVoxel : 0.02 * kVoxel)) {
                continue;
            }
            ++judged;
            ASSERT_EQ((*lattice)->distance_m(p) < 0, expected < 0)
                << thin << ": " << p.x << " " << p.y << " " << p.z << " "
                << (*lattice)->distance_m(p) << " " << expected;
        }
        EXPECT_GT(judged, 10000);
    }
}

TEST(DistanceLattice, of_a_sheet_is_a_plate_with_its_rim_in_place) {
    TriangleMesh sheet;
    add_quad(sheet, {-0.4, -0.3, 0}, {0.4, -0.3, 0}, {0.4, 0.3, 0}, {-0.4, 0.3, 0});
    const auto lattice = DistanceLattice::from_mesh(sheet, {kVoxel});
    ASSERT_TRUE(lattice);
    const Vec3 plate{0.4, 0.3, 0.5 * limits::kThinnestWallVoxels * kVoxel};
    std::mt19937 random(5);
    for (int i = 0; i < 40000; ++i) {
        const Vec3 p = point_in(random, {0.5, 0.4, 0.12});
        const double expected = box_distance(plate, p);
        if (std::abs(expected) > 0.15 * kVoxel) {
            ASSERT_EQ((*lattice)->distance_m(p) < 0, expected < 0)
                << p.x << " " << p.y << " " << p.z << " " << (*lattice)->distance_m(p);
        }
    }
}

TEST(DistanceLattice, plates_with_a_face_left_out_are_as_thick_as_whole_ones) {
    // A shell of two faces, 20 mm apart. As an open sheet each of them would be a plate of its own.
    const TriangleMesh whole = thick_bucket({0.4, 0.35, 0.3}, 0.02);
    const auto expected = DistanceLattice::from_mesh(whole, {kVoxel});
    ASSERT_TRUE(expected);
    std::mt19937 random(13);
    for (size_t t = 0; t < whole.triangles.size(); ++t) {
        TriangleMesh gap = whole;
        gap.triangles.erase(gap.triangles.begin() + static_cast<std::ptrdiff_t>(t));
        const auto lattice = DistanceLattice::from_mesh(gap, {kVoxel});
        ASSERT_TRUE(lattice);
        int judged = 0, off = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3 p = point_in(random, {0.5, 0.45, 0.4});
            const double d = (*expected)->distance_m(p);
            if (std::abs(d) > 0.02) continue;
            ++judged;
            off += std::abs((*lattice)->distance_m(p) - d) > 0.1 * kVoxel ? 1 : 0;
        }
        // Edges are round, and cut elsewhere. Plates around each face would lie 0.2 voxels off.
        EXPECT_GT(judged, 200);
        EXPECT_LT(off, judged / 20) << "triangle " << t;
    }
    // A pipe that is wider than a wall is thick stays open, however small its ends are.
    TriangleMesh pipe;
    const double r = 0.15;
    const Vec3 corners[4] = {{r, r, 0}, {-r, r, 0}, {-r, -r, 0}, {r, -r, 0}};
    for (int k = 0; k < 4; ++k) {
        const Vec3 a = corners[k], b = corners[(k + 1) % 4];
        add_quad(pipe, a, b, b + Vec3{0, 0, 4}, a + Vec3{0, 0, 4});
    }
    const auto open = DistanceLattice::from_mesh(pipe, {kVoxel});
    ASSERT_TRUE(open);
    EXPECT_GT((*open)->distance_m({0, 0, 2}), 0);
    EXPECT_LT((*open)->distance_m({r, 0, 2}), 0);
}

TEST(DistanceLattice, margin_moves_the_surface_out) {
    const Vec3 half{0.31, 0.22, 0.43};
    const auto lattice = DistanceLattice::from_mesh(box_mesh(half), {kVoxel, 0.04});
    ASSERT_TRUE(lattice);
    std::mt19937 random(6);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = point_in(random, 1.4 * half);
        const double expected = box_distance(half, p) - 0.04;
        if (std::abs(expected) < 0.02) {
            ASSERT_NEAR((*lattice)->distance_m(p), expected, 0.15 * kVoxel);  // corners are round
        }
    }
}

TEST(DistanceLattice, of_a_function_is_the_function_near_its_surface) {
    const auto torus = [](Vec3 p) { return std::hypot(std::hypot(p.x, p.y) - 0.4, p.z) - 0.15; };
    const auto lattice = DistanceLattice::from_distance(
        torus, {{-0.55, -0.55, -0.15}, {0.55, 0.55, 0.15}}, {kVoxel});
    ASSERT_TRUE(lattice);
    std::mt19937 random(7);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = point_in(random, {0.6, 0.6, 0.2});
        const double expected = torus(p);
        if (std::abs(expected) < 0.5 * kVoxel) {
            ASSERT_NEAR((*lattice)->distance_m(p), expected, 0.002);
            const DistanceLattice::Face face = (*lattice)->nearest_face(p);
            const Vec3 ring = Vec3{p.x, p.y, 0} * (0.4 / std::hypot(p.x, p.y));
            ASSERT_GT(dot(face.normal, p - ring), 0.98 * length(p - ring));
        } else {
            ASSERT_EQ((*lattice)->distance_m(p) < 0, expected < 0);
        }
    }
}

TEST(DistanceLattice, nearest_faces_are_those_of_the_box) {
    const Vec3 half{0.31, 0.22, 0.43};
    const auto lattice = DistanceLattice::from_mesh(box_mesh(half), {kVoxel});
    ASSERT_TRUE(lattice);
    std::mt19937 random(8);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 p = point_in(random, 1.2 * half);
        const Vec3 q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
        const double highest = std::max({q.x, q.y, q.z});
        const DistanceLattice::Face face = (*lattice)->nearest_face(p);
        ASSERT_NEAR(face.distance_m, highest, 1e-9);
        ASSERT_NEAR(length(face.normal), 1, 1e-9);
        const double along = std::abs(face.normal.x) * q.x + std::abs(face.normal.y) * q.y +
                             std::abs(face.normal.z) * q.z;
        ASSERT_NEAR(along, highest, 1e-9);
        ASSERT_GT(dot(face.normal, p), 0);
    }
}

TEST(DistanceLattice, region_cuts_a_large_mesh) {
    const LatticeDef def{kVoxel, 0, {{-1, -1, -1}, {1, 1, 1}}};
    const auto lattice = DistanceLattice::from_mesh(
        [] {
            TriangleMesh ground;
            add_box(ground, {-900, -900, -900}, {900, 900, 0.2});
            return ground;
        }(),
        def);
    ASSERT_TRUE(lattice) << lattice.error();
    EXPECT_LT((*lattice)->memory_bytes(), 1 << 20);
    std::mt19937 random(9);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 p = point_in(random, {1, 1, 1});
        ASSERT_EQ((*lattice)->distance_m(p) < 0, p.z < 0.2);
    }
}

TEST(DistanceLattice, spacing_grows_with_size_and_then_creation_fails) {
    TriangleMesh large, huge;
    add_box(large, {0, 0, 0}, {30, 30, 10});
    add_box(huge, {0, 0, 0}, {400, 400, 400});
    const auto lattice = DistanceLattice::from_mesh(large, {kVoxel});
    ASSERT_TRUE(lattice) << lattice.error();
    EXPECT_GT((*lattice)->spacing_m(), 0.6 * kVoxel);
    EXPECT_LE((*lattice)->memory_bytes(), int64_t{64} << 20);
    const auto refused = DistanceLattice::from_mesh(huge, {kVoxel});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("MiB"), std::string::npos) << refused.error();
}

TEST(DistanceLattice, refuses_broken_meshes_by_what_is_wrong) {
    const auto refuse = [](const TriangleMesh& mesh, const LatticeDef& def, const char* mention) {
        const auto lattice = DistanceLattice::from_mesh(mesh, def);
        ASSERT_FALSE(lattice) << mention;
        EXPECT_NE(lattice.error().find(mention), std::string::npos) << lattice.error();
    };
    const TriangleMesh box = box_mesh({0.3, 0.3, 0.3});
    TriangleMesh mesh;
    refuse(mesh, {kVoxel}, "no triangles");
    mesh = box;
    mesh.vertices[5].y = std::numeric_limits<double>::quiet_NaN();
    refuse(mesh, {kVoxel}, "vertex 5");
    mesh = box;
    mesh.vertices[7].x = 2e5;
    refuse(mesh, {kVoxel}, "vertex 7");
    mesh = box;
    mesh.triangles[3][1] = 24;
    refuse(mesh, {kVoxel}, "triangle 3 has vertex index 24, must be 0 to 23");
    mesh.triangles[3][1] = -1;
    refuse(mesh, {kVoxel}, "vertex index -1");
    mesh = {{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}}};
    refuse(mesh, {kVoxel}, "no area");
    mesh = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}};
    refuse(mesh, {kVoxel}, "no area");
    refuse(box, {0}, "voxel_m");
    refuse(box, {kVoxel, -1}, "margin_m");
    refuse(box, {kVoxel, 0, {{5, 5, 5}, {6, 6, 6}}}, "region");
    refuse(box, {kVoxel, 0, {{5, 5, 5}, {4, 6, 6}}}, "region");
    const auto nan = DistanceLattice::from_distance(
        [](Vec3) { return std::numeric_limits<double>::quiet_NaN(); }, {{0, 0, 0}, {1, 1, 1}},
        {kVoxel});
    ASSERT_FALSE(nan);
    EXPECT_NE(nan.error().find("not a number"), std::string::npos) << nan.error();
}

// --- in the soil

StatePlanes voxelized(StageBench& bench, const ConvexShape& shape, const Pose& pose) {
    bench.write(bench.empty_planes());
    std::vector<Mover> movers;
    movers.emplace_back(0, shape, pose.position);
    movers.back().body.pose.rotation = pose.rotation;
    bench.place(movers);
    return bench.read();
}

Pose random_pose_in(std::mt19937& random, double middle) {
    std::uniform_real_distribution<double> u(middle - 0.5, middle + 0.5);
    return {Vec3{u(random), u(random), u(random)} * kVoxel, random_turn(random)};
}

TEST(DistanceLattice, mesh_box_covers_what_the_box_covers) {
    const Scenario scenario{1, 16, 16, 16, 1};
    const Vec3 half = Vec3{4.3, 2.6, 3.2} * kVoxel;
    const ConvexShape mesh = lattice_shape(box_mesh(half), kVoxel), box = box_shape(half);
    StageBench& bench = bench_of(scenario, Backend::cpu);
    std::mt19937 random(10);
    for (int k = 0; k < 4; ++k) {
        const Pose pose = random_pose_in(random, 8);
        const StatePlanes got = voxelized(bench, mesh, pose);
        const StatePlanes expected = voxelized(bench, box, pose);
        double worst = 0, sum = 0;
        for (int z = 0; z < 16; ++z) {
            for (int y = 0; y < 16; ++y) {
                for (int x = 0; x < 16; ++x) {
                    const double a = got.at(kPlaneCoverage, x, y, z) / 65536.0,
                                 b = expected.at(kPlaneCoverage, x, y, z) / 65536.0;
                    worst = std::max(worst, std::abs(a - b));
                    sum += a;
                }
            }
        }
        // An edge rounded over a cell of half a voxel takes up to a tenth of a voxel off it.
        EXPECT_LT(worst, 0.1);
        EXPECT_NEAR(sum / (8 * 4.3 * 2.6 * 3.2), 1, 0.01);
    }
}

TEST(DistanceLattice, covers_with_the_same_bits_on_gl) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    const Scenario scenario{1, 16, 16, 16, 1};
    std::mt19937 random(11);
    const ConvexShape shapes[] = {
        lattice_shape(box_mesh(Vec3{4.3, 2.6, 3.2} * kVoxel), kVoxel),
        lattice_shape(ball_mesh(4 * kVoxel, 12), kVoxel),
        lattice_shape(open_bucket(Vec3{4, 3, 2.5} * kVoxel), kVoxel),
        lattice_shape(thick_bucket(Vec3{4, 3, 2.5} * kVoxel, 0.01), kVoxel, 0.005)};
    for (const ConvexShape& shape : shapes) {
        const Pose pose = random_pose_in(random, 8);
        EXPECT_TRUE(voxelized(bench_of(scenario, Backend::cpu), shape, pose) ==
                    voxelized(bench_of(scenario, Backend::gl), shape, pose));
    }
}

/// Whether a way over faces, edges or corners of voxels open to flow leads from the first to the
/// second.
bool leaks(const StatePlanes& planes, const int from[3], const int to[3]) {
    const int n[3] = {planes.nx, planes.ny, planes.nz};
    std::vector<char> seen(static_cast<size_t>(n[0] * n[1] * n[2]), 0);
    std::vector<std::array<int, 3>> queue{{from[0], from[1], from[2]}};
    while (!queue.empty()) {
        const auto v = queue.back();
        queue.pop_back();
        if (v[0] == to[0] && v[1] == to[1] && v[2] == to[2]) return true;
        for (int d = 0; d < 27; ++d) {
            const int x = v[0] + d % 3 - 1, y = v[1] + d / 3 % 3 - 1, z = v[2] + d / 9 - 1;
            if (x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2]) continue;
            char& mark = seen[static_cast<size_t>((z * n[1] + y) * n[0] + x)];
            if (mark == 0 && planes.at(kPlaneCoverage, x, y, z) < kSolidCoverage) {
                mark = 1;
                queue.push_back({x, y, z});
            }
        }
    }
    return false;
}

TEST(DistanceLattice, thin_walls_have_no_holes_whichever_way_they_are_turned) {
    // Closed boxes of thin plate with room for a few voxels inside: nothing gets in or out.
    const Scenario scenario{1, 24, 16, 24, 3};
    StageBench& bench = bench_of(scenario, Backend::cpu);
    const Vec3 half = Vec3{4.6, 4.2, 4.4} * kVoxel;
    const double plate = 0.01;
    TriangleMesh closed = box_mesh(half);  // two closed surfaces, the inner one inside out
    const TriangleMesh sheets = [&] {
        TriangleMesh open = open_bucket(half);
        add_quad(open, {-half.x, -half.y, half.z}, {half.x, -half.y, half.z},
                 {half.x, half.y, half.z - 1e-6}, {-half.x, half.y, half.z});
        return open;
    }();
    const TriangleMesh inner = box_mesh(half - Vec3{plate, plate, plate});
    const int first = static_cast<int>(closed.vertices.size());
    for (const Vec3 v : inner.vertices) closed.vertices.push_back(v);
    for (const auto& t : inner.triangles) {
        closed.triangles.push_back({t[1] + first, t[0] + first, t[2] + first});
    }
    TriangleMesh plates;  // six thin boxes that overlap at the edges
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            Vec3 low = -half, high = half;
            double& l = axis == 0 ? low.x : axis == 1 ? low.y : low.z;
            double& h = axis == 0 ? high.x : axis == 1 ? high.y : high.z;
            (side < 0 ? h : l) = side * ((axis == 0   ? half.x
                                          : axis == 1 ? half.y
                                                      : half.z) -
                                         plate);
            add_box(plates, low, high);
        }
    }
    std::mt19937 random(12);
    for (const TriangleMesh& mesh : {closed, sheets, plates}) {
        const ConvexShape shape = lattice_shape(mesh, kVoxel);
        for (int k = 0; k < 12; ++k) {
            std::uniform_real_distribution<double> u(-0.5, 0.5);
            const Pose pose{Vec3{12 + u(random), 8 + u(random), 12 + u(random)} * kVoxel,
                            k == 0 ? Quat{} : random_turn(random)};
            const StatePlanes planes = voxelized(bench, shape, pose);
            const int inside[3] = {static_cast<int>(pose.position.x / kVoxel),
                                   static_cast<int>(pose.position.y / kVoxel),
                                   static_cast<int>(pose.position.z / kVoxel)};
            const int outside[3] = {0, 0, 0};
            EXPECT_EQ(planes.at(kPlaneCoverage, inside[0], inside[1], inside[2]), 0);
            EXPECT_FALSE(leaks(planes, inside, outside)) << "turn " << k;
        }
    }
}

double mass_in(const Soil& soil, Vec3 half, Vec3 position) {
    return soil.mass_inside_kg(box_shape(half), {position, {}});
}

TEST(DistanceLattice, bucket_holds_the_soil_poured_into_it) {
    const Vec3 half = Vec3{6.2, 5.7, 5.3} * kVoxel;
    for (const TriangleMesh& mesh : {open_bucket(half), thick_bucket(half, 0.01)}) {
        auto soil = make_soil(grid_def(32, 32, 32));
        ASSERT_TRUE(soil);
        const Vec3 middle = Vec3{16.3, 15.8, 10.4} * kVoxel;
        std::vector<Mover> movers;
        movers.emplace_back(0, lattice_shape(mesh, kVoxel), middle, true);
        ASSERT_TRUE(soil->step(bodies_of(movers)).status_bits == 0);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {12, 12, 18}, {20, 20, 24})));
        const double poured = soil->totals().mass_kg[0];
        ASSERT_GT(poured, 0);
        for (int i = 0; i < 150; ++i) soil->step(bodies_of(movers));
        EXPECT_EQ(soil->totals().mass_kg[0], poured);
        // All of it lies between the walls, above the floor.
        EXPECT_NEAR(mass_in(*soil, half + Vec3{0, 0, kVoxel}, middle), poured, 1e-9 * poured);
        EXPECT_GT(soil->sample(16, 15, 7).volume, 0.9);
    }
}

}  // namespace
}  // namespace bsoil::distance_lattice_test
