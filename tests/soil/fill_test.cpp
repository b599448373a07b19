// Fills: what they put where, and what level ground costs.
#include <array>
#include <set>
#include <thread>

#include "soil_fixture.h"

namespace bsoil::fill_test {
namespace {

constexpr double kVoxel = 0.05;

size_t content_count(Soil& soil) {
    std::set<const PackedTile*> contents;
    for (const auto& tile : SoilProbe::impl(soil).tiles) {
        if (tile && tile->packed) contents.insert(tile->packed.get());
    }
    return contents.size();
}

/// Volume units and bond of every voxel of a fill, from its share of the voxel.
void expect_shares(Soil& soil, const std::function<double(int x, int y, int z)>& share) {
    const int* size = soil.frame().size;
    for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x) {
                const double wanted = share(x, y, z);
                // A crumb is not put in; else to half a unit.
                const double expected = wanted * 65536 > layout::kWholeMost ? wanted : 0;
                ASSERT_NEAR(soil.sample(x, y, z).volume, expected, 0.6 / 65536)
                    << x << " " << y << " " << z;
            }
        }
    }
}

double overlap(double low, double high, int cell) {
    return std::clamp(std::min(high, cell + 1.0) - std::max(low, 1.0 * cell), 0.0, 1.0);
}

TEST(Fill, a_box_puts_the_share_of_each_voxel_that_it_covers) {
    auto soil = make_soil(grid_def(27, 21, 13));
    const Vec3 low{1.3, 2.6, 0.4}, high{25.7, 19.2, 6.55};
    ASSERT_TRUE(soil->fill(voxel_box(*soil, low, high)));
    expect_shares(*soil, [&](int x, int y, int z) {
        return overlap(low.x, high.x, x) * overlap(low.y, high.y, y) * overlap(low.z, high.z, z);
    });
}

// Blocks near the body alone are active. What its soil rests on, from the floor up, is looked at
// all the same: in tiles that were awake before there was any.
TEST(Fill, bears_a_body_in_tiles_that_were_awake) {
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        if (backend == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
        size_t contacts_of_woken = 0;
        for (const bool is_awake : {false, true}) {
            SoilDef def = grid_def(16, 16, 40);
            def.backend = backend;
            const auto soil = make_soil(def);
            ASSERT_TRUE(soil);
            ASSERT_TRUE(soil->add_terrain([](Vec3 at) { return kVoxel - at.z; }));
            Soil::Impl& impl = SoilProbe::impl(*soil);
            for (int tile = 0; is_awake && tile < impl.tile_count(); ++tile) impl.tiles.wake(tile);
            ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 1}, {16, 16, 24})));
            std::vector<Mover> movers;
            movers.emplace_back(1, box_shape(Vec3{2, 2, 1} * kVoxel), Vec3{8, 8, 24.9} * kVoxel);
            const StepReport report = soil->step(bodies_of(movers));
            EXPECT_FALSE(report.contacts.empty());
            if (is_awake) {
                EXPECT_EQ(report.contacts.size(), contacts_of_woken);
            }
            contacts_of_woken = report.contacts.size();
            for (int z = 8; z < 20; ++z) {
                EXPECT_EQ(length(soil->sample(4, 4, z).velocity_m_s), 0) << z;
                EXPECT_EQ(soil->sample(4, 4, z).undisturbed, 1) << z;
            }
        }
    }
}

TEST(Fill, a_height_map_fills_up_to_its_heights) {
    auto soil = make_soil(grid_def(19, 12, 16));
    HeightMapFill fill{2, 2, {0.1f, 0.1f, 0.6f, 0.6f}, {}};
    ASSERT_TRUE(soil->fill(fill));
    expect_shares(*soil, [&](int, int y, int z) {
        // As float heights are.
        const double height = (0.1f + (0.6f - 0.1f) * (y + 0.5) / 12) / kVoxel;
        return std::clamp(height - z, 0.0, 1.0);
    });
}

TEST(Fill, a_turned_box_holds_what_it_should) {
    SoilDef def = grid_def(64, 64, 16);
    def.yaw_rad = 0.6;
    auto soil = make_soil(def);
    const Vec3 middle{1.6, 1.6, 0};
    ASSERT_TRUE(
        soil->fill(BoxFill{{middle - Vec3{0.8, 0.6, 0}, middle + Vec3{0.8, 0.6, 0.32}}, {}}));
    const double mass_kg = 1.6 * 1.2 * 0.32 * soil->materials()[0].density_kg_m3;
    // Sides are sampled at thirds of a voxel: 1/6 voxel around 5.6 m of them, on 1.9 m2.
    EXPECT_NEAR(soil->totals().mass_kg[0], mass_kg, 0.02 * mass_kg);
}

