#include "mesh/display_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "mesh/mesh_kernels.h"

namespace bsoil::mesh {
namespace {

using kernels::kHiddenEdge;
using kernels::kNormalReach;
using kernels::kReach;
using kernels::kSlopeMax;
using kernels::kWallMin;

constexpr float kBelowSolid = 0.5f;   ///< soil hidden in terrain stays this deep below its surface
constexpr float kHiddenDepth = 2.0f;  ///< and is this thick [samples]
constexpr float kSheetStep = 3.0f;  ///< tops further apart are not one surface at the grid's sides
/// Soil on a support dives into it by this many voxels for each voxel between samples, so that a
/// sample of a coarse level lies in it, however thin it is.
constexpr float kDive = 2.0f;

}  // namespace

void DisplayField::build(const GridColumns& grid, const TileLevels& levels, int level, int tx,
                         int ty) {
    level_ = level;
    for (int axis = 0; axis < 3; ++axis) lattice_[axis] = {grid.size[axis], 1 << level};
    word_count_ = (sample_count_z() + 63) / 64;
    runs_.clear();
    columns_.fill({});
    bits_.assign(static_cast<size_t>(kWindow * kWindow * word_count_), 0);
    const int tile[2] = {tx, ty}, side = TileLevels::cells_of(level);
    int first[2], last[2];  // samples of the window that are not empty
    for (int axis = 0; axis < 2; ++axis) {
        const int begin = tile[axis] * side, count = lattice_[axis].count();
        const bool is_last = tile[axis] + 1 == grid.tile_count[axis];
        origin_[axis] = begin - 2;
        cell_first_[axis] = begin == 0 ? -2 : begin;
        cell_last_[axis] = is_last ? count : begin + side - 1;
        // A side that the window ends just short of is the next tile's: nothing here reads beyond.
        first[axis] = begin - 1;
        last[axis] = std::min(begin + side + 1, count);
    }
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
            columns_[column_index(i, j)] =
                make_column(grid, levels, lattice_[0].voxel(i), lattice_[1].voxel(j));
            set_bits(i, j);
        }
    }
}

/// The column of voxels (x, y), the same whichever tile asks. Beyond a side of the grid, half a
/// voxel further on: the straight continuation of the two columns before it. At an edge of the grid
/// first along x, then along y.
DisplayField::Column DisplayField::make_column(const GridColumns& grid, const TileLevels& levels,
                                               int x, int y) {
    const int nx = grid.size[0], ny = grid.size[1];
    const auto before = [](int at, int size) {
        return at < 0 ? std::min(1, size - 1) : std::max(0, size - 2);
    };
    const bool is_fine = levels.finest_at(std::clamp(x, 0, nx - 1), std::clamp(y, 0, ny - 1)) == 0;
    if (y < 0 || y == ny) {
        const Column last = make_column(grid, levels, x, std::clamp(y, 0, ny - 1));
        return continued(last, make_column(grid, levels, x, before(y, ny)), is_fine);
    }
    if (x < 0 || x == nx) {
        const Column last = make_column(grid, levels, std::clamp(x, 0, nx - 1), y);
        return continued(last, make_column(grid, levels, before(x, nx), y), is_fine);
    }
    const TileColumns& tile = grid.tiles[(y / kTileSide) * grid.tile_count[0] + x / kTileSide];
    const int c = (y % kTileSide) * kTileSide + x % kTileSide;
    const int spacing = 1 << levels.finest_at(x, y);
    Column column;
    column.solids = tile.solids.column(c);
    column.layers = tile.layers.column(c);
    column.mixes = tile.mixes.column(c);
    column.run_begin = static_cast<uint32_t>(runs_.size());
    for (Run run : tile.runs.column(c)) {
        if (run.on_solid) run.bottom -= kDive * static_cast<float>(spacing - 1);
        runs_.push_back(run);
    }
    column.run_end = static_cast<uint32_t>(runs_.size());
    continue_into_solid(grid, x, y, spacing, column);
    return column;
}

