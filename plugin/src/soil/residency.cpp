// Tiles asleep and awake: cost follows what moves.
#include <algorithm>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {
// A tile nobody needed for so many steps goes to sleep: long enough that a slow avalanche does not
// pack and unpack it.
constexpr int64_t kSleepAfterSteps = 30;

/// Tile::top of these voxels.
int top_of(const TileVoxels& voxels) {
    for (int z = voxels.height - 1; z >= 0; --z) {
        for (int c = 0; c < kTileColumns; ++c) {
            if (voxels.at(kKeptVolume, z, c) != 0) {
                return z + 1;
            }
        }
    }
    return 0;
}

int top_of(const TileRuns& tile) {
    int top = 0;
    for (int c = 0; c < kTileColumns; ++c) {
        int z = 0;
        for (const ColumnRun& run : tile.column(c)) {
            z += run.length;
            top = run.values[kKeptVolume] != 0 ? std::max(top, z) : top;
        }
    }
    return top;
}

template <typename Soil>
std::shared_ptr<const PackedTile> packed_of(std::vector<uint8_t> bytes, const Soil& soil) {
    auto packed = std::make_shared<PackedTile>();
    packed->bytes = std::move(bytes);
    packed->top = top_of(soil);
    return packed;
}
}  // namespace

std::shared_ptr<const PackedTile> make_packed(const TileRuns& runs) {
    return packed_of(pack_runs(runs), runs);
}
std::shared_ptr<const PackedTile> make_packed(const TileVoxels& voxels) {
    return packed_of(pack_tile(voxels), voxels);
}

Tile& Soil::Impl::tile_for(int index) {
    if (!tiles[index]) {
        tiles[index] = std::make_unique<Tile>();
        tiles[index]->revision = revision_base + 1;
        // Columns of the last tiles that lie beyond the grid's sides are rock; see is_in_grid() in
        // kernel_common.glsl.
        const int x0 = index % tiles_x * kTileSide, y0 = index / tiles_x * kTileSide;
        if (x0 + kTileSide > frame.size[0] || y0 + kTileSide > frame.size[1]) {
            TileVoxels voxels;
            voxels.reset(height, kept_planes);
            for (int c = 0; c < kTileColumns; ++c) {
                if (x0 + c % kTileSide >= frame.size[0] || y0 + c / kTileSide >= frame.size[1]) {
                    for (int z = 0; z < height; ++z) {
                        voxels.at(kKeptTerrain, z, c) = kVoxelFull;
                    }
                }
            }
            tiles[index]->packed = make_packed(voxels);
        }
        stamp_new_tile(index);
    }
    return *tiles[index];
}

Status Soil::Impl::allocate_slots(int count) {
    const int64_t tile_voxels = params.tile_voxels;
    const int64_t planes = kTransportFirst + params.transport_count;
    params.plane_stride = static_cast<int32_t>(tile_voxels * count);
    const int64_t columns = static_cast<int64_t>(count) * kTileColumns;
    params.column_count = static_cast<int32_t>(columns);
    const int64_t blocks = static_cast<int64_t>(count) * blocks_per_tile;
    for (const auto& [buffer, words] :
         {std::pair{Buffer::state, planes * params.plane_stride},
          std::pair{Buffer::delta,
                    static_cast<int64_t>(params.transport_count) * params.plane_stride},
          std::pair{Buffer::tile_table, static_cast<int64_t>(count) * kTileTableWords},
          std::pair{Buffer::block_flags, (kFlagArrays + kMaskWords) * blocks},
          std::pair{Buffer::spans, columns * (kColumnWords + kColumnArrays) +
                                       static_cast<int64_t>(kTileArrays) * count}}) {
        if (Status allocated = device->allocate(buffer, words); !allocated) {
            return allocated;
        }
    }
    for (int slot = count - 1; slot >= slot_count; --slot) {
        free_slots.push_back(slot);
    }
    slot_tile.resize(count, -1);
    woken_step.resize(count, 0);
    looked_step.assign(count, -1);
    looked_blocks.resize(count, 0);
    for (auto* steps : {&listed_step, &rebuild_step, &contact_step}) {
        steps->resize(blocks, 0);
    }
    slot_count = count;
    tile_table.assign(static_cast<size_t>(count) * kTileTableWords, kNeighbourAbsent);
    table_dirty = true;
    forget_stamps();
    return Done{};
}

