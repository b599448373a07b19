// Soil put in before the first step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check_range.h"
#include "bsoil/limits.h"
#include "bsoil/soil.h"
#include "soil/noise.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

// Sub-cells along each axis in which a density function or a turned box is sampled.
constexpr int kSubCells = 3;

/// Share of a voxel's sub-cells in which `inside` holds at their centres.
template <typename Inside>
double sampled_share(int x, int y, int z, Inside&& inside) {
    int count = 0;
    for (int i = 0; i < kSubCells * kSubCells * kSubCells; ++i) {
        const Vec3 at{x + (i % kSubCells + 0.5) / kSubCells,
                      y + (i / kSubCells % kSubCells + 0.5) / kSubCells,
                      z + (i / (kSubCells * kSubCells) + 0.5) / kSubCells};
        count += inside(at);
    }
    return static_cast<double>(count) / (kSubCells * kSubCells * kSubCells);
}

/// Share of a column's sub-cells across in which `inside` holds at their middles.
template <typename Inside>
double share_across(int x, int y, Inside&& inside) {
    int count = 0;
    for (int i = 0; i < kSubCells * kSubCells; ++i) {
        count +=
            inside(x + (i % kSubCells + 0.5) / kSubCells, y + (i / kSubCells + 0.5) / kSubCells);
    }
    return static_cast<double>(count) / (kSubCells * kSubCells);
}

double overlap(double low, double high, int cell) {
    return std::clamp(std::min(high, cell + 1.0) - std::max(low, static_cast<double>(cell)), 0.0,
                      1.0);
}

bool is_proper(const Aabb& box) {
    return is_finite(box.min) && is_finite(box.max) && box.min.x < box.max.x &&
           box.min.y < box.max.y && box.min.z < box.max.z;
}

}  // namespace

void TileFill::ask(const FillShape& shape) {
    const bool is_known_level = shape.is_level && shape.is_level(low[0], low[1], high[0], high[1]);
    is_level = (high[0] - low[0] + 1) * (high[1] - low[1] + 1) == kTileColumns;
    wanted.fill(nullptr);
    some = nullptr;
    for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
            const auto c = static_cast<size_t>(y % kTileSide * kTileSide + x % kTileSide);
            if (!some || !is_known_level) {
                runs[c].clear();
                shape.column(x, y, runs[c]);
                is_level = is_level && (!some || runs[c] == *some);
                some = &runs[c];
            }
            wanted[c] = some;
        }
    }
}

void TileFill::work(const FillMaterial& what) {
    added = fill_columns(held, wanted, what, filled);
    after = make_packed(filled);
}

Result<int> Soil::Impl::material_index(const std::string& name) const {
    if (name.empty()) return 0;
    std::string names;
    for (size_t m = 0; m < materials.size(); ++m) {
        if (materials[m].name == name) return static_cast<int>(m);
        names += (m > 0 ? ", " : "") + materials[m].name;
    }
    return Error{fmt::format("fill.material '{}' is not in this soil; it has {}", name, names)};
}