/// Where soil ends at terrain its surface goes on for one sample inside the terrain, so that the
/// two surfaces cross each other instead of leaving a crack.
void DisplayField::continue_into_solid(const GridColumns& grid, int x, int y, int spacing,
                                       Column& column) {
    for (const SolidRun& solid : column.solids) {
        const std::span<const Run> own{runs_.data() + column.run_begin,
                                       column.run_end - column.run_begin};
        const bool covered = std::any_of(own.begin(), own.end(), [&](const Run& run) {
            return run.bottom < solid.top && run.top >= solid.top;
        });
        if (covered) continue;
        float top_sum = 0;
        int top_count = 0;
        const Run* soil = nullptr;
        for (int v = y - spacing; v <= y + spacing; v += spacing) {
            for (int u = x - spacing; u <= x + spacing; u += spacing) {
                if (u < 0 || u >= grid.size[0] || v < 0 || v >= grid.size[1]) continue;
                const TileColumns& tile =
                    grid.tiles[(v / kTileSide) * grid.tile_count[0] + u / kTileSide];
                const int c = (v % kTileSide) * kTileSide + u % kTileSide;
                for (const Run& run : tile.runs.column(c)) {
                    if (run.top <= solid.bottom || run.bottom >= solid.top) continue;
                    top_sum += run.top;
                    ++top_count;
                    soil = &run;
                }
            }
        }
        if (top_count == 0) continue;
        const float top =
            std::min(solid.top - kBelowSolid, top_sum / static_cast<float>(top_count));
        const float depth = kHiddenDepth * static_cast<float>(spacing);
        const float bottom = std::max(solid.bottom, top - depth);
        if (top <= bottom) continue;
        Run hidden;
        hidden.bottom = bottom;
        hidden.top = top;
        hidden.material = soil->material;
        hidden.in_solid = true;
        hidden.look = soil->look;
        runs_.push_back(hidden);
        column.run_end = static_cast<uint32_t>(runs_.size());
    }
}

/// Where soil on a support ends that a side of the grid lays bare: on that support, or at its
/// highest sample, without which it would not be there at all.
float DisplayField::bare_bottom(const Run& run, std::span<const SolidRun> solids) {
    const auto support = std::ranges::find_if(
        solids, [&run](const SolidRun& solid) { return solid.top > run.bottom; });
    if (support == solids.end()) return run.bottom;
    const float highest = std::ceil(run.top - 0.5f) - 0.5f;
    return std::max(run.bottom, std::min(support->top, highest));
}

/// is_fine: at full detail. From afar what is hidden fills up what coarse terrain leaves open.
DisplayField::Column DisplayField::continued(const Column& last, const Column& before,
                                             bool is_fine) {
    Column column = last;
    column.run_begin = static_cast<uint32_t>(runs_.size());
    for (uint32_t r = last.run_begin; r < last.run_end; ++r) {
        Run run = runs_[r];
        if (run.in_solid && is_fine) continue;  // the plane would lay it bare
        for (uint32_t b = before.run_begin; b < before.run_end; ++b) {
            const Run inner = runs_[b];
            if (std::abs(inner.top - run.top) > kSheetStep) continue;
            run.top += 0.5f * (run.top - inner.top);
            if (run.bottom != kOnFloor && std::abs(inner.bottom - run.bottom) <= kSheetStep) {
                run.bottom += 0.5f * (run.bottom - inner.bottom);
            }
            break;
        }
        run.top = std::min(run.top, static_cast<float>(lattice_[2].size));
        if (run.on_solid && is_fine) run.bottom = bare_bottom(run, column.solids);
        if (run.top > run.bottom) runs_.push_back(run);
    }
    column.run_end = static_cast<uint32_t>(runs_.size());
    return column;
}

void DisplayField::set_bits(int i, int j) {
    uint64_t* bits = &bits_[column_index(i, j) * word_count_];
    const auto spacing = static_cast<float>(lattice_[2].spacing);
    for (const Run& run : runs(i, j)) {
        // Sample k is inside where bottom <= height < top; sample -1 lies on the floor. Divisions
        // by a power of two are exact.
        int first =
            run.bottom <= 0 ? -1 : static_cast<int>(std::ceil((run.bottom - 0.5f) / spacing));
        int last = run.top <= 0 ? -2 : static_cast<int>(std::ceil((run.top - 0.5f) / spacing)) - 1;
        last = std::min(last, lattice_[2].count() - 1);
        for (int q = first + 2; q <= last + 2; q = (q / 64 + 1) * 64) {
            const int count = std::min(last + 2, q | 63) - q + 1;
            bits[q / 64] |= (~uint64_t{0} >> (64 - count)) << (q % 64);
        }
    }
}

const Run* DisplayField::run_at(int i, int j, float z) const {
    const Run* found = nullptr;
    for (const Run& run : runs(i, j)) {
        if (run.bottom <= z && z < run.top && (!found || run.top > found->top)) found = &run;
    }
    return found;
}

float DisplayField::distance(int i, int j, float z, float reach) const {
    float result = std::max(-reach, -z);  // soil thins out towards the floor, not towards nothing
    for (const Run& run : runs(i, j)) {
        result = std::max(result, std::min(run.top - z, z - run.bottom));
    }
    return std::min(result, reach);
}

