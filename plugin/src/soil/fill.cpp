// Soil put in before the first step, and which of it must be looked at by the step because it may
// not stand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "bsoil/limits.h"
#include "bsoil/soil.h"
#include "soil/check_range.h"
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

double overlap(double low, double high, int cell) {
    return std::clamp(std::min(high, cell + 1.0) - std::max(low, static_cast<double>(cell)), 0.0,
                      1.0);
}

bool is_proper(const Aabb& box) {
    return is_finite(box.min) && is_finite(box.max) && box.min.x < box.max.x &&
           box.min.y < box.max.y && box.min.z < box.max.z;
}

}  // namespace

Result<int> Soil::Impl::material_index(const std::string& name) const {
    if (name.empty()) {
        return 0;
    }
    std::string names;
    for (size_t m = 0; m < materials.size(); ++m) {
        if (materials[m].name == name) {
            return static_cast<int>(m);
        }
        names += (m > 0 ? ", " : "") + materials[m].name;
    }
    return Error{fmt::format("fill.material '{}' is not in this soil; it has {}", name, names)};
}

Status Soil::Impl::fill_with(const std::string& material, const int low[3], const int high[3],
                             const VoxelFraction& fraction) {
    const Result<int> found = material_index(material);
    if (!found) {
        return Error{found.error()};
    }
    // A full voxel of a lighter material has fewer mass units; volume units are the same for all.
    const double mass_per_volume = materials[*found].density_kg_m3 / kReferenceDensity;
    int first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
        first[axis] = std::max(0, low[axis]);
        last[axis] = std::min(frame.size[axis] - 1, high[axis]);
        if (first[axis] > last[axis]) {
            return Error{"the fill lies outside of the grid"};
        }
    }
    int64_t added = 0;
    TileVoxels voxels;
    for (int ty = first[1] / kTileSide; ty <= last[1] / kTileSide; ++ty) {
        for (int tx = first[0] / kTileSide; tx <= last[0] / kTileSide; ++tx) {
            const int index = tile_index(tx, ty);
            Tile& tile = tile_for(index);
            read_voxels(index, voxels);
            int64_t tile_added = 0;
            for (int c = 0; c < kTileColumns; ++c) {
                const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
                if (x < first[0] || y < first[1] || x > last[0] || y > last[1]) {
                    continue;
                }
                for (int z = first[2]; z <= last[2]; ++z) {
                    const int room =
                        kVoxelFull - voxels.at(kKeptTerrain, z, c) - voxels.at(kKeptVolume, z, c);
                    const int wanted = static_cast<int>(
                        std::lround(std::clamp(fraction(x, y, z), 0.0, 1.0) * kVoxelFull));
                    const int units = std::min(room, wanted);
                    // Less than a crumb is not worth a voxel: it would hover until a neighbour's
                    // flow took it along.
                    if (units > kCrumb) {
                        voxels.at(kKeptVolume, z, c) += units;
                        voxels.at(kKeptBond, z, c) += units;
                        voxels.at(kKeptMaterial + *found, z, c) +=
                            std::max(1, static_cast<int>(std::lround(units * mass_per_volume)));
                        tile_added += units;
                    }
                }
            }
            if (tile_added > 0) {
                write_voxels(index, voxels);
                ++tile.revision;
                tile.unchecked = true;
                any_unchecked = true;
                added += tile_added;
            }
        }
    }
    if (added == 0) {
        return Error{
            "the fill holds no soil: it lies outside of the grid, or all its room is taken"};
    }
    return Done{};
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
    if (s.def.yaw_rad == 0) {
        return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
            return overlap(low.x, high.x, x) * overlap(low.y, high.y, y) *
                   overlap(low.z, high.z, z);
        });
    }
    return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
        return sampled_share(x, y, z, [&](Vec3 at) {
            const Vec3 w = s.frame.to_world(at);
            return w.x >= fill.box.min.x && w.x <= fill.box.max.x && w.y >= fill.box.min.y &&
                   w.y <= fill.box.max.y && w.z >= fill.box.min.z && w.z <= fill.box.max.z;
        });
    });
}

