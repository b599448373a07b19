// Snapshots: exact, and refused when damaged.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "cure.h"
#include "moving_scene.h"
#include "snapshot_files.h"

namespace bsoil::snapshot_test {
namespace {

class Snapshot : public SnapshotFiles {};

TEST_F(Snapshot, a_loaded_soil_goes_on_like_the_saved_one) {
    for (int steps : {0, 1, 45}) {
        MovingScene first(21, MovingScene::default_def());
        first.run(steps);
        ASSERT_TRUE(first.soil().save(path("a")));
        MovingScene second(22, MovingScene::default_def());
        second.run(7);
        // The bodies of the second scene take the first one's courses.
        MovingScene twin(21, MovingScene::default_def());
        twin.replace_soil(make_soil(MovingScene::default_def()));
        twin.skip_to(first.step_count());
        ASSERT_TRUE(twin.soil().load(path("a")));
        EXPECT_EQ(second.soil().state_revision(), 0u);
        ASSERT_TRUE(second.soil().load(path("a")));
        EXPECT_EQ(second.soil().state_revision(), 1u);
        EXPECT_EQ(twin.soil().checksum(), first.soil().checksum());
        EXPECT_EQ(second.soil().checksum(), first.soil().checksum());
        EXPECT_EQ(twin.soil().totals().units, first.soil().totals().units);
        for (int i = 0; i < 40; ++i) {
            first.step();
            twin.step();
            ASSERT_EQ(twin.soil().checksum(), first.soil().checksum())
                << "saved at " << steps << ", step " << i + 1 << " after";
        }
    }
}

TEST_F(Snapshot, goes_on_without_bodies_while_soil_slides_and_falls) {
    auto soil = make_soil(grid_def(32, 32, 32));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {10, 10, 2}, {22, 22, 28})));
    for (int i = 0; i < 35; ++i) soil->step({});
    ASSERT_TRUE(soil->save(path("a")));
    auto other = make_soil(grid_def(32, 32, 32));
    ASSERT_TRUE(other->load(path("a")));
    for (int i = 0; i < 100; ++i) {
        soil->step({});
        other->step({});
        ASSERT_EQ(soil->checksum(), other->checksum()) << "step " << i + 1;
    }
}

/// A grid of four tiles in a row: a bed of two voxels with a ledge of cohesive soil in the first,
/// and at the other end a wall that slides.
std::unique_ptr<Soil> ledge_and_slide() {
    SoilDef def = grid_def(32, 8, 16);
    def.materials = {fixed_density(sand(20, 5000)), fixed_density(sand(20))};
    def.materials[1].name = "loose";
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 8, 2})));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 4, 2}, {8, 8, 3})));
    EXPECT_TRUE(soil->settle(100, {})->is_at_rest);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {28, 0, 2}, {32, 8, 12}, "loose")));
    return soil;
}

/// A unit of loose dust on the ledge.
void put_dust(Soil& soil) {
    Soil::Impl& s = SoilProbe::impl(soil);
    s.lists.activate(s.block_key(0, 0));
    soil.step({});  // wakes the tile
    const int slot = s.tiles[0]->slot;
    ASSERT_GE(slot, 0);
    constexpr int kAt = 3 * layout::kTileColumns + 4 * layout::kTileSide + 3;
    for (const int plane : {layout::kPlaneVolume, layout::kPlaneMaterial + 1}) {
        const int32_t one = 1;
        s.device->write(layout::Buffer::state, s.tiles.plane_offset(plane, slot) + kAt, {&one, 1});
    }
    s.tiles.note_stale(slot, true);
    s.lists.activate(s.block_key(0, 0));
}

// Dust on a failing slope can be shared out among no columns and stays. A step that looks at it has
// as many slip passes as the slope asks for. A restored soil looked at all that was awake, and so
// slid further than the one that was saved, in which no step looked there any more. By hand: a step
// of a voxel stands by tan 20 deg, so that the dust's slope is 65536 (1 - 0.364) = 41683.
TEST_F(Snapshot, a_loaded_soil_looks_at_what_the_saved_one_looks_at) {
    const auto soil = ledge_and_slide();
    put_dust(*soil);
    for (int i = 0; i < 8; ++i) soil->step({});
    Soil::Impl& s = SoilProbe::impl(*soil);
    const int slot = s.tiles[0]->slot;
    ASSERT_GE(slot, 0);
    const auto step = [](Soil& of) { return of.step({}).block_active_count; };
    ASSERT_GT(step(*soil), 0);
    ASSERT_TRUE(
        std::ranges::none_of(std::array{0, 1}, [&](int z) { return s.lists.is_listed(slot, z); }));
    ASSERT_TRUE(soil->save(path("a")));
    const auto twin = make_soil(soil->def());
    ASSERT_TRUE(twin->load(path("a")));
    for (int i = 0; i < 40; ++i) {
        step(*soil);
        step(*twin);
        ASSERT_EQ(SoilProbe::impl(*twin).slope_q16, s.slope_q16) << i;
        ASSERT_EQ(twin->checksum(), soil->checksum()) << i;
        ASSERT_TRUE(twin->state() == soil->state()) << i;
    }
}