float DisplayField::crossing_up(int i, int j, int q) const {
    const float low = height(q), high = height(q + 1);
    const bool top = (inside_bits(i, j)[q / 64] >> (q % 64) & 1) != 0;
    const Run* run = run_at(i, j, top ? low : high);
    assert(run);
    return std::clamp(top ? run->top : run->bottom, low, high);
}

float DisplayField::crossing_aside(const int inside[2], const int outside[2], float length,
                                   float z) const {
    const Run* run = run_at(inside[0], inside[1], z);
    if (run && run->in_solid) {
        const auto& solids = columns_[column_index(outside[0], outside[1])].solids;
        const bool hidden = std::any_of(solids.begin(), solids.end(), [&](const SolidRun& solid) {
            return solid.bottom <= z && z < solid.top;
        });
        return hidden ? 0.5f : kHiddenEdge;
    }
    const float scale = std::max(1.0f, length);  // at a side of the grid samples lie closer
    const float here = distance(inside[0], inside[1], z, kReach * scale);
    const float there = distance(outside[0], outside[1], z, kReach * scale);
    const float difference = here - there;
    if (difference <= 0) return 0.5f;
    const float linear = here / difference;  // thesis (11)
    const float wall =
        std::clamp((difference / scale - kSlopeMax) / (kWallMin - kSlopeMax), 0.0f, 1.0f);
    return linear + wall * (0.5f - linear);
}

float DisplayField::limited(int i, int j, float z) const {
    return distance(i, j, z, kNormalReach * static_cast<float>(lattice_[2].spacing));
}

float DisplayField::step(int axis, int i, int j, float z) const {
    const int along = axis == 0 ? i : j;
    const float length = position(axis, along + 1) - position(axis, along);
    const float rise = (axis == 0 ? limited(i + 1, j, z) : limited(i, j + 1, z)) - limited(i, j, z);
    return length > 0 ? rise / length : 0.0f;
}

float DisplayField::slope(int axis, int i, int j, float z) const {
    const int along = axis == 0 ? i : j;
    const int low = std::max(along - 1, -1), high = std::min(along + 1, lattice_[axis].count());
    const float length = position(axis, high) - position(axis, low);
    const float rise = axis == 0 ? limited(high, j, z) - limited(low, j, z)
                                 : limited(i, high, z) - limited(i, low, z);
    return length > 0 ? rise / length : 0.0f;
}

float DisplayField::slope_up(int i, int j, float z) const {
    const auto spacing = static_cast<float>(lattice_[2].spacing);
    return (limited(i, j, z + 0.5f * spacing) - limited(i, j, z - 0.5f * spacing)) / spacing;
}

uint8_t DisplayField::material(int i, int j, float z) const {
    const Run* run = run_at(i, j, z);
    if (run && run->in_solid) return run->material;
    const auto voxel = static_cast<int>(z);
    uint8_t result = run ? run->material : uint8_t{0};
    for (const MaterialLayer& layer : columns_[column_index(i, j)].layers) {
        if (layer.bottom_voxel > voxel) break;
        result = layer.material;
    }
    return result;
}

const MixedLayer* DisplayField::mixture(int i, int j, float z) const {
    const Run* run = run_at(i, j, z);
    if (run && run->in_solid) return nullptr;
    const MixedLayer* result = nullptr;
    for (const MixedLayer& layer : columns_[column_index(i, j)].mixes) {
        if (layer.bottom_voxel > static_cast<int>(z)) break;
        result = &layer;
    }
    return result;
}

const Look* DisplayField::bare_look(int i, int j, float z) const {
    const Run* run = run_at(i, j, z);
    const float depth = kBareDepth * static_cast<float>(lattice_[2].spacing);
    return run && z >= run->top - depth ? &run->look : nullptr;
}

uint64_t DisplayField::material_borders(int i, int j, int w) const {
    uint64_t borders = 0;
    const auto add = [&](const auto& layers) {
        for (size_t k = 1; k < layers.size(); ++k) {
            const int spacing = lattice_[2].spacing;
            const int first_above = (layers[k].bottom_voxel + spacing - 1) / spacing;
            const int above = first_above + 2;  // sample 0 is two below the first voxel
            for (const int q : {above - 1, above}) {
                if (q / 64 == w) borders |= uint64_t{1} << (q % 64);
            }
        }
    };
    const Column& column = columns_[column_index(i, j)];
    add(column.layers);
    add(column.mixes);
    return borders;
}

}  // namespace bsoil::mesh
