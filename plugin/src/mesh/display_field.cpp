#include "mesh/display_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace bsoil::mesh {
namespace {

constexpr float kReach = 6.0f;  ///< the field is linear this far from a surface [voxels]
/// Up to the first height difference [voxels] neighbouring tops are joined by a straight line, from
/// the second on by an upright wall half way. 2.5 is 68 degrees: steeper than any slope at rest.
constexpr float kSlopeMax = 2.5f, kWallMin = 5.0f;
constexpr float kNormalReach = 2.0f;  ///< beyond this a height difference tilts normals no more
constexpr float kBelowSolid = 0.5f;   ///< soil hidden in terrain stays this deep below its surface
constexpr float kHiddenDepth = 2.0f;  ///< and is this thick
constexpr float kHiddenEdge = 0.05f;  ///< where it ends between two samples, so as not to peep out
constexpr float kSheetStep = 3.0f;  ///< tops further apart are not one surface at the grid's sides

}  // namespace

float DisplayField::position(int axis, int i) const {
    const auto end = static_cast<float>(size_[axis]);
    return std::clamp(static_cast<float>(i) + 0.5f, 0.0f, end);
}

void DisplayField::build(const GridColumns& grid, int tx, int ty) {
    std::copy(std::begin(grid.size), std::end(grid.size), size_);
    word_count_ = (sample_count_z() + 63) / 64;
    runs_.clear();
    columns_.fill({});
    bits_.assign(static_cast<size_t>(kWindow * kWindow * word_count_), 0);
    const int tile[2] = {tx, ty};
    int first[2], last[2];  // real columns of the window
    for (int axis = 0; axis < 2; ++axis) {
        const int begin = tile[axis] * kTileSide;
        const bool last_tile = tile[axis] + 1 == grid.tile_count[axis];
        origin_[axis] = begin - 2;
        cell_first_[axis] = begin == 0 ? -2 : begin;
        cell_last_[axis] = last_tile ? size_[axis] : begin + kTileSide - 1;
        first[axis] = std::max(0, begin - 1);
        last[axis] = std::min(size_[axis] - 1, origin_[axis] + kWindow - 1);
    }
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
            take_column(grid, i, j);
            continue_into_solid(grid, i, j);
            set_bits(i, j);
        }
    }
    // Beyond the sides along x, then along y with the columns just made, which gives the corners.
    const int nx = size_[0], ny = size_[1];
    const bool at_begin[2] = {tx == 0, ty == 0};
    // A side that the window ends just short of is the next tile's: nothing here reads beyond it.
    const bool at_end[2] = {nx < origin_[0] + kWindow, ny < origin_[1] + kWindow};
    for (int j = first[1]; j <= last[1]; ++j) {
        const int low[2] = {0, j}, low_next[2] = {std::min(1, nx - 1), j};
        const int high[2] = {nx - 1, j}, high_next[2] = {std::max(0, nx - 2), j};
        if (at_begin[0]) continue_beyond(-1, j, low, low_next);
        if (at_end[0]) continue_beyond(nx, j, high, high_next);
    }
    const int wide_first = at_begin[0] ? -1 : first[0], wide_last = at_end[0] ? nx : last[0];
    for (int i = wide_first; i <= wide_last; ++i) {
        const int low[2] = {i, 0}, low_next[2] = {i, std::min(1, ny - 1)};
        const int high[2] = {i, ny - 1}, high_next[2] = {i, std::max(0, ny - 2)};
        if (at_begin[1]) continue_beyond(i, -1, low, low_next);
        if (at_end[1]) continue_beyond(i, ny, high, high_next);
    }
}

void DisplayField::take_column(const GridColumns& grid, int i, int j) {
    const TileColumns& tile = grid.tiles[(j / kTileSide) * grid.tile_count[0] + i / kTileSide];
    const int c = (j % kTileSide) * kTileSide + i % kTileSide;
    Column& column = columns_[column_index(i, j)];
    column.solids = tile.solids.column(c);
    column.layers = tile.layers.column(c);
    const std::span<const Run> source = tile.runs.column(c);
    column.run_begin = static_cast<uint32_t>(runs_.size());
    runs_.insert(runs_.end(), source.begin(), source.end());
    column.run_end = static_cast<uint32_t>(runs_.size());
}

void DisplayField::continue_into_solid(const GridColumns& grid, int i, int j) {
    // Where soil ends at terrain its surface goes on for one column inside the terrain, so that the
    // two surfaces cross each other instead of leaving a crack.
    Column& column = columns_[column_index(i, j)];
    for (const SolidRun& solid : column.solids) {
        const std::span<const Run> own{runs_.data() + column.run_begin,
                                       column.run_end - column.run_begin};
        const bool covered = std::any_of(own.begin(), own.end(), [&](const Run& run) {
            return run.bottom < solid.top && run.top >= solid.top;
        });
        if (covered) continue;
        float top_sum = 0;
        int top_count = 0;
        uint8_t soil_material = 0;
        for (int y = std::max(0, j - 1); y <= std::min(size_[1] - 1, j + 1); ++y) {
            for (int x = std::max(0, i - 1); x <= std::min(size_[0] - 1, i + 1); ++x) {
                const TileColumns& tile =
                    grid.tiles[(y / kTileSide) * grid.tile_count[0] + x / kTileSide];
                const int c = (y % kTileSide) * kTileSide + x % kTileSide;
                for (const Run& run : tile.runs.column(c)) {
                    if (run.top <= solid.bottom || run.bottom >= solid.top) continue;
                    top_sum += run.top;
                    ++top_count;
                    soil_material = run.material;
                }
            }
        }
        if (top_count == 0) continue;
        const float top =
            std::min(solid.top - kBelowSolid, top_sum / static_cast<float>(top_count));
        const float bottom = std::max(solid.bottom, top - kHiddenDepth);
        if (top <= bottom) continue;
        runs_.push_back({bottom, top, soil_material, true});
        column.run_end = static_cast<uint32_t>(runs_.size());
    }
}

