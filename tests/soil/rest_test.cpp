// What is at rest sleeps: the smallest scenes in which soil stayed awake for good, by what random
// worlds had.
#include "soil_fixture.h"

namespace bsoil::rest_test {
namespace {

using namespace layout;

/// A grid of one tile.
SoilDef tile_def(MaterialDef material, double voxel_m = 0.05) {
    SoilDef def = grid_def(8, 8, 16, voxel_m);
    def.material = std::move(material);
    return def;
}

/// What a voxel is given; of mass, as much as of volume, unless there is more.
struct VoxelSoil {
    int volume = 0;
    int momentum_x = 0, momentum_y = 0;
    int force_x = 0, force_y = 0;
    int mass = 0;
};

/// Puts soil into a voxel beside these bodies and lets it be found.
void put(Soil& soil, int x, int y, int z, const VoxelSoil& what,
         std::span<const SoilBody> bodies = {}) {
    Soil::Impl& s = SoilProbe::impl(soil);
    s.lists.activate(s.block_key(0, 0));
    soil.step(bodies);  // wakes the tile, and knows what covers it
    const int slot = s.tiles[0]->slot;
    ASSERT_GE(slot, 0);
    const auto write = [&](int plane, int word) {
        s.device->write(Buffer::state,
                        int64_t{plane} * s.params.plane_stride +
                            int64_t{slot} * s.params.tile_voxels + z * kTileColumns +
                            y * kTileSide + x,
                        std::vector<int32_t>(1, word));
    };
    write(kPlaneVolume, what.volume);
    write(kPlaneMaterial, std::max(what.volume, what.mass));
    write(kPlaneMomentumX, what.momentum_x);
    write(kPlaneMomentumY, what.momentum_y);
    write(kPlaneForceX, what.force_x);
    write(kPlaneForceY, what.force_y);
    s.tiles.note_stale(slot, true);
    s.lists.activate(s.block_key(0, z / kTileSide));
}

/// Steps until no block is active; so many at most.
int steps_until_rest(Soil& soil, int most, std::span<const SoilBody> bodies = {}) {
    for (int i = 0; i < most; ++i) {
        if (soil.step(bodies).block_active_count == 0) return i;
    }
    return most;
}

int units_in(const Soil& soil, int x, int y, int z) {
    return static_cast<int>(std::lround(soil.sample(x, y, z).volume * kVoxelFull));
}

/// A bed of two voxels, and a ledge of one on its farther half that cohesion holds. Its soil keeps
/// momentum, and such a part of its cohesion.
std::unique_ptr<Soil> ledge(double loose_cohesion_fraction, double step_s = 1.0 / 60) {
    SoilDef def = tile_def(fixed_density(sand(20, 5000)));
    def.step_s = step_s;
    def.material.loose_cohesion_fraction = loose_cohesion_fraction;
    def.slides = SlideMotion::run_out;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 2})));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 4, 2}, {8, 8, 3})));
    EXPECT_TRUE(soil->settle(100, {})->is_at_rest);
    return soil;
}

// A unit of dust on a failing slope can be shared out among no columns. It was set in motion in
// each step, and came to rest in each.
TEST(Rest, dust_on_a_ledge_is_not_set_in_motion) {
    const auto soil = ledge(0);
    put(*soil, 3, 4, 3, {.volume = 1});
    EXPECT_LT(steps_until_rest(*soil, 20), 10);
    EXPECT_EQ(units_in(*soil, 3, 4, 3), 1);
}

// A crumb on top of a slide has no cohesion, and leaves no share. It was asked what holds the soil
// under it, which stands by cohesion and had no friction. By hand: friction takes up to 1,800
// units of speed in a pass, and the soil has 8.
TEST(Rest, a_slow_slide_under_a_crumb_stops) {
    const auto soil = ledge(0);
    put(*soil, 3, 4, 3, {.volume = 1});
    put(*soil, 3, 4, 2, {.volume = kVoxelFull, .momentum_y = -31});
    EXPECT_LT(steps_until_rest(*soil, 200), 10);
}

// A slope that stands by cohesion had no friction where it is steeper than phi: a thin layer on it
// that had come with some speed kept it, too thin for a share to leave.
TEST(Rest, a_thin_slide_stops_where_cohesion_holds) {
    const auto soil = ledge(1);
    // Its share of what lies there is 0.9 units a pass.
    put(*soil, 3, 4, 3, {.volume = 744, .momentum_y = -896});
    EXPECT_LT(steps_until_rest(*soil, 200), 50);
}

