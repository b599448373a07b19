#include "mesh/column_runs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace bsoil::mesh {
namespace {

constexpr float kDense = 0.5f;  ///< from this fill on a voxel counts as part of a run: the isovalue
constexpr float kTrace = 0.01f;             ///< less soil than this in a voxel is not shown
constexpr float kGrainLeast = 1.0f / 1024;  ///< less soil than this is not even a grain
constexpr float kOverlap = 2.0f;  ///< how far soil continues into the solid it rests on [voxels]
constexpr float kGapMin =
    1.0f;  ///< runs closer than this are one: pores of moving soil are not shown
constexpr float kSliverHalf =
    0.05f;  ///< a run too thin to hold a sample is widened about one by this

/// Bit c: column c of a tile.
using ColumnBits = uint64_t;
constexpr ColumnBits kAllColumns = ~ColumnBits{0};
static_assert(kTileColumns == 64);

/// Those beside the columns of `bits` in the tile.
ColumnBits beside(ColumnBits bits) {
    constexpr ColumnBits kFirstOfRows = 0x0101010101010101;
    return (bits << 1 & ~kFirstOfRows) | (bits >> 1 & ~(kFirstOfRows << (kTileSide - 1))) |
           bits << kTileSide | bits >> kTileSide;
}

/// What the voxels of a tile are, a layer at a time.
class LayerBits {
  public:
    /// `solid` may be null: none.
    LayerBits(const float* volume, const float* solid, int height)
        : layers_(static_cast<size_t>(height) + 2) {
        std::array<uint8_t, kTileColumns> flags{}, before{};
        Layer* layer = &layers_[1];
        for (int z = 0; z < height; ++z, ++layer) {
            flag_layer(volume + z * kTileColumns, solid ? solid + z * kTileColumns : nullptr,
                       flags);
            if (z > 0 && flags == before) {  // as in a bed, and above it
                *layer = layer[-1];
            } else {
                unpack(flags, *layer);
                before = flags;
            }
        }
    }

    ColumnBits supported(int z) const { return z > 0 ? at(z - 1).solid : kAllColumns; }
    ColumnBits solid(int z) const { return at(z).solid; }
    /// Thin soil on a support counts too, so that a layer may thin out to nothing.
    ColumnBits thick(int z) const {
        const Layer& layer = at(z);
        return layer.dense | (layer.trace & (layer.filled | supported(z)));
    }
    /// Thick, without single voxels that fly and have none beside them in the tile: the surface
    /// would show them as octahedra. They are drawn as grains.
    ColumnBits in_run(int z) const {
        const ColumnBits here = thick(z);
        if (here == 0) return 0;
        const Layer& layer = at(z);
        return here & (supported(z) | layer.solid_trace | thick(z - 1) | thick(z + 1) |
                       beside(layer.dense | layer.solid));
    }
    ColumnBits grains(int z) const { return at(z).grain; }

  private:
    struct Layer {
        ColumnBits dense = 0, trace = 0, grain = 0, filled = 0, solid = 0, solid_trace = 0;
    };
    /// One of the empty layers below and above, too.
    const Layer& at(int z) const { return layers_[static_cast<size_t>(z + 1)]; }

    /// Bits of a byte for each of Layer's words, in order: loops that become vectors.
    static void flag_layer(const float* volume, const float* solid,
                           std::array<uint8_t, kTileColumns>& flags) {
        if (solid == nullptr) {
            for (size_t c = 0; c < kTileColumns; ++c) {
                const float soil = volume[c];
                flags[c] =
                    static_cast<uint8_t>((soil >= kDense ? 1 : 0) | (soil > kTrace ? 2 : 0) |
                                         (soil >= kGrainLeast ? 4 : 0) | (soil >= kDense ? 8 : 0));
            }
            return;
        }
        for (size_t c = 0; c < kTileColumns; ++c) {
            const float soil = volume[c], ground = solid[c];
            flags[c] = static_cast<uint8_t>(
                (soil >= kDense ? 1 : 0) | (soil > kTrace ? 2 : 0) | (soil >= kGrainLeast ? 4 : 0) |
                (soil + ground >= kDense ? 8 : 0) | (ground >= kDense ? 16 : 0) |
                (ground >= kTrace ? 32 : 0));
        }
    }

    static void unpack(const std::array<uint8_t, kTileColumns>& flags, Layer& layer) {
        ColumnBits* const words[] = {&layer.dense,  &layer.trace, &layer.grain,
                                     &layer.filled, &layer.solid, &layer.solid_trace};
        for (size_t row = 0; row < kTileSide; ++row) {
            uint64_t bytes = 0;
            for (size_t c = kTileSide; c-- > 0;) bytes = bytes << 8 | flags[row * kTileSide + c];
            for (size_t w = 0; w < std::size(words); ++w) {
                // The lowest bits of eight bytes side by side.
                const uint64_t bits =
                    ((bytes >> w & 0x0101010101010101) * 0x0102040810204080) >> 56;
                *words[w] |= bits << (row * kTileSide);
            }
        }
    }

