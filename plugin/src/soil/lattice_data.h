/// What a DistanceLattice is made of, and its makers' common part.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "base/layout.h"
#include "bsoil/distance_lattice.h"
#include "soil/triangle_tree.h"

namespace bsoil {

/// Where a lattice's nodes are. Brick (bx, by, bz) has the nodes kLatticeCells * b ... + 7.
struct LatticeFrame {
    Vec3 origin;
    double spacing_m = 0;
    int bricks[3] = {0, 0, 0};
    double far_m = 0;

    int64_t brick_count() const { return static_cast<int64_t>(bricks[0]) * bricks[1] * bricks[2]; }
    Vec3 node(int x, int y, int z) const {
        return {origin.x + x * spacing_m, origin.y + y * spacing_m, origin.z + z * spacing_m};
    }
    int nodes_along(int axis) const { return bricks[axis] * layout::kLatticeCells + 1; }
};

/// A triangle of a mesh as the lattice sees it, see mesh_pieces.h.
struct MeshPiece {
    Triangle triangle;
    Vec3 normal;                             ///< unit, outward
    Vec3 edge_out[3];                        ///< unit, in the plane, out over edge k
    double growth_m[3] = {0, 0, 0};          ///< by which the surface is moved out, at each corner
    bool is_rim[3] = {false, false, false};  ///< edge k: growth ends at it, flat
    /// Edge k that is no rim: growth goes on beyond it as far as its height above the plane times
    /// this, into the gap that the fold to the next face opens; there that face's own takes over.
    double fold_slope[3] = {0, 0, 0};
    bool is_solid = true;  ///< of a closed part; else of a plate
};

struct DistanceLattice::Data {
    LatticeFrame frame;
    LatticeDef def;
    Aabb bounds;
    std::vector<int32_t> words;
    TriangleMesh mesh;
    std::vector<MeshPiece> pieces;
    TriangleTree tree;  ///< over the pieces
};

namespace lattice {

/// Nodes of one brick, x fastest.
using Brick = std::array<double, 512>;

/// The lattice over a box (of the solid, not grown) at the finest of three spacings whose bricks
/// fit into memory. `find_bricks(frame)`: which bricks the surface comes near, sorted; stops where
/// there are more than it is told. Error: how much memory it would take.
using FindBricks = std::function<std::vector<int64_t>(const LatticeFrame&, int64_t most)>;
Result<LatticeFrame> choose_frame(const Aabb& box, const LatticeDef& def,
                                  const FindBricks& find_bricks, std::vector<int64_t>& bricks);

/// Packs distances into words. `is_inside(brick)`: of a brick that is not in the list.
std::vector<int32_t> pack(const LatticeFrame& frame, const std::vector<int64_t>& bricks,
                          const std::vector<Brick>& distances,
                          const std::function<bool(int64_t)>& is_inside);

/// LatticeDef::region and margins within their ranges.
Status validate(const LatticeDef& def);

}  // namespace lattice
}  // namespace bsoil