// Ground of many tiles that all hold the same is packed once, whatever is filled on top of it.
TEST(Fill, level_tiles_share_what_they_hold) {
    auto soil = make_soil(grid_def(804, 800, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {804, 800, 4.5})));
    // The tiles of the last row are filled up with rock.
    EXPECT_LE(content_count(*soil), 101u);
    const int64_t mass = soil->totals().units[0];
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 4.5}, {804, 800, 6})));
    EXPECT_LE(content_count(*soil), 101u);
    EXPECT_NEAR(static_cast<double>(soil->totals().units[0]), 6 / 4.5 * static_cast<double>(mass),
                804 * 800);  // a unit a column
    const StepReport report = soil->step({});
    EXPECT_EQ(report.tile_awake_count, 0);
    EXPECT_LT(soil->memory_use().bytes_per_asleep_column, 3);
}

TEST(Fill, one_of_the_tiles_that_share_changes_alone) {
    auto soil = make_soil(grid_def(64, 64, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {64, 64, 4})));
    const auto other = make_soil(grid_def(64, 64, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {20, 20, 4}, {22, 22, 6})));
    EXPECT_EQ(soil->surface_height_m(21, 21), 6 * kVoxel);
    EXPECT_EQ(soil->surface_height_m(29, 21), 4 * kVoxel);
    EXPECT_EQ(soil->surface_height_m(13, 21), 4 * kVoxel);
    Soil::Impl& impl = SoilProbe::impl(*soil);
    impl.tiles.wake(3);
    impl.tiles.put_to_sleep(std::array{3});
    EXPECT_EQ(soil->surface_height_m(29, 3), 4 * kVoxel);
}

TEST(Fill, is_the_same_on_any_number_of_threads) {
    std::vector<uint64_t> checksums;
    for (const int threads : {1, 4}) {
        SoilDef def = grid_def(150, 91, 24);
        def.thread_count = threads;
        auto soil = make_soil(def);
        NoiseFill hills;
        hills.base_m = 0.3;
        hills.amplitude_m = 0.2;
        hills.wavelength_m = 2;
        ASSERT_TRUE(soil->fill(hills));
        checksums.push_back(soil->checksum());
        // A caller's function is called on the caller's thread, wherever it lies.
        const auto caller = std::this_thread::get_id();
        bool is_of_caller = true;
        ASSERT_TRUE(soil->fill(FunctionFill{[&](Vec3 p) {
                                                is_of_caller = is_of_caller &&
                                                               std::this_thread::get_id() == caller;
                                                return 0.7 - p.z;
                                            },
                                            {}}));
        EXPECT_TRUE(is_of_caller);
        ASSERT_TRUE(soil->fill(HeightMapFill{2, 2, {0.5f, 0.9f, 0.6f, 1.1f}, {}}));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {3.3, 5, 0}, {120, 80, 20.5})));
        checksums.push_back(soil->checksum());
    }
    EXPECT_EQ(checksums[0], checksums[2]);
    EXPECT_EQ(checksums[1], checksums[3]);
}

// Order and pieces do not matter: what shares content and what does not holds the same soil.
TEST(Fill, a_box_in_pieces_is_the_same_box) {
    const auto whole = make_soil(grid_def(45, 37, 16)), parts = make_soil(grid_def(45, 37, 16));
    ASSERT_TRUE(whole->fill(voxel_box(*whole, {0, 0, 0}, {45, 37, 6})));
    for (double z : {3.0, 0.0, 5.0}) {
        const double top = z == 0 ? 3 : z == 3 ? 5 : 6;
        ASSERT_TRUE(parts->fill(voxel_box(*parts, {0, 0, z}, {21, 37, top})));
        ASSERT_TRUE(parts->fill(voxel_box(*parts, {21, 0, z}, {45, 11, top})));
        ASSERT_TRUE(parts->fill(voxel_box(*parts, {21, 11, z}, {45, 37, top})));
    }
    EXPECT_EQ(parts->checksum(), whole->checksum());
    // Into tiles that are awake, too.
    const auto awake = make_soil(grid_def(45, 37, 16));
    Soil::Impl& impl = SoilProbe::impl(*awake);
    for (size_t i = 0; i < impl.tiles.size(); ++i) impl.tiles.wake(static_cast<int>(i));
    ASSERT_TRUE(awake->fill(voxel_box(*awake, {0, 0, 0}, {45, 37, 6})));
    EXPECT_EQ(awake->checksum(), whole->checksum());
}

}  // namespace
}  // namespace bsoil::fill_test
