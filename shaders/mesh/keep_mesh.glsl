// Puts a tile's mesh where it stays: vertices with normals and looks, copies behind them, triangles. The lanes share them out.
// Reads columns, runs, vertices, copies and triangles; writes kept_vertices and kept_indices.

// The look of soil inside a column, as VertexWriter::look_inside has it.
int look_inside(int column, int run, float z) {
    int found = run == kNoRun ? 0 : runs[run + kRunPlain];
    if (run != kNoRun && runs[run + kRunInSolid] != 0) return found;
    int end = columns[column + kColumnLayerEnd];
    for (int layer = columns[column + kColumnLayerAt]; layer < end; layer += kLayerWords) {
        if (runs[layer + kLayerBottom] > int(z)) break;
        found = runs[layer + kLayerLook];
    }
    return found;
}

// As DeviceMesher::take_vertex has it.
int look_of_vertex(IN(MeshTile) tile, int vertex) {
    int code = vertices[vertex + kVertexLook];
    int column = tile.columns_at + (code / kLookKinds) * (kColumnWords + 2 * tile.words);
    int kind = code % kLookKinds;
    if (kind == kLookFloor) return columns[column + kColumnFloor] * kLookWords;
    float z = height_of(tile, vertices[vertex + kVertexSample]);
    int run = run_at(column, z);
    if (kind != kLookBare || run == kNoRun) return look_inside(column, run, z);
    PRECISE float depth = kBareDepth * float(tile.spacing);
    PRECISE float bare = int_as_float(runs[run + kRunTop]) - depth;
    return z >= bare ? runs[run + kRunLook] : look_inside(column, run, z);
}

void keep_vertex(IN(MeshTile) tile, int vertex, int to) {
    for (int k = 0; k < 3; ++k) {
        kept_vertices[to + kKeptPosition + k] = vertices[vertex + kVertexPosition + k];
    }
    int look = look_of_vertex(tile, vertex);
    for (int k = 0; k < kLookWords; ++k) kept_vertices[to + kKeptLook + k] = runs[look + k];
}

void keep_normal(int to, float x, float y, float z) {
    PRECISE float square = x * x + y * y + z * z;
    float scale = inv_sqrt_exact(square);
    PRECISE float unit_x = x * scale;
    PRECISE float unit_y = y * scale;
    PRECISE float unit_z = scale > 0.0f ? z * scale : 1.0f;
    kept_vertices[to + kKeptNormal] = float_as_int(unit_x);
    kept_vertices[to + kKeptNormal + 1] = float_as_int(unit_y);
    kept_vertices[to + kKeptNormal + 2] = float_as_int(unit_z);
}

void keep_mesh(int group, int lane) {
    int stride = kWindowGroups * kGroupLanes;
    int first = lane_column(group, lane);
    MeshTile tile = tile_of(group / kWindowGroups);
    int vertex_at = tiles[tile.record + kTileVertexAt];
    int vertex_count = tiles[tile.record + kTileVertexCount];
    int kept_at = tiles[tile.record + kTileKeptVertexAt] * kKeptWords;
    for (int v = first; v < vertex_count; v += stride) {
        int vertex = (vertex_at + v) * kVertexWords;
        int to = kept_at + v * kKeptWords;
        keep_vertex(tile, vertex, to);
        keep_normal(to, int_as_float(vertices[vertex + kVertexOutward]),
                    int_as_float(vertices[vertex + kVertexOutward + 1]),
                    int_as_float(vertices[vertex + kVertexOutward + 2]));
    }
    int copy_count = tiles[tile.record + kTileCopyCount];
    for (int c = first; c < copy_count; c += stride) {
        int copy = (tiles[tile.record + kTileCopyAt] + c) * kCopyWords;
        int to = kept_at + (vertex_count + c) * kKeptWords;
        keep_vertex(tile, (vertex_at + copies[copy + kCopyOf]) * kVertexWords, to);
        int side = copies[copy + kCopySide];
        keep_normal(to, float(side % 3 - 1), float(side / 3 - 1), 0.0f);
    }
    int index_count = tiles[tile.record + kTileTriangleCount] * kTriangleWords;
    int index_at = tiles[tile.record + kTileTriangleAt] * kTriangleWords;
    for (int i = first; i < index_count; i += stride) {
        kept_indices[tiles[tile.record + kTileKeptIndexAt] + i] = triangles[index_at + i];
    }
}

int keep_mesh_lanes(int group, int half_at) { return kAllLanes; }