Status Soil::fill(const CylinderFill& fill) {
    Impl& s = *impl_;
    if (!is_finite(fill.base_center_m)) {
        return Error{"fill.base_center_m has a NaN or infinite coordinate"};
    }
    for (const Status& status : {check_range("fill.radius_m", fill.radius_m, 1e-6, 1e6),
                                 check_range("fill.height_m", fill.height_m, 1e-6, 1e6)}) {
        if (!status) {
            return status;
        }
    }
    const Vec3 base = s.to_grid(fill.base_center_m);
    const double r = fill.radius_m / s.frame.voxel_m, h = fill.height_m / s.frame.voxel_m;
    const auto whole = [](double v) {
        return static_cast<int>(std::floor(std::clamp(v, -1e6, 1e6)));
    };
    const int first[3] = {whole(base.x - r), whole(base.y - r), whole(base.z)};
    const int last[3] = {whole(base.x + r), whole(base.y + r), whole(base.z + h)};
    return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
        const double across = sampled_share(
            x, y, z, [&](Vec3 at) { return std::hypot(at.x - base.x, at.y - base.y) <= r; });
        return across * overlap(base.z, base.z + h, z);
    });
}

Status Soil::fill(const HeightMapFill& fill) {
    Impl& s = *impl_;
    for (const Status& status : {check_range("fill.width", fill.width, limits::kHeightMapSideMin,
                                             limits::kHeightMapSideMax),
                                 check_range("fill.height", fill.height, limits::kHeightMapSideMin,
                                             limits::kHeightMapSideMax)}) {
        if (!status) {
            return status;
        }
    }
    if (fill.heights_m.size() !=
        static_cast<size_t>(fill.width) * static_cast<size_t>(fill.height)) {
        return Error{fmt::format("fill.heights_m has {} values, width x height is {}",
                                 fill.heights_m.size(),
                                 static_cast<int64_t>(fill.width) * fill.height)};
    }
    if (!std::all_of(fill.heights_m.begin(), fill.heights_m.end(),
                     [](float h) { return std::isfinite(h); })) {
        return Error{"fill.heights_m has a NaN or infinite value"};
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
    const int first[3] = {0, 0, 0};
    const int last[3] = {s.frame.size[0] - 1, s.frame.size[1] - 1, s.height - 1};
    return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
        return std::clamp(height_at(x, y) - z, 0.0, 1.0);
    });
}

Status Soil::fill(const NoiseFill& fill) {
    Impl& s = *impl_;
    for (const Status& status : {check_range("fill.base_m", fill.base_m, 0, 1e4),
                                 check_range("fill.amplitude_m", fill.amplitude_m, 0, 1e4),
                                 check_range("fill.wavelength_m", fill.wavelength_m, 1e-3, 1e6),
                                 check_range("fill.octaves", fill.octaves, 1, 12),
                                 check_range("fill.persistence", fill.persistence, 0, 1)}) {
        if (!status) {
            return status;
        }
    }
    const int first[3] = {0, 0, 0};
    const int last[3] = {s.frame.size[0] - 1, s.frame.size[1] - 1, s.height - 1};
    const bool y_up = s.def.up == UpAxis::y;
    std::vector<double> heights(static_cast<size_t>(s.frame.size[0]) * s.frame.size[1]);
    for (int y = 0; y < s.frame.size[1]; ++y) {
        for (int x = 0; x < s.frame.size[0]; ++x) {
            // With Y up the ground is that of Z up turned, not mirrored: -z takes the place of y.
            const Vec3 w = s.frame.to_world({x + 0.5, y + 0.5, 0});
            heights[static_cast<size_t>(y) * s.frame.size[0] + x] =
                (fill.base_m +
                 fill.amplitude_m * fractal_noise(w.x / fill.wavelength_m,
                                                  (y_up ? -w.z : w.y) / fill.wavelength_m,
                                                  fill.octaves, fill.persistence, fill.seed)) /
                s.frame.voxel_m;
        }
    }
    return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
        return std::clamp(heights[static_cast<size_t>(y) * s.frame.size[0] + x] - z, 0.0, 1.0);
    });
}

