// Helpers of the kernels that mesh the soil's surface: one tile's window of the display field, as plugin/src/mesh/display_field.h
// and plane_strips.h have it, and the vertices of its edges. A lane is a column of the window.

struct MeshTile {
    int record;
    int spacing;
    int origin_x;
    int origin_y;
    int first_x;
    int first_y;
    int last_x;
    int last_y;
    int columns_at;
    int words;
    int edges_at;
    int cells_at;
};

MeshTile tile_of(int index) {
    MeshTile tile;
    tile.record = kHeaderWords + index * kTileWords;
    tile.spacing = tiles[tile.record + kTileSpacing];
    tile.origin_x = tiles[tile.record + kTileOriginX];
    tile.origin_y = tiles[tile.record + kTileOriginY];
    tile.first_x = tiles[tile.record + kTileFirstX];
    tile.first_y = tiles[tile.record + kTileFirstY];
    tile.last_x = tiles[tile.record + kTileLastX];
    tile.last_y = tiles[tile.record + kTileLastY];
    tile.columns_at = tiles[tile.record + kTileColumnsAt];
    tile.words = tiles[tile.record + kTileWordCount];
    tile.edges_at = tiles[tile.record + kTileWorkAt];
    tile.cells_at = tile.edges_at + kWindowColumns * kEdgesOfColumn * (kEdgeBits + tile.words);
    return tile;
}

int lane_column(int group, int lane) { return (group % kWindowGroups) * kGroupLanes + lane; }

int column_of(IN(MeshTile) tile, int i, int j) {
    return (j - tile.origin_y) * kWindowSide + (i - tile.origin_x);
}
// The record of a column.
int column_at(IN(MeshTile) tile, int i, int j) {
    return tile.columns_at + column_of(tile, i, j) * (kColumnWords + 2 * tile.words);
}
int edge_at(IN(MeshTile) tile, int column, int edge) {
    return tile.edges_at + (column * kEdgesOfColumn + edge) * (kEdgeBits + tile.words);
}

// --- bits of samples ---------------------------------------------------------------------------------------------

// Each bit moved up by one, the lowest from the word below; and down by one, the highest from the word above.
int moved_up(int word, int below) { return (word << 1) | ((below >> 31) & 1); }
int moved_down(int word, int above) { return ((word >> 1) & 0x7FFFFFFF) | (above << 31); }

int inside_word(IN(MeshTile) tile, int column, int w) {
    return w < tile.words ? columns[column + kColumnWords + w] : 0;
}
int inside_above(IN(MeshTile) tile, int column, int w) {
    return moved_down(inside_word(tile, column, w), inside_word(tile, column, w + 1));
}
bool is_inside(int column, int q) {
    return ((columns[column + kColumnWords + (q >> 5)] >> (q & 31)) & 1) != 0;
}

// --- PlaneStrips -------------------------------------------------------------------------------------------------

bool is_plain(IN(MeshTile) tile, int i, int j) {
    return columns[column_at(tile, i, j) + kColumnIsPlain] != 0;
}

int whole_of_side(IN(MeshTile) tile, int i, int j, int along, int w) {
    if (!is_plain(tile, i, j)) return 0;
    int low = column_at(tile, i, j);
    int high = column_at(tile, along == 0 ? i + 1 : i, along == 1 ? j + 1 : j);
    return inside_word(tile, low, w) & inside_above(tile, low, w) & inside_word(tile, high, w) &
           inside_above(tile, high, w);
}

int kept_on_side(IN(MeshTile) tile, int i, int j, int along, int w) {
    int column = column_at(tile, i, j);
    int inside = inside_word(tile, column, w);
    if (inside == 0) return 0;
    int before_i = along == 0 ? i - 1 : i;
    int before_j = along == 1 ? j - 1 : j;
    int here = whole_of_side(tile, before_i, before_j, along, w) & whole_of_side(tile, i, j, along, w);
    int below = 0;
    if (w > 0) {
        below = whole_of_side(tile, before_i, before_j, along, w - 1) &
                whole_of_side(tile, i, j, along, w - 1);
    }
    int borders = columns[column + kColumnWords + tile.words + w];
    return inside & (~(here & moved_up(here, below)) | borders);
}

// Bit 1 of the first word is the sample on the floor; sample 0, there too, is empty.
bool stands_on_floor(IN(MeshTile) tile, int i, int j) {
    return (columns[column_at(tile, i, j) + kColumnWords] & 2) != 0;
}

bool is_whole_of_floor(IN(MeshTile) tile, int i, int j) {
    return is_plain(tile, i, j) && stands_on_floor(tile, i, j) && stands_on_floor(tile, i + 1, j) &&
           stands_on_floor(tile, i, j + 1) && stands_on_floor(tile, i + 1, j + 1);
}

bool is_kept_on_floor(IN(MeshTile) tile, int i, int j) {
    // At a border between tiles.
    if ((i & (kTileSide / tile.spacing - 1)) == 0) return true;
    for (int y = j - 1; y <= j; ++y) {
        for (int x = i - 1; x <= i; ++x) {
            if (!is_whole_of_floor(tile, x, y)) return true;
        }
    }
    int own = columns[column_at(tile, i, j) + kColumnFloor];
    return columns[column_at(tile, i - 1, j) + kColumnFloor] != own ||
           columns[column_at(tile, i + 1, j) + kColumnFloor] != own;
}

// --- the display field -------------------------------------------------------------------------------------------

