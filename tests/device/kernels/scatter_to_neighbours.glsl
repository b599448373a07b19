// Each group adds to its tile's columns and to those up to half a tile away. block_list holds the
// group's tile.

void scatter_to_neighbours(int group, int lane) {
    int tile = block_list[params.list_offset + group];
    for (int way = 0; way < 9; ++way) {
        int x = (lane & 7) + (way % 3 - 1) * 4;
        int y = (lane >> 3) + (way / 3 - 1) * 4;
        int neighbour = tile_table[tile * kTileTableWords + ((y >> 3) + 1) * 3 + (x >> 3) + 1];
        if (neighbour != kNeighbourAbsent) {
            int column = neighbour * kTileColumns + (y & 7) * kTileSide + (x & 7);
            ATOMIC_ADD_OWNED(delta[column], 1000 * way + tile);
            ATOMIC_MAX_OWNED(state[column], 9 * tile + way);
        }
    }
}
