// Tiles asleep and awake: cost follows what moves. How they wake and fall asleep is in
// tile_residency.cpp.
#include "soil/tile_table.h"

#include <algorithm>

#include "soil/slot_buffers.h"

namespace bsoil {

using namespace layout;

namespace {
// Memory that SoilDef::tile_capacity = 0 allows awake tiles to take.
constexpr int64_t kAwakeBytesDefault = int64_t{1} << 30;
// Awake tiles that a soil starts with; the table doubles when it needs more.
constexpr int kSlotsAtStart = 64;

/// Tile::top of these runs.
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

int top_of(const TileVoxels& voxels) {
    for (int z = voxels.height - 1; z >= 0; --z) {
        for (int c = 0; c < kTileColumns; ++c) {
            if (voxels.at(kKeptVolume, z, c) != 0) return z + 1;
        }
    }
    return 0;
}

std::shared_ptr<const PackedTile> make_packed(const TileRuns& runs) {
    return packed_of(pack_runs(runs), runs);
}
std::shared_ptr<const PackedTile> make_packed(const TileVoxels& voxels) {
    return packed_of(pack_tile(voxels), voxels);
}

Tile& TileTable::make(int index) {
    if (!tiles_[index]) {
        tiles_[index] = std::make_unique<Tile>();
        tiles_[index]->revision = revision_base_ + 1;
        // Columns of the last tiles_ that lie beyond the grid's sides are rock; see is_in_grid() in
        // kernel_common.glsl.
        const int x0 = index % core_.tiles_x * kTileSide, y0 = index / core_.tiles_x * kTileSide;
        if (x0 + kTileSide > core_.frame.size[0] || y0 + kTileSide > core_.frame.size[1]) {
            TileVoxels voxels;
            voxels.reset(core_.height, core_.kept_planes);
            for (int c = 0; c < kTileColumns; ++c) {
                if (x0 + c % kTileSide >= core_.frame.size[0] ||
                    y0 + c / kTileSide >= core_.frame.size[1]) {
                    for (int z = 0; z < core_.height; ++z) {
                        voxels.at(kKeptTerrain, z, c) = kVoxelFull;
                    }
                }
            }
            tiles_[index]->packed = make_packed(voxels);
        }
        if (on_new_tile) on_new_tile(index);
    }
    return *tiles_[index];
}

int TileTable::top_around(int tx, int ty) const {
    int top = 0;
    core_.tiles_around(tx, ty).for_each_tile([&](int nx, int ny) {
        const Tile* tile = tiles_[core_.tile_index(nx, ny)].get();
        top = std::max(top, tile ? tile->top : 0);
    });
    return top;
}

Status TileTable::start() {
    tiles_.resize(static_cast<size_t>(core_.tile_count()));
    const SoilParams& p = core_.params;
    const int64_t tile_bytes =
        int64_t{p.tile_voxels} * 4 * (kTransportFirst + 2 * p.transport_count);
    slot_capacity_ = static_cast<int>(std::min<int64_t>(
        core_.tile_count(), core_.def.tile_capacity > 0
                                ? core_.def.tile_capacity
                                : std::max<int64_t>(1, kAwakeBytesDefault / tile_bytes)));
    slot_capacity_ = std::min(slot_capacity_, slots_most(core_));
    if (Status ready = expect_large(); !ready) return ready;
    const Status allocated = allocate_slots(std::min(kSlotsAtStart, slot_capacity_));
    if (!allocated) return allocated;
    forget_stamps();
    return Done{};
}

Status TileTable::expect_large() {
    std::vector<SlotBuffer> buffers = slot_buffers(core_);
    std::erase_if(buffers, [](const SlotBuffer& buffer) { return !buffer.is_large; });
    keeps_places_ = true;
    for (const SlotBuffer& buffer : buffers) {
        keeps_places_ &= core_.device->expect(buffer.buffer, buffer.words(slot_capacity_));
    }
    for (const SlotBuffer& buffer : buffers) {
        if (keeps_places_) break;  // else they grow, one where the system has refused another, too
        if (Status freed = core_.device->allocate(buffer.buffer, 0); !freed) return freed;
    }
    return Done{};
}

Status TileTable::allocate_slots(int count) {
    std::vector<SlotBuffer> buffers = slot_buffers(core_);
    if (keeps_places_) {
        for (const SlotBuffer& buffer : buffers) {
            if (!buffer.is_large) continue;
            if (count == slot_capacity_) {
                core_.device->use(buffer.buffer, 0, buffer.words(count));
                continue;
            }
            for (const auto& [offset, words] : buffer.parts(slot_capacity_, count)) {
                core_.device->use(buffer.buffer, offset, words);
            }
        }
        std::erase_if(buffers, [](const SlotBuffer& buffer) { return buffer.is_large; });
    }
    for (size_t done = 0; done < buffers.size(); ++done) {
        const SlotBuffer& buffer = buffers[done];
        const Status allocated = core_.device->rearrange(
            buffer.buffer, buffer.words(count),
            slot_count_ > 0 ? buffer.moves(slot_count_, count) : std::vector<device::WordMove>{});
        if (allocated) continue;
        while (slot_count_ > 0 && done-- > 0) {  // back to what there was
            const SlotBuffer& grown = buffers[done];
            if (Status shrunk = core_.device->rearrange(grown.buffer, grown.words(slot_count_),
                                                        grown.moves(count, slot_count_));
                !shrunk) {
                core_.device->give_up(shrunk.error());  // some have grown, and others not
                return shrunk;
            }
        }
        return allocated;
    }
    core_.params.plane_stride = static_cast<int32_t>(
        int64_t{core_.params.tile_voxels} * (keeps_places_ ? slot_capacity_ : count) + kPlanePad);
    core_.params.block_count = count * core_.blocks_per_tile;
    core_.params.column_count = static_cast<int32_t>(int64_t{count} * kTileColumns + kColumnPad);
    for (int slot = count - 1; slot >= slot_count_; --slot) free_slots_.push_back(slot);
    slot_tile_.resize(count, -1);
    woken_step_.resize(count, 0);
    is_edited_.resize(static_cast<size_t>(count), false);
    is_restored_.resize(static_cast<size_t>(count), false);
    filled_levels_.resize(count, kNeverUsed);
    looked_step_.resize(count, -1);
    looked_blocks_.resize(count, 0);
    slot_count_ = count;
    neighbour_words_.assign(static_cast<size_t>(count) * kTileTableWords, kNeighbourAbsent);
    is_dirty_ = true;
    return Done{};
}

int64_t TileTable::memory_bytes() const {
    int64_t words = 0;
    for (const SlotBuffer& buffer : slot_buffers(core_)) {
        if (keeps_places_ && buffer.is_large) {
            words += buffer.words(slot_capacity_) - buffer.words(slot_count_);
        }
    }
    return core_.device->memory_bytes() - words * static_cast<int64_t>(sizeof(int32_t));
}

Status TileTable::grow_slots(int wanted) {
    const int count = std::min(slot_capacity_, std::max(wanted, 2 * slot_count_));
    if (wanted > slot_capacity_ || count <= slot_count_) {
        return Error{"the tile table is full; raise tile_capacity"};
    }
    return allocate_slots(count);
}

void TileTable::note_stale(int slot, bool may_be_covered) {
    looked_step_[slot] = -1;
    column_words_.assign(static_cast<size_t>(core_.blocks_per_tile) * kMaskWords, 0);
    for (size_t first = 0; first < column_words_.size(); first += kMaskWords) {
        for (int mask : {kMaskPressed, kMaskMoving}) {
            column_words_[first + mask] = column_words_[first + mask + 1] = -1;
        }
        if (may_be_covered) {
            column_words_[first + kMaskBody] = column_words_[first + kMaskBody + 1] = -1;
        }
    }
    core_.device->write(
        Buffer::block_flags,
        kFlagArrays * block_count() + int64_t{kMaskWords} * slot * core_.blocks_per_tile,
        column_words_);
    write_columns(slot, kColumnSoilTop, core_.height);
    write_columns(slot, kColumnFull, 0);
    write_columns(slot, kColumnEnd, core_.height);
    write_columns(slot, kColumnSingle, kNotSingle);
    write_columns(slot, kColumnSlides, 1);
    write_columns(slot, kColumnIntact, kIntactUnknown);
    for (const int array : {kColumnCut, kColumnFailing, kColumnSinks}) {
        write_columns(slot, array, 0);
    }
    write_columns(slot, kColumnHollow, kHollowUnknown);
}

void TileTable::look_anew_at_all() {
    note_edit();
    for (const auto& tile : tiles_) {
        if (!tile) continue;
        tile->unchecked = any_unchecked = true;
        if (!tile->is_awake()) continue;
        note_stale(tile->slot, true);
        look_anew(tile->slot);
    }
}

void TileTable::note_all_revised() {
    for (const auto& tile : tiles_) {
        if (tile) ++tile->revision;
    }
}

void TileTable::stamp_columns(int slot) {
    write_columns(slot, kColumnStamp, core_.params.pass_stamp);
    core_.device->write(Buffer::spans, tile_array_offset(kTileStamp, slot),
                        {&core_.params.pass_stamp, 1});
}

void TileTable::note_look(int slot, int blocks_up) {
    int64_t& step = looked_step_[static_cast<size_t>(slot)];
    int& blocks = looked_blocks_[static_cast<size_t>(slot)];
    if (step != core_.step_index - 1 || blocks != blocks_up) stamp_columns(slot);
    step = core_.step_index;
    blocks = blocks_up;
    is_edited_[static_cast<size_t>(slot)] = false;
}

void TileTable::forget_restored() {
    is_restored_.assign(is_restored_.size(), false);
    any_restored_ = false;
}

void TileTable::write_columns(int slot, int array, int32_t word) {
    column_words_.assign(kTileColumns, word);
    core_.device->write(Buffer::spans, column_array_offset(array, slot), column_words_);
}

void TileTable::forget_stamps() {
    core_.device->fill_zero(Buffer::spans, column_array_offset(kColumnStamp, 0),
                            int64_t{slot_count_} * kTileColumns);
    for (const int array : {kTileStamp, kTileCut, kTileFailing}) {
        core_.device->fill_zero(Buffer::spans, tile_array_offset(array, 0), slot_count_);
    }
    std::ranges::fill(looked_step_, -1);
    core_.stamps.forget();
}

void TileTable::upload() {
    if (!is_dirty_) return;
    for (int slot = 0; slot < slot_count_; ++slot) {
        int32_t* entry = &neighbour_words_[static_cast<size_t>(slot) * kTileTableWords];
        const int index = slot_tile_[slot];
        std::fill(entry, entry + kTileTableWords, kNeighbourAbsent);
        if (index < 0) continue;
        const int tx = index % core_.tiles_x, ty = index / core_.tiles_x;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const int nx = tx + dx, ny = ty + dy;
                if (nx >= 0 && nx < core_.tiles_x && ny >= 0 && ny < core_.tiles_y &&
                    tiles_[core_.tile_index(nx, ny)]) {
                    entry[kTileTableNeighbours + (dy + 1) * kNeighbourRow + dx + 1] =
                        tiles_[core_.tile_index(nx, ny)]->slot;
                }
            }
        }
        entry[kTileTableX] = tx;
        entry[kTileTableY] = ty;
        entry[kTileTableTop] = entry[kTileTableAsked] = entry[kTileTableBars] = 0;
    }
    core_.device->write(Buffer::tile_table, 0, neighbour_words_);
    is_dirty_ = false;
}

