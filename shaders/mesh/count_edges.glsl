// Which edges of the samples' lattice the surface crosses, and how many of each column's have a vertex.
// Reads columns; writes the edges of work.

int crossed_up(IN(MeshTile) tile, int i, int j, int w) {
    int column = column_at(tile, i, j);
    int crossed = inside_word(tile, column, w) ^ inside_above(tile, column, w);
    if (w != 0 || (crossed & 1) == 0) return crossed;
    return params.close_floor != 0 && is_kept_on_floor(tile, i, j) ? crossed : crossed ^ 1;
}

int crossed_aside(IN(MeshTile) tile, int axis, int i, int j, int w) {
    int next_i = axis == 0 ? i + 1 : i;
    int next_j = axis == 1 ? j + 1 : j;
    int here = inside_word(tile, column_at(tile, i, j), w);
    int crossed = here ^ inside_word(tile, column_at(tile, next_i, next_j), w);
    int first = axis == 0 ? i : j;
    if (crossed == 0 || position_of(tile, axis, first) != position_of(tile, axis, first + 1)) {
        return crossed;
    }
    // A side of the grid: one of the two columns is empty.
    return crossed & (here != 0 ? kept_on_side(tile, i, j, 1 - axis, w)
                                : kept_on_side(tile, next_i, next_j, 1 - axis, w));
}

void count_edges(int group, int lane) {
    int column = lane_column(group, lane);
    if (column >= kWindowColumns) return;
    MeshTile tile = tile_of(group / kWindowGroups);
    int i = tile.origin_x + column % kWindowSide;
    int j = tile.origin_y + column / kWindowSide;
    bool is_up = i >= tile.first_x && j >= tile.first_y && i <= tile.last_x + 1 && j <= tile.last_y + 1;
    for (int edge = 0; edge < kEdgesOfColumn; ++edge) {
        bool is_own = is_up;
        if (edge == 1) is_own = is_up && i <= tile.last_x;
        if (edge == 2) is_own = is_up && j <= tile.last_y;
        int record = edge_at(tile, column, edge);
        int count = 0;
        for (int w = 0; w < tile.words; ++w) {
            int bits = 0;
            if (is_own) {
                bits = edge == 0 ? crossed_up(tile, i, j, w) : crossed_aside(tile, edge - 1, i, j, w);
            }
            work[record + kEdgeBits + w] = bits;
            count += bit_count(bits);
        }
        work[record + kEdgeFirst] = count;
    }
}

int count_edges_lanes(int group, int half_at) { return kAllLanes; }
