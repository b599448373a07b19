/// The 256 cases of marching cubes (Lorensen and Cline 1987), derived instead of tabulated.
#pragma once

#include <array>
#include <cstdint>

namespace bsoil::mesh {

/// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1). Edges 0..3 run along x from corner
/// (0, e & 1, e >> 1), 4..7 along y from (e & 1, 0, e >> 1 & 1), 8..11 along z from (e & 1, e >> 1
/// & 1, 0).
struct MarchingCase {
    /// Twelve crossed edges form at most four closed contours, hence at most ten triangles.
    static constexpr int kTriangleCapacity = 10;
    uint8_t triangle_count = 0;
    std::array<uint8_t, 3 * kTriangleCapacity> edges{};  ///< three a triangle, outward
};

/// Indexed by the set of inside corners, bit c for corner c.
///
/// Each face of the cell is walked around; every stretch of inside corners gives one contour piece,
/// so on an ambiguous face the two inside corners are kept apart. The rule depends on the face
/// alone, so neighbouring cells agree and the surface has no holes.
const std::array<MarchingCase, 256>& marching_cases();

}  // namespace bsoil::mesh
