// How many triangles the cells over each column have, and copies of vertices.
// Reads columns, vertices and the edges of work; writes the cells of work.

#include "mesh_cells.glsl"

void count_triangles(int group, int lane) {
    int column = lane_column(group, lane);
    if (column >= kWindowColumns) return;
    MeshTile tile = tile_of(group / kWindowGroups);
    int i = tile.origin_x + column % kWindowSide;
    int j = tile.origin_y + column / kWindowSide;
    MeshWalk walk;
    walk.stores = false;
    walk.triangle_at = 0;
    walk.copy_at = 0;
    walk.copy_number = 0;
    walk.triangles = 0;
    walk.copies = 0;
    if (has_room(tile) && is_own_cell(tile, i, j)) walk_cells(tile, walk, i, j);
    work[tile.cells_at + column * kCellWords + kCellTriangles] = walk.triangles;
    work[tile.cells_at + column * kCellWords + kCellCopies] = walk.copies;
}

int count_triangles_lanes(int group, int half_at) { return kAllLanes; }
