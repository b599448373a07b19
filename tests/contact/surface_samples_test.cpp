// A body's surface cut into pieces: what they add up to is the surface, whatever the shape.
#include "contact/surface_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bsoil/soil.h"
#include "contact/surface_pieces.h"

namespace bsoil::surface_samples_test {
namespace {

/// Area, the sum of normal times area, and a third of the sum of place times normal times area: the
/// volume.
struct Sums {
    double area_m2 = 0, volume_m3 = 0;
    Vec3 closed_m2;
};
Sums sums_of(const std::vector<ConvexShape>& shapes, double voxel_m) {
    WallShapes walls;
    walls.make(shapes, voxel_m);
    SurfaceSamples surface;
    surface.make(shapes, walls.growth, voxel_m);
    EXPECT_TRUE(surface.is_whole);
    Sums sums;
    for (const SurfaceSample& s : surface.samples) {
        EXPECT_NEAR(length(s.normal), 1, 1e-9);
        sums.area_m2 += s.area_m2;
        sums.closed_m2 += s.area_m2 * s.normal;
        sums.volume_m3 += s.area_m2 * dot(s.at, s.normal) / 3;
    }
    // Every sample is in a cluster's ball.
    size_t counted = 0;
    for (const SampleCluster& cluster : surface.clusters) {
        for (size_t i = cluster.first; i < cluster.last; ++i) {
            EXPECT_LE(length(surface.samples[i].at - cluster.center), cluster.radius_m + 1e-12);
        }
        counted += cluster.last - cluster.first;
    }
    EXPECT_EQ(counted, surface.samples.size());
    return sums;
}

ConvexShape shape(ConvexShape::Kind kind, double radius_m, double half_height_m) {
    ConvexShape out;
    out.kind = kind;
    out.radius_m = radius_m;
    out.half_height_m = half_height_m;
    out.local = {{0.3, -0.2, 0.1}, {0.5, 0.5, 0.5, 0.5}};
    return out;
}
ConvexShape box(Vec3 half_m, Vec3 at_m = {}) {
    ConvexShape out;
    out.half_extents_m = half_m;
    out.local.position = at_m;
    return out;
}

void expect_surface(const ConvexShape& shape, double area_m2, double volume_m3) {
    // Curved faces are flat in each piece: within the square of a piece's angle.
    const Sums found = sums_of({shape}, 0.02);
    EXPECT_NEAR(found.area_m2, area_m2, 0.003 * area_m2);
    EXPECT_NEAR(found.volume_m3, volume_m3, 0.003 * volume_m3);
    EXPECT_LT(length(found.closed_m2), 0.002 * area_m2);
}

TEST(SurfaceSamples, add_up_to_the_surface_of_every_shape) {
    using Kind = ConvexShape::Kind;
    const double r = 0.15, h = 0.2;
    expect_surface(box({0.1, 0.2, 0.3}), 8 * (0.02 + 0.06 + 0.03), 8 * 0.006);
    expect_surface(shape(Kind::sphere, r, 0), 4 * std::numbers::pi * r * r,
                   4 * std::numbers::pi / 3 * r * r * r);
    expect_surface(shape(Kind::cylinder, r, h), 2 * std::numbers::pi * r * (2 * h + r),
                   std::numbers::pi * r * r * 2 * h);
    expect_surface(shape(Kind::capsule, r, h), 2 * std::numbers::pi * r * (2 * h + 2 * r),
                   std::numbers::pi * r * r * (2 * h + 4 * r / 3));
    expect_surface(shape(Kind::capsule, r, 0), 4 * std::numbers::pi * r * r,
                   4 * std::numbers::pi / 3 * r * r * r);
    expect_surface(shape(Kind::cone, r, h), std::numbers::pi * r * (r + std::hypot(r, 2 * h)),
                   std::numbers::pi * r * r * 2 * h / 3);
    // An octahedron, its corners 0.2 m out.
    ConvexShape hull;
    hull.kind = Kind::hull;
    hull.bound_m = 0.2;
    const double n = 1 / std::sqrt(3.0);
    for (int i = 0; i < 8; ++i) {
        hull.planes.push_back(
            {{i & 1 ? n : -n, i & 2 ? n : -n, i & 4 ? n : -n}, 0.2 / std::sqrt(3.0)});
    }
    expect_surface(hull, 4 * std::sqrt(3.0) * 0.04, 4.0 / 3 * 0.008);
}

TEST(SurfaceSamples, leave_out_what_lies_inside_another_part) {
    // Two boxes overlap by half: a box of 0.3 x 0.2 x 0.2.
    const Sums overlap = sums_of({box({0.1, 0.1, 0.1}), box({0.1, 0.1, 0.1}, {0.1, 0, 0})}, 0.02);
    EXPECT_NEAR(overlap.area_m2, 4 * 0.06 + 2 * 0.04, 1e-9);
    EXPECT_NEAR(overlap.volume_m3, 0.012, 1e-9);
    // Two that touch: the faces between them are gone.
    const Sums touching = sums_of({box({0.1, 0.1, 0.1}), box({0.1, 0.1, 0.1}, {0.2, 0, 0})}, 0.02);
    EXPECT_NEAR(touching.area_m2, 4 * 0.08 + 2 * 0.04, 1e-9);
    // A lug on a rim: part of its sides and a strip of the rim are hidden. Pieces that are cut are
    // told by 64 points.
    const Sums lug = sums_of({box({0.2, 0.1, 0.1}), box({0.005, 0.1, 0.03}, {0, 0, 0.12})}, 0.02);
    const double sides = 2 * 0.05 * (0.2 + 0.01), base = 0.8 * 0.2 + 0.8 * 0.2;
    EXPECT_NEAR(lug.area_m2, base + 2 * 0.04 + sides, 0.02 * sides + 0.001);
}

/// Contacts of a turning wheel with lugs after some steps.
std::vector<ContactVoxel> contacts(int thread_count) {
    SoilDef def;
    def.size_m = {1.2, 0.8, 0.64};
    def.up = UpAxis::z;
    def.voxel_m = 0.02;
    def.backend = Backend::cpu;
    def.thread_count = thread_count;
    def.contact_law.faces_by_shape = true;
    auto soil = std::move(*Soil::create(def));
    EXPECT_TRUE(soil->fill(BoxFill{{{-1, -1, 0}, {1, 1, 0.3}}, ""}));
    std::vector<ConvexShape> shapes{shape(ConvexShape::Kind::cylinder, 0.15, 0.1)};
    shapes[0].local = {{}, {std::sin(std::numbers::pi / 4), 0, 0, std::cos(std::numbers::pi / 4)}};
    shapes.push_back(box({0.005, 0.1, 0.03}, {0, 0, 0.15}));
    shapes.push_back(box({0.03, 0.1, 0.005}, {-0.15, 0, 0}));
    SoilBody wheel;
    wheel.shapes = &shapes;
    std::vector<ContactVoxel> out;
    for (int i = 0; i < 20; ++i) {
        const double angle = 0.03 * i;
        wheel.pose = {{0.003 * i, 0, 0.42}, {0, std::sin(angle / 2), 0, std::cos(angle / 2)}};
        wheel.center_of_mass_m = wheel.pose.position;
        wheel.linear_velocity_m_s = {0.18, 0, 0};
        wheel.angular_velocity_rad_s = {0, 1.8, 0};
        const StepReport report = soil->step({&wheel, 1});
        out.assign(report.contacts.begin(), report.contacts.end());
    }
    return out;
}

// A lug that is put against a rim touches it along a line. Rim and lug looked at each other across
// 0.07 voxel at most, and the rim bore there as much as beside the lug.
TEST(SurfaceSamples, leave_out_what_looks_at_another_part_across_a_crack) {
    const double voxel_m = 0.02, one_m2 = 2 * (0.2 * 0.2 + 2 * 0.2 * 0.1);
    const auto apart = [&](double gap_voxels) {
        return std::vector{box({0.1, 0.1, 0.05}),
                           box({0.1, 0.1, 0.05}, {0, 0, 0.1 + gap_voxels * voxel_m})};
    };
    for (const double gap_voxels : {0.01, 0.2, 0.45}) {
        const Sums sums = sums_of(apart(gap_voxels), voxel_m);
        EXPECT_NEAR(sums.area_m2, 2 * (one_m2 - 0.2 * 0.2), 1e-9) << gap_voxels;
        EXPECT_LT(length(sums.closed_m2), 1e-9);
    }
    EXPECT_NEAR(sums_of(apart(0.55), voxel_m).area_m2, 2 * one_m2, 1e-9);
    // Past it, and beside it in one plane, a face stays whole.
    const std::vector beside{box({0.1, 0.1, 0.05}), box({0.1, 0.1, 0.02}, {0.201, 0, -0.03})};
    const double other_m2 = 2 * (0.2 * 0.2 + 2 * 0.2 * 0.04);
    EXPECT_NEAR(sums_of(beside, voxel_m).area_m2, one_m2 + other_m2 - 2 * 0.2 * 0.04,
                0.2 * 0.1 / 64);  // the higher one's side is cut

    ConvexShape rim = shape(ConvexShape::Kind::cylinder, 0.14, 0.08);
    rim.local = {};
    const Sums wheel = sums_of({rim, box({0.03, 0.02, 0.08}, {0.17, 0, 0})}, voxel_m);
    const double under_m2 = 2 * std::asin(0.02 / 0.14) * 0.14 * 0.16;  // of the rim
    EXPECT_NEAR(wheel.area_m2,
                2 * std::numbers::pi * 0.14 * (0.14 + 0.16) - under_m2 +
                    2 * (2 * 0.03 * 0.04 + 0.06 * 0.16) + 0.04 * 0.16,
                0.003 * wheel.area_m2);
}

TEST(SurfaceSamples, contacts_are_the_same_on_any_number_of_threads) {
    const std::vector<ContactVoxel> one = contacts(1), four = contacts(4);
    ASSERT_GT(one.size(), 50u);
    ASSERT_EQ(one.size(), four.size());
    for (size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].area_m2, four[i].area_m2);
        EXPECT_EQ(length(one[i].position_m - four[i].position_m), 0);
        EXPECT_EQ(length(one[i].normal - four[i].normal), 0);
        EXPECT_EQ(one[i].depth_m, four[i].depth_m);
        // Shear displacement goes by the voxel: a sample's share is of its own and the next ones.
        const Vec3 off = one[i].position_m - one[i].center_m;
        EXPECT_LT(std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}), 1.5 * 0.02 + 1e-9);
    }
}

