// The triangles of the cells over a column, in the order in which TileMesher has them: strips of the floor, strips of the grid's
// sides, then cell by cell upwards. Cells beside finer tiles are the host's. Counts them, and stores them where it is told to.
#ifndef BSOIL_MESH_CELLS
#define BSOIL_MESH_CELLS

struct MeshWalk {
    bool stores;
    int triangle_at;  // the next triangle's place
    int copy_at;      // the next copy's place
    int copy_number;  // and its number within the tile
    int triangles;    // so far
    int copies;
};

void put_triangle(INOUT(MeshWalk) walk, int a, int b, int c) {
    int at = walk.triangle_at + walk.triangles;
    walk.triangles += 1;
    if (!walk.stores || at >= params.triangle_capacity) return;
    triangles[at * kTriangleWords] = a;
    triangles[at * kTriangleWords + 1] = b;
    triangles[at * kTriangleWords + 2] = c;
}

// A copy of a vertex that belongs to a side of the grid alone.
int put_copy(INOUT(MeshWalk) walk, int vertex, int side_x, int side_y) {
    int at = walk.copy_at + walk.copies;
    int number = walk.copy_number + walk.copies;
    walk.copies += 1;
    if (walk.stores && at < params.copy_capacity) {
        copies[at * kCopyWords + kCopyOf] = vertex;
        copies[at * kCopyWords + kCopySide] = side_x + 1 + 3 * (side_y + 1);
    }
    return number;
}

void add_floor_strip(IN(MeshTile) tile, INOUT(MeshWalk) walk, int j) {
    int last_low = 0;
    int last_high = 0;
    for (int i = tile.first_x; i <= tile.last_x + 1; ++i) {
        bool is_reached = i > tile.first_x && is_whole_of_floor(tile, i - 1, j);
        bool is_whole = i <= tile.last_x && is_whole_of_floor(tile, i, j);
        if (!is_reached && !is_whole) continue;
        for (int line = 0; line < 2; ++line) {
            if (!is_kept_on_floor(tile, i, j + line)) continue;
            int vertex = edge_vertex(tile, 2, i, j + line, 0);
            if (is_reached) put_triangle(walk, last_low, last_high, vertex);
            if (line == 0) last_low = vertex;
            if (line == 1) last_high = vertex;
        }
    }
}

// The whole squares of a side between two columns, as strips up.
void add_side_strips(IN(MeshTile) tile, INOUT(MeshWalk) walk, int i, int j, int side_x, int side_y) {
    int axis = side_x != 0 ? 0 : 1;
    int along = 1 - axis;
    int column_i = i == -2 ? i + 1 : i;  // on the side
    int column_j = j == -2 ? j + 1 : j;
    int next_i = axis == 1 ? i + 1 : i;
    int next_j = axis == 0 ? j + 1 : j;
    // Seen from outside: y goes to the right at the far end of x, x at the near end of y.
    bool is_turned = axis == 0 ? side_x < 0 : side_y > 0;
    int last_low = 0;
    int last_high = 0;
    int before = 0;
    for (int w = 0; w < tile.words; ++w) {
        int whole = whole_of_side(tile, column_i, column_j, along, w);
        int reached = moved_up(whole, before);  // a square ends here
        before = whole;
        int kept_low = kept_on_side(tile, column_i, column_j, along, w);
        int kept_high = kept_on_side(tile, along == 0 ? column_i + 1 : column_i,
                                     along == 1 ? column_j + 1 : column_j, along, w);
        int rest = (whole | reached) & (kept_low | kept_high);
        while (rest != 0) {
            int bit = lowest_bit(rest);
            rest = rest ^ (1 << bit);
            bool goes_on = ((reached >> bit) & 1) != 0;
            for (int line = 0; line < 2; ++line) {
                int kept = line == 0 ? kept_low : kept_high;
                if (((kept >> bit) & 1) == 0) continue;
                int vertex = edge_vertex(tile, axis, line == 0 ? i : next_i, line == 0 ? j : next_j,
                                         32 * w + bit);
                if (goes_on && is_turned) put_triangle(walk, last_high, last_low, vertex);
                if (goes_on && !is_turned) put_triangle(walk, last_low, last_high, vertex);
                if (line == 0) last_low = vertex;
                if (line == 1) last_high = vertex;
            }
        }
    }
}

bool same_place(IN(MeshTile) tile, int a, int b) {
    int first = tiles[tile.record + kTileVertexAt];
    int at_a = (first + a) * kVertexWords + kVertexPosition;
    int at_b = (first + b) * kVertexWords + kVertexPosition;
    // As floats: 0 and -0 are one place.
    return int_as_float(vertices[at_a]) == int_as_float(vertices[at_b]) &&
           int_as_float(vertices[at_a + 1]) == int_as_float(vertices[at_b + 1]) &&
           int_as_float(vertices[at_a + 2]) == int_as_float(vertices[at_b + 2]);
}

