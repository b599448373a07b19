#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "bsoil/surface_mesh.h"
#include "bsoil/work_threads.h"
#include "mesh/bare_walls.h"
#include "mesh/coarse_error.h"
#include "mesh/column_runs.h"
#include "mesh/device_mesher.h"
#include "mesh/display_field.h"
#include "mesh/rolling_soil.h"
#include "mesh/soil_color.h"
#include "mesh/tile_levels.h"
#include "mesh/tile_meshers.h"

namespace bsoil {
namespace {

using mesh::kTileSide;
using mesh::TileLevels;

static_assert(SurfaceMesher::kLevelMost == TileLevels::kMost);

/// A tile keeps its level until its distance is this much beyond the one where it changes.
constexpr double kKeepShare = 0.1;
constexpr uint8_t kNoLevel = 255;

/// Tiles around one that changed whose meshes may depend on it, by their level: cells and normals
/// read columns up to two samples away, and where there is terrain those read the ones a sample
/// further on.
constexpr int kReach[] = {1, 1, 1, 2}, kReachAtTerrain[] = {1, 2, 2, 3};
constexpr int kReachMost = 3;
static_assert(std::size(kReach) == TileLevels::kMost + 1);
static_assert(std::size(kReachAtTerrain) == TileLevels::kMost + 1);

}  // namespace

struct SurfaceMesher::Impl {
    struct Tile {
        bool read = false, dirty = false;
        uint64_t source_revision = 0, mesh_revision = 0;
        uint64_t levels_around = 0;
        bool has_errors = false;     ///< those of its present columns
        bool has_old_walls = false;  ///< columns around have changed since they were found
        mesh::CoarseErrors errors{};
        Mesh mesh;
        std::vector<LooseVoxel> loose;
        std::vector<RollingSoil> rolling;
        bool rolls = false;  ///< `rolling` is to be made anew
        std::vector<mesh::ColumnMotion> motions;
    };

    Impl(const TileSource& tile_source, const SurfaceMeshDef& mesh_def,
         std::unique_ptr<mesh::DeviceMesher> hosts_mesher)
        : source(tile_source),
          def(mesh_def),
          has_water(tile_source.has_water()),
          grid(empty_grid(tile_source.frame())),
          tiles(grid.tiles.size()),
          levels(grid.tile_count[0], grid.tile_count[1]),
          wanted_levels(tiles.size(), kNoLevel),
          threads(mesh_def.thread_count),
          meshers(tile_source, mesh_def),
          device_mesher(std::move(hosts_mesher)) {
        if (!device_mesher) choose_backend(mesh_def.backend.value_or(tile_source.backend()));
    }

    void choose_backend(Backend backend) {
        if (backend == Backend::cpu) {
            backend_reason = "the CPU was asked for";
            return;
        }
        auto made = mesh::DeviceMesher::create(source, def, backend == Backend::gl);
        if (!made) {
            backend_reason = made.error();
            return;
        }
        device_mesher = std::move(*made);
        backend_reason = device_mesher->device().device_name() + " offers OpenGL 4.5 compute";
    }

    static mesh::GridColumns empty_grid(const GridFrame& frame) {
        mesh::GridColumns grid;
        std::copy(std::begin(frame.size), std::end(frame.size), grid.size);
        for (int axis = 0; axis < 2; ++axis) {
            grid.tile_count[axis] = (grid.size[axis] + kTileSide - 1) / kTileSide;
        }
        grid.tiles.resize(static_cast<size_t>(grid.tile_count[0]) *
                          static_cast<size_t>(grid.tile_count[1]));
        return grid;
    }

    size_t tile_index(int tx, int ty) const {
        assert(tx >= 0 && tx < grid.tile_count[0] && ty >= 0 && ty < grid.tile_count[1]);
        return static_cast<size_t>(ty * grid.tile_count[0] + tx);
    }

