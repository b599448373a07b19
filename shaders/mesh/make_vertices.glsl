// The vertices of the edges that the surface crosses, as TileMesher::add_vertex_up and add_vertex_aside make them.
// Reads columns, runs and the edges of work; writes vertices.

void put_vertex(int at, float x, float y, float z, float out_x, float out_y, float out_z) {
    vertices[at + kVertexPosition] = float_as_int(x);
    vertices[at + kVertexPosition + 1] = float_as_int(y);
    vertices[at + kVertexPosition + 2] = float_as_int(z);
    vertices[at + kVertexOutward] = float_as_int(out_x);
    vertices[at + kVertexOutward + 1] = float_as_int(out_y);
    vertices[at + kVertexOutward + 2] = float_as_int(out_z);
}

void put_look(IN(MeshTile) tile, int at, int i, int j, int q, int kind) {
    vertices[at + kVertexLook] = column_of(tile, i, j) * kLookKinds + kind;
    vertices[at + kVertexSample] = q;
}

void make_vertex_up(IN(MeshTile) tile, int i, int j, int q, int at) {
    int column = column_at(tile, i, j);
    bool is_top = is_inside(column, q);
    float low = height_of(tile, q);
    float high = height_of(tile, q + 1);
    int run = run_at(column, is_top ? low : high);
    float crossing = run == kNoRun ? low : int_as_float(runs[run + (is_top ? kRunTop : kRunBottom)]);
    float z = clamp(crossing, low, high);
    float x = position_of(tile, 0, i);
    float y = position_of(tile, 1, j);
    if (q == 0) {
        put_vertex(at, x, y, z, 0.0f, 0.0f, -1.0f);
        put_look(tile, at, i, j, q, kLookFloor);
        return;
    }
    put_vertex(at, x, y, z, -slope_of(tile, 0, i, j, z), -slope_of(tile, 1, i, j, z),
               is_top ? 1.0f : -1.0f);
    put_look(tile, at, i, j, is_top ? q : q + 1, kLookBare);
}

// On a side of the grid.
void make_cut_vertex(IN(MeshTile) tile, int axis, int i, int j, int q, bool is_leaving, int at) {
    float out_aside = is_leaving ? 1.0f : -1.0f;
    put_vertex(at, position_of(tile, 0, i), position_of(tile, 1, j), height_of(tile, q),
               axis == 0 ? out_aside : 0.0f, axis == 1 ? out_aside : 0.0f, 0.0f);
}

// Between two samples, a share t of the distance from the first to the second.
void make_slope_vertex(IN(MeshTile) tile, int axis, int i, int j, int q, float t, int at) {
    int next_i = axis == 0 ? i + 1 : i;
    int next_j = axis == 1 ? j + 1 : j;
    float z = height_of(tile, q);
    float along = step_of(tile, axis, i, j, z);
    float across_here = slope_of(tile, 1 - axis, i, j, z);
    PRECISE float across =
        across_here + t * (slope_of(tile, 1 - axis, next_i, next_j, z) - across_here);
    float up_here = slope_up(tile, i, j, z);
    PRECISE float up = up_here + t * (slope_up(tile, next_i, next_j, z) - up_here);
    float begin = position_of(tile, axis, axis == 0 ? i : j);
    float end = position_of(tile, axis, axis == 0 ? next_i : next_j);
    PRECISE float mixed = begin + t * (end - begin);
    float x = axis == 0 ? mixed : position_of(tile, 0, i);
    float y = axis == 1 ? mixed : position_of(tile, 1, j);
    put_vertex(at, x, y, z, axis == 0 ? -along : -across, axis == 0 ? -across : -along, -up);
}

void make_vertex_aside(IN(MeshTile) tile, int axis, int i, int j, int q, int at) {
    int next_i = axis == 0 ? i + 1 : i;
    int next_j = axis == 1 ? j + 1 : j;
    int here = column_at(tile, i, j);
    int next = column_at(tile, next_i, next_j);
    bool is_leaving = is_inside(here, q);
    int inner_i = is_leaving ? i : next_i;
    int inner_j = is_leaving ? j : next_j;
    float begin = position_of(tile, axis, axis == 0 ? i : j);
    float end = position_of(tile, axis, axis == 0 ? next_i : next_j);
    if (begin == end) {
        make_cut_vertex(tile, axis, i, j, q, is_leaving, at);
        put_look(tile, at, inner_i, inner_j, q, kLookCut);
        return;
    }
    PRECISE float length = end - begin;
    PRECISE float t = crossing_aside(is_leaving ? here : next, is_leaving ? next : here, length,
                                     height_of(tile, q));
    if (!is_leaving) t = 1.0f - t;
    make_slope_vertex(tile, axis, i, j, q, t, at);
    put_look(tile, at, inner_i, inner_j, q, kLookBare);
}

void make_vertices(int group, int lane) {
    int column = lane_column(group, lane);
    if (column >= kWindowColumns) return;
    MeshTile tile = tile_of(group / kWindowGroups);
    if (!has_room(tile)) return;
    int i = tile.origin_x + column % kWindowSide;
    int j = tile.origin_y + column / kWindowSide;
    for (int edge = 0; edge < kEdgesOfColumn; ++edge) {
        int record = edge_at(tile, column, edge);
        int at = tiles[tile.record + kTileVertexAt] + work[record + kEdgeFirst];
        for (int w = 0; w < tile.words; ++w) {
            int rest = work[record + kEdgeBits + w];
            while (rest != 0) {
                int bit = lowest_bit(rest);
                rest = rest ^ (1 << bit);
                int q = 32 * w + bit;
                vertices[at * kVertexWords + kVertexEdge] = (q * kWindowColumns + column) * kEdgesOfColumn + edge;
                if (edge == 0) make_vertex_up(tile, i, j, q, at * kVertexWords);
                if (edge != 0) make_vertex_aside(tile, edge - 1, i, j, q, at * kVertexWords);
                at += 1;
            }
        }
    }
}

int make_vertices_lanes(int group, int half_at) { return kAllLanes; }