// The number of corner k's edge in a case, 0..11.
int case_edge(int corners, int k) {
    int word = cases[corners * kCaseWords + 1 + k / kCaseEdgesPerWord];
    return (word >> (kCaseEdgeBits * (k % kCaseEdgesPerWord))) & kCaseEdgeMask;
}

int case_vertex(IN(MeshTile) tile, int edge, int i, int j, int q) {
    int a = edge & 1;
    int b = (edge >> 1) & 1;
    if (edge < 4) return edge_vertex(tile, 0, i, j + a, q + b);
    if (edge < 8) return edge_vertex(tile, 1, i + a, j, q + b);
    return edge_vertex(tile, 2, i + a, j + b, q);
}

void add_case(IN(MeshTile) tile, INOUT(MeshWalk) walk, int corners, int i, int j, int q, int side_x,
              int side_y) {
    int count = cases[corners * kCaseWords];
    for (int t = 0; t < count; ++t) {
        int edge_a = case_edge(corners, 3 * t);
        int edge_b = case_edge(corners, 3 * t + 1);
        int edge_c = case_edge(corners, 3 * t + 2);
        int a = case_vertex(tile, edge_a, i, j, q);
        int b = case_vertex(tile, edge_b, i, j, q);
        int c = case_vertex(tile, edge_c, i, j, q);
        if (side_x != 0 || side_y != 0) {
            // Cells of no thickness: what is in the plane of the cut alone, with a sharp rim.
            if (same_place(tile, a, b) || same_place(tile, b, c) || same_place(tile, c, a)) continue;
            int axis = side_x != 0 ? 0 : 1;
            if ((edge_a >> 2) != axis) a = put_copy(walk, a, side_x, side_y);
            if ((edge_b >> 2) != axis) b = put_copy(walk, b, side_x, side_y);
            if ((edge_c >> 2) != axis) c = put_copy(walk, c, side_x, side_y);
        }
        put_triangle(walk, a, b, c);
    }
}

// Bits of the cells that are not empty, not full, and no part of a strip.
int crossed_cells(IN(MeshTile) tile, int i, int j, int w, int side_x, int side_y) {
    int any = 0;
    int all = -1;
    for (int c = 0; c < 4; ++c) {
        int column = column_at(tile, i + (c & 1), j + (c >> 1));
        int here = inside_word(tile, column, w);
        int above = inside_above(tile, column, w);
        any = any | here | above;
        all = all & here & above;
    }
    int whole = 0;
    if ((side_x == 0) != (side_y == 0)) {
        whole = whole_of_side(tile, i == -2 ? i + 1 : i, j == -2 ? j + 1 : j, side_x != 0 ? 1 : 0, w);
    }
    if (w == 0 && (is_whole_of_floor(tile, i, j) || params.close_floor == 0)) whole = whole | 1;
    return any & ~all & ~whole;
}

void add_cells(IN(MeshTile) tile, INOUT(MeshWalk) walk, int i, int j, int side_x, int side_y) {
    for (int w = 0; w < tile.words; ++w) {
        int rest = crossed_cells(tile, i, j, w, side_x, side_y);
        while (rest != 0) {
            int bit = lowest_bit(rest);
            rest = rest ^ (1 << bit);
            int q = 32 * w + bit;
            int corners = 0;
            for (int c = 0; c < 4; ++c) {
                int column = column_at(tile, i + (c & 1), j + (c >> 1));
                if (is_inside(column, q)) corners = corners | (1 << c);
                if (is_inside(column, q + 1)) corners = corners | (16 << c);
            }
            add_case(tile, walk, corners, i, j, q, side_x, side_y);
        }
    }
}

int side_of(IN(MeshTile) tile, int axis, int cell) {
    if (cell == -2) return -1;
    return cell == sample_count(tile, axis) ? 1 : 0;
}

bool is_own_cell(IN(MeshTile) tile, int i, int j) {
    return i >= tile.first_x && i <= tile.last_x && j >= tile.first_y && j <= tile.last_y;
}

void walk_cells(IN(MeshTile) tile, INOUT(MeshWalk) walk, int i, int j) {
    if (i == tile.first_x && params.close_floor != 0) add_floor_strip(tile, walk, j);
    if (!is_plain(tile, i, j)) return;
    int side_x = side_of(tile, 0, i);
    int side_y = side_of(tile, 1, j);
    if ((side_x == 0) != (side_y == 0)) add_side_strips(tile, walk, i, j, side_x, side_y);
    add_cells(tile, walk, i, j, side_x, side_y);
}
#endif