void TileTable::read_voxels(int index, TileVoxels& out) const {
    read_planes(index, core_.kept_planes, out);
}

void TileTable::read_planes(int index, int plane_count, TileVoxels& out) const {
    const Tile* tile = tiles_[index].get();
    if (!tile) {
        out.reset(core_.height, plane_count);
        return;
    }
    if (tile->slot < 0) {
        out.resize(core_.height, plane_count);
        unpack_first_planes(tile->bytes(), core_.kept_planes, out);
        return;
    }
    ranges_.clear();
    want_planes(index, plane_count, kAllPlanes, out, ranges_);
    core_.device->read(ranges_);
}

void TileTable::want_voxels(int index, PlaneSet planes, TileVoxels& out,
                            std::vector<device::ReadRange>& ranges) const {
    want_planes(index, core_.kept_planes, planes, out, ranges);
}

void TileTable::want_planes(int index, int plane_count, PlaneSet planes, TileVoxels& out,
                            std::vector<device::ReadRange>& ranges) const {
    out.resize(core_.height, plane_count);
    const auto words = static_cast<size_t>(core_.params.tile_voxels);
    for (int p = 0; p < plane_count; ++p) {
        if ((planes >> p & 1) == 0) continue;
        ranges.push_back(
            plane_range(state_plane_of(p), tiles_[index]->slot,
                        std::span(out.words).subspan(static_cast<size_t>(p) * words, words)));
    }
}

