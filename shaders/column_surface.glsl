// How a column is told from its voxels, from the floor up: which span has a voxel, how high it reaches, where the surface is.
// The one text of these rules. build_spans reads columns in work by it, with bodies; the host reads tiles without bodies
// (column_surface.cpp). column_terrain(column, z) and column_volume(column, z) say what is in a voxel, in volume units;
// falling_least() how much of it a voxel of a falling span has; is_column_roof(column, z) whether its soil is held with none under
// it.

CONST_INT(kNoSpan, 0)    // kind of air and of soil too thin to be a span
CONST_INT(kNotBare, -1)

// Whether what is in a voxel has something below it that carries it: the span below it is of `kind` and reaches up to `top`.
// base: the voxel's floor, Q16.
bool is_carried(int kind, int top, int base) { return kind == kSpanRigid || (kind == kSpanPiled && top == base); }

// Whether a roof begins in a voxel: a piled span that starts on nothing, see soil_roofs.glsl.
bool begins_roof(int column, int z, int kind, int top, int volume, int coverage) {
    return volume > 0 && coverage < kSolidCoverage && !is_carried(kind, top, z * kVoxelFull) && is_column_roof(column, z);
}

// Kind of the span that a voxel belongs to, above one of `kind` that reaches up to `top`.
int kind_above(int kind, int top, int base, int volume, int coverage) {
    if (coverage >= kSolidCoverage) return kSpanRigid;  // thesis Table 1
    if (kind == kSpanRigid) return kSpanPiled;          // Table 2: a piled span starts directly on a rigid one
    if (volume + coverage > 0 && is_carried(kind, top, base)) return kSpanPiled;
    if (volume >= falling_least() && coverage == 0) return kSpanFalling;  // Table 3
    return kind == kSpanPiled ? kSpanPiled : kNoSpan;
}

// How high a span reaches in a voxel that is its topmost so far. kind_below, bottom and top: of the span that the voxel below
// belongs to. slack: what may be missing in a voxel that carries soil.
int top_in_voxel(int kind, int kind_below, int bottom, int top, int base, int volume, int coverage, int slack) {
    if (kind != kSpanPiled) return base + kVoxelFull;
    bool is_first = kind_below != kSpanPiled;
    if (!is_first && (top != base || volume + coverage == 0)) return top;  // what lies above a gap is not of it
    if (volume + coverage >= kVoxelFull - slack) return base + kVoxelFull;
    // Table 2: coverage counts as height where it carries the soil, not where a body hangs into it.
    bool stands = is_first ? volume > 0 : bottom == base;
    return base + min(kVoxelFull, volume + (stands ? coverage : 0));
}

// Whether a piled span's top can be the ground's surface: bare terrain is none, the bare floor is.
bool is_surface(int bottom, int top) { return top > bottom || bottom == 0; }

// The surface is a piled span's top that ends below voxel z. Terrain that begins there covers it where there is no room for a body
// between them. bare: how high that terrain reaches, kNotBare where there is none. climbs: whether it may go on above.
void note_surface(int z, int terrain, int top, OUT(int) surface, OUT(int) bare, OUT(bool) climbs) {
    surface = top;
    climbs = terrain >= kSolidCoverage && z <= (top >> 16) + 1;
    bare = climbs ? z * kVoxelFull + min(kVoxelFull, terrain) : kNotBare;
}

// The terrain that covers the surface, one voxel further up.
void climb_terrain(int z, int terrain, INOUT(int) bare, INOUT(bool) climbs) {
    if (climbs && terrain > 0) bare = z * kVoxelFull + min(kVoxelFull, terrain);
    climbs = climbs && terrain >= kSolidCoverage;
}

// As kColumnSurface has it where no body stands.
int surface_word(int surface, int bare) { return bare == kNotBare ? surface : kTerrainTop - bare; }

// Surface word of a column as if there were no bodies. full: voxels below are full; end: voxels from here on hold no soil.
int bare_surface(int column, int full, int end) {
    int surface = 0;
    int bare = kNotBare;
    bool climbs = false;
    int kind = kSpanPiled;
    int bottom = 0;
    int top = full * kVoxelFull;
    for (int z = full; z < end; ++z) {
        int terrain = min(kVoxelFull, column_terrain(column, z));
        int volume = column_volume(column, z);
        int base = z * kVoxelFull;
        bool is_roof = begins_roof(column, z, kind, top, volume, terrain);
        int next = is_roof ? kSpanPiled : kind_above(kind, top, base, volume, terrain);
        climb_terrain(z, terrain, bare, climbs);
        if (kind == kSpanPiled && (next != kSpanPiled || is_roof) && is_surface(bottom, top)) {
            note_surface(z, terrain, top, surface, bare, climbs);
        }
        top = top_in_voxel(next, is_roof ? kNoSpan : kind, bottom, top, base, volume, terrain, kSupportSlack);
        bottom = next == kind && !is_roof ? bottom : base;
        kind = next;
    }
    return kind == kSpanPiled && is_surface(bottom, top) ? top : surface_word(surface, bare);
}
