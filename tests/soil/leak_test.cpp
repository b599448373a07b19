// Walls hold soil back, whatever their thickness and motion: units of soil that come out on the far
// side.
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "mesh_solids.h"
#include "soil_fixture.h"

namespace bsoil::leak_test {
namespace {

using namespace layout;

constexpr double kVoxel = 0.05, kStep = 1.0 / 60;

/// Mass units of which `far` says that their voxel's middle (world) is on the wrong side, and of
/// all.
template <typename Far>
std::array<int64_t, 2> count_units(Soil& soil, Far&& far) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    std::array<int64_t, 2> units{0, 0};
    TileVoxels voxels;
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (!impl.tiles[index]) continue;
        const int tile = static_cast<int>(index);
        impl.tiles.read_voxels(tile, voxels);
        for (int z = 0; z < impl.height; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                const int64_t mass = voxels.at(kKeptMaterial, z, c);
                if (mass > 0) {
                    const Vec3 at = impl.frame.to_world(
                        {tile % impl.tiles_x * kTileSide + c % kTileSide + 0.5,
                         tile / impl.tiles_x * kTileSide + c / kTileSide + 0.5, z + 0.5});
                    units[0] += far(at) ? mass : 0;
                    units[1] += mass;
                }
            }
        }
    }
    return units;
}

struct WallMotion {
    const char* name;
    Vec3 voxels_a_step;  ///< along the wall's normal, along it level, along it upwards
    Vec3 turn_a_step;    ///< radians, world axes
    int step_count;
};

struct WallCase {
    double thickness;   ///< voxels
    double yaw, pitch;  ///< radians; pitch > 0: the wall leans over the soil
    WallMotion motion;
};

std::string name_of(const WallCase& c) {
    const auto tenths = [](double v) { return std::to_string(std::lround(v * 10)); };
    return std::string(c.motion.name) + "_thick_" + tenths(c.thickness) + "_yaw_" +
           std::to_string(std::lround(c.yaw * 180 / std::numbers::pi)) + "_pitch_" +
           (c.pitch < 0 ? "minus_" : "") +
           std::to_string(std::lround(std::abs(c.pitch) * 180 / std::numbers::pi));
}
void PrintTo(const WallCase& c, std::ostream* out) { *out << name_of(c); }

/// Share of the soil that a wall across the grid lets through.
double wall_leak(const WallCase& c) {
    auto soil = make_soil(grid_def(56, 16, 32, kVoxel));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{c.thickness / 2, 80, 80} * kVoxel),
                        Vec3{24.3, 8, 8} * kVoxel);
    SoilBody& wall = movers[0].body;
    wall.pose.rotation = turn({0, 0, 1}, c.yaw) * turn({0, 1, 0}, c.pitch);
    const Vec3 velocity = rotate(wall.pose.rotation, c.motion.voxels_a_step) * (kVoxel / kStep);
    movers[0].set_velocity(velocity, c.motion.turn_a_step * (1 / kStep));
    const auto ahead = [&](Vec3 at) {
        return dot(at - wall.pose.position, rotate(wall.pose.rotation, {1, 0, 0})) / kVoxel;
    };
    EXPECT_TRUE(soil->fill(FunctionFill{
        [&](Vec3 at) { return ahead(at) > 1.9 && at.z < 7 * kVoxel ? 1.0 : -1.0; }, {}}));
    for (int i = 0; i < c.motion.step_count; ++i) {
        movers[0].advance(kStep);
        soil->step(bodies_of(movers));
    }
    const auto units = count_units(*soil, [&](Vec3 at) { return ahead(at) < 0; });
    return static_cast<double>(units[0]) / static_cast<double>(units[1]);
}

class Wall : public testing::TestWithParam<WallCase> {};

// Two cases at a voxel a step, where soil is squeezed in between a leaning wall and the grid's
// ends, were measured to lose 0.03 and 0.06 %, the others nothing.
TEST_P(Wall, lets_no_soil_through) { EXPECT_LT(wall_leak(GetParam()), 1e-3); }