Status Soil::Impl::fill_with(const std::string& material, const int low[3], const int high[3],
                             const FillShape& shape) {
    finish();
    const Result<int> found = material_index(material);
    if (!found) return Error{found.error()};
    // A full voxel of a lighter material has fewer mass units; volume units are the same for all.
    const FillMaterial what{
        static_cast<size_t>(kKeptMaterial + *found),
        materials[*found].density_kg_m3 / kReferenceDensity,
        water.per_mass_of_layers(materials[*found]),
        static_cast<size_t>(kKeptMaterial + params.material_count),
        materials[*found].placed_saturation * materials[*found].pore_water_fraction};
    int first[2], last[2];
    for (int axis = 0; axis < 3; ++axis) {
        const int from = std::max(0, low[axis]), to = std::min(frame.size[axis] - 1, high[axis]);
        if (from > to) {
            return Error{"the fill lies outside of the grid; move it, or enlarge size_m"};
        }
        if (axis < 2) {
            first[axis] = from;
            last[axis] = to;
        }
    }
    int64_t added = 0;
    LevelTiles level_tiles;
    std::vector<TileFill> row(static_cast<size_t>(last[0] / kTileSide - first[0] / kTileSide + 1));
    for (int ty = first[1] / kTileSide; ty <= last[1] / kTileSide; ++ty) {
        // A row of tiles at a time. What is asked of tiles and changed in them has its order; the
        // rest is work on threads.
        for (size_t i = 0; i < row.size(); ++i) {
            const int tx = first[0] / kTileSide + static_cast<int>(i);
            row[i].index = tile_index(tx, ty);
            row[i].low[0] = std::max(first[0], tx * kTileSide);
            row[i].low[1] = std::max(first[1], ty * kTileSide);
            row[i].high[0] = std::min(last[0], tx * kTileSide + kTileSide - 1);
            row[i].high[1] = std::min(last[1], ty * kTileSide + kTileSide - 1);
        }
        const auto on_threads = [&](bool is_safe, const auto& each) {
            for_ranges(is_safe ? work_threads.get() : nullptr, row.size(), 1,
                       [&](size_t from, size_t to) {
                           for (size_t i = from; i < to; ++i) each(row[i]);
                       });
        };
        on_threads(shape.is_ours, [&](TileFill& fill) { fill.ask(shape); });
        for (TileFill& fill : row) begin_fill(fill, level_tiles);
        on_threads(true, [&](TileFill& fill) {
            if (fill.is_worked) fill.work(what);
        });
        for (TileFill& fill : row) added += end_fill(fill);
    }
    if (added == 0) {
        return Error{
            "the fill holds no soil: it lies outside of the grid, or all its room is taken; move "
            "it"};
    }
    return Done{};
}

/// What a tile holds, and whether it is like one that gets the same. In the tiles' order.
void Soil::Impl::begin_fill(TileFill& fill, LevelTiles& level_tiles) {
    if (!tiles[fill.index] && ground.is_over(fill.index)) tiles.make(fill.index);
    const bool is_asleep = !tiles[fill.index] || tiles[fill.index]->slot < 0;
    fill.level = nullptr;
    fill.is_worked = true;
    if (fill.is_level && is_asleep) {
        const std::shared_ptr<const PackedTile> before =
            tiles[fill.index] ? tiles[fill.index]->packed : nullptr;
        const auto [entry, fresh] = level_tiles.try_emplace({before.get(), *fill.some});
        fill.level = &entry->second;
        fill.is_worked = fresh;
        if (fresh) fill.level->before = before;
    }
    if (fill.is_worked) tiles.read_runs(fill.index, fill.held);
}

/// Puts what a tile holds now in its place; returns the units added to it. In the tiles' order.
int64_t Soil::Impl::end_fill(TileFill& fill) {
    if (fill.level && fill.is_worked) {
        fill.level->after = std::move(fill.after);
        fill.level->added = fill.added;
    }
    const int64_t added = fill.level ? fill.level->added : fill.added;
    if (added > 0) {
        tiles.write_packed(fill.index, fill.level ? fill.level->after : std::move(fill.after));
        ++tiles[fill.index]->revision;
        tiles[fill.index]->unchecked = true;
        tiles.any_unchecked = true;
    }
    fill.after = nullptr;
    return added;
}

Status Soil::Impl::check_density_grid() const {
    const int64_t voxel_count = int64_t{frame.size[0]} * frame.size[1] * height;
    if (voxel_count <= limits::kDensityVoxelsMax) return Done{};
    return Error{fmt::format(
        "a density function would be asked in {:.3g} voxels, at most {:.3g} are possible: take "
        "larger voxels, a smaller box or another kind of ground",
        static_cast<double>(voxel_count), static_cast<double>(limits::kDensityVoxelsMax))};
}

