/// A mesh cut into pieces small enough to say how thick the solid is behind each.
#pragma once

#include <vector>

#include "bsoil/result.h"
#include "soil/lattice_data.h"
#include "soil/mesh_topology.h"

namespace bsoil {

/// The pieces of the faces that come near to the region. Faces that lie inside of other closed
/// parts are no surface and left out. half_growth_m: half of the least thickness of a wall, less
/// the margin.
Result<std::vector<MeshPiece>> mesh_pieces(const MeshTopology& mesh, const LatticeDef& def,
                                           double half_growth_m);

/// Distances of a point to a piece.
struct PieceDistance {
    double to_triangle_m = 0;
    /// Signed, to the piece moved out by its growth; for a point inside of the solid only where the
    /// piece is the near face of a wall, else infinite.
    double to_grown_m = 0;
};
PieceDistance piece_distance(const MeshPiece& piece, Vec3 point, bool is_inside,
                             double half_growth_m);

}  // namespace bsoil
