// States made by hand: every field out of its range is refused by name, and changes nothing.
#include <functional>

#include "soil_fixture.h"
#include "temporary_file.h"

namespace bsoil::snapshot_fields_test {
namespace {

using namespace layout;

constexpr double kVoxel = 0.05;

/// A heap that slides beside a moving box, in a grid with tiles that are awake, asleep and cut by
/// its sides.
std::unique_ptr<Soil> living_soil() {
    auto soil = make_soil(grid_def(60, 21, 16));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {60, 21, 4})));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 4}, {12, 12, 12})));
    Mover box(5, box_shape(Vec3{2.2, 2.2, 2.2} * kVoxel), Vec3{9, 14, 5} * kVoxel);
    box.set_velocity({0.4, 0, 0});
    for (int i = 0; i < 12; ++i) {
        box.advance(1.0 / 60);
        std::vector<SoilBody> bodies{box.body};
        soil->step(bodies);
    }
    return soil;
}

struct BadField {
    const char* text;  ///< in the error
    std::function<void(Soil::Impl&)> spoil;
};

/// Sets a word of a voxel (3 up, column 9) of tile 0, which is awake.
auto word(int plane, int32_t value) {
    return [=](Soil::Impl& soil) {
        const int64_t at =
            soil.tiles.plane_offset(plane, soil.tiles[0]->slot) + 3 * kTileColumns + 9;
        soil.device->write(Buffer::state, at, std::span(&value, 1));
    };
}

auto span_word(int at, int32_t value) {
    return [=](Soil::Impl& soil) {
        const int64_t column = int64_t{soil.tiles[0]->slot} * kTileColumns + 9;
        soil.device->write(Buffer::spans, column * kColumnWords + at, std::span(&value, 1));
    };
}

auto surface_word(int32_t value) {
    return [=](Soil::Impl& soil) {
        const int64_t tops = soil.tiles.column_array_offset(kColumnSurface, soil.tiles[0]->slot);
        soil.device->write(Buffer::spans, tops + 9, std::span(&value, 1));
    };
}

/// Changes SoilBody::id by index.
template <typename Change>
auto with_ids(Change change) {
    return [change](Soil::Impl& soil) {
        std::vector<int> ids(soil.bodies.ids().begin(), soil.bodies.ids().end());
        change(ids);
        soil.bodies.restart(soil.bodies.tracks(), ids);
    };
}

/// Changes what is known of body 5.
template <typename Change>
auto with_body_5(Change change) {
    return [change](Soil::Impl& soil) {
        auto tracks = soil.bodies.tracks();
        change(tracks.at(5), soil);
        soil.bodies.restart(tracks, {soil.bodies.ids().begin(), soil.bodies.ids().end()});
    };
}

