/// Runs and loose voxels of random tiles, against what they are voxel by voxel.
#include "mesh/column_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace bsoil::mesh::column_runs_test {
namespace {

/// A tile of soil and ground.
struct Voxels {
    int height = 0;
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;

    float soil_at(int z, int c) const {
        return z < 0 || z >= height ? 0 : volume[static_cast<size_t>(z * kTileColumns + c)];
    }
    float solid_at(int z, int c) const {
        return z < 0 || z >= height ? 0 : solid[static_cast<size_t>(z * kTileColumns + c)];
    }
    bool is_supported(int z, int c) const { return z == 0 || solid_at(z - 1, c) >= 0.5f; }
    /// At least half full, or a trace on ground or that fills up ground.
    bool is_thick(int z, int c) const {
        if (z < 0 || z >= height) return false;
        const float soil = soil_at(z, c);
        return soil >= 0.5f ||
               (soil > 0.01f && (soil + solid_at(z, c) >= 0.5f || is_supported(z, c)));
    }
    bool is_beside_some(int z, int c) const {
        const int x = c % kTileSide, y = c / kTileSide;
        for (const auto& [i, j] : {std::pair(x - 1, y), {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
            if (i < 0 || j < 0 || i >= kTileSide || j >= kTileSide) continue;
            const int other = j * kTileSide + i;
            if (soil_at(z, other) >= 0.5f || solid_at(z, other) >= 0.5f) return true;
        }
        return false;
    }
    /// A voxel that flies all by itself is in no run.
    bool is_in_run(int z, int c) const {
        return is_thick(z, c) && (is_supported(z, c) || solid_at(z, c) >= 0.01f ||
                                  is_thick(z - 1, c) || is_thick(z + 1, c) || is_beside_some(z, c));
    }
    bool is_loose(int z, int c) const {
        return soil_at(z, c) >= 1.0f / 1024 && solid_at(z, c) < 0.5f && !is_in_run(z, c) &&
               !is_in_run(z - 1, c) && !(is_in_run(z + 1, c) && !is_supported(z + 1, c));
    }
};

/// Beds, clouds of soil, and noise of all that decides.
Voxels random_voxels(std::mt19937& random) {
    Voxels voxels;
    const auto any = [&](int count) {
        return static_cast<int>(random() % static_cast<unsigned>(count));
    };
    voxels.height = 1 + any(130);
    const int kind = any(4), full = any(voxels.height);
    const auto amount = [&] {
        constexpr float kAmounts[] = {0, 1, 0.5f, 0.01f, 0.4999f, 1.0f / 1024};
        const int which = any(8);
        return which < 6 ? kAmounts[which]
                         : static_cast<float>(any(1000)) / (which < 7 ? 1e3f : 1e5f);
    };
    const auto rarely = [&](int rare) { return any(rare) == 0 ? amount() : 0.0f; };
    for (int v = 0; v < voxels.height * kTileColumns; ++v) {
        const int z = v / kTileColumns;
        voxels.volume.push_back(kind == 0 ? amount() : kind < 3 && z < full ? 1 : rarely(15));
        voxels.solid.push_back(kind == 0                   ? amount()
                               : kind == 2 && z < full / 2 ? 1
                                                           : rarely(kind == 3 ? 1000000 : 40));
        voxels.material.push_back(static_cast<uint8_t>(kind == 1   ? any(3)
                                                       : kind == 2 ? z / 5 % 2
                                                                   : 0));
    }
    return voxels;
}

// Of columns that are full up to a height, and of a slab in the air.
TEST(ColumnRuns, of_a_bed_end_where_its_soil_does) {
    constexpr int kHeight = 70;
    std::vector<float> volume(kHeight * kTileColumns), none(kHeight * kTileColumns);
    const auto top_of = [](int c) { return 1 + c % 67; };
    for (int c = 0; c < kTileColumns; ++c) {
        for (int z = 0; z < top_of(c); ++z) volume[static_cast<size_t>(z * kTileColumns + c)] = 1;
        volume[static_cast<size_t>(top_of(c) * kTileColumns + c)] = 0.75f;
    }
    TileColumns columns;
    find_soil_runs(volume, none, std::vector<uint8_t>(volume.size()), kHeight, columns);
    for (int c = 0; c < kTileColumns; ++c) {
        ASSERT_EQ(columns.runs.column(c).size(), 1u);
        EXPECT_EQ(columns.runs.column(c)[0].bottom, kOnFloor);
        EXPECT_EQ(columns.runs.column(c)[0].top, static_cast<float>(top_of(c)) + 0.75f);
    }
    find_terrain_runs(volume, kHeight, columns);
    for (int c = 0; c < kTileColumns; ++c) {
        ASSERT_EQ(columns.runs.column(c).size(), 1u);
        EXPECT_EQ(columns.runs.column(c)[0].top, static_cast<float>(top_of(c)) + 0.75f);
    }
    std::ranges::fill(volume, 0.0f);
    std::fill_n(volume.begin() + 30 * kTileColumns, 3 * kTileColumns, 1.0f);
    find_soil_runs(volume, none, std::vector<uint8_t>(volume.size()), kHeight, columns);
    for (int c = 0; c < kTileColumns; ++c) {
        ASSERT_EQ(columns.runs.column(c).size(), 1u);
        EXPECT_EQ(columns.runs.column(c)[0].bottom, 30.0f);
        EXPECT_EQ(columns.runs.column(c)[0].top, 33.0f);
    }
}

TEST(ColumnRuns, are_what_voxels_say_one_by_one) {
    std::mt19937 random(7);
    for (int round = 0; round < 300; ++round) {
        const Voxels voxels = random_voxels(random);
        const int height = voxels.height;
        TileColumns columns;
        std::vector<int> loose, expected_loose;
        find_soil_runs(voxels.volume, voxels.solid, voxels.material, height, columns, &loose);
        for (int v = 0; v < height * kTileColumns; ++v) {
            if (voxels.is_loose(v / kTileColumns, v % kTileColumns)) expected_loose.push_back(v);
        }
        ASSERT_EQ(loose, expected_loose) << round;
        for (int c = 0; c < kTileColumns; ++c) {
            std::vector<MaterialLayer> layers;
            std::vector<int> grounds;  // where solid begins
            bool has_run = false;
            for (int z = 0; z < height; ++z) {
                if (voxels.solid_at(z, c) >= 0.5f && voxels.solid_at(z - 1, c) < 0.5f) {
                    grounds.push_back(z);
                }
                if (!voxels.is_in_run(z, c)) continue;
                has_run = true;
                const uint8_t material = voxels.material[static_cast<size_t>(z * kTileColumns + c)];
                if (layers.empty() || layers.back().material != material) {
                    layers.push_back({z, material});
                }
            }
            ASSERT_TRUE(std::ranges::equal(columns.layers.column(c), layers)) << round;
            ASSERT_EQ(columns.runs.column(c).empty(), !has_run) << round;
            const auto solids = columns.solids.column(c);
            ASSERT_EQ(solids.size(), grounds.size()) << round;
            for (size_t k = 0; k < grounds.size(); ++k) {
                ASSERT_EQ(solids[k].bottom, static_cast<float>(grounds[k])) << round;
                int end = grounds[k];
                while (voxels.solid_at(end, c) >= 0.5f) ++end;
                ASSERT_EQ(solids[k].top, static_cast<float>(end - 1) +
                                             std::min(1.0f, voxels.solid_at(end - 1, c)) +
                                             voxels.solid_at(end, c))
                    << round;
            }
        }
    }
}

}  // namespace
}  // namespace bsoil::mesh::column_runs_test