// A face on the border of two voxels has nothing in the third, and a piece without area no normal.
TEST(SurfacePieces, face_on_the_border_of_voxels_is_shared_by_the_two_beside_it) {
    constexpr double kVoxelM = 0.125;  // exact, as its multiples are
    for (const double side : {1.0, -1.0}) {
        SurfaceSamples surface;
        surface.samples = {{.at = {5.5 * kVoxelM, 5.5 * kVoxelM, 5 * kVoxelM},
                            .normal = {0, 0, side},
                            .area_m2 = 0.01}};
        surface.clusters = {{surface.samples[0].at, 0, 0, 1}};
        std::vector<ContactRecord> records(4);
        for (size_t i = 0; i < records.size(); ++i) {
            records[i].voxel[0] = records[i].voxel[1] = 5;
            records[i].voxel[2] = 3 + static_cast<int>(i);
            records[i].gradient = {0, 0, -65536 * side};
        }
        const SampledBody body{&surface, {}};
        SurfacePieces pieces;
        pieces.gather(records, {&body, 1}, {{16, 16, 16}, kVoxelM, {}}, 0.7);
        std::vector<double> areas_m2(records.size(), 0);
        for (size_t i = 0; i < records.size(); ++i) {
            pieces.for_each(i, [&](const SurfacePiece& piece) {
                EXPECT_GT(length(piece.area), 0) << i;
                areas_m2[i] += piece.area_m2;
            });
        }
        EXPECT_EQ(areas_m2, (std::vector<double>{0, 0.005, 0.005, 0})) << side;
    }
}

