// Voxelized shapes against the oracle's 16 x 16 x 16 points per voxel.
#include "oracle/coverage.h"

#include <cmath>
#include <numbers>

#include "stage_scenario.h"

namespace bsoil::coverage_test {
namespace {

using namespace layout;

struct ShapeCase {
    const char* name;
    ConvexShape shape;
    double volume_voxels;
};

constexpr double kVoxel = 0.05;

// As many faces as a hull may have, nearly all of them near in each voxel of a column.
ConvexShape prism_shape(double radius_m, double half_height_m) {
    ConvexShape prism;
    prism.kind = ConvexShape::Kind::hull;
    prism.bound_m = std::hypot(1.1 * radius_m, half_height_m);
    const int sides = limits::kHullPlaneCapacity - 2;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        prism.planes.push_back({{std::cos(angle), std::sin(angle), 0}, radius_m});
    }
    prism.planes.push_back({{0, 0, 1}, half_height_m});
    prism.planes.push_back({{0, 0, -1}, half_height_m});
    return prism;
}

std::vector<ShapeCase> shapes() {
    using Kind = ConvexShape::Kind;
    constexpr double kPi = std::numbers::pi;
    std::vector<ShapeCase> cases;
    const auto add = [&](const char* name, ConvexShape shape, double volume) {
        cases.push_back({name, std::move(shape), volume});
    };
    add("box", box_shape(Vec3{4.3, 2.6, 3.2} * kVoxel), 8 * 4.3 * 2.6 * 3.2);
    add("sphere", sphere_shape(4.4 * kVoxel), 4 * kPi / 3 * std::pow(4.4, 3));
    add("capsule", round_shape(Kind::capsule, 2.7 * kVoxel, 2.4 * kVoxel),
        kPi * 2.7 * 2.7 * (4.8 + 4.0 / 3 * 2.7));
    add("cylinder", round_shape(Kind::cylinder, 3.6 * kVoxel, 2.9 * kVoxel), kPi * 3.6 * 3.6 * 5.8);
    add("cone", round_shape(Kind::cone, 4.2 * kVoxel, 3.4 * kVoxel), kPi * 4.2 * 4.2 * 6.8 / 3);
    add("hull", octahedron_shape(5.5 * kVoxel), 4.0 / 3 * std::pow(5.5, 3));
    add("prism", prism_shape(0.9 * kVoxel, 6.4 * kVoxel), 254 * 0.81 * std::tan(kPi / 254) * 12.8);
    ConvexShape rounded = sphere_shape(3.4 * kVoxel);
    rounded.rounding_m = kVoxel;
    add("rounded_sphere", rounded, 4 * kPi / 3 * std::pow(4.4, 3));
    ConvexShape grown = box_shape(Vec3{3.8, 2.1, 2.7} * kVoxel);
    grown.rounding_m = 0.5 * kVoxel;
    add("rounded_box", grown, 8 * 4.3 * 2.6 * 3.2);
    return cases;
}

void PrintTo(const ShapeCase& shape, std::ostream* out) { *out << shape.name; }

ConvexShape in_voxels(ConvexShape shape) {
    shape.half_extents_m = shape.half_extents_m * (1 / kVoxel);
    shape.radius_m /= kVoxel;
    shape.half_height_m /= kVoxel;
    shape.rounding_m /= kVoxel;
    for (Plane& plane : shape.planes) plane.offset /= kVoxel;
    return shape;
}

class Coverage : public testing::TestWithParam<ShapeCase> {
  protected:
    static Mover posed(unsigned seed) {
        std::mt19937 random(seed);
        const auto uniform = [&](double low, double high) {
            return std::uniform_real_distribution(low, high)(random);
        };
        Mover mover(0, GetParam().shape,
                    Vec3{uniform(7.5, 8.5), uniform(7.5, 8.5), uniform(7.5, 8.5)} * kVoxel);
        mover.shapes[0].local.position = Vec3{0.3, -0.2, 0.1} * kVoxel;
        if (seed > 0) {  // seed 0: along the grid
            const Vec3 axis{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            mover.body.pose.rotation = turn(axis * (1 / length(axis)), uniform(0, 3));
        }
        return mover;
    }
    static StatePlanes voxelized(StageBench& bench, unsigned seed) {
        bench.write(bench.empty_planes());
        std::vector<Mover> movers;
        movers.push_back(posed(seed));
        bench.place(movers);
        return bench.read();
    }
    const Scenario scenario_{1, 16, 16, 16, 1};
};

TEST_P(Coverage, follows_the_oracle) {
    StageBench& bench = bench_of(scenario_, Backend::cpu);
    for (unsigned seed = 0; seed < 2; ++seed) {
        const StatePlanes planes = voxelized(bench, seed);
        const Mover mover = posed(seed);
        Pose grid_to_shape = inverse(mover.body.pose * mover.shapes[0].local);
        grid_to_shape.position = grid_to_shape.position * (1 / kVoxel);
        const ConvexShape shape = in_voxels(GetParam().shape);
        Deviation worst;
        double sum = 0, sum_of_squares = 0;
        int surface_count = 0;
        for (int z = 0; z < 16; ++z) {
            for (int y = 0; y < 16; ++y) {
                for (int x = 0; x < 16; ++x) {
                    const double got =
                        planes.at(kPlaneCoverage, x, y, z) / static_cast<double>(kVoxelFull);
                    const double expected = oracle::coverage(shape, grid_to_shape, x, y, z);
                    worst.take(got, expected, x, y, z);
                    sum += got;
                    if (expected > 0 && expected < 1) {
                        sum_of_squares += (got - expected) * (got - expected);
                        ++surface_count;
                    }
                    const int owner = planes.at(kPlaneOwner, x, y, z) & 0xffff;
                    EXPECT_EQ(owner, got > 0 ? 1 : 0);
                }
            }
        }
        // A sub-cell's share is taken as 1/2 - distance, exact for faces along the grid only: at
        // the corner of a box turned by 45 deg it is off by up to 0.1 of a sub-cell, and a voxel
        // has 16 of them on a face. The oracle's own points resolve 1/16 of a voxel: 1/32 on a face
        // along the grid.
        EXPECT_LT(worst.value, 0.035) << GetParam().name << " seed " << seed << " " << worst;
        EXPECT_LT(std::sqrt(sum_of_squares / surface_count), 0.02);
        // Errors of single voxels have both signs; edges lose a little.
        EXPECT_NEAR(sum / GetParam().volume_voxels, 1, 0.01);
    }
}

TEST_P(Coverage, has_the_same_bits_on_gl) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    for (unsigned seed = 0; seed < 3; ++seed) {
        EXPECT_TRUE(voxelized(bench_of(scenario_, Backend::cpu), seed) ==
                    voxelized(bench_of(scenario_, Backend::gl), seed));
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Coverage, testing::ValuesIn(shapes()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::coverage_test