    /// True when the tile's runs are not what they were.
    bool read_columns(int tx, int ty) {
        if (def.layer == SurfaceMeshDef::Layer::terrain) {
            source.read_terrain(tx, ty, solid);
            mesh::find_terrain_runs(solid, grid.size[2], columns);
            for (mesh::Run& run : columns.runs.items) run.look.color = def.terrain_color;
        } else {
            source.read_tile(tx, ty, volume, solid, material);
            mesh::clear_beyond(grid.size[0] - tx * kTileSide, grid.size[1] - ty * kTileSide, solid);
            mesh::find_soil_runs(volume, solid, material, grid.size[2], columns, &loose_voxels);
            read_looks(tx, ty);
            if (shows_inside()) {
                mesh::find_bare_walls(grid, columns, tx, ty, columns.walls);
                read_mixes(tx, ty, columns);
            }
            read_loose(tx, ty);
        }
        mesh::TileColumns& known = grid.tiles[tile_index(tx, ty)];
        if (columns == known) return false;
        std::swap(known, columns);
        return true;
    }

    /// Those of the runs just found, at their topmost voxels.
    void read_looks(int tx, int ty) {
        for (int c = 0; c < mesh::kTileColumns; ++c) {
            const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
            if (x >= grid.size[0] || y >= grid.size[1]) continue;
            for (uint32_t r = columns.runs.begin[c]; r < columns.runs.begin[c + 1]; ++r) {
                mesh::Run& run = columns.runs.items[r];
                const int z = mesh::seen_voxel(run, volume, c);
                const int main = material[z * mesh::kTileColumns + c];
                run.look.color = source.color_at(x, y, z, main);
                run.look.wetness = wetness_at(x, y, z);
                if (source.materials().size() < 2) continue;
                run.look.weights = source.weights_at(x, y, z, main);
            }
        }
    }

    uint8_t wetness_at(int x, int y, int z) const {
        if (!has_water) return 0;
        return mesh::wetness_of(static_cast<double>(source.saturation_at(x, y, z)));
    }

    /// Whether walls show more than one dry material by itself.
    bool shows_inside() const {
        return def.layer == SurfaceMeshDef::Layer::soil &&
               (source.materials().size() > 1 || has_water);
    }

    /// Of the walls just found, from the arrays of the tile just read.
    void read_mixes(int tx, int ty, mesh::TileColumns& of) {
        std::vector<mesh::MixedLayer>& mixes = of.mixes.items;
        mixes.clear();
        for (int c = 0; c < mesh::kTileColumns; ++c) {
            const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
            const size_t first = mixes.size();
            for (const mesh::BareWall& wall : of.walls.column(c)) {
                for (int z = wall.bottom_voxel; z < std::min(wall.end_voxel, grid.size[2]); ++z) {
                    const auto v = static_cast<size_t>(z * mesh::kTileColumns + c);
                    if (volume[v] < mesh::kBareLeast) continue;
                    mesh::MixedLayer layer{z, {}, wetness_at(x, y, z)};
                    if (source.materials().size() > 1) {
                        layer.weights = source.weights_at(x, y, z, material[v]);
                    }
                    if (mixes.size() > first && mixes.back().weights == layer.weights &&
                        mixes.back().wetness == layer.wetness) {
                        continue;
                    }
                    mixes.push_back(layer);
                }
            }
            of.mixes.begin[static_cast<size_t>(c) + 1] = static_cast<uint32_t>(mixes.size());
        }
    }

    /// What tiles around have bared or covered up since a tile was read.
    void read_walls() {
        if (!shows_inside()) return;
        for_each_tile([&](int tx, int ty) {
            Tile& tile = tiles[tile_index(tx, ty)];
            if (!std::exchange(tile.has_old_walls, false)) return;
            mesh::TileColumns& known = grid.tiles[tile_index(tx, ty)];
            mesh::find_bare_walls(grid, known, tx, ty, walls);
            if (walls == known.walls) return;
            std::swap(walls, known.walls);
            source.read_tile(tx, ty, volume, solid, material);
            read_mixes(tx, ty, known);
            mark_dirty(tx, ty);
        });
    }