void TileTable::write_voxels(int index, const TileVoxels& in) {
    note_edit();
    Tile& tile = *tiles_[index];
    if (tile.slot < 0) {
        tile.packed = make_packed(in);
    } else {
        const auto words = static_cast<size_t>(core_.params.tile_voxels);
        for (int p = 0; p < core_.kept_planes; ++p) {
            core_.device->write(Buffer::state, plane_offset(state_plane_of(p), tile.slot),
                                std::span(in.words).subspan(static_cast<size_t>(p) * words, words));
        }
    }
    tile.top = top_of(in);
    if (tile.slot < 0) return;
    note_stale(tile.slot, true);
    look_anew(tile.slot);
}

bool TileTable::read_asleep(int index, TileRuns& runs) const {
    const Tile& tile = *tiles_[index];
    if (tile.slot >= 0) return false;
    runs.height = core_.height;
    runs.plane_count = core_.kept_planes;
    unpack_runs(tile.bytes(), runs);
    return true;
}

void TileTable::read_runs(int index, TileRuns& runs) {
    make(index);
    if (read_asleep(index, runs)) return;
    runs.height = core_.height;
    runs.plane_count = core_.kept_planes;
    read_voxels(index, voxels_);
    unpack_runs(pack_tile(voxels_), runs);
}

