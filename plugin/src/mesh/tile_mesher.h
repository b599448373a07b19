/// The mesh of a tile at its level of detail.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh/display_field.h"
#include "mesh/marching_cases.h"
#include "mesh/plane_strips.h"
#include "mesh/split_cell.h"
#include "mesh/tile_levels.h"
#include "mesh/vertex_writer.h"

#pragma GCC visibility push(default)
namespace bsoil::mesh {

/// Meshes one tile after the other; holds what is reused from tile to tile.
class TileMesher {
  public:
    /// The writer must outlive it.
    TileMesher(const VertexWriter& writer, bool close_floor)
        : close_floor_(close_floor), writer_(writer) {}
    void build(const GridColumns& grid, const TileLevels& levels, int tx, int ty, Mesh& out);

    /// The edge that leaves sample (i, j, q) along an axis.
    struct Edge {
        int axis, i, j, q;
    };
    /// Adds the cells beside finer tiles to a tile's mesh that has all others. `edges`: on which
    /// its first vertices lie; `places`: of all its vertices [voxels].
    void add_border(const GridColumns& grid, const TileLevels& levels, int tx, int ty,
                    std::span<const Edge> edges, std::span<const GridVector> places, Mesh& out);

  private:
    /// The vertex of the edge that leaves sample (i, j, q) along an axis. Only crossed edges are
    /// set.
    uint32_t& edge_vertex(int axis, int i, int j, int q);
    /// The same in the lattice of the finer tiles beside this one.
    uint32_t& finer_edge_vertex(int axis, int i, int j, int q);

    uint32_t add_vertex(GridVector position, GridVector outward, const Look& look);
    uint32_t add_vertex_up(const DisplayField& field, int i, int j, int q);
    uint32_t add_vertex_aside(const DisplayField& field, int axis, int i, int j, int q);
    uint32_t copy_vertex(uint32_t vertex, GridVector outward);
    void add_vertices_up(int i, int j);
    void add_vertices_aside(int axis, int i, int j);

    void add_side_strips(int i, int j, GridVector side);
    void add_floor_strips(int j);
    void begin(const GridColumns& grid, const TileLevels& levels, int tx, int ty, Mesh& out);
    void add_split_tile(const GridColumns& grid, int tx, int ty);
    GridVector side_of(int i, int j) const;
    void add_cells(int i, int j);
    void add_case(const MarchingCase& triangles, int i, int j, int q, GridVector side);
    void add_split_cells(const TileLevels::FinerAround& around, int i, int j, GridVector side);
    uint32_t vertex_of(const SplitCell::Edge& edge, const int cell[3]);
    /// Three vertices, and the axes of the edges they lie on.
    void add_cell_triangle(uint32_t (&vertices)[3], const int (&axes)[3], GridVector side);
    void add_triangle(uint32_t a, uint32_t b, uint32_t c, bool turned);

    bool close_floor_;
    const VertexWriter& writer_;
    const TileLevels* levels_ = nullptr;
    DisplayField field_, finer_field_;
    PlaneStrips strips_{field_};
    int sample_count_ = 0, finer_sample_count_ = 0;
    std::vector<uint32_t> edge_vertices_, finer_edge_vertices_;
    std::vector<SplitCell::Edge> split_corners_;
    Mesh* out_ = nullptr;
    std::vector<GridVector> places_;  ///< of its vertices [voxels]
};

}  // namespace bsoil::mesh
#pragma GCC visibility pop
