// Of a piece of a body's surface that the surface of the soil cuts, what lies below it bears.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "soil_fixture.h"

namespace bsoil::cut_pieces_test {
namespace {

constexpr double kVoxelM = 0.05, kBedM = 0.4;

/// Sum of depth times area times normal of a body in a level bed [m3].
Vec3 buoyancy_m3(const ConvexShape& shape, const Pose& pose) {
    SoilDef def = grid_def(24, 24, 16, kVoxelM);
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(BoxFill{{{-9, -9, -9}, {9, 9, kBedM}}, "dry_sand"}));
    std::vector<Mover> movers;
    movers.emplace_back(0, shape, pose.position);
    movers[0].body.pose.rotation = pose.rotation;
    const std::vector<SoilBody> bodies = bodies_of(movers);
    Vec3 sum;
    for (const ContactVoxel& v : soil->step(bodies).contacts) {
        sum += v.depth_m * v.area_m2 * v.normal;
    }
    return sum;
}

// On an edge, a corner or a ball's lowest point no middle of a piece may be in the soil yet.
TEST(CutPieces, displace_what_of_them_is_in_the_soil) {
    struct Case {
        const char* name;
        ConvexShape shape;
        Quat turned;
        double lowest_m;                              ///< below the middle
        std::function<double(double deep_m)> volume;  ///< of what lies lower than that
        double error;                                 ///< of it, at most
    };
    const double half_m = 0.03, sixth = 1.0 / 6;
    const auto ball = [](double r) {
        return [r](double d) { return std::numbers::pi * d * d * (r - d / 3); };
    };
    const Case cases[] = {
        {"ball of two voxels", sphere_shape(0.055), {}, 0.055, ball(0.055), 0.2},
        {"ball of three voxels", sphere_shape(0.08), {}, 0.08, ball(0.08), 0.2},
        {"cube on an edge", box_shape({half_m, half_m, half_m}),
         turn({1, 0, 0}, std::numbers::pi / 4), half_m * std::numbers::sqrt2,
         [=](double d) { return d * d * 2 * half_m; }, 0.15},
        {"cube on a corner", box_shape({half_m, half_m, half_m}),
         turn({std::numbers::sqrt2 / 2, -std::numbers::sqrt2 / 2, 0},
              std::atan(std::numbers::sqrt2)),
         half_m * std::numbers::sqrt3,
         [=](double d) { return sixth * 3 * std::numbers::sqrt3 * d * d * d; }, 0.4},
    };
    for (const Case& it : cases) {
        SCOPED_TRACE(it.name);
        for (const double deep_m : {0.008, 0.012, 0.016}) {
            SCOPED_TRACE(deep_m);
            const Vec3 found_m3 =
                buoyancy_m3(it.shape, {{0.61, 0.58, kBedM + it.lowest_m - deep_m}, it.turned});
            const double wanted_m3 = it.volume(deep_m);
            EXPECT_NEAR(-found_m3.z, wanted_m3, it.error * wanted_m3);
            EXPECT_NEAR(found_m3.x, 0, 0.25 * wanted_m3);
        }
    }
}

// What of a leaning piece looks along each axis of the grid goes to voxels of its own. In no grid
// do parts lie where the piece is not: the sum is one, whatever way the plate looks.
TEST(CutPieces, of_a_plate_that_leans_are_where_it_is) {
    const ConvexShape plate = box_shape({0.02, 0.2, 0.2});
    for (const double lean : {0.02, 0.1, 0.4}) {
        SCOPED_TRACE(lean);
        std::vector<double> found_m3;
        double sum_m3 = 0;
        for (const double turned : {0.0, 0.3, 0.6, std::numbers::pi / 4}) {
            const Pose pose{{0.61, 0.58, kBedM + 0.05},
                            turn({0, 0, 1}, turned) * turn({0, 1, 0}, lean)};
            found_m3.push_back(-buoyancy_m3(plate, pose).z);
            sum_m3 += found_m3.back();
        }
        const double mean_m3 = sum_m3 / static_cast<double>(found_m3.size());
        for (const double each_m3 : found_m3) EXPECT_NEAR(each_m3, mean_m3, 0.15 * mean_m3);
        // 15 cm of its height are in the soil, and what it has pressed aside stands beside it.
        EXPECT_NEAR(mean_m3, 0.04 * 0.4 * 0.15, 0.25 * 0.04 * 0.4 * 0.15);
    }
}

}  // namespace
}  // namespace bsoil::cut_pieces_test