    /// From the arrays of the tile just read.
    void read_loose(int tx, int ty) {
        std::vector<LooseVoxel>& loose = tiles[tile_index(tx, ty)].loose;
        loose.clear();
        const GridFrame& frame = source.frame();
        for (const int v : loose_voxels) {
            const int x = tx * kTileSide + v % kTileSide,
                      y = ty * kTileSide + v / kTileSide % kTileSide;
            const int z = v / mesh::kTileColumns;
            if (x >= grid.size[0] || y >= grid.size[1]) continue;
            LooseVoxel voxel;
            voxel.center_m = frame.to_world({x + 0.5, y + 0.5, z + 0.5});
            voxel.velocity_m_s = source.velocity_m_s(x, y, z);
            voxel.side_m = static_cast<float>(frame.voxel_m);
            voxel.height_m = voxel.side_m * height_above_ground(v % mesh::kTileColumns, z);
            voxel.volume = volume[static_cast<size_t>(v)];
            voxel.color = source.color_at(x, y, z, material[static_cast<size_t>(v)]);
            voxel.dust = source.dust_at(x, y, z, material[static_cast<size_t>(v)]);
            voxel.seed = static_cast<uint32_t>((int64_t{z} * grid.size[1] + y) * grid.size[0] + x);
            loose.push_back(voxel);
        }
    }

    /// Of a voxel's middle in a column just read [voxels].
    float height_above_ground(int column, int z) const {
        const float middle = static_cast<float>(z) + 0.5f;
        float ground = 0;
        const auto raise = [&](float top) {
            if (top <= middle) ground = std::max(ground, top);
        };
        for (const mesh::Run& run : columns.runs.column(column)) raise(run.top);
        for (const mesh::SolidRun& run : columns.solids.column(column)) raise(run.top);
        return middle - ground;
    }

    template <typename Visit>
    void for_each_tile(Visit visit) {
        for (int ty = 0; ty < grid.tile_count[1]; ++ty) {
            for (int tx = 0; tx < grid.tile_count[0]; ++tx) visit(tx, ty);
        }
    }

    /// Calls visit(x, y) for each tile at most `reach` away.
    template <typename Visit>
    void for_each_around(int tx, int ty, int reach, Visit visit) {
        for (int y = std::max(0, ty - reach); y <= std::min(grid.tile_count[1] - 1, ty + reach);
             ++y) {
            for (int x = std::max(0, tx - reach); x <= std::min(grid.tile_count[0] - 1, tx + reach);
                 ++x) {
                visit(x, y);
            }
        }
    }

    void mark_with_neighbours(int tx, int ty) {
        has_terrain |= !grid.tiles[tile_index(tx, ty)].solids.items.empty();
        for_each_around(tx, ty, 1, [&](int x, int y) {
            Tile& tile = tiles[tile_index(x, y)];
            tile.has_errors = false;
            tile.has_old_walls = true;
        });
        mark_dirty(tx, ty);
    }

    /// Tiles whose meshes may depend on this one's columns.
    void mark_dirty(int tx, int ty) {
        const int* reach = has_terrain ? kReachAtTerrain : kReach;
        for_each_around(tx, ty, kReachMost, [&](int x, int y) {
            const int away = std::max(std::abs(x - tx), std::abs(y - ty));
            Tile& tile = tiles[tile_index(x, y)];
            if (away <= reach[levels.at(x, y)]) tile.dirty = true;
        });
    }

    void take_levels(std::span<const uint8_t> wanted) {
        if (!levels.take(wanted)) return;
        for_each_tile([&](int tx, int ty) {
            Tile& tile = tiles[tile_index(tx, ty)];
            const uint64_t around = levels.around(tx, ty);
            tile.dirty |= tile.levels_around != around;
            tile.levels_around = around;
        });
    }

    void take_detail(const SurfaceDetail& detail) {
        const Vec3 eye = source.frame().to_grid(detail.eye_m);
        const auto beyond = [](double at, double low, double high) {
            return std::max({0.0, low - at, at - high});
        };
        const double away_z = beyond(eye.z, 0, grid.size[2]);
        for (int ty = 0; ty < grid.tile_count[1]; ++ty) {
            const double away_y = beyond(eye.y, kTileSide * ty, kTileSide * (ty + 1));
            for (int tx = 0; tx < grid.tile_count[0]; ++tx) {
                const double away_x = beyond(eye.x, kTileSide * tx, kTileSide * (tx + 1));
                const double away = std::hypot(away_x, away_y, away_z);
                uint8_t& level = wanted_levels[tile_index(tx, ty)];
                const auto level_at = [&](double share) {
                    return level_of(tx, ty, detail, share * away);
                };
                const bool keeps =
                    level >= level_at(1 - kKeepShare) && level <= level_at(1 + kKeepShare);
                if (!keeps) level = level_at(1);
            }
        }
        take_levels(wanted_levels);
    }