TEST_F(Snapshot, damage_is_refused_and_changes_nothing) {
    MovingScene scene(23, MovingScene::default_def());
    scene.run(20);
    ASSERT_TRUE(scene.soil().save(path("a")));
    const std::vector<char> good = bytes_of(path("a"));
    scene.run(5);
    const uint64_t checksum = scene.soil().checksum();
    std::mt19937 random(5);
    const auto expect_refused = [&](const std::vector<char>& bytes, const std::string& what) {
        write_bytes(path("b"), bytes);
        const Status status = scene.soil().load(path("b"));
        ASSERT_FALSE(status) << what;
        EXPECT_NE(status.error().find(path("b")), std::string::npos) << status.error();
        EXPECT_TRUE(says_what_to_do(status.error())) << status.error();
        ASSERT_EQ(scene.soil().checksum(), checksum) << what;
    };
    for (size_t size : {size_t{0}, size_t{5}, size_t{12}, size_t{27}, size_t{28}, good.size() / 2,
                        good.size() - 1}) {
        expect_refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)},
                       "cut to " + std::to_string(size));
    }
    for (int i = 0; i < 40; ++i) {
        std::vector<char> flipped = good;
        const size_t at = i < 28 ? static_cast<size_t>(i) : random() % good.size();
        flipped[at] = static_cast<char>(flipped[at] ^ (1 << random() % 8));
        expect_refused(flipped, "bit flipped in byte " + std::to_string(at));
    }
    std::vector<char> longer = good;
    longer.push_back('x');
    expect_refused(longer, "a byte too many");
    EXPECT_FALSE(scene.soil().load(path("missing")));
    EXPECT_TRUE(scene.soil().load(path("a")));
}

// The file was written, and could never be read.
TEST_F(Snapshot, sections_that_could_not_be_read_are_not_written) {
    const auto refuses = [&](const std::vector<SnapshotSection>& sections, const char* words) {
        const Status written = write_snapshot_file(path("a"), sections);
        ASSERT_FALSE(written) << words;
        EXPECT_NE(written.error().find(words), std::string::npos) << written.error();
        EXPECT_TRUE(says_what_to_do(written.error())) << written.error();
        EXPECT_FALSE(std::filesystem::exists(path("a")));
    };
    refuses({}, "has 0 sections");
    std::vector<SnapshotSection> many;
    for (int i = 0; i < 65; ++i) many.push_back({"host " + std::to_string(i), {1}});
    refuses(many, "has 65 sections");
    refuses({{"host", {1}}, {"soil", {}}, {"host", {2}}}, "two sections named 'host'");
    refuses({{std::string("a\0b", 3), {1}}}, "none of them zero");
    many.pop_back();
    ASSERT_TRUE(write_snapshot_file(path("a"), many));
    EXPECT_TRUE(read_snapshot_file(path("a")));
    const auto folder = read_snapshot_file(std::filesystem::temp_directory_path().string());
    ASSERT_FALSE(folder);
    EXPECT_NE(folder.error().find("cannot be read"), std::string::npos) << folder.error();
}

// The snapshot was refused as damaged.
TEST_F(Snapshot, contacts_of_bodies_that_cannot_be_are_not_kept) {
    auto soil = make_soil(grid_def(8, 8, 8));
    for (const int body : {-1, 65535}) {
        soil->known_contacts().set_width(body, 1);
        soil->known_contacts().set_pressure(body, 1000);
        EXPECT_EQ(soil->known_contacts().of(body).width_m, 0);
    }
    const auto put = soil->prepare(soil->state());
    EXPECT_TRUE(put) << put.error();
}

TEST_F(Snapshot, another_grid_or_material_is_refused) {
    auto soil = make_soil(grid_def(16, 16, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 4})));
    ASSERT_TRUE(soil->save(path("a")));
    EXPECT_FALSE(make_soil(grid_def(24, 16, 16))->load(path("a")));
    EXPECT_FALSE(make_soil(grid_def(16, 16, 16, 0.1))->load(path("a")));
    SoilDef def = grid_def(16, 16, 16);
    def.material = materials::gravel();
    EXPECT_FALSE(make_soil(def)->load(path("a")));
    def.materials = {materials::dry_sand(), materials::gravel()};
    EXPECT_FALSE(make_soil(def)->load(path("a")));
    EXPECT_FALSE(soil->save("/nonexistent_directory/soil"));
}

}  // namespace
}  // namespace bsoil::snapshot_test
