// Finds the triangles and copies of each column of a tile a place among those of all tiles. A lane is a tile.
// Reads and writes the cells of work; writes the tiles' places of triangles and copies.

void place_triangles(int group, int lane) {
    int index = group * kGroupLanes + lane;
    if (index >= params.tile_count) return;
    MeshTile tile = tile_of(index);
    int triangle_count = 0;
    int copy_count = 0;
    for (int column = 0; column < kWindowColumns; ++column) {
        int record = tile.cells_at + column * kCellWords;
        int own_triangles = work[record + kCellTriangles];
        int own_copies = work[record + kCellCopies];
        work[record + kCellTriangles] = triangle_count;
        work[record + kCellCopies] = copy_count;
        triangle_count += own_triangles;
        copy_count += own_copies;
    }
    tiles[tile.record + kTileTriangleAt] = ATOMIC_ADD(tiles[kTotalTriangles], triangle_count);
    tiles[tile.record + kTileTriangleCount] = triangle_count;
    tiles[tile.record + kTileCopyAt] = ATOMIC_ADD(tiles[kTotalCopies], copy_count);
    tiles[tile.record + kTileCopyCount] = copy_count;
}

int place_triangles_lanes(int group, int half_at) { return kAllLanes; }
