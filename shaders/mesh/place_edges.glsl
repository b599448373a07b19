// Numbers the vertices of each tile, column by column, and finds them a place among those of all tiles. A lane is a tile.
// Reads and writes the edges of work; writes the tiles' places of vertices.

void place_edges(int group, int lane) {
    int index = group * kGroupLanes + lane;
    if (index >= params.tile_count) return;
    MeshTile tile = tile_of(index);
    int count = 0;
    for (int column = 0; column < kWindowColumns; ++column) {
        for (int edge = 0; edge < kEdgesOfColumn; ++edge) {
            int record = edge_at(tile, column, edge) + kEdgeFirst;
            int own = work[record];
            work[record] = count;
            count += own;
        }
    }
    tiles[tile.record + kTileVertexAt] = ATOMIC_ADD(tiles[kTotalVertices], count);
    tiles[tile.record + kTileVertexCount] = count;
}

int place_edges_lanes(int group, int half_at) { return kAllLanes; }