Status Soil::Impl::grow_slots(int wanted) {
    // The device's buffers are laid out by plane, so growing means moving every plane: awake tiles
    // take the detour through the host. Happens a few times in a run, by doubling.
    const int count = std::min(slot_capacity_max, std::max(wanted, 2 * slot_count));
    if (count <= slot_count) {
        return Error{"the tile table is full"};
    }
    struct Saved {
        int tile;
        TileVoxels voxels;
        std::vector<int32_t> coverage, owner, support, columns;
    };
    std::vector<Saved> saved;
    const auto plane_words = static_cast<size_t>(params.tile_voxels);
    for (int slot = 0; slot < slot_count; ++slot) {
        if (slot_tile[slot] >= 0) {
            Saved entry{slot_tile[slot],
                        {},
                        std::vector<int32_t>(plane_words),
                        std::vector<int32_t>(plane_words),
                        std::vector<int32_t>(plane_words),
                        std::vector<int32_t>(kTileColumns * kColumnWords)};
            read_voxels(slot_tile[slot], entry.voxels);
            read_scratch.clear();
            want_plane(kPlaneCoverage, slot, entry.coverage);
            want_plane(kPlaneOwner, slot, entry.owner);
            want_plane(kPlaneSupport, slot, entry.support);
            read_scratch.push_back({Buffer::spans,
                                    static_cast<int64_t>(slot) * kTileColumns * kColumnWords,
                                    entry.columns});
            device->read(read_scratch);
            saved.push_back(std::move(entry));
        }
    }
    std::vector<int32_t> tops(static_cast<size_t>(slot_count) * kTileColumns);
    device->read(Buffer::spans, static_cast<int64_t>(slot_count) * kTileColumns * kColumnWords,
                 tops);
    if (Status allocated = allocate_slots(count); !allocated) {
        return allocated;
    }
    for (const Saved& entry : saved) {
        const int slot = tiles[entry.tile]->slot;
        write_voxels(entry.tile, entry.voxels);
        const int64_t at = static_cast<int64_t>(slot) * params.tile_voxels;
        for (const auto& [plane, words] :
             {std::pair{kPlaneCoverage, &entry.coverage}, std::pair{kPlaneOwner, &entry.owner},
              std::pair{kPlaneSupport, &entry.support}}) {
            device->write(Buffer::state, static_cast<int64_t>(plane) * params.plane_stride + at,
                          *words);
        }
        device->write(Buffer::spans, static_cast<int64_t>(slot) * kTileColumns * kColumnWords,
                      entry.columns);
    }
    device->write(Buffer::spans, static_cast<int64_t>(count) * kTileColumns * kColumnWords, tops);
    return Done{};
}

