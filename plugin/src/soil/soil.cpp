// Creation of a soil and questions about it.
#include "bsoil/soil.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_set>

#include "soil/column_surface.h"
#include "soil/kernel_params.h"
#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;

namespace {

/// splitmix64's finisher: spreads a word over 64 bits.
uint64_t mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

constexpr float kUnit = 1.0f / kVoxelFull;  ///< of volume, in voxels

int voxel_count(double size, double voxel) {
    return static_cast<int>(std::ceil(size / voxel - 1e-9));
}

bool has_tile(const SoilCore& s, int tx, int ty) {
    return tx >= 0 && ty >= 0 && tx < s.tiles_x && ty < s.tiles_y;
}

// Where the grid lies, and its size.
void place_grid(SoilCore& s) {
    const SoilDef& def = s.def;
    const bool y_up = def.up == UpAxis::y;
    // Grid x, y, z are world Z, X, Y when Y is up: a turn, not a mirror.
    const double sizes[3] = {y_up ? def.size_m.z : def.size_m.x, y_up ? def.size_m.x : def.size_m.y,
                             y_up ? def.size_m.y : def.size_m.z};
    for (int axis = 0; axis < 3; ++axis) s.frame.size[axis] = voxel_count(sizes[axis], def.voxel_m);
    s.height = (s.frame.size[2] + 7) / 8 * 8;
    s.frame.size[2] = s.height;
    s.frame.voxel_m = def.voxel_m;
    const Quat turn = y_up ? Quat{-0.5, -0.5, -0.5, 0.5} : Quat{};
    const double half = def.yaw_rad / 2;
    const Quat yaw = y_up ? Quat{0, std::sin(half), 0, std::cos(half)}
                          : Quat{0, 0, std::sin(half), std::cos(half)};
    const Quat rotation = yaw * turn;
    const Vec3 corner{-s.frame.size[0] * def.voxel_m / 2, -s.frame.size[1] * def.voxel_m / 2, 0};
    s.frame.grid_to_world = {def.floor_center_m + rotate(rotation, corner), rotation};
    s.world_to_grid = inverse(s.frame.grid_to_world);
    s.kg_per_unit = kReferenceDensity * std::pow(def.voxel_m, 3) / kVoxelFull;
    s.tiles_x = (s.frame.size[0] + kTileSide - 1) / kTileSide;
    s.tiles_y = (s.frame.size[1] + kTileSide - 1) / kTileSide;
    s.blocks_per_tile = s.height / kTileSide;
}

}  // namespace