// In short steps friction takes little from it, and what is too slow for a share to leave was in
// motion until that had taken all. By hand: of 744 units of mass 5 units of momentum a pass at 240
// Hz, which takes 180. At 1000 Hz it is 0.27 units, and its momentum, a whole number, stayed.
TEST(Rest, a_thin_slide_stops_in_short_steps) {
    for (const double step_s : {1.0 / 240, 0.001}) {
        const auto soil = ledge(1, step_s);
        put(*soil, 3, 4, 3, {.volume = 744, .momentum_y = -896});
        EXPECT_LT(steps_until_rest(*soil, 400), 10) << step_s;
    }
}

// Where ground falls by more than a layer is thick slip_soil sees the edge of a ledge, as high as
// the layer, and a slide sees ground steeper than phi. One let it stand, the other had no friction.
TEST(Rest, a_thin_slide_stops_at_the_edge_of_a_ledge) {
    SoilDef def = tile_def(fixed_density(sand(30)));
    def.slides = SlideMotion::run_out;
    const auto soil = make_soil(def);
    const double voxel = def.voxel_m;
    ASSERT_TRUE(
        soil->add_terrain([&](Vec3 at) { return (at.y < 4 * voxel ? 1.3 : 2) * voxel - at.z; }));
    ASSERT_LT(soil->surface_height_m(3, 3), 1.5 * voxel);
    put(*soil, 3, 4, 2, {.volume = 744, .momentum_y = -896});
    EXPECT_LT(steps_until_rest(*soil, 200), 50);
    EXPECT_EQ(units_in(*soil, 3, 4, 2), 744);
}

// A crumb on a sloping roof drove the soil under the roof, in each step and nowhere: rigid voxels
// without soil were passed over like gaps.
TEST(Rest, a_crumb_on_a_roof_drives_nothing_under_it) {
    SoilDef def = tile_def(fixed_density(sand(10)));
    def.slides = SlideMotion::run_out;
    const auto soil = make_soil(def);
    const double voxel = def.voxel_m;
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 0.5})));
    ASSERT_TRUE(soil->add_terrain([&](Vec3 at) {  // ends at the third row
        return std::min({at.z - 5 * voxel, 6.9 * voxel + 0.4 * at.y - at.z, at.y - 2 * voxel});
    }));
    ASSERT_TRUE(soil->settle(100, {})->is_at_rest);
    put(*soil, 3, 3, 8, {.volume = 1});
    EXPECT_LT(steps_until_rest(*soil, 40), 20);
    EXPECT_EQ(units_in(*soil, 3, 3, 8), 1);
    EXPECT_EQ(length(soil->sample(3, 3, 0).velocity_m_s), 0);
}

// A bare column's top is where its rigid soil ends, and a grain's is what covers the voxel higher.
// So each column beside a grain looked like a hole, and it went round and round on a slope of 3
// deg.
TEST(Rest, dust_stays_on_a_gentle_slope_of_bare_terrain) {
    const auto soil = make_soil(tile_def(fixed_density(sand(10))));
    ASSERT_TRUE(soil->add_terrain([](Vec3 at) { return 0.06 + 0.05 * at.x + 0.02 * at.y - at.z; }));
    put(*soil, 3, 3, 1, {.volume = 16});
    EXPECT_LT(steps_until_rest(*soil, 20), 10);
    EXPECT_EQ(units_in(*soil, 3, 3, 1), 16);
}

/// A box at rest that covers seven tenths of voxels 2..5 in layer 2, and all above.
Mover resting_box() {
    Mover box(1, box_shape({0.1, 0.1, 0.085}), {0.2, 0.2, 0.2});
    box.set_velocity({});
    return box;
}

// A unit too much in a wall is no share of the voxel's soil: its push alone moved on, by a unit in
// each pass. Nor is it one of soil that has two units of mass in each of volume. Of that a unit of
// mass left in each pass, and no volume. The wall was as full as before, for minutes.
TEST(Rest, a_push_moves_nothing_without_soil) {
    for (const int dense : {1, 2}) {
        SoilDef def = tile_def(fixed_density(sand(30)));
        def.material.density_kg_m3 = 2000 * dense;
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 2})));
        const Mover box = resting_box();
        const std::vector<SoilBody> bodies{box.body};
        EXPECT_LT(steps_until_rest(*soil, 100, bodies), 50);
        put(*soil, 5, 3, 2, {}, bodies);
        const auto covered =
            static_cast<int>(std::lround(soil->sample(5, 3, 2).body_coverage * kVoxelFull));
        ASSERT_GT(covered, kSolidCoverage);
        const int volume = kVoxelFull + 1 - covered;
        put(*soil, 5, 3, 2,
            {.volume = volume, .force_x = 1024, .force_y = -300, .mass = dense * volume}, bodies);
        EXPECT_LT(steps_until_rest(*soil, 100, bodies), 50);
    }
}

