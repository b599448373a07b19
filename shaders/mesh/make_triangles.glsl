// Stores the triangles of the cells over each column, and the copies of vertices that they need.
// Reads columns, vertices and work; writes triangles and copies.

#include "mesh_cells.glsl"

void make_triangles(int group, int lane) {
    int column = lane_column(group, lane);
    if (column >= kWindowColumns) return;
    MeshTile tile = tile_of(group / kWindowGroups);
    int i = tile.origin_x + column % kWindowSide;
    int j = tile.origin_y + column / kWindowSide;
    if (!has_room(tile) || !is_own_cell(tile, i, j)) return;
    int record = tile.cells_at + column * kCellWords;
    MeshWalk walk;
    walk.stores = true;
    walk.triangle_at = tiles[tile.record + kTileTriangleAt] + work[record + kCellTriangles];
    walk.copy_at = tiles[tile.record + kTileCopyAt] + work[record + kCellCopies];
    walk.copy_number = tiles[tile.record + kTileVertexCount] + work[record + kCellCopies];
    walk.triangles = 0;
    walk.copies = 0;
    walk_cells(tile, walk, i, j);
}

int make_triangles_lanes(int group, int half_at) { return kAllLanes; }
