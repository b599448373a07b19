/// A kernel's buffer that notes which words are read and written. Only cpu_kernels.cpp includes
/// this, in its counting compilation; on one thread.
#pragma once

#include <cstdint>

#include "device/cpu_shim.h"
#include "device/kernel_set.h"

namespace bsoil::device {

/// Which cell a buffer's word belongs to: (word % plane_words) / cell_words.
struct CellMap {
    int plane_words = 0;  ///< 0: the buffer has one plane
    int cell_words = 0;   ///< 0: the buffer has no cells
};

namespace shim {

/// What stands for a word of a buffer in a kernel's text.
class CountedWord {
  public:
    CountedWord(int32_t& word, uint32_t& mark, int cell, TouchNotes& notes)
        : word_(word), mark_(mark), cell_(cell), notes_(notes) {}
    CountedWord(const CountedWord&) = default;

    operator int() const {
        note(mark_, TouchNotes::kRead, notes_.counts.read_words);
        note_cell(TouchNotes::kVisited, notes_.counts.visited_cells);
        return word_;
    }
    const CountedWord& operator=(int value) const {
        note(mark_, TouchNotes::kWritten, notes_.counts.written_words);
        note_cell(TouchNotes::kVisited, notes_.counts.visited_cells);
        if (value != word_) note_cell(TouchNotes::kChanged, notes_.counts.changed_cells);
        word_ = value;
        return *this;
    }
    const CountedWord& operator=(const CountedWord& other) const {
        return *this = static_cast<int>(other);
    }
    const CountedWord& operator|=(int value) const { return *this = *this | value; }
    const CountedWord& operator&=(int value) const { return *this = *this & value; }

  private:
    /// The first time in this dispatch counts.
    void note(uint32_t& mark, uint32_t bit, int64_t& count) const {
        if ((mark & ~TouchNotes::kBits) != notes_.dispatch) mark = notes_.dispatch;
        if ((mark & bit) != 0) return;
        mark |= bit;
        ++count;
    }
    void note_cell(uint32_t bit, int64_t& count) const {
        if (cell_ < 0) return;
        const auto cell = static_cast<size_t>(cell_);
        if (cell >= notes_.cells.size()) notes_.cells.resize(2 * cell + 1);
        note(notes_.cells[cell], bit, count);
    }

    int32_t& word_;
    uint32_t& mark_;
    int cell_;
    TouchNotes& notes_;
};

inline int atomic_load(CountedWord word) { return word; }
inline int add_owned(CountedWord word, int value) {
    const int old = word;
    word = static_cast<int>(static_cast<uint32_t>(old) + static_cast<uint32_t>(value));
    return old;
}
inline int max_owned(CountedWord word, int value) {
    const int old = word;
    if (old < value) word = value;
    return old;
}
inline int min_owned(CountedWord word, int value) {
    const int old = word;
    if (value < old) word = value;
    return old;
}
inline int atomic_add(CountedWord word, int value) { return add_owned(word, value); }
inline int atomic_max(CountedWord word, int value) { return max_owned(word, value); }
inline int atomic_or(CountedWord word, int value) {
    const int old = word;
    word = old | value;
    return old;
}
// GLM's are templates, which see no number in a word.
inline int min(int a, CountedWord b) { return glm::min(a, static_cast<int>(b)); }
inline int max(int a, CountedWord b) { return glm::max(a, static_cast<int>(b)); }

}  // namespace shim

class CountedBuffer {
  public:
    CountedBuffer(const KernelMemory& memory, int place, CellMap cells)
        : words_(memory.buffers[place]),
          marks_(memory.notes->words[place].data()),
          notes_(*memory.notes),
          cells_(cells) {}

    shim::CountedWord operator[](int at) const {
        const int in_plane = cells_.plane_words > 0 ? at % cells_.plane_words : at;
        const int cell = cells_.cell_words > 0 ? in_plane / cells_.cell_words : -1;
        return {words_[at], marks_[at], cell, notes_};
    }

  private:
    int32_t* words_;
    uint32_t* marks_;
    TouchNotes& notes_;
    CellMap cells_;
};

}  // namespace bsoil::device
