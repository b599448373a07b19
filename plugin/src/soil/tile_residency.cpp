// Tiles wake and fall asleep.
#include <algorithm>

#include "soil/tile_table.h"

namespace bsoil {

using namespace layout;

namespace {

// Steps after which a tile that nobody needs goes to sleep. Long enough that a slow avalanche does
// not pack and unpack it.
constexpr int64_t kSleepAfterSteps = 30;
// A tile that wakes is written up to a multiple of so many levels. Ours: 8 KiB a plane. Larger: air
// is written; smaller: a driver has more calls, of some microseconds each, with less in them.
constexpr int kLevelsWritten = 32;
// Tiles that are unpacked before they are written. Ours: one for each thread of a large machine,
// some MB. Larger: memory; smaller: threads wait.
constexpr size_t kTilesUnpacked = 16;

}  // namespace

int TileTable::wake(int index) {
    Tile& tile = make(index);
    tile.last_used_step = core_.step_index;
    if (tile.slot >= 0) return tile.slot;
    if (!take_slot(index)) {
        core_.conditions.note(StatusBit::tile_table_full, -1,
                              core_.frame.to_world({(index % core_.tiles_x + 0.5) * kTileSide,
                                                    (index / core_.tiles_x + 0.5) * kTileSide,
                                                    static_cast<double>(tile.top)}));
        return -1;
    }
    unpack_filled(index, voxels_);
    fill_slot(tile, voxels_);
    return tile.slot;
}

// Slots are taken in the order of the list, as by wake(). Where there are none left it says so.
void TileTable::wake_ahead(std::span<const int> indices) {
    waking_.clear();
    for (const int index : indices) {
        if (make(index).slot >= 0) continue;
        if (!take_slot(index)) break;
        waking_.push_back(index);
    }
    if (unpacked_.size() < std::min(kTilesUnpacked, waking_.size())) {
        unpacked_.resize(std::min(kTilesUnpacked, waking_.size()));
    }
    const std::span<const int> all = waking_;
    for (size_t done = 0; done < all.size(); done += kTilesUnpacked) {
        const std::span<const int> now =
            all.subspan(done, std::min(kTilesUnpacked, all.size() - done));
        for_ranges(core_.work_threads.get(), now.size(), 1, [&](size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) unpack_filled(now[i], unpacked_[i]);
        });
        for (size_t i = 0; i < now.size(); ++i) fill_slot(*tiles_[now[i]], unpacked_[i]);
    }
}

// False: there is none left, and no more memory for one.
bool TileTable::take_slot(int index) {
    if (free_slots_.empty() && !grow_slots(slot_count_ + 1)) return false;
    const int slot = free_slots_.back();
    free_slots_.pop_back();
    tiles_[index]->slot = slot;
    slot_tile_[slot] = index;
    woken_step_[slot] = core_.step_index;
    is_edited_[static_cast<size_t>(slot)] = is_restored_[static_cast<size_t>(slot)] = false;
    is_dirty_ = true;
    note_edit();
    return true;
}

// The lowest levels of a packed tile, up to where there is nothing.
void TileTable::unpack_filled(int index, TileVoxels& low) const {
    const std::span<const uint8_t> bytes = tiles_[index]->bytes();
    const int filled = filled_levels(bytes, core_.height, core_.kept_planes);
    const int written = (filled + kLevelsWritten - 1) / kLevelsWritten * kLevelsWritten;
    low.resize(std::min(written, core_.height), core_.kept_planes);
    unpack_levels(bytes, core_.height, low);
}

void TileTable::fill_slot(Tile& tile, const TileVoxels& low) {
    const int slot = tile.slot;
    int& filled = filled_levels_[static_cast<size_t>(slot)];
    const auto words = static_cast<size_t>(low.height) * kTileColumns;
    const int64_t above = int64_t{std::max(0, filled - low.height)} * kTileColumns;
    for (int p = 0; p < core_.kept_planes; ++p) {
        const int64_t offset = plane_offset(state_plane_of(p), slot);
        core_.device->write(Buffer::state, offset,
                            std::span(low.words).subspan(static_cast<size_t>(p) * words, words));
        core_.device->fill_zero(Buffer::state, offset + static_cast<int64_t>(words), above);
    }
    for (int plane : {kPlaneCoverage, kPlaneOwner, kPlaneSupport}) {
        if (filled == kNeverUsed) break;
        core_.device->fill_zero(Buffer::state, plane_offset(plane, slot), core_.params.tile_voxels);
    }
    filled = core_.height;
    tile.top = top_of(low);  // a snapshot has an upper bound
    core_.device->fill_zero(Buffer::spans, spans_offset(slot), kTileColumns * kColumnWords);
    for (int array = 0; array < kFlagArrays; ++array) {
        core_.device->fill_zero(Buffer::block_flags,
                                array * block_count() + int64_t{slot} * core_.blocks_per_tile,
                                core_.blocks_per_tile);
    }
    note_stale(slot, false);  // again: the flags above are new, and no body covers it yet
    tile.packed.reset();
}

void TileTable::put_to_sleep(std::span<const int> indices) {
    if (sleepers_.size() < indices.size()) sleepers_.resize(indices.size());
    ranges_.clear();
    for (size_t i = 0; i < indices.size(); ++i) {
        want_voxels(indices[i], kAllPlanes, sleepers_[i], ranges_);
    }
    core_.device->read(ranges_);
    for_ranges(core_.work_threads.get(), indices.size(), 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            Tile& tile = *tiles_[indices[i]];
            tile.packed = make_packed(sleepers_[i]);
            filled_levels_[static_cast<size_t>(tile.slot)] = filled_levels(sleepers_[i]);
        }
    });
    for (const int index : indices) {
        Tile& tile = *tiles_[index];
        slot_tile_[tile.slot] = -1;
        free_slots_.push_back(tile.slot);
        tile.slot = -1;
    }
    is_dirty_ = true;
    note_edit();  // a mean density leaves out what sleeps
}

void TileTable::sleep_idle() { sleep_unused_since(core_.step_index - kSleepAfterSteps); }

void TileTable::sleep_unused_since(int64_t step) {
    falling_asleep_.clear();
    for (int slot = 0; slot < slot_count_; ++slot) {
        const int index = slot_tile_[slot];
        if (index >= 0 && tiles_[index]->last_used_step < step) falling_asleep_.push_back(index);
    }
    const std::span<const int> all = falling_asleep_;
    for (size_t first = 0; first < all.size(); first += kTilesARead) {
        put_to_sleep(all.subspan(first, std::min(kTilesARead, all.size() - first)));
    }
}

}  // namespace bsoil