std::vector<BadField> bad_fields() {
    std::vector<BadField> bad;
    for (const auto& [plane, text, low, high] :
         {std::tuple{kPlaneTerrain, "terrain", -1, kVoxelFull + 1},
          {kPlaneVolume, "volume", -1, kVoxelMost + 1},
          {kPlaneMomentumX, "momentum", INT32_MIN, INT32_MAX},
          {kPlaneMomentumY, "momentum", INT32_MIN, INT32_MAX},
          {kPlaneMomentumZ, "momentum", INT32_MIN, INT32_MAX},
          {kPlaneForceX, "force", INT32_MIN, INT32_MAX},
          {kPlaneForceY, "force", INT32_MIN, INT32_MAX},
          {kPlaneForceZ, "force", -(1 << 30) - 1, (1 << 30) + 1},
          {kPlaneBond, "bond", INT32_MIN, kVoxelMost + 1},
          {kPlaneMaterial, "mass", -1, 2 * kVoxelMost},
          {kPlaneCoverage, "coverage", -1, INT32_MAX},
          {kPlaneOwner, "owner", -1, 2},
          {kPlaneSupport, "support", -1, kSupportBody + 1}}) {
        bad.push_back({text, word(plane, low)});
        bad.push_back({text, word(plane, high)});
    }
    // Within the range of momentum, beyond what any speed gives a mass.
    bad.push_back({"momentum", [](Soil::Impl& soil) {
                       word(kPlaneMaterial, 5)(soil);
                       word(kPlaneMomentumX, 1 << 29)(soil);
                   }});
    for (const auto& [at, text, low, high] :
         {std::tuple{0, "count", -1, kSpanCapacity + 1},
          {1, "bottom", -1, INT32_MAX},
          {2, "top", -1, INT32_MAX},
          {3, "kind", -1, kSpanFalling + 1},
          {kColumnSpeed, "speed", -1, kVoxelFull + 1},
          {kColumnSpeed + kSpanCapacity, "speed", INT32_MIN, INT32_MAX}}) {
        bad.push_back({text, span_word(at, low)});
        bad.push_back({text, span_word(at, high)});
    }
    for (int32_t value : {INT32_MIN, INT32_MAX}) bad.push_back({"surface", surface_word(value)});
    const auto add = [&](const char* text, auto spoil) { bad.push_back({text, spoil}); };
    add("step_index", [](Soil::Impl& s) { s.step_index = -1; });
    add("step_index", [](Soil::Impl& s) { s.step_index = INT64_MAX; });
    add("step_stamp", [](Soil::Impl& s) { s.params.step_stamp = 1 << 20; });
    add("step_stamp", [](Soil::Impl& s) { s.params.step_stamp = -1; });
    add("pass_stamp", [](Soil::Impl& s) { s.params.pass_stamp = -1; });
    add("pass_stamp", [](Soil::Impl& s) { s.params.pass_stamp = INT32_MAX; });
    add("slip_turn", [](Soil::Impl& s) { s.params.slip_turn = 2; });
    add("speed", [](Soil::Impl& s) { s.speed_q16 = -1; });
    add("speed", [](Soil::Impl& s) { s.speed_q16 = int64_t{1} << 31; });
    add("slope", [](Soil::Impl& s) { s.slope_q16 = -1; });
    add("slope", [](Soil::Impl& s) { s.slope_q16 = INT32_MAX; });
    add("slide", [](Soil::Impl& s) { s.slide_q16 = -1; });
    add("slide", [](Soil::Impl& s) { s.slide_q16 = layout::kSlideSpeedMost + 1; });
    const auto add_condition = [&](const char* text, auto spoil) {
        add(text, [spoil](Soil::Impl& s) {
            Condition condition{.bit = StatusBit::speed_clamped, .step_count = 1};
            spoil(condition, s);
            s.conditions.replace({&condition, 1});
        });
    };
    add_condition("status bit",
                  [](Condition& c, Soil::Impl&) { c.bit = static_cast<StatusBit>(1u << 31); });
    add_condition("condition", [](Condition& c, Soil::Impl&) { c.body = -2; });
    add_condition("condition", [](Condition& c, Soil::Impl&) { c.step_count = 0; });
    add_condition("condition", [](Condition& c, Soil::Impl&) { c.first_step = 1; });
    add_condition("condition", [](Condition& c, Soil::Impl& s) { c.last_step = s.step_index + 1; });
    add("conditions", [](Soil::Impl& s) {
        const std::vector<Condition> many(
            1000, Condition{.bit = StatusBit::speed_clamped, .step_count = 1});
        s.conditions.replace(many);
    });
    add("active block", [](Soil::Impl& s) { s.lists.restart({{-1, 1}}); });
    add("active block", [](Soil::Impl& s) { s.lists.restart({{int64_t{1} << 40, 1}}); });
    add("active block", [](Soil::Impl& s) { s.lists.restart({{0, s.step_index + 1}}); });
    for (const BlockKey block : {int64_t{-1}, int64_t{1} << 40}) {
        add("granted block", [block](Soil::Impl& s) { s.lists.restart({}, {&block, 1}); });
    }
    add("id", with_ids([](std::vector<int>& ids) { ids.push_back(-2); }));
    add("id", with_ids([](std::vector<int>& ids) { ids.push_back(65535); }));
    add("bodies",
        with_ids([](std::vector<int>& ids) { ids.resize(limits::kBodyCapacity + 1, -1); }));
    add("records", with_ids([](std::vector<int>& ids) { ids.push_back(9); }));
    add("body 5", with_body_5([](BodyTrack& b, Soil::Impl&) { b.index = 1; }));
    add("body 5", with_body_5([](BodyTrack& b, Soil::Impl&) { b.index = -1; }));
    add("body 5", with_body_5([](BodyTrack& b, Soil::Impl& s) { b.last_step = s.step_index + 1; }));
    add("body 5", with_body_5([](BodyTrack& b, Soil::Impl&) { b.blocks.assign(1, -1); }));
    add("body 5",
        with_body_5([](BodyTrack& b, Soil::Impl&) { b.blocks.assign(1, int64_t{1} << 40); }));
    add("body 5", with_body_5([](BodyTrack& b, Soil::Impl&) { b.blocks = {1, 0}; }));
    add("damaged", with_body_5([](BodyTrack& b, Soil::Impl&) { b.pose.position.x = NAN; }));
    add("top of a tile", [](Soil::Impl& s) { s.tiles[0]->top = -1; });
    add("top of a tile", [](Soil::Impl& s) { s.tiles[0]->top = 17; });
    add("last used", [](Soil::Impl& s) { s.tiles[0]->last_used_step = s.step_index + 1; });
    for (const int blocks : {-1, 3}) {
        add("looked at",
            [blocks](Soil::Impl& s) { s.tiles.note_restored(s.tiles[0]->slot, blocks); });
    }
    // Tiles asleep, one of which the grid's sides cut.
    const auto in_last_tile = [](int plane, int z, int column, int32_t value) {
        return [=](Soil::Impl& soil) {
            TileVoxels voxels;
            const int index = static_cast<int>(soil.tiles.size()) - 1;
            EXPECT_LT(soil.tiles[static_cast<size_t>(index)]->slot, 0);
            soil.tiles.read_voxels(index, voxels);
            voxels.at(plane, z, column) = value;
            soil.tiles.write_voxels(index, voxels);
        };
    };
    add("volume", in_last_tile(kKeptVolume, 2, 0, kVoxelMost + 1));
    add("bond", in_last_tile(kKeptBond, 2, 0, INT32_MAX));
    add("sides", in_last_tile(kKeptTerrain, 9, 63, 0));
    add("sides", in_last_tile(kKeptVolume, 2, 63, 5));
    add("no voxels", [](Soil::Impl& s) {
        s.tiles[s.tiles.size() - 1]->packed =
            std::make_shared<PackedTile>(PackedTile{{1, 2, 3}, 0, {}});
    });
    return bad;
}