    /// The coarsest level that the detail allows a tile, so far [voxels] from the eye.
    uint8_t level_of(int tx, int ty, const SurfaceDetail& detail, double away) {
        uint8_t level = 0;
        while (level < TileLevels::kMost && detail.cell_angle_rad * away >= 2 << level) ++level;
        if (level == TileLevels::kMost || detail.error_angle_rad < 0) return level;
        Tile& tile = tiles[tile_index(tx, ty)];
        if (!tile.has_errors) tile.errors = mesh::find_coarse_errors(grid, tx, ty);
        tile.has_errors = true;
        const double error = detail.error_angle_rad * away;
        while (level < TileLevels::kMost && static_cast<double>(tile.errors[level]) <= error) {
            ++level;
        }
        return level;
    }

    bool is_new(const Tile& tile, int tx, int ty) const {
        return !tile.read || tile.source_revision != source.tile_revision(tx, ty);
    }

    /// Where materials have other colours all tiles show them.
    void take_colors() {
        if (!meshers.take_colors(source.materials())) return;
        if (device_mesher) device_mesher->take_colors(source.materials());
        for (Tile& tile : tiles) tile.dirty = true;
    }

    /// Reads the tiles whose revision has changed.
    void read(SurfaceMeshReport& report) {
        take_colors();
        places.clear();
        for_each_tile([&](int tx, int ty) {
            const Tile& tile = tiles[tile_index(tx, ty)];
            if (is_new(tile, tx, ty) || !tile.rolling.empty()) places.push_back({tx, ty});
        });
        source.read_ahead(places);
        for_each_tile([&](int tx, int ty) {
            Tile& tile = tiles[tile_index(tx, ty)];
            const uint64_t revision = source.tile_revision(tx, ty);  // before it is read
            const bool has_changed = is_new(tile, tx, ty);
            // What has come to rest may have done so without a change.
            tile.rolls = has_changed || !tile.rolling.empty();
            if (has_changed) {
                const bool changed = read_columns(tx, ty);
                if (changed || !tile.read) mark_with_neighbours(tx, ty);
                tile.read = true;
                tile.source_revision = revision;
                ++report.tile_read_count;
            }
            if (tile.rolls && def.layer == SurfaceMeshDef::Layer::soil) {
                mesh::read_motions(grid, source, tx, ty, tile.motions);
            }
        });
        read_walls();
        if (def.layer != SurfaceMeshDef::Layer::soil) return;
        for_each_tile([&](int tx, int ty) {
            Tile& tile = tiles[tile_index(tx, ty)];
            if (!tile.rolls) return;
            mesh::find_rolling_soil(grid, source, tx, ty, tile.motions, tile.rolling);
        });
    }

    /// Meshes the tiles of which something has changed.
    void build(SurfaceMeshReport& report) {
        meshed.clear();
        jobs.clear();
        for_each_tile([&](int tx, int ty) {
            Tile& tile = tiles[tile_index(tx, ty)];
            report.tile_coarse_count += levels.at(tx, ty) > 0;
            if (tile.dirty) jobs.push_back({tx, ty, &tile.mesh});
        });
        if (!device_mesher || !build_on_device(report)) {
            meshers.build(grid, levels, jobs, threads);
        }
        for (const auto& job : jobs) finish(job.tx, job.ty, report);
    }

    void finish(int tx, int ty, SurfaceMeshReport& report) {
        Tile& tile = tiles[tile_index(tx, ty)];
        meshed.push_back(static_cast<int>(tile_index(tx, ty)));
        tile.dirty = false;
        ++tile.mesh_revision;
        ++report.tile_built_count;
    }

