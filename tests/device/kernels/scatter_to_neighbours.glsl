// Each group adds to its tile's columns and to those up to half a tile away. entries holds the
// group's tile.

void scatter_to_neighbours(int group, int lane) {
    int tile = entries[params.list_offset + group];
    for (int way = 0; way < 9; ++way) {
        int x = (lane & 7) + (way % 3 - 1) * 4;
        int y = (lane >> 3) + (way / 3 - 1) * 4;
        int neighbour = neighbours[tile * kTileNeighbours + ((y >> 3) + 1) * 3 + (x >> 3) + 1];
        if (neighbour != kAbsent) {
            int column = neighbour * kTileColumns + (y & 7) * kTileSide + (x & 7);
            ATOMIC_ADD_OWNED(outputs[column], 1000 * way + tile);
            ATOMIC_MAX_OWNED(counts[column], 9 * tile + way);
        }
    }
}

int scatter_to_neighbours_lanes(int group, int half_at) { return kAllLanes; }