Status Soil::fill(const BoxFill& fill) {
    Impl& s = *impl_;
    if (!is_proper(fill.box)) {
        return Error{"fill.box has no size: min must be below max on every axis"};
    }
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner = s.to_grid({i & 1 ? fill.box.max.x : fill.box.min.x,
                                       i & 2 ? fill.box.max.y : fill.box.min.y,
                                       i & 4 ? fill.box.max.z : fill.box.min.z});
        low = {std::min(low.x, corner.x), std::min(low.y, corner.y), std::min(low.z, corner.z)};
        high = {std::max(high.x, corner.x), std::max(high.y, corner.y), std::max(high.z, corner.z)};
    }
    const auto whole = [](double v) {
        return static_cast<int>(std::floor(std::clamp(v, -1e6, 1e6)));
    };
    const int first[3] = {whole(low.x), whole(low.y), whole(low.z)};
    const int last[3] = {whole(high.x), whole(high.y), whole(high.z)};
    // From the bottom up: only the voxels at both ends are not whole.
    const auto add_column = [&](double across, FillRuns& runs) {
        const int from = std::max(0, first[2]), to = std::min(s.height - 1, last[2]);
        for (int z = from; z <= to; ++z) add_voxel(runs, z, across * overlap(low.z, high.z, z));
    };
    if (s.def.yaw_rad == 0) {
        return s.fill_with(
            fill.material, first, last,
            {[&](int x, int y, FillRuns& runs) {
                 add_column(overlap(low.x, high.x, x) * overlap(low.y, high.y, y), runs);
             },
             [&](int x0, int y0, int x1, int y1) {
                 return x0 >= low.x && y0 >= low.y && x1 + 1 <= high.x && y1 + 1 <= high.y;
             },
             true});
    }
    const auto is_across = [&](double x, double y) {
        // Up or not, the box's ends are told by add_column.
        const Vec3 w = s.frame.to_world({x, y, 0});
        const bool y_up = s.def.up == UpAxis::y;
        return w.x >= fill.box.min.x && w.x <= fill.box.max.x &&
               (y_up ? w.z >= fill.box.min.z && w.z <= fill.box.max.z
                     : w.y >= fill.box.min.y && w.y <= fill.box.max.y);
    };
    return s.fill_with(
        fill.material, first, last,
        {[&](int x, int y, FillRuns& runs) { add_column(share_across(x, y, is_across), runs); },
         [&](int x0, int y0, int x1, int y1) {
             return is_across(x0, y0) && is_across(x1 + 1, y0) && is_across(x0, y1 + 1) &&
                    is_across(x1 + 1, y1 + 1);
         },
         true});
}

Status Soil::fill(const CylinderFill& fill) {
    Impl& s = *impl_;
    if (!is_finite(fill.base_center_m)) {
        return Error{"fill.base_center_m must be finite"};
    }
    for (const Status& status : {check_range("fill.radius_m", fill.radius_m, 1e-6, 1e6),
                                 check_range("fill.height_m", fill.height_m, 1e-6, 1e6)}) {
        if (!status) return status;
    }
    const Vec3 base = s.to_grid(fill.base_center_m);
    const double r = fill.radius_m / s.frame.voxel_m, h = fill.height_m / s.frame.voxel_m;
    const auto whole = [](double v) {
        return static_cast<int>(std::floor(std::clamp(v, -1e6, 1e6)));
    };
    const int first[3] = {whole(base.x - r), whole(base.y - r), whole(base.z)};
    const int last[3] = {whole(base.x + r), whole(base.y + r), whole(base.z + h)};
    const auto is_across = [&](double x, double y) {
        return std::hypot(x - base.x, y - base.y) <= r;
    };
    return s.fill_with(fill.material, first, last,
                       {[&](int x, int y, FillRuns& runs) {
                            const double across = share_across(x, y, is_across);
                            const int to = std::min(s.height - 1, last[2]);
                            for (int z = std::max(0, first[2]); z <= to; ++z) {
                                add_voxel(runs, z, across * overlap(base.z, base.z + h, z));
                            }
                        },
                        [&](int x0, int y0, int x1, int y1) {
                            return is_across(x0, y0) && is_across(x1 + 1, y0) &&
                                   is_across(x0, y1 + 1) && is_across(x1 + 1, y1 + 1);
                        },
                        true});
}

/// Ground whose surface is so high over each column [voxels].
Status Soil::Impl::fill_ground(const std::string& material,
                               const std::function<double(int x, int y)>& height_at) {
    const int first[3] = {0, 0, 0};
    const int last[3] = {frame.size[0] - 1, frame.size[1] - 1, height - 1};
    return fill_with(material, first, last,
                     {[&](int x, int y, FillRuns& runs) {
                          const double top = std::clamp(height_at(x, y), 0.0, 1.0 * height);
                          const int whole = static_cast<int>(top);
                          if (whole > 0) runs.push_back({0, whole, kVoxelFull});
                          add_voxel(runs, whole, top - whole);
                      },
                      {},
                      true});
}