    std::vector<Layer> layers_;
};

/// Heights at which something changes in the columns of a tile, noted layer by layer.
class ColumnSteps {
  public:
    void add(int z, ColumnBits columns) {
        for (; columns != 0; columns &= columns - 1) {
            const auto c = static_cast<size_t>(std::countr_zero(columns));
            steps_.push_back({static_cast<uint8_t>(c), z});
            ++begin_[c + 1];
        }
    }
    /// No more are added.
    void sort() {
        for (size_t c = 0; c < kTileColumns; ++c) begin_[c + 1] += begin_[c];
        heights_.resize(steps_.size());
        std::array<uint32_t, kTileColumns + 1> next = begin_;
        for (const Step& step : steps_) heights_[next[step.column]++] = step.z;
    }
    /// Upwards.
    std::span<const int> column(int c) const {
        const auto place = static_cast<size_t>(c);
        return std::span(heights_).subspan(begin_[place], begin_[place + 1] - begin_[place]);
    }

  private:
    struct Step {
        uint8_t column = 0;
        int z = 0;
    };
    std::vector<Step> steps_;
    std::vector<int> heights_;
    std::array<uint32_t, kTileColumns + 1> begin_{};
};

/// Where the layers' columns begin and cease to be so: pairs of a first voxel and one behind the
/// last.
template <typename BitsOfLayer>
ColumnSteps find_steps(int height, BitsOfLayer bits_of_layer) {
    ColumnSteps steps;
    ColumnBits before = 0;
    for (int z = 0; z < height; ++z) {
        const ColumnBits now = bits_of_layer(z);
        steps.add(z, now ^ before);
        before = now;
    }
    steps.add(height, before);
    steps.sort();
    return steps;
}

/// Where a voxel's material is another than that of the one below.
ColumnSteps find_material_steps(const uint8_t* material, int height) {
    ColumnSteps steps;
    for (int z = 1; z < height; ++z) {
        const uint8_t* layer = material + z * kTileColumns;
        if (std::equal(layer, layer + kTileColumns, layer - kTileColumns)) continue;
        ColumnBits changed = 0;
        for (int c = 0; c < kTileColumns; ++c) {
            changed |= ColumnBits{layer[c] != layer[c - kTileColumns]} << c;
        }
        steps.add(z, changed);
    }
    steps.sort();
    return steps;
}

/// A column of a tile; soil and solid by height.
struct ColumnView {
    const float* volume;
    const float* solid;  ///< null: none
    int height;

