// The bytes of a sleeping tile: exact both ways, damage refused.
#include "soil/tile_codec.h"

#include <gtest/gtest.h>

#include <climits>
#include <functional>
#include <random>

namespace bsoil::tile_codec_test {
namespace {

TileVoxels tile_of(int height, int planes,
                   const std::function<int32_t(int plane, int z, int column)>& value) {
    TileVoxels tile;
    tile.reset(height, planes);
    for (int p = 0; p < planes; ++p) {
        for (int z = 0; z < height; ++z) {
            for (int c = 0; c < 64; ++c) tile.at(p, z, c) = value(p, z, c);
        }
    }
    return tile;
}

void expect_round_trip(const TileVoxels& tile) {
    const std::vector<uint8_t> bytes = pack_tile(tile);
    TileVoxels back;
    back.reset(tile.height, tile.plane_count);
    std::fill(back.words.begin(), back.words.end(), 77);
    ASSERT_TRUE(unpack_tile(bytes, back));
    EXPECT_EQ(back.words, tile.words);
    TileVoxels two;
    two.reset(tile.height, 2);
    std::fill(two.words.begin(), two.words.end(), 77);
    ASSERT_TRUE(unpack_first_planes(bytes, tile.plane_count, two));
    EXPECT_TRUE(std::equal(two.words.begin(), two.words.end(), tile.words.begin()));
    const int filled = filled_levels(tile);
    EXPECT_EQ(filled_levels(bytes, tile.height, tile.plane_count), filled);
    for (const int levels : {filled, filled / 2, tile.height}) {
        TileVoxels low;
        low.reset(levels, tile.plane_count);
        std::fill(low.words.begin(), low.words.end(), 77);
        ASSERT_TRUE(unpack_levels(bytes, tile.height, low));
        for (int p = 0; p < tile.plane_count; ++p) {
            for (int z = 0; z < tile.height; ++z) {
                for (int c = 0; c < 64; ++c) {
                    ASSERT_EQ(z < levels ? low.at(p, z, c) : 0,
                              z < filled && z < levels ? tile.at(p, z, c) : 0);
                    ASSERT_TRUE(z < filled || tile.at(p, z, c) == 0);
                }
            }
        }
    }
}

TEST(TileCodec, tells_up_to_where_there_is_anything) {
    for (const int top : {0, 1, 7, 24}) {
        const TileVoxels tile = tile_of(
            24, 9, [top](int p, int z, int c) { return p == 3 && c == 63 && z < top ? -1 : 0; });
        EXPECT_EQ(filled_levels(tile), top);
        EXPECT_EQ(filled_levels(pack_tile(tile), 24, 9), top);
    }
    EXPECT_EQ(filled_levels(std::span<const uint8_t>(), 24, 9), 0);
}

TEST(TileCodec, gives_back_what_it_got) {
    std::mt19937 random(1);
    for (int height : {8, 24, 512}) {
        for (int planes : {9, 16}) {
            expect_round_trip(tile_of(height, planes, [](int, int, int) { return 0; }));
            expect_round_trip(tile_of(height, planes, [](int, int, int) { return INT_MIN; }));
            expect_round_trip(tile_of(height, planes, [](int p, int z, int c) {
                return (p + z + c) % 2 ? INT_MAX : INT_MIN;
            }));
            expect_round_trip(tile_of(
                height, planes, [&](int, int, int) { return static_cast<int32_t>(random()); }));
            expect_round_trip(tile_of(height, planes, [&](int, int, int) {
                return random() % 5 ? 0 : static_cast<int32_t>(random() % 9) - 4;
            }));
            // Level ground of equal columns, and one column that differs in its last voxel only.
            expect_round_trip(tile_of(height, planes, [&](int p, int z, int) {
                return p == 1 && z < height / 2 ? 65536 : 0;
            }));
            expect_round_trip(tile_of(height, planes, [&](int p, int z, int c) {
                return p == planes - 1 && z == height - 1 && c == 63 ? -1 : 0;
            }));
        }
    }
}

TEST(TileCodec, gives_the_same_bytes_from_runs) {
    std::mt19937 random(4);
    for (const auto& value : std::vector<std::function<int32_t(int, int, int)>>{
             [](int, int, int) { return 0; }, [](int p, int z, int) { return p == 1 && z < 9; },
             [](int p, int, int c) { return p * c; },
             [&](int, int, int) { return static_cast<int32_t>(random() % 3); }}) {
        const std::vector<uint8_t> bytes = pack_tile(tile_of(24, 10, value));
        TileRuns runs;
        runs.height = 24;
        runs.plane_count = 10;
        ASSERT_TRUE(unpack_runs(bytes, runs));
        EXPECT_EQ(pack_runs(runs), bytes);
    }
}

TEST(TileCodec, packs_level_ground_into_two_bytes_a_column_or_less) {
    const TileVoxels level =
        tile_of(64, 9, [](int p, int z, int) { return (p == 1 || p == 8) && z < 20 ? 65536 : 0; });
    EXPECT_LE(pack_tile(level).size(), 2u * 64);
}

TEST(TileCodec, takes_no_bytes_as_air) {
    TileVoxels tile = tile_of(8, 9, [](int, int, int) { return 5; });
    ASSERT_TRUE(unpack_tile({}, tile));
    EXPECT_EQ(tile.words, tile_of(8, 9, [](int, int, int) { return 0; }).words);
}

TEST(TileCodec, refuses_bytes_cut_short_or_with_more_behind) {
    std::mt19937 random(2);
    const TileVoxels tile = tile_of(
        16, 9, [&](int, int, int) { return random() % 3 ? 0 : static_cast<int32_t>(random()); });
    const std::vector<uint8_t> bytes = pack_tile(tile);
    TileVoxels back;
    back.reset(16, 9);
    for (size_t size = 1; size < bytes.size(); size += 7) {
        EXPECT_FALSE(unpack_tile(std::span(bytes).first(size), back)) << size;
    }
    std::vector<uint8_t> longer = bytes;
    longer.push_back(0);
    EXPECT_FALSE(unpack_tile(longer, back));
}

TEST(TileCodec, survives_any_damage) {
    // Damage that still reads as a tile cannot be told from one here; the snapshot's hash does
    // that. No byte may make the reader leave its buffers (sanitizers watch).
    std::mt19937 random(3);
    const TileVoxels tile = tile_of(
        16, 9, [&](int, int z, int c) { return (z + c) % 4 ? 0 : static_cast<int32_t>(random()); });
    const std::vector<uint8_t> bytes = pack_tile(tile);
    TileVoxels back;
    back.reset(16, 9);
    int refused_count = 0;
    for (int i = 0; i < 2000; ++i) {
        std::vector<uint8_t> damaged = bytes;
        damaged[random() % damaged.size()] ^= static_cast<uint8_t>(1u << random() % 8);
        refused_count += !unpack_tile(damaged, back);
        for (uint8_t& byte : damaged) byte = static_cast<uint8_t>(random());
        refused_count += !unpack_tile(damaged, back);
    }
    EXPECT_GT(refused_count, 2000);
}

}  // namespace
}  // namespace bsoil::tile_codec_test