/// Areas of one sample in 4 x 4 x 4 voxels from `low` on, all with soil that agrees with it.
std::vector<double> areas_of(Vec3 at_voxels, Vec3 normal, int low) {
    constexpr double kVoxelM = 0.125;
    SurfaceSamples surface;
    surface.samples = {{.at = kVoxelM * at_voxels, .normal = normal, .area_m2 = 0.005}};
    surface.clusters = {{surface.samples[0].at, 0, 0, 1}};
    std::vector<ContactRecord> records(64);
    for (int i = 0; i < 64; ++i) {
        ContactRecord& record = records[static_cast<size_t>(i)];
        record.voxel[0] = low + i % 4;
        record.voxel[1] = low + i / 4 % 4;
        record.voxel[2] = low + i / 16;
        record.gradient = -65536 * normal;
    }
    const SampledBody body{&surface, {}};
    SurfacePieces pieces;
    pieces.gather(records, {&body, 1}, {{16, 16, 16}, kVoxelM, {}}, 0.7);
    std::vector<double> areas_m2(records.size(), 0);
    for (size_t i = 0; i < records.size(); ++i) {
        pieces.for_each(i, [&](const SurfacePiece& piece) { areas_m2[i] += piece.area_m2; });
    }
    return areas_m2;
}

// In the corner of eight voxels, and as much along one axis as along another.
TEST(SurfacePieces, rounding_does_not_pick_the_voxels_of_a_face) {
    const double s = std::sqrt(0.5);
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{-1, 0, 0}, Vec3{s, 0, s}, Vec3{0, -s, s}}) {
        const std::vector<double> areas_m2 = areas_of({6, 6, 6}, normal, 4);
        EXPECT_NEAR(std::accumulate(areas_m2.begin(), areas_m2.end(), 0.0), 0.005, 1e-12);
        for (const Vec3 off : {Vec3{1, 1, 1}, Vec3{-1, 1, -1}, Vec3{1, -1, -1}}) {
            const std::vector<double> beside_m2 =
                areas_of(Vec3{6, 6, 6} + 1e-9 * off, normal + 1e-9 * Vec3{off.y, 0, 0}, 4);
            for (size_t i = 0; i < areas_m2.size(); ++i) {
                EXPECT_NEAR(beside_m2[i], areas_m2[i], 1e-6 * 0.005) << i;
            }
        }
    }
}

