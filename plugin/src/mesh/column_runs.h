/// The columns of a tile as runs [bottom, top]: what the display field is made from.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/surface_mesh.h"

#pragma GCC visibility push(default)
namespace bsoil::mesh {

inline constexpr int kTileSide = 8;
inline constexpr int kTileColumns = kTileSide * kTileSide;

/// Bottom of a run that stands on the grid's floor: so deep that only its top shapes the field.
inline constexpr float kOnFloor = -1e9f;

/// Soil this far below its top is seen from above [samples].
inline constexpr float kBareDepth = 1.5f;

/// Of a voxel: less soil than this has no colour of its own where more lies below it.
inline constexpr float kBareLeast = 0.05f;

/// What soil looks like where it lies bare.
struct Look {
    std::array<float, 3> color{};  ///< linear RGB
    MaterialWeights weights{};
    uint8_t wetness = 0;  ///< as Mesh::wetness
    friend bool operator==(const Look&, const Look&) = default;
};

/// A stretch of soil in a column [voxels above the grid's floor].
struct Run {
    float bottom = 0, top = 0;
    uint8_t material = 0;  ///< at its top
    /// Continues soil of a neighbouring column inside terrain: never visible.
    bool in_solid = false;
    bool on_solid = false;  ///< lies on terrain or a body, and dives into it
    Look look;              ///< at its top
    friend bool operator==(const Run&, const Run&) = default;
};

/// A stretch of terrain or static bodies in a column.
struct SolidRun {
    float bottom = 0, top = 0;
    friend bool operator==(const SolidRun&, const SolidRun&) = default;
};

/// From this voxel up, until the next entry, the material is this.
struct MaterialLayer {
    int bottom_voxel = 0;
    uint8_t material = 0;
    friend bool operator==(const MaterialLayer&, const MaterialLayer&) = default;
};

/// From this voxel up, until the next entry, the soil mixes like this and is this wet.
struct MixedLayer {
    int bottom_voxel = 0;
    MaterialWeights weights{};  ///< all 0 where there is but one material
    uint8_t wetness = 0;        ///< as Mesh::wetness
    friend bool operator==(const MixedLayer&, const MixedLayer&) = default;
};

/// Voxels of a column that lie bare to a side: from `bottom_voxel` up to below `end_voxel`.
struct BareWall {
    int bottom_voxel = 0, end_voxel = 0;
    friend bool operator==(const BareWall&, const BareWall&) = default;
};

/// One list per column, packed: column c has items[begin[c]] .. items[begin[c + 1] - 1].
template <typename T>
struct ColumnLists {
    std::vector<T> items;
    std::array<uint32_t, kTileColumns + 1> begin{};
    std::span<const T> column(int c) const {
        return {items.data() + begin[c], begin[c + 1] - begin[c]};
    }
    friend bool operator==(const ColumnLists&, const ColumnLists&) = default;
};

/// The runs of the 64 columns of a tile, index y * 8 + x.
struct TileColumns {
    ColumnLists<Run> runs;
    ColumnLists<SolidRun> solids;
    ColumnLists<MaterialLayer> layers;
    ColumnLists<BareWall> walls;    ///< where there are several materials, or water
    ColumnLists<MixedLayer> mixes;  ///< of those walls
    friend bool operator==(const TileColumns&, const TileColumns&) = default;
};

/// Empties the columns of a tile that lie beyond the grid's sides, of which it has so many along x
/// and y: a soil's are rock. Arrays as from Soil::read_tile.
void clear_beyond(int x_count, int y_count, std::span<float> solid);

/// The runs of a tile of soil, and unless it is null its loose voxels: those whose soil none of the
/// runs shows, index z * 64 + y * 8 + x. Arrays as from Soil::read_tile.
void find_soil_runs(std::span<const float> volume, std::span<const float> solid,
                    std::span<const uint8_t> material, int height, TileColumns& columns,
                    std::vector<int>* loose_voxels = nullptr);
/// The topmost voxel of a run of column c that has a colour of its own, or else that with the most
/// soil. `volume` as from Soil::read_tile.
int seen_voxel(const Run& run, std::span<const float> volume, int c);

/// The runs of a tile of terrain.
void find_terrain_runs(std::span<const float> solid, int height, TileColumns& columns);

}  // namespace bsoil::mesh
#pragma GCC visibility pop