void TileTable::write_packed(int index, std::shared_ptr<const PackedTile> in) {
    note_edit();
    Tile& tile = make(index);
    if (tile.slot < 0) {
        tile.top = in->top;
        tile.packed = std::move(in);
    } else {
        voxels_.reset(core_.height, core_.kept_planes);
        unpack_tile(in->bytes, voxels_);
        write_voxels(index, voxels_);
    }
}

bool TileTable::read_buried(int index, TileVoxels& out) const {
    if (!tiles_[index] || !tiles_[index]->buried) return false;
    out.reset(core_.height, core_.kept_planes);
    unpack_tile(*tiles_[index]->buried, out);
    return true;
}

void TileTable::read_ground(int index, TileVoxels& out) const {
    out.words.clear();
    if (tiles_[index] && tiles_[index]->ground) {
        out.reset(core_.height, 1);
        unpack_tile(*tiles_[index]->ground, out);
    }
}

void TileTable::clear() {
    // Whoever remembers a tile's revision must see that it is another tile now.
    for (const auto& tile : tiles_) {
        if (tile) revision_base_ = std::max(revision_base_, tile->revision);
    }
    ++revision_base_;
    note_edit();
    for (auto& tile : tiles_) tile.reset();
    std::ranges::fill(slot_tile_, -1);
    // Nobody has looked what they hold.
    std::ranges::fill(filled_levels_, core_.height);
    free_slots_.clear();
    for (int slot = slot_count_ - 1; slot >= 0; --slot) free_slots_.push_back(slot);
    std::ranges::fill(woken_step_, 0);
    forget_restored();
    is_dirty_ = true;
    core_.device->fill_zero(Buffer::block_flags, 0, kFlagArrays * block_count());
    forget_stamps();
}

}  // namespace bsoil