// A body whose samples one thread takes is put together as it goes, another one bin by bin.
TEST(SurfacePieces, are_the_same_however_many_threads_take_a_body) {
    constexpr double kVoxelM = 0.125;
    constexpr int kMiddle = 8;
    ConvexShape ball;
    ball.kind = ConvexShape::Kind::sphere;
    ball.radius_m = 5.2 * kVoxelM;
    SurfaceSamples one;
    one.make({ball}, std::vector<SheetGrowth>(1), kVoxelM);
    SurfaceSamples many = one;
    one.clusters = {{{}, ball.radius_m, 0, one.samples.size()}};
    many.clusters.clear();
    for (size_t i = 0; i < many.samples.size(); ++i) {
        many.clusters.push_back({many.samples[i].at, 0, i, i + 1});
    }
    std::vector<ContactRecord> records;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        ContactRecord record;
        record.voxel[0] = i % 16;
        record.voxel[1] = i / 16 % 16;
        record.voxel[2] = i / 256;
        const Vec3 off{i % 16 + 0.5 - kMiddle, i / 16 % 16 + 0.5 - kMiddle,
                       i / 256 + 0.5 - kMiddle};
        record.gradient = -65536 * (off * (1 / length(off)));
        if (std::abs(length(off) - 5.2) < 1.2 && off.z < 2) records.push_back(record);
    }
    const auto pieces_of = [&](const SurfaceSamples& surface) {
        const SampledBody body{&surface, {kVoxelM * Vec3{kMiddle, kMiddle, kMiddle}, {}}};
        SurfacePieces pieces;
        pieces.gather(records, {&body, 1}, {{16, 16, 16}, kVoxelM, {}}, 0.7);
        std::vector<double> numbers;
        for (size_t i = 0; i < records.size(); ++i) {
            pieces.for_each(i, [&](const SurfacePiece& piece) {
                for (const Vec3 v : {piece.area, piece.moment, piece.spread}) {
                    numbers.insert(numbers.end(), {v.x, v.y, v.z});
                }
            });
        }
        return numbers;
    };
    const std::vector<double> numbers = pieces_of(one);
    EXPECT_GT(numbers.size(), 9 * records.size() / 2);
    EXPECT_EQ(numbers, pieces_of(many));
}

TEST(SurfacePieces, what_is_beyond_the_grid_is_not_counted) {
    for (const double x : {0.0, 0.1, -0.1, -0.6}) {
        const std::vector<double> areas_m2 = areas_of({x, 2, 2}, {0, 0, 1}, 0);
        const double half = std::sqrt(0.005) / 0.125 / 2;
        EXPECT_NEAR(std::accumulate(areas_m2.begin(), areas_m2.end(), 0.0),
                    0.005 * std::clamp(0.5 + x / (2 * half), 0.0, 1.0), 1e-12)
            << x;
    }
}

// They go by the coverage field. Their pieces would take gigabytes, so they are counted before they
// are made.
TEST(SurfaceSamples, of_bodies_too_large_for_them_are_not_made) {
    ConvexShape hull;
    hull.kind = ConvexShape::Kind::hull;
    hull.bound_m = 900;
    for (const double s : {-1.0, 1.0}) {
        hull.planes.push_back({{s, 0, 0}, 500});
        hull.planes.push_back({{0, s, 0}, 500});
        hull.planes.push_back({{0, 0, s}, 1});
    }
    using Kind = ConvexShape::Kind;
    for (const ConvexShape& huge :
         {box({500, 500, 1}), shape(Kind::sphere, 500, 0), shape(Kind::capsule, 1, 90'000),
          shape(Kind::cylinder, 90'000, 1), shape(Kind::cone, 500, 500), hull}) {
        for (const std::vector<ConvexShape>& shapes : {std::vector{huge}, {box({1, 1, 1}), huge}}) {
            WallShapes walls;
            walls.make(shapes, 0.05);
            SurfaceSamples surface;
            surface.make(shapes, walls.growth, 0.05);
            EXPECT_FALSE(surface.is_whole) << static_cast<int>(huge.kind);
            EXPECT_LE(surface.samples.capacity(), size_t{1} << 19);
        }
    }
}
}  // namespace
}  // namespace bsoil::surface_samples_test
