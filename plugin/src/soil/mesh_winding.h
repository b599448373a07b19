/// How often a closed mesh winds around the nodes of a lattice.
#pragma once

#include <vector>

#include "soil/lattice_data.h"
#include "soil/mesh_topology.h"

namespace bsoil {

/// Along every line of nodes, the places where the closed parts of a mesh are crossed, and which
/// way. The signed crossings beyond a node sum to its winding number. Which of two faces a line
/// through their common edge meets is decided by the edge alone, so that it meets one.
class WindingLines {
  public:
    WindingLines(const MeshTopology& mesh, const LatticeFrame& frame);
    /// Adds, for the 8 x 8 x 8 nodes of a brick from node (x, y, z) on, 1 for each axis along which
    /// the winding number is above zero. 2 or 3: inside.
    void count_inside(int x, int y, int z, std::array<int, 512>& votes) const;
    bool is_inside(int x, int y, int z) const;

  private:
    struct Crossing {
        double at = 0;  ///< [nodes]
        int sign = 1;   ///< 1 where a line upwards leaves the solid
    };
    int winding(int axis, size_t line, int node) const;
    size_t line_of(int axis, const int node[3]) const;

    int nodes_[3] = {0, 0, 0};
    std::vector<size_t> first_[3];  ///< by line: of its crossings
    std::vector<Crossing> crossings_[3];
};

}  // namespace bsoil
