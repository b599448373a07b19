/// The surface in a cell that is shared with cells of half its size.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace bsoil::mesh {

/// A cell of marching cubes whose faces towards finer cells are cut into the faces of those. On
/// each of its faces, cut or not, the contour follows from the samples of that face alone by the
/// rule of marching_cases.h. So cells agree, be they of one level or of two, and no table of
/// transition cells is needed (Lengyel's Transvoxel has one).
///
/// Samples of the cell have coordinates 0, 1, 2 along each axis: its corners 0 and 2, what the
/// finer lattice has between them 1. Sample s is x + 3 y + 9 z.
class SplitCell {
  public:
    struct Borders {
        /// Along each axis: the finer lattice has a sample in the middle.
        std::array<bool, 3> has_middle{true, true, true};
        /// A finer cell lies beyond the faces at low x, high x, low y, high y.
        std::array<bool, 4> finer_side{};
        /// And somewhere around the upright edges at corners x + 2 y. Those of a side that is
        /// finer are, too.
        std::array<bool, 4> finer_upright{};
    };
    explicit SplitCell(const Borders& borders);

    /// An edge of the cell, or of a face that it is cut into.
    struct Edge {
        uint8_t at[3];  ///< its lower end
        uint8_t axis;
        bool is_whole;  ///< two long, else one
    };

    /// Bit s: sample s matters.
    uint32_t samples() const { return samples_; }
    /// Adds the triangles that part the samples inside (bit s for sample s) from the others: three
    /// edges each, outward.
    void add_triangles(uint32_t inside, std::vector<Edge>& corners) const;

  private:
    static constexpr int kPolygonCapacity = 4 * 4 + 2;  ///< four sides cut in four, bottom and top
    struct Polygon {
        int size = 0;
        std::array<uint8_t, 8> samples{};  ///< counter-clockwise seen from outside
        void add(int sample) { samples[size++] = static_cast<uint8_t>(sample); }
    };
    Polygon& new_polygon() { return polygons_[polygon_count_++]; }

    int polygon_count_ = 0;
    std::array<Polygon, kPolygonCapacity> polygons_;
    uint32_t samples_ = 0;
};

}  // namespace bsoil::mesh