std::vector<WallCase> walls_of(double thickness) {
    const WallMotion motions[] = {
        {"at_rest", {}, {}, 60},
        {"into_slowly", {0.1, 0, 0}, {}, 60},
        {"into", {1, 0, 0}, {}, 14},
        {"away_slowly", {-0.1, 0, 0}, {}, 60},
        {"away", {-1, 0, 0}, {}, 14},
        {"along", {0, 1, 0}, {}, 24},
        {"upwards", {0, 0, 1}, {}, 24},
        {"downwards", {0, 0, -1}, {}, 24},
        {"askew", {0.6, 0.6, 0}, {}, 20},
        {"yawing", {}, {0, 0, 0.02}, 24},
        {"tilting", {}, {0, -0.03, 0}, 20},
        {"tilting_back", {}, {0, 0.03, 0}, 20},
    };
    std::vector<WallCase> cases;
    for (const WallMotion& motion : motions) {
        for (const auto& [yaw, pitch] : {std::pair{0.0, 0.0},
                                         {0.4, 0.0},
                                         {0.0, std::numbers::pi / 6},
                                         {0.3, -std::numbers::pi / 6}}) {
            cases.push_back({thickness, yaw, pitch, motion});
        }
    }
    return cases;
}

INSTANTIATE_TEST_SUITE_P(Motions, Wall, testing::ValuesIn(walls_of(0.2)),
                         [](const auto& test) { return name_of(test.param); });
INSTANTIATE_TEST_SUITE_P(SlowMotions, Wall, testing::ValuesIn(walls_of(2)),
                         [](const auto& test) { return name_of(test.param); });

struct VesselCase {
    double thickness;  ///< of its walls, voxels
    Vec3 axis;
    double turn_a_step;  ///< radians
    int step_count;
};
std::string name_of(const VesselCase& c) {
    return "thick_" + std::to_string(std::lround(c.thickness * 10)) + "_turning_" +
           std::to_string(std::lround(c.turn_a_step * 1000)) + "_axis_" +
           std::to_string(std::lround(c.axis.x * 10)) + std::to_string(std::lround(c.axis.y * 10));
}
void PrintTo(const VesselCase& c, std::ostream* out) { *out << name_of(c); }

/// Share of the soil that leaves a closed box, 16 voxels between the middles of its walls.
double vessel_leak(const VesselCase& c) {
    auto soil = make_soil(grid_def(40, 40, 40, kVoxel));
    std::vector<Mover> movers;
    const double half = 8, outer = half + c.thickness / 2, thin = c.thickness / 2;
    movers.emplace_back(1, box_shape(Vec3{thin, outer, outer} * kVoxel), Vec3{20, 20, 20} * kVoxel);
    SoilBody& box = movers[0].body;
    movers[0].shapes.clear();
    for (int axis = 0; axis < 3; ++axis) {
        for (double side : {-half, half}) {
            Vec3 extents{outer, outer, outer}, at;
            (axis == 0 ? extents.x : axis == 1 ? extents.y : extents.z) = thin;
            (axis == 0 ? at.x : axis == 1 ? at.y : at.z) = side;
            movers[0].shapes.push_back(box_shape(extents * kVoxel));
            movers[0].shapes.back().local.position = at * kVoxel;
        }
    }
    movers[0].set_velocity({}, c.axis * (c.turn_a_step / kStep));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, Vec3{14, 14, 14}, Vec3{26, 26, 20})));
    for (int i = 0; i < c.step_count; ++i) {
        movers[0].advance(kStep);
        soil->step(bodies_of(movers));
    }
    const auto units = count_units(*soil, [&](Vec3 at) {
        const Vec3 p = transform(inverse(box.pose), at);
        return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > half * kVoxel;
    });
    return static_cast<double>(units[0]) / static_cast<double>(units[1]);
}

class Vessel : public testing::TestWithParam<VesselCase> {};

TEST_P(Vessel, keeps_its_soil) { EXPECT_LT(vessel_leak(GetParam()), 1e-3); }

std::vector<VesselCase> vessel_cases() {
    constexpr double kTurn = 2 * std::numbers::pi;
    std::vector<VesselCase> cases;
    for (double t : {0.2, 2.0}) {
        cases.push_back({t, {0, 1, 0}, 0, 120});
        cases.push_back({t, {0, 1, 0}, kTurn / 80, 80});
        cases.push_back({t, {0.48, 0.64, 0.6}, kTurn / 120, 120});
        cases.push_back({t, {0, 1, 0}, kTurn / 400, 200});
    }
    return cases;
}
INSTANTIATE_TEST_SUITE_P(Turning, Vessel, testing::ValuesIn(vessel_cases()),
                         [](const auto& test) { return name_of(test.param); });

