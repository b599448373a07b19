// Soil does not leak through a thin moving plate.
#include <numbers>

#include "soil_fixture.h"

namespace bsoil::plate_test {
namespace {

using namespace layout;

/// Mass units in front of (0) and behind (1) the middle plane of a plate.
std::array<int64_t, 2> sides_of(Soil& soil, const SoilBody& plate) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    const Vec3 normal = rotate(plate.pose.rotation, {1, 0, 0});
    std::array<int64_t, 2> sides{0, 0};
    TileVoxels voxels;
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (!impl.tiles[index]) continue;
        impl.tiles.read_voxels(static_cast<int>(index), voxels);
        for (int z = 0; z < impl.height; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                const Vec3 at = impl.frame.to_world(
                    {static_cast<int>(index) % impl.tiles_x * 8 + c % 8 + 0.5,
                     static_cast<int>(index) / impl.tiles_x * 8 + c / 8 + 0.5, z + 0.5});
                sides[dot(at - plate.pose.position, normal) >= 0 ? 0 : 1] +=
                    voxels.at(kKeptMaterial, z, c);
            }
        }
    }
    return sides;
}

struct PlateCase {
    const char* name;
    double voxels_a_step;
    double radians_a_step;
    double yaw_rad;
    bool soil_behind;
};
void PrintTo(const PlateCase& c, std::ostream* out) { *out << c.name; }

class Plate : public testing::TestWithParam<PlateCase> {};

// A plate 2 voxels thick, wider and higher than the grid, through a bed 6 voxels deep.
TEST_P(Plate, keeps_the_soil_on_its_side) {
    const PlateCase& plate_case = GetParam();
    auto soil = make_soil(grid_def(64, 24, 24));
    const double voxel = 0.05, step = 1.0 / 60;
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{1, 60, 40} * voxel), Vec3{18, 12, 12} * voxel);
    movers[0].body.pose.rotation = turn({0, 0, 1}, plate_case.yaw_rad);
    movers[0].set_velocity(Vec3{plate_case.voxels_a_step, 0, 0} * (voxel / step),
                           {0, 0, plate_case.radians_a_step / step});
    const Vec3 normal = rotate(movers[0].body.pose.rotation, {1, 0, 0});
    const auto fill_side = [&](double sign) {
        return soil->fill(FunctionFill{
            [&, sign](Vec3 at) {
                const double ahead = sign * dot(at - movers[0].body.pose.position, normal);
                return ahead > 1.6 * voxel && at.z < 6 * voxel ? 1.0 : -1.0;
            },
            {}});
    };
    ASSERT_TRUE(fill_side(1));
    if (plate_case.soil_behind) {
        ASSERT_TRUE(fill_side(-1));
    }
    soil->step(bodies_of(movers));
    const std::array<int64_t, 2> before = sides_of(*soil, movers[0].body);
    ASSERT_EQ(before[1] > 0, plate_case.soil_behind);
    for (int s = 0; s < 24; ++s) {
        movers[0].advance(step);
        soil->step(bodies_of(movers));
        const std::array<int64_t, 2> now = sides_of(*soil, movers[0].body);
        ASSERT_EQ(now[0] + now[1], before[0] + before[1]);
        // What the plate runs over stands in its front voxels until it is pushed on, within a step
        // or two.
        EXPECT_LE(static_cast<double>(std::abs(now[1] - before[1])),
                  0.002 * static_cast<double>(before[0]))
            << "step " << s + 1;
    }
}

INSTANTIATE_TEST_SUITE_P(Motions, Plate,
                         testing::Values(PlateCase{"along_the_grid", 1, 0, 0, false},
                                         PlateCase{"askew", 1, 0, 0.5, false},
                                         PlateCase{"slowly", 0.3, 0, 0.2, false},
                                         PlateCase{"turning", 0.3, 0.03, 0, true},
                                         PlateCase{"with_soil_behind", 1, 0, 0, true}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::plate_test
