#include "soil/step_reader.h"

#include <algorithm>

namespace bsoil {

using namespace layout;

void StepReader::ask() {
    const auto slots = static_cast<size_t>(tiles_.slot_count());
    const auto blocks = static_cast<size_t>(tiles_.block_count());
    static_assert(kFlagWanted == kFlagChanged + 1);
    header_.resize(kResultHeader + bodies_.ids().size() * kLoadWords);
    flag_words_.resize(2 * blocks);
    table_words_.resize(slots * kTileTableWords);
    ranges_.clear();
    ranges_.push_back({Buffer::result, 0, header_});
    ranges_.push_back({Buffer::block_flags, kFlagChanged * tiles_.block_count(), flag_words_});
    ranges_.push_back({Buffer::tile_table, 0, table_words_});
    contacts_.want(lists_.contacts().group_count > 0, ranges_);
    flows_.want(ranges_);
    core_.device->start_read(ranges_);
}

void StepReader::read() {
    core_.device->finish_read();
    note_kernel_conditions();
    core_.speed_q16 = header_[kResultSpeed];
    core_.slope_q16 = header_[kResultSlope];
    core_.slide_q16 = header_[kResultSlide];
    contacts_.read(header_);
}

// The kernels keep, of each condition, the place that comes last in the grid's order.
void StepReader::note_kernel_conditions() {
    const auto bits = static_cast<uint32_t>(header_[kResultStatus]);
    for (const auto& [bit, word] : {std::pair{StatusBit::speed_clamped, kResultSpeedPlace},
                                    std::pair{StatusBit::amount_headroom, kResultHeadroomPlace},
                                    std::pair{StatusBit::span_list_full, kResultSpansPlace}}) {
        if ((bits & static_cast<uint32_t>(bit)) == 0) continue;
        const int levels = ((core_.height - 1) >> core_.params.place_shift) + 1;
        const int code = header_[word] - 1;
        const int column = code / levels;
        const double half = 0.5 * (1 << core_.params.place_shift);
        core_.conditions.note(
            bit, -1,
            core_.frame.to_world({column / core_.params.place_rows + 0.5,
                                  column % core_.params.place_rows + 0.5,
                                  (code % levels << core_.params.place_shift) + half}));
    }
    if (bits & kStatusContactsFull) core_.conditions.note(StatusBit::contact_list_full);
}

// Those that a look along the wind or a plane of find_failures runs on into; see kTileTableAsked.
void StepReader::wake_neighbours(int index, int32_t asked) {
    tiles_.note_dirty();  // takes back what was asked
    for (int n = 0; n < 9; ++n) {
        const int tx = index % core_.tiles_x + n % 3 - 1, ty = index / core_.tiles_x + n / 3 - 1;
        if (tx < 0 || ty < 0 || tx >= core_.tiles_x || ty >= core_.tiles_y) continue;
        const BlockKey block = core_.block_key(core_.tile_index(tx, ty), 0);
        if ((asked >> n & 1) != 0) lists_.activate(block);
        if ((asked >> (kNeighbourCount + n) & 1) != 0) lists_.ask(block);
    }
}

bool StepReader::note_activity() {
    bool any_changed = false;
    // As many as there were when they were asked for.
    const size_t blocks = flag_words_.size() / 2;
    const auto slots = static_cast<int>(table_words_.size() / kTileTableWords);
    for (int slot = 0; slot < slots; ++slot) {
        const int index = tiles_.slot_tiles()[static_cast<size_t>(slot)];
        if (index < 0) continue;
        Tile& tile = *tiles_[static_cast<size_t>(index)];
        bool changed = false;
        int changed_top = 0;
        for (int zb = 0; zb < core_.blocks_per_tile; ++zb) {
            const size_t block = static_cast<size_t>(slot) * core_.blocks_per_tile + zb;
            if (flag_words_[block] == core_.params.step_stamp) {
                changed = true;
                changed_top = (zb + 1) * kTileSide;
                lists_.activate(core_.block_key(index, zb));
            }
            const int32_t wanted = flag_words_[blocks + block];
            if (wanted == kWantedBy * core_.params.step_stamp + kWantedBySoil) {
                lists_.activate(core_.block_key(index, zb));
            } else if (wanted == kWantedBy * core_.params.step_stamp + kWantedByBank) {
                lists_.ask(core_.block_key(index, zb));
            }
        }
        tile.revision += changed;
        any_changed = any_changed || changed;
        if (const int32_t asked =
                table_words_[static_cast<size_t>(slot) * kTileTableWords + kTileTableAsked];
            asked > 0) {
            wake_neighbours(index, asked);
        }
        const int32_t top =
            table_words_[static_cast<size_t>(slot) * kTileTableWords + kTileTableTop];
        if (top / kTileTopStep == core_.params.step_stamp) {
            // find_support looks no higher than soil was expected to reach; where soil moved it may
            // have come higher.
            tile.top = std::max(top % kTileTopStep, changed_top);
        }
    }
    lists_.grant_asked();
    return any_changed;
}

}  // namespace bsoil