TEST(SnapshotFields, each_out_of_its_range_is_refused_by_name) {
    const auto good = living_soil();
    const auto other = living_soil();
    const uint64_t checksum = other->checksum();
    int i = 0;
    for (const BadField& bad : bad_fields()) {
        const auto spoilt = make_soil(grid_def(60, 21, 16));
        const auto copy = spoilt->prepare(good->state());
        ASSERT_TRUE(copy) << copy.error();
        (*copy)();
        bad.spoil(SoilProbe::impl(*spoilt));
        const auto put = other->prepare(spoilt->state());
        EXPECT_FALSE(put) << bad.text << ", field " << i;
        if (!put) {
            EXPECT_NE(put.error().find(bad.text), std::string::npos)
                << bad.text << ": " << put.error();
        }
        ASSERT_EQ(other->checksum(), checksum) << bad.text;
        ++i;
    }
}

// Sanitizers watch: at the ends of the ranges the kernels' integers hold.
TEST(SnapshotFields, those_at_the_ends_of_their_ranges_step) {
    struct End {
        int volume, mass, momentum;
    };
    constexpr int kFullMass = 2 * kVoxelFull - 1;  // of nearly 4000 kg/m3
    const End most{kVoxelMost, 2 * kVoxelMost - 1, 1 << 28};
    const End fastest{kVoxelFull, kFullMass, kFullMass * (kSpeedMost / 64)};
    for (const auto& [end, sign] : {std::pair{most, -1}, {most, 1}, {fastest, -1}, {fastest, 1}}) {
        const auto soil = living_soil();
        Soil::Impl& impl = SoilProbe::impl(*soil);
        word(kPlaneVolume, end.volume)(impl);
        word(kPlaneMaterial, end.mass)(impl);
        word(kPlaneForceX, sign * (1 << 30))(impl);
        word(kPlaneForceZ, sign * (1 << 30))(impl);
        word(kPlaneBond, kVoxelMost)(impl);
        word(kPlaneMomentumX, sign * end.momentum)(impl);
        const auto twin = make_soil(grid_def(60, 21, 16));
        const auto put = twin->prepare(soil->state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        const std::vector<int64_t> units = twin->totals().units;
        for (int i = 0; i < 20; ++i) twin->step({});
        EXPECT_EQ(twin->totals().units, units);
    }
}

// It would be refused when it is needed.
TEST(SnapshotFields, a_soil_with_more_than_a_snapshot_takes_is_not_saved) {
    const auto soil = living_soil();
    const TemporaryFile file("crushed.snapshot");
    Soil::Impl& impl = SoilProbe::impl(*soil);
    impl.conditions.note(StatusBit::amount_headroom);
    soil->clear_status();
    ASSERT_TRUE(soil->save(file.path()));
    word(kPlaneVolume, kVoxelMost + 1)(impl);
    const Status saved = soil->save(file.path());
    ASSERT_FALSE(saved);
    EXPECT_NE(saved.error().find("cannot be saved: it is damaged: volume"), std::string::npos)
        << saved.error();
    EXPECT_FALSE(soil->checked_state());
    const auto twin = make_soil(soil->def());
    EXPECT_TRUE(twin->load(file.path())) << "the file of before is whole";
}

TEST(SnapshotFields, tiles_that_held_the_same_share_it_again) {
    const auto soil = make_soil(grid_def(400, 400, 16)), twin = make_soil(grid_def(400, 400, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {400, 400, 5})));
    const auto put = twin->prepare(soil->state());
    ASSERT_TRUE(put) << put.error();
    (*put)();
    EXPECT_EQ(twin->memory_use().asleep_bytes, soil->memory_use().asleep_bytes);
    EXPECT_EQ(twin->checksum(), soil->checksum());
}

}  // namespace
}  // namespace bsoil::snapshot_fields_test