int Soil::Impl::wake(int index) {
    Tile& tile = tile_for(index);
    tile.last_used_step = step_index;
    if (tile.slot >= 0) {
        return tile.slot;
    }
    if (free_slots.empty() && !grow_slots(slot_count + 1)) {
        conditions.note(
            StatusBit::tile_table_full, -1,
            frame.to_world({(index % tiles_x + 0.5) * kTileSide,
                            (index / tiles_x + 0.5) * kTileSide, static_cast<double>(tile.top)}));
        return -1;
    }
    scratch.reset(height, kept_planes);
    unpack_tile(tile.bytes(), scratch);
    tile.slot = free_slots.back();
    free_slots.pop_back();
    slot_tile[tile.slot] = index;
    woken_step[tile.slot] = step_index;
    write_voxels(index, scratch);
    const int64_t base = static_cast<int64_t>(tile.slot) * params.tile_voxels;
    for (int plane : {kPlaneCoverage, kPlaneOwner, kPlaneSupport}) {
        device->fill_zero(Buffer::state, static_cast<int64_t>(plane) * params.plane_stride + base,
                          params.tile_voxels);
    }
    device->fill_zero(Buffer::spans, static_cast<int64_t>(tile.slot) * kTileColumns * kColumnWords,
                      kTileColumns * kColumnWords);
    for (int array = 0; array < kFlagArrays; ++array) {
        device->fill_zero(Buffer::block_flags,
                          static_cast<int64_t>(array) * slot_count * blocks_per_tile +
                              static_cast<int64_t>(tile.slot) * blocks_per_tile,
                          blocks_per_tile);
    }
    note_stale(tile.slot, false);  // again: the flags above are new, and no body covers it yet
    tile.packed.reset();
    table_dirty = true;
    contacts_known = false;
    return tile.slot;
}

void Soil::Impl::note_stale(int slot, bool may_be_covered) {
    looked_step[slot] = -1;
    mask_scratch.assign(static_cast<size_t>(blocks_per_tile) * kMaskWords, 0);
    for (size_t first = 0; first < mask_scratch.size(); first += kMaskWords) {
        for (int mask : {kMaskPressed, kMaskMoving}) {
            mask_scratch[first + mask] = mask_scratch[first + mask + 1] = -1;
        }
        if (may_be_covered) {
            mask_scratch[first + kMaskBody] = mask_scratch[first + kMaskBody + 1] = -1;
        }
    }
    device->write(
        Buffer::block_flags,
        (static_cast<int64_t>(kFlagArrays) * slot_count + static_cast<int64_t>(kMaskWords) * slot) *
            blocks_per_tile,
        mask_scratch);
    write_columns(slot, kColumnSoilTop, height);
    write_columns(slot, kColumnFull, 0);
    write_columns(slot, kColumnEnd, height);
    write_columns(slot, kColumnSingle, kNotSingle);
    write_columns(slot, kColumnSlides, 1);
    write_columns(slot, kColumnIntact, kIntactUnknown);
    write_columns(slot, kColumnCut, 0);
}

// As if all of its columns had changed in the last pass.
void Soil::Impl::stamp_columns(int slot) {
    write_columns(slot, kColumnStamp, params.pass_stamp);
    device->write(
        Buffer::spans,
        static_cast<int64_t>(kColumnWords + kColumnArrays) * slot_count * kTileColumns + slot,
        {&params.pass_stamp, 1});
}

void Soil::Impl::write_columns(int slot, int array, int32_t word) {
    mask_scratch.assign(kTileColumns, word);
    const int64_t columns = static_cast<int64_t>(slot_count) * kTileColumns;
    device->write(Buffer::spans,
                  (kColumnWords + array) * columns + static_cast<int64_t>(slot) * kTileColumns,
                  mask_scratch);
}

void Soil::Impl::forget_stamps() {
    const int64_t columns = static_cast<int64_t>(slot_count) * kTileColumns;
    device->fill_zero(Buffer::spans, (kColumnWords + kColumnStamp) * columns, columns);
    device->fill_zero(Buffer::spans, (kColumnWords + kColumnArrays) * columns, slot_count);
    std::ranges::fill(looked_step, -1);
    params.support_stamp = params.spans_stamp = slip_stamps[0] = slip_stamps[1] = failure_stamp =
        -1;
}

void Soil::Impl::put_to_sleep(int index) {
    Tile& tile = *tiles[index];
    read_voxels(index, scratch);
    tile.packed = make_packed(scratch);
    slot_tile[tile.slot] = -1;
    free_slots.push_back(tile.slot);
    tile.slot = -1;
    table_dirty = true;
    contacts_known = false;  // a mean density leaves out what sleeps
}

