/// Which buffers have a part for each tile slot, and what moves in them when slots are added.
#pragma once

#include <utility>
#include <vector>

#include "soil/soil_core.h"

namespace bsoil {

/// Rows of a buffer, one after the other: `slot_words` a slot, then some words of padding.
struct SlotRows {
    int64_t row_count = 0, slot_words = 0, pad_words = 0;
};

/// How a buffer is laid out over tile slots.
struct SlotBuffer {
    device::BufferIndex buffer;
    std::vector<SlotRows> rows;
    /// All zero between passes: nothing of it moves. Who copies what is zero touches all of it.
    bool is_empty_between_passes = false;
    /// Most of what an awake tile takes.
    bool is_large = false;

    int64_t words(int64_t slots) const;
    /// Where the words of its first `slots` lie when there is room for `room`: offset and count.
    std::vector<std::pair<int64_t, int64_t>> parts(int64_t room, int64_t slots) const;
    /// With more slots its words have no numbers of 32 bits, and no kernel finds them.
    int slots_most() const;
    /// What moves where as `from` slots become `to`: the words of those that both have.
    std::vector<device::WordMove> moves(int64_t from, int64_t to) const;
};

/// All of them, the largest first.
std::vector<SlotBuffer> slot_buffers(const SoilCore& core);
/// With more slots a word of one of them, or the entry of a tile list (kTileWord), has no number of
/// 31 bits.
int slots_most(const SoilCore& core);

}  // namespace bsoil