Soil::Soil(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Soil::~Soil() = default;

Result<std::unique_ptr<Soil>> Soil::create(const SoilDef& def) {
    if (Status status = def.validate(); !status) return Error{status.error()};
    auto impl = std::make_unique<Impl>();
    Impl& s = *impl;
    s.tiles.on_new_tile = [&s](int index) { s.ground.stamp_new_tile(index); };
    s.def = def;
    s.materials = def.material_list();
    s.contacts.start();
    place_grid(s);
    set_kernel_params(s);

    auto device = create_device(def.backend, def.thread_count, s.device_reason);
    if (!device) return Error{device.error()};
    s.device = std::move(*device);
    s.work_threads = std::make_unique<WorkThreads>(def.thread_count);

    if (Status status = s.tiles.start(); !status) return Error{status.error()};
    std::vector<int32_t> tables = make_material_tables(s);
    SoilParams& p = s.params;
    p.contact_offset = kContactsFirst;
    p.flow_result = kFlowResultsFirst;
    if (Status status = s.device->allocate(Buffer::tables, static_cast<int64_t>(tables.size()));
        !status) {
        return Error{status.error()};
    }
    s.contacts.make_room(0);
    s.device->write(Buffer::tables, 0, tables);
    s.passes.start();
    s.shapes.start();
    s.lists.start();
    s.flows.start(std::move(tables));
    if (const std::string& failure = s.device->failure(); !failure.empty()) return Error{failure};
    return std::unique_ptr<Soil>(new Soil(std::move(impl)));
}

StepReport Soil::step(std::span<const SoilBody> bodies) {
    return impl_->step(bodies, impl_->def.step_budget_ms);
}
Result<SettleReport> Soil::settle(int steps_max, std::span<const SoilBody> bodies) {
    return impl_->settle(steps_max, bodies);
}
KnownContacts& Soil::known_contacts() { return impl_->bodies.known_contacts; }
const KnownContacts& Soil::known_contacts() const { return impl_->bodies.known_contacts; }

ContactSoil Soil::contact_soil() const {
    const SoilDef& def = impl_->def;
    const Vec3 up = def.up == UpAxis::y ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    return {up, def.gravity_m_s2, def.voxel_m, impl_->materials, def.contact_law};
}

const SoilDef& Soil::def() const { return impl_->def; }
uint64_t Soil::def_revision() const { return impl_->def_revision; }
uint64_t Soil::state_revision() const { return impl_->state_revision; }
const std::vector<MaterialDef>& Soil::materials() const { return impl_->materials; }
const GridFrame& Soil::frame() const { return impl_->frame; }
WorkCounts Soil::work_counts() const {
    const device::DeviceCounters& counted = impl_->device->counters();
    WorkCounts out{counted.dispatch_count,
                   counted.read_count,
                   counted.read_bytes,
                   counted.wait_count,
                   counted.write_count,
                   counted.write_bytes,
                   {}};
    const auto& kernels = soil_kernel_set().kernels;
    for (size_t i = 0; i < kernels.size(); ++i) {
        const bool is_counted = i < counted.lane_counts.size();
        out.passes.push_back({kernels[i].name, counted.kernel_dispatch_counts[i],
                              is_counted ? counted.lane_counts[i] : 0, counted.kernel_ms[i]});
        if (counted.kernel_touches.empty()) continue;
        const device::TouchCounts& touched = counted.kernel_touches[i];
        out.passes.back().voxel_visited_count = touched.visited_cells;
        out.passes.back().voxel_changed_count = touched.changed_cells;
        out.passes.back().moved_bytes =
            (touched.read_words + touched.written_words) * static_cast<int64_t>(sizeof(int32_t));
    }
    return out;
}

const WorkThreads& Soil::threads() const { return *impl_->work_threads; }
std::string Soil::backend_name() const { return impl_->device->backend_name(); }
std::string Soil::device_name() const { return impl_->device->device_name(); }
std::string Soil::device_failure() const { return impl_->device->failure(); }
int Soil::thread_count() const { return impl_->device->thread_count(); }
uint32_t Soil::status_bits() const { return impl_->conditions.bits(); }
std::span<const Condition> Soil::conditions() const { return impl_->conditions.all(); }
void Soil::clear_status() { impl_->conditions.clear(); }
void Soil::set_status(StatusBit bit) { impl_->conditions.note(bit); }
int64_t Soil::voxels_total() const {
    return int64_t{impl_->frame.size[0]} * impl_->frame.size[1] * impl_->frame.size[2];
}
uint64_t Soil::checksum() const {
    impl_->finish();
    return impl_->checksum();
}
StepRate Soil::step_rate() const { return impl_->budget.rate(); }
bool Soil::is_stepping() const { return impl_->pieces.is_open(); }

SoilTotals Soil::totals() const {
    impl_->finish();
    const Impl& s = *impl_;
    SoilTotals totals;
    totals.units.assign(s.materials.size(), 0);
    const auto material_count = static_cast<int>(s.materials.size());
    const int water = s.water.is_there() ? kKeptMaterial + material_count : -1;
    const auto count = [&](int plane, int64_t units) {
        if (plane == water) {
            totals.water_units += units;
        } else if (plane >= kKeptMaterial && plane < kKeptMaterial + material_count) {
            totals.units[static_cast<size_t>(plane - kKeptMaterial)] += units;
        }
    };
    TileVoxels voxels;
    TileRuns runs;
    const auto count_voxels = [&] {
        for (int plane = kKeptMaterial; plane < s.kept_planes; ++plane) {
            const auto words = std::span(voxels.words)
                                   .subspan(static_cast<size_t>(plane) * s.params.tile_voxels,
                                            static_cast<size_t>(s.params.tile_voxels));
            count(plane, std::accumulate(words.begin(), words.end(), int64_t{0}));
        }
    };
    for (size_t i = 0; i < s.tiles.size(); ++i) {
        const auto index = static_cast<int>(i);
        if (!s.tiles[i]) continue;
        if (s.tiles.read_asleep(index, runs)) {
            runs.for_each([&](int, int, const ColumnRun& run) {
                for (int plane = kKeptMaterial; plane < s.kept_planes; ++plane) {
                    count(plane, int64_t{run.values[static_cast<size_t>(plane)]} * run.length);
                }
            });
        } else {
            s.tiles.read_voxels(index, voxels);
            count_voxels();
        }
        if (s.tiles.read_buried(index, voxels)) count_voxels();
    }
    totals.water_units_in = s.water.units_in();
    totals.water_units_out = s.water.units_out();
    totals.units_in = s.flows.units_in();
    totals.units_out = s.flows.units_out();
    for (int64_t units : totals.units) {
        totals.mass_kg.push_back(static_cast<double>(units) * s.kg_per_unit);
    }
    return totals;
}

// A sum over all voxels and planes of a hash of place, plane and value: independent of order and of
// what is awake.
uint64_t Soil::Impl::checksum() const {
    uint64_t sum = 0;
    const auto words = static_cast<size_t>(kept_planes) * params.tile_voxels;
    const auto add = [&](size_t tile, size_t at, int32_t value) {
        sum += mix(mix(tile * words + at + 1) ^ static_cast<uint32_t>(value));
    };
    TileVoxels voxels;
    TileRuns runs;
    const auto add_voxels = [&](size_t tile) {
        for (size_t at = 0; at < words; ++at) {
            if (voxels.words[at] != 0) add(tile, at, voxels.words[at]);
        }
    };
    const auto add_run = [&](size_t tile, int column, int z, const ColumnRun& run) {
        for (int plane = 0; plane < kept_planes; ++plane) {
            const int32_t value = run.values[static_cast<size_t>(plane)];
            for (int i = 0; value != 0 && i < run.length; ++i) {
                add(tile, static_cast<size_t>((plane * height + z + i) * kTileColumns + column),
                    value);
            }
        }
    };
    for (size_t i = 0; i < tiles.size(); ++i) {
        const auto index = static_cast<int>(i);
        if (!tiles[i]) continue;
        if (tiles.read_asleep(index, runs)) {
            runs.for_each(
                [&](int column, int z, const ColumnRun& run) { add_run(i, column, z, run); });
        } else {
            tiles.read_voxels(index, voxels);
            add_voxels(i);
        }
        if (tiles.read_buried(index, voxels)) add_voxels(tiles.size() + i);
    }
    return sum;
}

MemoryUse Soil::memory_use() const {
    const Impl& s = *impl_;
    MemoryUse use;
    use.awake_bytes = s.tiles.memory_bytes();
    int64_t awake_tiles = 0;
    std::unordered_set<const void*> counted;
    for (const auto& tile : s.tiles) {
        if (tile && tile->slot >= 0) {
            ++awake_tiles;
        } else if (tile) {
            use.asleep_columns += kTileColumns;
            use.asleep_bytes += static_cast<int64_t>(sizeof(Tile));
            if (tile->packed && counted.insert(tile->packed.get()).second) {
                use.asleep_bytes +=
                    static_cast<int64_t>(sizeof(PackedTile) + tile->packed->bytes.capacity() +
                                         tile->packed->surface.capacity() * sizeof(int32_t));
            }
            for (const TileBytes& bytes : {tile->ground, tile->buried}) {
                if (bytes && counted.insert(bytes.get()).second) {
                    use.asleep_bytes += static_cast<int64_t>(bytes->capacity());
                }
            }
        }
    }
    use.awake_voxels = awake_tiles * s.params.tile_voxels;
    use.bytes_per_awake_voxel =
        4.0 *
        static_cast<double>(slot_words(s.height, s.params.material_count, s.params.water_count)) /
        s.params.tile_voxels;
    use.bytes_per_asleep_column =
        use.asleep_columns > 0
            ? static_cast<double>(use.asleep_bytes) / static_cast<double>(use.asleep_columns)
            : 0;
    return use;
}

VoxelSample Soil::sample(int x, int y, int z) const { return impl_->sample(x, y, z, kAllPlanes); }

VoxelSample Soil::sample_matter(int x, int y, int z) const {
    return impl_->sample(x, y, z, kMatterPlanes);
}

Vec3 Soil::velocity_m_s(int x, int y, int z) const {
    return impl_->sample(x, y, z, kMaterialPlanes | kMomentumPlanes).velocity_m_s;
}

VoxelSample Soil::Impl::sample(int x, int y, int z, PlaneSet planes) const {
    const Impl& s = *this;
    VoxelSample sample;
    if (x < 0 || y < 0 || z < 0 || x >= s.frame.size[0] || y >= s.frame.size[1] || z >= s.height) {
        return sample;
    }
    const TileVoxels& voxels = s.sampler.voxels(s.tile_index(x / kTileSide, y / kTileSide),
                                                planes | kTerrainPlane | kVolumePlane);
    const int column = y % kTileSide * kTileSide + x % kTileSide;
    sample.coverage = voxels.at(kKeptTerrain, z, column) / static_cast<double>(kVoxelFull);
    const int volume = voxels.at(kKeptVolume, z, column);
    sample.volume = volume / static_cast<double>(kVoxelFull);
    const std::span<const int32_t> covered = s.sampler.body_coverage();
    if (!covered.empty()) {
        sample.body_coverage = covered[static_cast<size_t>(z) * kTileColumns + column] /
                               static_cast<double>(kVoxelFull);
    }
    const BlockKey block =
        BlockKey{s.tile_index(x / kTileSide, y / kTileSide)} * s.blocks_per_tile + z / kTileSide;
    sample.is_active = s.lists.is_active(block);
    const auto world_vector = [&](int plane, double scale) {
        return rotate(s.frame.grid_to_world.rotation,
                      Vec3{static_cast<double>(voxels.at(plane, z, column)),
                           static_cast<double>(voxels.at(plane + 1, z, column)),
                           static_cast<double>(voxels.at(plane + 2, z, column))} *
                          scale);
    };
    if (volume > 0) {
        if ((planes >> kKeptBond & 1) != 0) {
            // Where soil has left, roundings may leave more bonds than volume.
            sample.undisturbed =
                std::clamp(voxels.at(kKeptBond, z, column) / static_cast<double>(volume), 0.0, 1.0);
        }
        if ((planes & kForcePlanes) != 0) {
            sample.push =
                world_vector(kKeptForce, static_cast<double>(kForceShare) / kForceOne / kVoxelFull);
        }
    }
    int64_t mass = 0;
    int most = 0;
    for (int m = 0; m < s.params.material_count; ++m) {
        const int units = voxels.at(kKeptMaterial + m, z, column);
        mass += units;
        if (units > most) {
            most = units;
            sample.material = m;
        }
    }
    if (mass > 0 && s.water.is_there()) {
        double pores = 0;
        for (int m = 0; m < s.params.material_count; ++m) {
            pores += voxels.at(kKeptMaterial + m, z, column) *
                     s.materials[static_cast<size_t>(m)].pore_water_fraction * kWaterParts;
        }
        const int water_units = voxels.at(kKeptMaterial + s.params.material_count, z, column);
        if (pores > 0) sample.saturation = std::min(1.0, water_units / pores);
    }
    if (mass > 0) {
        sample.density_kg_m3 = static_cast<double>(mass) * kReferenceDensity / volume;
        if ((planes & kMomentumPlanes) != 0) {
            sample.velocity_m_s =
                world_vector(kKeptMomentum, s.frame.voxel_m / s.def.step_s / kVelocityOne /
                                                static_cast<double>(mass));
        }
    }
    return sample;
}

std::array<double, limits::kMaterialCapacity> Soil::material_shares(int x, int y, int z) const {
    const Impl& s = *impl_;
    std::array<double, limits::kMaterialCapacity> shares{};
    if (x < 0 || y < 0 || z < 0 || x >= s.frame.size[0] || y >= s.frame.size[1] || z >= s.height) {
        return shares;
    }
    const TileVoxels& voxels =
        s.sampler.voxels(s.tile_index(x / kTileSide, y / kTileSide), kMaterialPlanes);
    const int column = y % kTileSide * kTileSide + x % kTileSide;
    double mass = 0;
    for (int m = 0; m < s.params.material_count; ++m) {
        mass += shares[static_cast<size_t>(m)] = voxels.at(kKeptMaterial + m, z, column);
    }
    for (double& share : shares) share /= std::max(1.0, mass);
    return shares;
}

GroundMotion Soil::ground_motion(int x, int y) const {
    const Impl& s = *impl_;
    GroundMotion motion;
    if (x < 0 || y < 0 || x >= s.frame.size[0] || y >= s.frame.size[1]) return motion;
    const TileVoxels& voxels =
        s.sampler.voxels(s.tile_index(x / kTileSide, y / kTileSide), kVolumePlane);
    const int column = y % kTileSide * kTileSide + x % kTileSide;
    const std::span<const int32_t> slips = s.sampler.slip_speeds();
    if (!slips.empty()) {
        motion.slip_m_s =
            slips[static_cast<size_t>(column)] / 65536.0 * s.frame.voxel_m / s.def.step_s;
    }
    if (s.def.slides != SlideMotion::run_out) return motion;
    const std::span<const int32_t> covered = s.sampler.body_coverage();
    for (size_t v = static_cast<size_t>(column); v < covered.size(); v += kTileColumns) {
        if (covered[v] > 0) return motion;  // what a body carries has its velocity
    }
    int top = s.height - 1;
    while (top > 0 && voxels.at(kKeptVolume, top, column) == 0) --top;
    motion.velocity_m_s = velocity_m_s(x, y, top);
    return motion;
}

double Soil::surface_height_m(int x, int y) const {
    const Impl& s = *impl_;
    if (x < 0 || y < 0 || x >= s.frame.size[0] || y >= s.frame.size[1]) return 0;
    const int column = y % kTileSide * kTileSide + x % kTileSide;
    return s.sampler.top_q16(s.tile_index(x / kTileSide, y / kTileSide), column) / 65536.0 *
           s.frame.voxel_m;
}

uint64_t Soil::tile_revision(int tx, int ty) const {
    if (!has_tile(*impl_, tx, ty)) return 0;
    const auto& tile = impl_->tiles[impl_->tile_index(tx, ty)];
    return tile ? tile->revision : impl_->tiles.revision_base();
}

void Soil::read_ahead(std::span<const std::array<int, 2>> tiles) const {
    const Impl& s = *impl_;
    if (s.device->backend_name() != "gl") return;
    std::vector<int> indices;
    indices.reserve(tiles.size());
    for (const auto& [tx, ty] : tiles) {
        if (has_tile(s, tx, ty)) indices.push_back(s.tile_index(tx, ty));
    }
    s.sampler.read_ahead(std::move(indices));
}

void Soil::read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                     std::vector<uint8_t>& material) const {
    const Impl& s = *impl_;
    const size_t count = static_cast<size_t>(s.params.tile_voxels);
    material.assign(count, 0);
    if (!has_tile(s, tx, ty)) {
        volume.assign(count, 0);
        solid.assign(count, 0);
        return;
    }
    volume.resize(count);
    solid.resize(count);
    const bool has_others = s.params.material_count > 1;
    const TileVoxels& voxels = s.sampler.voxels(
        s.tile_index(tx, ty), kTerrainPlane | kVolumePlane | (has_others ? kMaterialPlanes : 0));
    for (size_t v = 0; v < count; ++v) {
        solid[v] = static_cast<float>(voxels.words[v]) * kUnit;
        volume[v] = static_cast<float>(voxels.words[count + v]) * kUnit;
    }
    if (has_others) {
        for (size_t v = 0; v < count; ++v) {
            int most = 0;
            for (int m = 0; m < s.params.material_count; ++m) {
                const int units = voxels.words[(kKeptMaterial + m) * count + v];
                if (units > most) {
                    most = units;
                    material[v] = static_cast<uint8_t>(m);
                }
            }
        }
    }
}

void Soil::read_terrain(int tx, int ty, std::vector<float>& terrain) const {
    const Impl& s = *impl_;
    const auto count = static_cast<size_t>(s.params.tile_voxels);
    if (!has_tile(s, tx, ty)) return terrain.assign(count, 0);
    terrain.resize(count);
    const TileVoxels& voxels = s.sampler.voxels(s.tile_index(tx, ty), kTerrainPlane);
    const std::vector<int32_t>& ground = s.sampler.ground().words;
    for (size_t v = 0; v < terrain.size(); ++v) {
        const int of_bodies = ground.empty() ? 0 : ground[v];
        terrain[v] = static_cast<float>(voxels.words[v] - of_bodies) * kUnit;
    }
}

}  // namespace bsoil