Status Soil::fill(const FunctionFill& fill) {
    Impl& s = *impl_;
    if (!fill.density) {
        return Error{"fill.density is empty"};
    }
    const int first[3] = {0, 0, 0};
    const int last[3] = {s.frame.size[0] - 1, s.frame.size[1] - 1, s.height - 1};
    return s.fill_with(fill.material, first, last, [&](int x, int y, int z) {
        return sampled_share(x, y, z,
                             [&](Vec3 at) { return fill.density(s.frame.to_world(at)) > 0; });
    });
}

Status Soil::add_terrain(const DensityFunction& density) {
    Impl& s = *impl_;
    if (!density) {
        return Error{"terrain.density is empty"};
    }
    return s.terrain_with([&](int x, int y, int z) {
        return sampled_share(x, y, z, [&](Vec3 at) { return density(s.frame.to_world(at)) > 0; });
    });
}

// Level ground sleeps from the start. What may move (hanging soil, and slopes steeper than the
// flattest angle of friction) is marked active; the step then decides.
void Soil::Impl::wake_unstable_columns() {
    any_unchecked = false;
    double flattest = 10;
    for (const MaterialDef& material : materials) {
        flattest = std::min(flattest, std::tan(material.friction_angle_rad));
    }
    using Profiles = std::array<ColumnProfile, kTileColumns>;
    std::map<int, Profiles> profiles;
    TileVoxels voxels;
    const auto profiles_of = [&](int index) -> const Profiles& {
        const auto [entry, fresh] = profiles.try_emplace(index);
        if (fresh) {
            read_voxels(index, voxels);
            for (int c = 0; c < kTileColumns; ++c) {
                entry->second[c] = column_profile(voxels, c);
            }
        }
        return entry->second;
    };
    for (size_t i = 0; i < tiles.size(); ++i) {
        const int index = static_cast<int>(i);
        if (!tiles[i] || !tiles[i]->unchecked) {
            continue;
        }
        tiles[i]->unchecked = false;
        const int tx = index % tiles_x, ty = index / tiles_x;
        const Profiles profile = profiles_of(index);
        for (int c = 0; c < kTileColumns; ++c) {
            const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
            if (x >= frame.size[0] || y >= frame.size[1]) {
                continue;
            }
            const auto activate_at = [&](int px, int py, double z) {
                const int zb = std::clamp(static_cast<int>(z) / kTileSide, 0, blocks_per_tile - 1);
                activate(static_cast<BlockKey>(tile_index(px / kTileSide, py / kTileSide)) *
                             blocks_per_tile +
                         zb);
            };
            for (int z = 0; profile[c].hanging >= 0 && z < blocks_per_tile; ++z) {
                activate(static_cast<BlockKey>(index) * blocks_per_tile + z);
            }
            for (int n = 0; n < 9; ++n) {
                const int nx = x + n % 3 - 1, ny = y + n / 3 - 1;
                if (n == 4 || nx < 0 || ny < 0 || nx >= frame.size[0] || ny >= frame.size[1]) {
                    continue;
                }
                const int other = tile_index(nx / kTileSide, ny / kTileSide);
                const double other_top =
                    tiles[other]
                        ? profiles_of(other)[ny % kTileSide * kTileSide + nx % kTileSide].top
                        : 0;
                const double drop =
                    std::abs(profile[c].top - other_top) / (n % 2 == 0 ? std::numbers::sqrt2 : 1.0);
                // Facets between two neighbours can be steeper than either by up to 1 / cos 22.5
                // deg.
                if (drop > 0.9 * flattest) {
                    activate_at(x, y, profile[c].top);
                    activate_at(nx, ny, other_top);
                }
            }
        }
    }
}

}  // namespace bsoil