void Soil::Impl::sleep_idle_tiles() { sleep_tiles_unused_since(step_index - kSleepAfterSteps); }

void Soil::Impl::sleep_tiles_unused_since(int64_t step) {
    for (int slot = 0; slot < slot_count; ++slot) {
        const int index = slot_tile[slot];
        if (index >= 0 && tiles[index]->last_used_step < step) {
            put_to_sleep(index);
        }
    }
}

void Soil::Impl::upload_tile_table() {
    if (!table_dirty) {
        return;
    }
    for (int slot = 0; slot < slot_count; ++slot) {
        int32_t* entry = &tile_table[static_cast<size_t>(slot) * kTileTableWords];
        const int index = slot_tile[slot];
        std::fill(entry, entry + kTileTableWords, kNeighbourAbsent);
        if (index < 0) {
            continue;
        }
        const int tx = index % tiles_x, ty = index / tiles_x;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const int nx = tx + dx, ny = ty + dy;
                if (nx >= 0 && nx < tiles_x && ny >= 0 && ny < tiles_y &&
                    tiles[tile_index(nx, ny)]) {
                    entry[(dy + 1) * 3 + dx + 1] = tiles[tile_index(nx, ny)]->slot;
                }
            }
        }
        entry[kTileTableX] = tx;
        entry[kTileTableY] = ty;
        entry[kTileTableTop] = entry[kTileTableAsked] = 0;
    }
    device->write(Buffer::tile_table, 0, tile_table);
    table_dirty = false;
}

void Soil::Impl::read_voxels(int index, TileVoxels& out) const {
    out.reset(height, kept_planes);
    const Tile* tile = tiles[index].get();
    if (!tile) {
        return;
    }
    if (tile->slot < 0) {
        unpack_tile(tile->bytes(), out);
        return;
    }
    read_scratch.clear();
    const auto words = static_cast<size_t>(params.tile_voxels);
    for (int p = 0; p < kept_planes; ++p) {
        want_plane(p == kKeptTerrain ? kPlaneTerrain : kTransportFirst + p - 1, tile->slot,
                   std::span(out.words).subspan(static_cast<size_t>(p) * words, words));
    }
    device->read(read_scratch);
}

void Soil::Impl::want_plane(int plane, int slot, std::span<int32_t> words) const {
    const int64_t offset = static_cast<int64_t>(plane) * params.plane_stride +
                           static_cast<int64_t>(slot) * params.tile_voxels;
    read_scratch.push_back({Buffer::state, offset, words});
}

void Soil::Impl::write_voxels(int index, const TileVoxels& in) {
    contacts_known = false;
    Tile& tile = *tiles[index];
    if (tile.slot < 0) {
        tile.packed = make_packed(in);
    } else {
        const int64_t base = static_cast<int64_t>(tile.slot) * params.tile_voxels;
        for (int p = 0; p < kept_planes; ++p) {
            const int64_t plane = p == kKeptTerrain ? kPlaneTerrain : kTransportFirst + p - 1;
            device->write(Buffer::state, plane * params.plane_stride + base,
                          std::span(in.words).subspan(static_cast<size_t>(p) * params.tile_voxels,
                                                      params.tile_voxels));
        }
    }
    tile.top = top_of(in);
    if (tile.slot >= 0) {
        note_stale(tile.slot, true);
    }
}

TileRuns Soil::Impl::read_runs(int index) {
    const Tile& tile = tile_for(index);
    TileRuns runs;
    runs.height = height;
    runs.plane_count = kept_planes;
    if (tile.slot < 0) {
        unpack_runs(tile.bytes(), runs);
    } else {
        read_voxels(index, scratch);
        unpack_runs(pack_tile(scratch), runs);
    }
    return runs;
}

void Soil::Impl::write_packed(int index, std::shared_ptr<const PackedTile> in) {
    contacts_known = false;
    Tile& tile = tile_for(index);
    if (tile.slot < 0) {
        tile.top = in->top;
        tile.packed = std::move(in);
    } else {
        scratch.reset(height, kept_planes);
        unpack_tile(in->bytes, scratch);
        write_voxels(index, scratch);
    }
}