Status Soil::fill(const HeightMapFill& fill) {
    Impl& s = *impl_;
    for (const Status& status : {check_range("fill.width", fill.width, limits::kHeightMapSideMin,
                                             limits::kHeightMapSideMax),
                                 check_range("fill.height", fill.height, limits::kHeightMapSideMin,
                                             limits::kHeightMapSideMax)}) {
        if (!status) return status;
    }
    if (fill.heights_m.size() !=
        static_cast<size_t>(fill.width) * static_cast<size_t>(fill.height)) {
        return Error{fmt::format("fill.heights_m has {} values, must have width x height, {}",
                                 fill.heights_m.size(),
                                 static_cast<int64_t>(fill.width) * fill.height)};
    }
    if (!std::all_of(fill.heights_m.begin(), fill.heights_m.end(),
                     [](float h) { return std::isfinite(h); })) {
        return Error{"fill.heights_m must be finite everywhere"};
    }
    // Image column runs with the first horizontal world axis, image row with the second, whatever
    // the grid's own axes.
    const bool y_up = s.def.up == UpAxis::y;
    const auto height_at = [&](int x, int y) {
        const double across =
            ((y_up ? y : x) + 0.5) / s.frame.size[y_up ? 1 : 0] * (fill.width - 1);
        const double along =
            ((y_up ? x : y) + 0.5) / s.frame.size[y_up ? 0 : 1] * (fill.height - 1);
        const int i = std::min(static_cast<int>(across), fill.width - 2),
                  j = std::min(static_cast<int>(along), fill.height - 2);
        const double u = across - i, v = along - j;
        const auto h = [&](int a, int b) {
            return static_cast<double>(fill.heights_m[static_cast<size_t>(b) * fill.width + a]);
        };
        return ((h(i, j) * (1 - u) + h(i + 1, j) * u) * (1 - v) +
                (h(i, j + 1) * (1 - u) + h(i + 1, j + 1) * u) * v) /
               s.frame.voxel_m;
    };
    return s.fill_ground(fill.material, height_at);
}

Status Soil::fill(const NoiseFill& fill) {
    Impl& s = *impl_;
    for (const Status& status : {check_range("fill.base_m", fill.base_m, 0, 1e4),
                                 check_range("fill.amplitude_m", fill.amplitude_m, 0, 1e4),
                                 check_range("fill.wavelength_m", fill.wavelength_m, 1e-3, 1e6),
                                 check_range("fill.octaves", fill.octaves, 1, 12),
                                 check_range("fill.persistence", fill.persistence, 0, 1)}) {
        if (!status) return status;
    }
    const bool y_up = s.def.up == UpAxis::y;
    return s.fill_ground(fill.material, [&](int x, int y) {
        // With Y up the ground is that of Z up turned, not mirrored: -z takes the place of y.
        const Vec3 w = s.frame.to_world({x + 0.5, y + 0.5, 0});
        return (fill.base_m +
                fill.amplitude_m * fractal_noise(w.x / fill.wavelength_m,
                                                 (y_up ? -w.z : w.y) / fill.wavelength_m,
                                                 fill.octaves, fill.persistence, fill.seed)) /
               s.frame.voxel_m;
    });
}

Status Soil::fill(const FunctionFill& fill) {
    Impl& s = *impl_;
    if (!fill.density) return Error{"fill.density is empty; give it a function"};
    if (Status small = s.check_density_grid(); !small) return small;
    const int first[3] = {0, 0, 0};
    const int last[3] = {s.frame.size[0] - 1, s.frame.size[1] - 1, s.height - 1};
    return s.fill_with(fill.material, first, last,
                       {[&](int x, int y, FillRuns& runs) {
                            for (int z = 0; z < s.height; ++z) {
                                add_voxel(runs, z, sampled_share(x, y, z, [&](Vec3 at) {
                                              return fill.density(s.frame.to_world(at)) > 0;
                                          }));
                            }
                        },
                        {},
                        false});
}

Status Soil::add_terrain(const DensityFunction& density) {
    Impl& s = *impl_;
    if (!density) return Error{"terrain.density is empty; give it a function"};
    if (Status small = s.check_density_grid(); !small) return small;
    return s.terrain_with(
        [&](int x, int y, int z) {
            return sampled_share(x, y, z,
                                 [&](Vec3 at) { return density(s.frame.to_world(at)) > 0; });
        },
        s.height);
}

}  // namespace bsoil