void DisplayField::continue_beyond(int i, int j, const int last[2], const int before[2]) {
    // Half a voxel further on, on the grid's side: the straight continuation of each surface.
    Column& column = columns_[column_index(i, j)];
    const Column& source = columns_[column_index(last[0], last[1])];
    column = source;
    column.run_begin = static_cast<uint32_t>(runs_.size());
    for (uint32_t r = source.run_begin; r < source.run_end; ++r) {
        Run run = runs_[r];
        for (const Run& inner : runs(before[0], before[1])) {
            if (std::abs(inner.top - run.top) > kSheetStep) continue;
            run.top += 0.5f * (run.top - inner.top);
            if (run.bottom != kOnFloor && std::abs(inner.bottom - run.bottom) <= kSheetStep) {
                run.bottom += 0.5f * (run.bottom - inner.bottom);
            }
            break;
        }
        run.top = std::min(run.top, static_cast<float>(size_[2]));
        if (run.top > run.bottom) runs_.push_back(run);
    }
    column.run_end = static_cast<uint32_t>(runs_.size());
    set_bits(i, j);
}

void DisplayField::set_bits(int i, int j) {
    uint64_t* bits = &bits_[column_index(i, j) * word_count_];
    for (const Run& run : runs(i, j)) {
        // Sample k is inside where bottom <= height < top; sample -1 lies on the floor.
        int first = run.bottom <= 0 ? -1 : static_cast<int>(std::ceil(run.bottom - 0.5f));
        int last = run.top <= 0 ? -2 : static_cast<int>(std::ceil(run.top - 1.5f));
        last = std::min(last, size_[2] - 1);
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

float DisplayField::distance(int i, int j, float z) const {
    float result = std::max(-kReach, -z);  // soil thins out towards the floor, not towards nothing
    for (const Run& run : runs(i, j)) {
        result = std::max(result, std::min(run.top - z, z - run.bottom));
    }
    return std::min(result, kReach);
}

float DisplayField::crossing_up(int i, int j, int q) const {
    const float low = height(q), high = height(q + 1);
    const bool top = (inside_bits(i, j)[q / 64] >> (q % 64) & 1) != 0;
    const Run* run = run_at(i, j, top ? low : high);
    assert(run);
    return std::clamp(top ? run->top : run->bottom, low, high);
}

float DisplayField::crossing_aside(const int inside[2], const int outside[2], float z) const {
    const Run* run = run_at(inside[0], inside[1], z);
    if (run && run->in_solid) {
        const auto& solids = columns_[column_index(outside[0], outside[1])].solids;
        const bool hidden = std::any_of(solids.begin(), solids.end(), [&](const SolidRun& solid) {
            return solid.bottom <= z && z < solid.top;
        });
        return hidden ? 0.5f : kHiddenEdge;
    }
    const float here = distance(inside[0], inside[1], z);
    const float there = distance(outside[0], outside[1], z);
    const float difference = here - there;
    if (difference <= 0) return 0.5f;
    const float linear = here / difference;  // thesis (11)
    const float wall = std::clamp((difference - kSlopeMax) / (kWallMin - kSlopeMax), 0.0f, 1.0f);
    return linear + wall * (0.5f - linear);
}

float DisplayField::limited(int i, int j, float z) const {
    return std::clamp(distance(i, j, z), -kNormalReach, kNormalReach);
}

float DisplayField::step(int axis, int i, int j, float z) const {
    const int along = axis == 0 ? i : j;
    const float length = position(axis, along + 1) - position(axis, along);
    const float rise = (axis == 0 ? limited(i + 1, j, z) : limited(i, j + 1, z)) - limited(i, j, z);
    return length > 0 ? rise / length : 0.0f;
}

float DisplayField::slope(int axis, int i, int j, float z) const {
    const int along = axis == 0 ? i : j;
    const int low = std::max(along - 1, -1), high = std::min(along + 1, size_[axis]);
    const float length = position(axis, high) - position(axis, low);
    const float rise = axis == 0 ? limited(high, j, z) - limited(low, j, z)
                                 : limited(i, high, z) - limited(i, low, z);
    return length > 0 ? rise / length : 0.0f;
}

float DisplayField::slope_up(int i, int j, float z) const {
    return limited(i, j, z + 0.5f) - limited(i, j, z - 0.5f);
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

uint64_t DisplayField::material_borders(int i, int j, int w) const {
    uint64_t borders = 0;
    const auto& layers = columns_[column_index(i, j)].layers;
    for (size_t k = 1; k < layers.size(); ++k) {
        const int above = layers[k].bottom_voxel + 2;  // sample 0 is two below the first voxel
        for (const int q : {above - 1, above}) {
            if (q / 64 == w) borders |= uint64_t{1} << (q % 64);
        }
    }
    return borders;
}

}  // namespace bsoil::mesh