std::span<const int32_t> Soil::Impl::surface_heights(int index) {
    static constexpr int32_t kBareFloor[kTileColumns] = {};
    if (!tiles[index] && !is_over_ground(index)) {
        return kBareFloor;
    }
    Tile& tile = tile_for(index);
    if (tile.slot >= 0) {
        return std::span(tile_tops).subspan(static_cast<size_t>(tile.slot) * kTileColumns,
                                            kTileColumns);
    }
    if (!tile.packed) {
        return kBareFloor;
    }
    if (tile.packed->surface.empty()) {
        tile.packed->surface = surface_heights_q16(read_runs(index));
    }
    return tile.packed->surface;
}

// The records of a tile's columns as they are after this step.
const int32_t* Soil::Impl::spans_of(int slot) {
    constexpr size_t kTileSpanWords = static_cast<size_t>(kTileColumns) * kColumnWords;
    if (std::ranges::find(span_asked, slot) == span_asked.end()) {
        span_asked.push_back(slot);
    }
    int& place = span_place[static_cast<size_t>(slot)];
    if (place < 0) {
        place = static_cast<int>(span_slots.size());
        span_slots.push_back(slot);
        tile_spans.resize(span_slots.size() * kTileSpanWords);
        device->read(Buffer::spans, static_cast<int64_t>(slot) * kTileSpanWords,
                     std::span(tile_spans).last(kTileSpanWords));
    }
    return &tile_spans[static_cast<size_t>(place) * kTileSpanWords];
}

std::span<const int32_t> Soil::Impl::carried_surface(int index, int carrier) {
    carried_tops.assign(kTileColumns, kBare);
    // Bodies that may move keep the tiles with their soil awake.
    if (!tiles[index] || tiles[index]->slot < 0) {
        return carried_tops;
    }
    const int32_t* spans = spans_of(tiles[index]->slot);
    for (int c = 0; c < kTileColumns; ++c) {
        const int32_t* column = spans + static_cast<size_t>(c) * kColumnWords;
        for (int i = 0; i < column[kColumnCount]; ++i) {
            const auto pair = static_cast<uint32_t>(column[kColumnBase + i / 2]);
            const int base = static_cast<int>(pair >> (i % 2 * 16) & 0xffff);
            if ((base & kBaseBody) != carrier + 1) {
                continue;
            }
            const int32_t* span = column + kColumnSpans + i * kSpanWords;
            const int32_t bottom = span[kSpanBottom], top = span[kSpanTop];
            if (top > bottom) {
                carried_tops[c] = (base & kBaseFree) != 0 ? top : kCovered - top;
            } else if (carried_tops[c] == kBare && (base & kBaseFree) != 0) {
                carried_tops[c] = kBareTop - top;
            }
        }
    }
    return carried_tops;
}

const TileVoxels& Soil::Impl::sampled_voxels(int index) const {
    const uint64_t revision = tiles[index] ? tiles[index]->revision : revision_base;
    if (index != sampled_tile || revision != sampled_revision) {
        read_voxels(index, sampled);
        read_ground(index, sampled_ground);
        sampled_tile = index;
        sampled_revision = revision;
        coverage_step = -1;
    }
    return sampled;
}

std::span<const int32_t> Soil::Impl::body_coverage_of_sampled() const {
    if (coverage_step == step_index) return sampled_coverage;
    coverage_step = step_index;
    sampled_coverage.clear();
    const Tile* tile = tiles[sampled_tile].get();
    if (!tile || tile->slot < 0) return sampled_coverage;
    sampled_coverage.resize(static_cast<size_t>(params.tile_voxels));
    read_scratch.clear();
    want_plane(kPlaneCoverage, tile->slot, sampled_coverage);
    device->read(read_scratch);
    return sampled_coverage;
}

}  // namespace bsoil
