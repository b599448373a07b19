/// The grid's sides and floor are planes, and most of their cells whole squares: between two lines
/// of samples they join to strips.
#pragma once

#include <cstdint>

#include "mesh/display_field.h"

namespace bsoil::mesh {

/// Which cells of a side or of the floor are whole squares, and which samples keep their vertex all
/// the same: those of a cell that an outline crosses, and where the material changes. What a line
/// keeps depends on the samples about it alone, so the strips on both of its sides agree, in this
/// tile and the next. A line of a side goes up a column; one of the floor goes along x, and keeps
/// its vertices at the borders of tiles. Cells at a border between two levels of detail are not
/// joined.
class PlaneStrips {
  public:
    /// The field must outlive it, and hold the tile that is asked about.
    explicit PlaneStrips(const DisplayField& field) : field_(field) {}

    /// To be called when the field holds another tile.
    void build(const TileLevels& levels);
    /// Cell (i, j) of the field, or of the tiles around, is one that may be joined to others.
    bool is_plain(int i, int j) const { return is_plain_[field_.column_index(i, j)]; }

    /// Bit q of word w: of the side, the square from sample q to the next and from column (i, j),
    /// which lies on the side, to the next along x (along = 0) or y (1) is whole.
    uint64_t whole_of_side(int i, int j, int along, int w) const;
    /// Bit q of word w: sample q of a column on a side keeps its vertex.
    uint64_t kept_on_side(int i, int j, int along, int w) const;

    /// Of the floor, the square from column (i, j) to the next ones is whole.
    bool is_whole_of_floor(int i, int j) const;
    /// The column keeps its vertex on the floor.
    bool is_kept_on_floor(int i, int j) const;

  private:
    const DisplayField& field_;
    std::array<bool, DisplayField::kWindow * DisplayField::kWindow> is_plain_{};
};

/// Word `word` of `bits`, each bit moved down by one.
inline uint64_t shifted_down(const uint64_t* bits, int word, int word_count) {
    const uint64_t above = word + 1 < word_count ? bits[word + 1] : 0;
    return bits[word] >> 1 | above << 63;
}

}  // namespace bsoil::mesh