    /// A device that fails leaves all tiles to the CPU, now and later.
    bool build_on_device(SurfaceMeshReport& report) {
        if (const Status built = device_mesher->build(grid, levels, jobs, &threads); !built) {
            backend_reason = built.error();
            device_mesher.reset();
            return false;
        }
        report.tile_gl_count = static_cast<int>(jobs.size());
        return true;
    }

    const TileSource& source;
    SurfaceMeshDef def;
    bool has_water;
    mesh::GridColumns grid;
    bool has_terrain = false;  ///< or ground bodies, be it in a single column
    std::vector<Tile> tiles;
    TileLevels levels;
    std::vector<uint8_t> wanted_levels;  ///< of the last detail, before neighbours lower them
    WorkThreads threads;
    mesh::TileMeshers meshers;
    std::unique_ptr<mesh::DeviceMesher> device_mesher;  ///< null: the CPU meshes
    std::string backend_reason;
    std::vector<mesh::TileJob> jobs;
    std::vector<int> meshed;                 ///< tiles, by the last update
    std::vector<std::array<int, 2>> places;  ///< of tiles to read
    mesh::TileColumns columns;
    mesh::ColumnLists<mesh::BareWall> walls;
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    std::vector<int> loose_voxels;
};

SurfaceMesher::SurfaceMesher(const TileSource& source, const SurfaceMeshDef& def)
    : impl_(std::make_unique<Impl>(source, def, nullptr)) {}
SurfaceMesher::SurfaceMesher(const TileSource& source, const SurfaceMeshDef& def,
                             std::unique_ptr<mesh::DeviceMesher> device_mesher)
    : impl_(std::make_unique<Impl>(source, def, std::move(device_mesher))) {}
SurfaceMesher::~SurfaceMesher() = default;

SurfaceMeshReport SurfaceMesher::update() {
    SurfaceMeshReport report;
    impl_->read(report);
    impl_->build(report);
    return report;
}

SurfaceMeshReport SurfaceMesher::update(const SurfaceDetail& detail) {
    SurfaceMeshReport report;
    impl_->read(report);
    impl_->take_detail(detail);
    impl_->build(report);
    return report;
}

SurfaceMeshReport SurfaceMesher::update(std::span<const uint8_t> levels) {
    assert(levels.size() == impl_->tiles.size());
    SurfaceMeshReport report;
    impl_->read(report);
    impl_->take_levels(levels);
    impl_->build(report);
    return report;
}

int SurfaceMesher::tile_level(int tx, int ty) const {
    assert(impl_->tile_index(tx, ty) < impl_->tiles.size());
    return impl_->levels.at(tx, ty);
}

std::string SurfaceMesher::backend_name() const { return impl_->device_mesher ? "gl" : "cpu"; }

const std::string& SurfaceMesher::backend_reason() const { return impl_->backend_reason; }

Vec3 SurfaceMesher::origin_m() const { return impl_->def.origin_m; }
int SurfaceMesher::tile_count_x() const { return impl_->grid.tile_count[0]; }
int SurfaceMesher::tile_count_y() const { return impl_->grid.tile_count[1]; }

const Mesh& SurfaceMesher::tile_mesh(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].mesh;
}

uint64_t SurfaceMesher::tile_mesh_revision(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].mesh_revision;
}

std::span<const int> SurfaceMesher::changed_tiles() const { return impl_->meshed; }

void SurfaceMesher::visit_changed(const std::function<void(int, int, const Mesh&)>& visit) const {
    for (const int tile : impl_->meshed) {
        const int tx = tile % tile_count_x(), ty = tile / tile_count_x();
        visit(tx, ty, tile_mesh(tx, ty));
    }
}

std::span<const LooseVoxel> SurfaceMesher::loose_soil(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].loose;
}

std::span<const RollingSoil> SurfaceMesher::rolling_soil(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].rolling;
}

void SurfaceMesher::gather(Mesh& mesh) const {
    mesh.clear();
    for (const Impl::Tile& tile : impl_->tiles) mesh.append(tile.mesh);
}

}  // namespace bsoil
