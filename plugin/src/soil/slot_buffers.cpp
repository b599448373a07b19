#include "soil/slot_buffers.h"

#include <algorithm>
#include <limits>

namespace bsoil {

using namespace layout;

int64_t SlotBuffer::words(int64_t slots) const {
    int64_t sum = 0;
    for (const SlotRows& r : rows) sum += r.row_count * (r.slot_words * slots + r.pad_words);
    return sum;
}

std::vector<std::pair<int64_t, int64_t>> SlotBuffer::parts(int64_t room, int64_t slots) const {
    std::vector<std::pair<int64_t, int64_t>> out;
    int64_t offset = 0;
    for (const SlotRows& r : rows) {
        for (int64_t row = 0; row < r.row_count; ++row) {
            out.push_back({offset, r.slot_words * slots});
            offset += r.slot_words * room + r.pad_words;
        }
    }
    return out;
}

int SlotBuffer::slots_most() const {
    constexpr int64_t kNumbers = std::numeric_limits<int32_t>::max();
    return static_cast<int>((kNumbers - words(0)) / (words(1) - words(0)));
}

std::vector<device::WordMove> SlotBuffer::moves(int64_t from, int64_t to) const {
    std::vector<device::WordMove> out;
    if (is_empty_between_passes) return out;
    int64_t old_row = 0, new_row = 0;
    for (const SlotRows& r : rows) {
        for (int64_t row = 0; row < r.row_count; ++row) {
            out.push_back({old_row, new_row, r.slot_words * std::min(from, to)});
            old_row += r.slot_words * from + r.pad_words;
            new_row += r.slot_words * to + r.pad_words;
        }
    }
    return out;
}

std::vector<SlotBuffer> slot_buffers(const SoilCore& core) {
    const int64_t tile_voxels = core.params.tile_voxels, blocks = core.blocks_per_tile,
                  transported = core.params.transport_count;
    return {{Buffer::state, {{kTransportFirst + transported, tile_voxels, kPlanePad}}, false, true},
            {Buffer::delta, {{1, transported * tile_voxels, 0}}, true, true},
            {Buffer::spans,
             {{1, int64_t{kColumnWords} * kTileColumns, int64_t{kColumnWords} * kColumnPad},
              {kColumnArrays, kTileColumns, kColumnPad},
              {kTileArrays, 1, 0}}},
            {Buffer::block_flags, {{kFlagArrays, blocks, 0}, {1, kMaskWords * blocks, 0}}},
            {Buffer::tile_table, {{1, kTileTableWords, 0}}}};
}

int slots_most(const SoilCore& core) {
    int most = std::numeric_limits<int32_t>::max() / (kTileWord * kTileWord);
    for (const SlotBuffer& buffer : slot_buffers(core)) most = std::min(most, buffer.slots_most());
    return most;
}

}  // namespace bsoil