    float soil_at(int z) const { return z >= 0 && z < height ? volume[z * kTileColumns] : 0.0f; }
    float solid_at(int z) const {
        return solid && z >= 0 && z < height ? solid[z * kTileColumns] : 0.0f;
    }
    float fill_at(int z) const { return std::min(1.0f, soil_at(z) + solid_at(z)); }
    bool supported(int z) const { return z == 0 || solid_at(z - 1) >= kDense; }
};

/// Top and bottom of the run of voxels first..last.
Run bounds_of(const ColumnView& column, int first, int last) {
    Run run;
    const float above = std::min(1.0f, column.soil_at(last + 1));
    if (column.supported(first)) {
        // Full voxels, then a partial one. While soil moves the last two may both be partial.
        run.on_solid = first > 0;
        run.bottom = run.on_solid ? static_cast<float>(first) - kOverlap : kOnFloor;
        run.top = static_cast<float>(last) + column.fill_at(last) + above;
        if (last > first) run.top -= 1.0f - column.fill_at(last - 1);
        return run;
    }
    // In the air: as much as there is, about its centre.
    float amount = 0, moment = 0;
    for (int z = first - 1; z <= last + 1; ++z) {
        const bool inside = z >= first && z <= last;
        const float fill = inside ? column.fill_at(z) : std::min(1.0f, column.soil_at(z));
        amount += fill;
        moment += fill * (static_cast<float>(z) + 0.5f);
    }
    const float center = moment / amount;
    const float sample = std::floor(center) + 0.5f;
    run.bottom = std::min(center - 0.5f * amount, sample - kSliverHalf);
    run.top = std::max(center + 0.5f * amount, sample + kSliverHalf);
    return run;
}

/// Runs of soil and of solid, and the materials of the first from layer to layer; `material` null:
/// all are 0.
void find_runs(const LayerBits& bits, const float* volume, const float* solid,
               const uint8_t* material, int height, bool can_fly, TileColumns& columns) {
    const ColumnSteps soil_steps =
        find_steps(height, [&](int z) { return can_fly ? bits.in_run(z) : bits.thick(z); });
    const ColumnSteps solid_steps = find_steps(height, [&](int z) { return bits.solid(z); });
    const ColumnSteps material_steps =
        material ? find_material_steps(material, height) : ColumnSteps();
    std::vector<Run>& runs = columns.runs.items;
    std::vector<SolidRun>& solids = columns.solids.items;
    std::vector<MaterialLayer>& layers = columns.layers.items;
    runs.clear();
    solids.clear();
    layers.clear();
    for (int c = 0; c < kTileColumns; ++c) {
        const ColumnView column{volume + c, solid ? solid + c : nullptr, height};
        const size_t run_begin = runs.size(), layer_begin = layers.size();
        const auto material_at = [&](int z) {
            return material ? material[z * kTileColumns + c] : uint8_t{0};
        };
        const auto add_layer = [&](int z) {
            if (layers.size() == layer_begin || layers.back().material != material_at(z)) {
                layers.push_back({z, material_at(z)});
            }
        };
        const std::span<const int> changes = material_steps.column(c);
        const std::span<const int> bounds = soil_steps.column(c);
        for (size_t i = 0; i + 1 < bounds.size(); i += 2) {
            const int first = bounds[i], last = bounds[i + 1] - 1;
            add_layer(first);
            for (auto next = std::ranges::upper_bound(changes, first);
                 next != changes.end() && *next <= last; ++next) {
                add_layer(*next);
            }
            Run run = bounds_of(column, first, last);
            run.top = std::min(run.top, static_cast<float>(height));
            run.material = material_at(last);
            if (runs.size() > run_begin && run.bottom - runs.back().top < kGapMin) {
                runs.back().top = std::max(runs.back().top, run.top);
                runs.back().material = run.material;
            } else {
                runs.push_back(run);
            }
        }
        const std::span<const int> solid_bounds = solid_steps.column(c);
        for (size_t i = 0; i + 1 < solid_bounds.size(); i += 2) {
            const int first = solid_bounds[i], end = solid_bounds[i + 1];
            solids.push_back({static_cast<float>(first),
                              static_cast<float>(end - 1) +
                                  std::min(1.0f, column.solid_at(end - 1)) + column.solid_at(end)});
        }
        columns.runs.begin[c + 1] = static_cast<uint32_t>(runs.size());
        columns.solids.begin[c + 1] = static_cast<uint32_t>(solids.size());
        columns.layers.begin[c + 1] = static_cast<uint32_t>(layers.size());
    }
}

/// As find_soil_runs() has them.
void find_loose(const LayerBits& bits, int height, std::vector<int>& voxels) {
    voxels.clear();
    for (int z = 0; z < height; ++z) {
        // What lies on a run is its partial top; a run in the air takes in what is below it, too.
        ColumnBits loose = bits.grains(z) & ~bits.solid(z);
        if (loose == 0) continue;
        loose &=
            ~(bits.in_run(z) | bits.in_run(z - 1) | (bits.in_run(z + 1) & ~bits.supported(z + 1)));
        for (; loose != 0; loose &= loose - 1) {
            voxels.push_back(z * kTileColumns + std::countr_zero(loose));
        }
    }
}

}  // namespace

void clear_beyond(int x_count, int y_count, std::span<float> solid) {
    if (x_count >= kTileSide && y_count >= kTileSide) return;
    for (size_t v = 0; v < solid.size(); ++v) {
        const int c = static_cast<int>(v % kTileColumns);
        if (c % kTileSide >= x_count || c / kTileSide >= y_count) solid[v] = 0;
    }
}

void find_soil_runs(std::span<const float> volume, std::span<const float> solid,
                    std::span<const uint8_t> material, int height, TileColumns& columns,
                    std::vector<int>* loose_voxels) {
    const bool any_solid = std::ranges::any_of(solid, [](float s) { return s > 0; });
    const bool any_other = std::ranges::any_of(material, [](uint8_t m) { return m != 0; });
    const float* ground = any_solid ? solid.data() : nullptr;
    const LayerBits bits(volume.data(), ground, height);
    find_runs(bits, volume.data(), ground, any_other ? material.data() : nullptr, height, true,
              columns);
    if (loose_voxels) find_loose(bits, height, *loose_voxels);
}

int seen_voxel(const Run& run, std::span<const float> volume, int c) {
    const int height = static_cast<int>(volume.size()) / kTileColumns;
    const int top = std::min(static_cast<int>(std::ceil(run.top)), height) - 1;
    const int lowest = std::max(0, static_cast<int>(std::floor(run.bottom)));
    const auto soil_at = [&](int z) { return volume[static_cast<size_t>(z * kTileColumns + c)]; };
    int fullest = top;
    for (int z = top; z >= lowest; --z) {
        if (soil_at(z) >= kBareLeast) return z;
        if (soil_at(z) > soil_at(fullest)) fullest = z;
    }
    return fullest;
}

void find_terrain_runs(std::span<const float> solid, int height, TileColumns& columns) {
    find_runs(LayerBits(solid.data(), nullptr, height), solid.data(), nullptr, nullptr, height,
              false, columns);
}

}  // namespace bsoil::mesh