// Thin soil that air lets fall slowly has no share that leaves its voxel in a step: it hung.
TEST(Rest, thin_soil_comes_down_however_slowly_it_falls) {
    SoilDef def = tile_def(fixed_density(sand(30)));
    def.material.fall_speed_m_s = 0.05;  // a sixtieth of a voxel a step: 15 units
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 1})));
    ASSERT_TRUE(soil->settle(100, {})->is_at_rest);
    put(*soil, 3, 3, 5, {.volume = 900});
    const int steps = steps_until_rest(*soil, 2000);
    EXPECT_LT(steps, 3 * 4 * 60);
    EXPECT_EQ(units_in(*soil, 3, 3, 5), 0);
}

// Thicker soil gets on along a wall once it falls faster, which it never does in air.
TEST(Rest, soil_that_wind_presses_to_a_wall_comes_down) {
    SoilDef def = tile_def(fixed_density(sand(30)));
    def.material.fall_speed_m_s = 0.01;
    def.wind_m_s = {0.5, 0, 0};
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->add_terrain([](Vec3 at) { return at.x > 0.2 ? 0.5 : 0.05 - at.z; }));
    const int volume = kPacingLeast + 100;
    put(*soil, 3, 3, 2, {.volume = volume, .momentum_x = 8 * volume});
    EXPECT_LT(steps_until_rest(*soil, 4000), 4000);
    EXPECT_EQ(units_in(*soil, 3, 3, 2), 0);
}

// With what a wall took went what the crumb fell with. It was in the air for ten times as long as
// soil at its fall speed.
TEST(Rest, a_crumb_that_wind_presses_into_a_corner_comes_down) {
    SoilDef def = tile_def(fixed_density(sand(30)));
    def.material.fall_speed_m_s = 0.5;
    def.wind_m_s = {-4, -6, 0};
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 1})));
    ASSERT_TRUE(soil->settle(100, {})->is_at_rest);
    constexpr int kFall = 12;
    put(*soil, 0, 0, kFall + 1, {.volume = 200});
    // As random worlds have it, and a second for what else there is.
    const double voxels_a_step = def.material.fall_speed_m_s * def.step_s / def.voxel_m;
    const double most = std::pow(std::sqrt(kFall) + 3.7, 2) / voxels_a_step + 60;
    EXPECT_LT(steps_until_rest(*soil, 4000), most);
    EXPECT_EQ(units_in(*soil, 0, 0, kFall + 1), 0);
}

// Wind blew a share of it to the ledge beside it, which slid back from there, and it fell too
// slowly for a share to come down. In strong wind it met the ledge's edge whenever it fell. A crumb
// of it fell as fast as it can, gained nothing, and went to sleep in the air.
TEST(Rest, soil_that_wind_blows_to_a_ledge_comes_down_beside_it) {
    for (const double wind_m_s : {0.6, 3.0}) {
        SoilDef def = tile_def(fixed_density(sand(10)));
        def.material.fall_speed_m_s = 0.046;
        def.wind_m_s = {wind_m_s, 0, 0};
        const auto soil = make_soil(def);
        const double voxel = def.voxel_m;
        ASSERT_TRUE(soil->add_terrain([&](Vec3 at) {  // between two walls
            const bool is_wall = at.y < 3 * voxel || at.y > 4 * voxel;
            return (is_wall ? 12.0 : at.x > 4 * voxel ? 5.4 : 1.0) * voxel - at.z;
        }));
        put(*soil, 3, 3, 5, {.volume = 441});
        EXPECT_LT(steps_until_rest(*soil, 4000), 2000) << wind_m_s;
        EXPECT_EQ(units_in(*soil, 3, 3, 1), 441) << wind_m_s;
    }
}

// The slide took the drop beyond the edge for a slope, on which there is no friction, and what
// makes soil slip saw a slope as high as the soil. It trickled off at one speed, ever less in a
// step.
TEST(Rest, what_slides_to_the_edge_of_bare_rock_stops) {
    SoilDef def = tile_def(fixed_density(sand(30)));
    def.slides = SlideMotion::run_out;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->add_terrain([](Vec3 at) { return (at.x < 0.2 ? 0.1 : 0.0) - at.z; }));
    const int volume = 4000;
    put(*soil, 3, 3, 2, {.volume = volume, .momentum_x = 2 * volume});
    EXPECT_LT(steps_until_rest(*soil, 1000), 30);
    EXPECT_GT(units_in(*soil, 3, 3, 2), volume * 0.9);
}

}  // namespace
}  // namespace bsoil::rest_test