/// How a bucket with walls of 0.4 voxels is given to the soil: five boxes, or one closed mesh.
enum class BucketSolid { plates, mesh };
void PrintTo(BucketSolid solid, std::ostream* out) {
    *out << (solid == BucketSolid::plates ? "plates" : "mesh");
}

constexpr Vec3 kBucketHalf{9 * kVoxel, 8 * kVoxel, 7 * kVoxel};

std::vector<ConvexShape> bucket_shapes(BucketSolid solid) {
    constexpr double kPlate = 0.4 * kVoxel;
    if (solid == BucketSolid::mesh) {
        return {lattice_shape(thick_bucket(kBucketHalf, kPlate), kVoxel)};
    }
    std::vector<ConvexShape> shapes;
    const auto add = [&](Vec3 half, Vec3 at) {
        shapes.push_back(box_shape(half));
        shapes.back().local.position = at;
    };
    const Vec3 h = kBucketHalf;
    const double thin = kPlate / 2;
    for (const double side : {-1.0, 1.0}) {
        add({thin, h.y, h.z}, {side * (h.x - thin), 0, 0});
        add({h.x, thin, h.z}, {0, side * (h.y - thin), 0});
    }
    add({h.x, h.y, thin}, {0, 0, thin - h.z});
    return shapes;
}

class SwungBucket : public testing::TestWithParam<BucketSolid> {};

// An excavator's swing: 40 deg in 2.5 s on an arm of 3.5 m. The bucket is accelerated by up to 2.3
// m/s2 = 0.24 g and slowed down by as much, which friction on its floor (0.4 g) can give; on its
// way round it is pulled in by 0.06 g. The load is level with the rim, which is a slope of atan
// 0.24 = 14 deg to what it feels, and stands at 33 deg: all of it stays in. Before carried soil
// went with its walls, 0.09 of it was pressed up and over the rim.
TEST_P(SwungBucket, keeps_a_load_level_with_its_rim) {
    constexpr int kStepCount = 150;
    constexpr double kAngle = 40 * std::numbers::pi / 180;
    const Vec3 arm = Vec3{70, 0, 0} * kVoxel, hinge = Vec3{-4, 16, 12} * kVoxel;
    auto soil = make_soil(grid_def(88, 80, 24, kVoxel));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(kBucketHalf), hinge + arm);
    movers[0].shapes = bucket_shapes(GetParam());
    SoilBody& bucket = movers[0].body;
    bucket.surface.friction = 0.4;
    const Vec3 room = kBucketHalf - Vec3{2, 2, 0} * kVoxel;
    ASSERT_TRUE(soil->fill(FunctionFill{[&](Vec3 at) {
                                            const Vec3 p = at - bucket.pose.position;
                                            const bool is_in = std::abs(p.x) < room.x &&
                                                               std::abs(p.y) < room.y &&
                                                               p.z > 2 * kVoxel - kBucketHalf.z &&
                                                               p.z < kBucketHalf.z;
                                            return is_in ? 1.0 : -1.0;
                                        },
                                        {}}));
    for (int i = 1; i <= kStepCount; ++i) {
        const double t = static_cast<double>(i) / kStepCount;
        const double angle = kAngle * t * t * (3 - 2 * t);
        const Vec3 spin{0, 0, kAngle * 6 * t * (1 - t) / (kStepCount * kStep)};
        const Vec3 reach = rotate(turn({0, 0, 1}, angle), arm);
        bucket.pose = {hinge + reach, turn({0, 0, 1}, angle)};
        bucket.center_of_mass_m = bucket.pose.position;
        bucket.linear_velocity_m_s = cross(spin, reach);
        bucket.angular_velocity_rad_s = spin;
        soil->step(bodies_of(movers));
    }
    const auto units = count_units(*soil, [&](Vec3 at) {
        const Vec3 p = transform(inverse(bucket.pose), at);
        return std::abs(p.x) > kBucketHalf.x || std::abs(p.y) > kBucketHalf.y ||
               p.z < -kBucketHalf.z;
    });
    const double lost = static_cast<double>(units[0]) / static_cast<double>(units[1]);
    RecordProperty("lost", std::to_string(lost));
    EXPECT_LT(lost, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Solids, SwungBucket,
                         testing::Values(BucketSolid::plates, BucketSolid::mesh),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::leak_test