int size_of(int axis) { return axis == 0 ? params.size_x : axis == 1 ? params.size_y : params.size_z; }
int sample_count(IN(MeshTile) tile, int axis) {
    return (size_of(axis) + tile.spacing - 1) / tile.spacing;
}
float position_of(IN(MeshTile) tile, int axis, int i) {
    if (i < 0) return 0.0f;
    if (i >= sample_count(tile, axis)) return float(size_of(axis));
    return float(i * tile.spacing) + 0.5f;
}
float height_of(IN(MeshTile) tile, int q) { return position_of(tile, 2, q - 2); }

// The topmost run about a height; kNoRun: none.
CONST_INT(kNoRun, -1)
int run_at(int column, float z) {
    int found = kNoRun;
    float highest = 0.0f;
    int end = columns[column + kColumnRunEnd];
    for (int run = columns[column + kColumnRunAt]; run < end; run += kRunWords) {
        float bottom = int_as_float(runs[run + kRunBottom]);
        float top = int_as_float(runs[run + kRunTop]);
        if (bottom <= z && z < top && (found == kNoRun || top > highest)) {
            found = run;
            highest = top;
        }
    }
    return found;
}

float depth_at(int column, float z, float reach) {
    PRECISE float result = max(-reach, -z);
    int end = columns[column + kColumnRunEnd];
    for (int run = columns[column + kColumnRunAt]; run < end; run += kRunWords) {
        PRECISE float below = int_as_float(runs[run + kRunTop]) - z;
        PRECISE float above = z - int_as_float(runs[run + kRunBottom]);
        result = max(result, min(below, above));
    }
    return min(result, reach);
}

float limited_depth(IN(MeshTile) tile, int i, int j, float z) {
    return depth_at(column_at(tile, i, j), z, kNormalReach * float(tile.spacing));
}

// Field gradients along x (axis 0) or y (1).
float slope_of(IN(MeshTile) tile, int axis, int i, int j, float z) {
    int along = axis == 0 ? i : j;
    int low = max(along - 1, -1);
    int high = min(along + 1, sample_count(tile, axis));
    PRECISE float length = position_of(tile, axis, high) - position_of(tile, axis, low);
    float there = axis == 0 ? limited_depth(tile, high, j, z) : limited_depth(tile, i, high, z);
    float here = axis == 0 ? limited_depth(tile, low, j, z) : limited_depth(tile, i, low, z);
    PRECISE float rise = there - here;
    return length > 0.0f ? divide_exact(rise, length) : 0.0f;
}

float step_of(IN(MeshTile) tile, int axis, int i, int j, float z) {
    int along = axis == 0 ? i : j;
    PRECISE float length = position_of(tile, axis, along + 1) - position_of(tile, axis, along);
    float there = axis == 0 ? limited_depth(tile, i + 1, j, z) : limited_depth(tile, i, j + 1, z);
    PRECISE float rise = there - limited_depth(tile, i, j, z);
    return length > 0.0f ? divide_exact(rise, length) : 0.0f;
}

float slope_up(IN(MeshTile) tile, int i, int j, float z) {
    float spacing = float(tile.spacing);
    PRECISE float above = z + 0.5f * spacing;
    PRECISE float below = z - 0.5f * spacing;
    PRECISE float rise = limited_depth(tile, i, j, above) - limited_depth(tile, i, j, below);
    return divide_exact(rise, spacing);
}

// A solid run of the column is about this height.
bool is_solid_at(int column, float z) {
    int end = columns[column + kColumnSolidEnd];
    for (int solid = columns[column + kColumnSolidAt]; solid < end; solid += kSolidWords) {
        if (int_as_float(runs[solid + kRunBottom]) <= z && z < int_as_float(runs[solid + kRunTop])) {
            return true;
        }
    }
    return false;
}

// Where the surface crosses from a sample that is inside to the one beside it that is not, 0..1.
float crossing_aside(int inner, int outer, float length, float z) {
    int run = run_at(inner, z);
    if (run != kNoRun && runs[run + kRunInSolid] != 0) {
        return is_solid_at(outer, z) ? 0.5f : kHiddenEdge;
    }
    float scale = max(1.0f, length);
    PRECISE float reach = kReach * scale;
    float here = depth_at(inner, z, reach);
    float there = depth_at(outer, z, reach);
    PRECISE float difference = here - there;
    if (difference <= 0.0f) return 0.5f;
    float linear = divide_exact(here, difference);  // thesis (11)
    PRECISE float steep = divide_exact(difference, scale) - kSlopeMax;
    float wall = clamp(divide_exact(steep, kWallMin - kSlopeMax), 0.0f, 1.0f);
    PRECISE float half_way = wall * (0.5f - linear);
    PRECISE float crossing = linear + half_way;
    return crossing;
}

// --- vertices ----------------------------------------------------------------------------------------------------

// The edge's vertex that leaves sample q along an axis: its number within the tile.
int edge_vertex(IN(MeshTile) tile, int axis, int i, int j, int q) {
    int edge = edge_at(tile, column_of(tile, i, j), axis == 2 ? 0 : axis + 1);
    int number = work[edge + kEdgeFirst];
    int word = q >> 5;
    for (int w = 0; w < word; ++w) number += bit_count(work[edge + kEdgeBits + w]);
    return number + bit_count(work[edge + kEdgeBits + word] & ~(-1 << (q & 31)));
}

// All of the tile's vertices have room; else the host tries again with more.
bool has_room(IN(MeshTile) tile) {
    return tiles[tile.record + kTileVertexAt] + tiles[tile.record + kTileVertexCount] <=
           params.vertex_capacity;
}
