// Where a column's surface is: build_spans asks it of columns in work, the host of tiles asleep (column_surface.cpp).
// column_terrain(column, z) and column_volume(column, z) say what is in a voxel, in volume units.

CONST_INT(kNotBare, -1)

// Whether a piled span's top can be the ground's surface: bare terrain is none, the bare floor is.
bool is_surface(int bottom, int top) { return top > bottom || bottom == 0; }

// Whether terrain that begins in voxel z covers the soil below it: there is no room for a body between them.
bool is_on_top(int z, int top) { return z <= (top >> 16) + 1; }

// Surface word of a column (see kCovered) as if there were no bodies.
// full: voxels below are full; end: voxels from here on hold no soil.
int bare_surface(int column, int full, int end) {
    int surface = 0;
    int bare = kNotBare;     // top of the terrain that covers that surface
    bool climbs = false;     // going up in it
    int bottom = 0;
    int top = full * kVoxelFull;
    int kind = kSpanPiled;
    for (int z = full; z < end; ++z) {
        int terrain = min(kVoxelFull, column_terrain(column, z));
        int volume = column_volume(column, z);
        int base = z * kVoxelFull;
        bool hangs = volume >= kVoxelFull && terrain == 0;
        int least = volume + terrain >= kVoxelFull - kSupportSlack ? kVoxelFull : 0;
        bare = climbs && terrain > 0 ? base + terrain : bare;
        climbs = climbs && terrain >= kSolidCoverage;
        if (terrain >= kSolidCoverage) {
            if (kind == kSpanPiled && is_surface(bottom, top)) {
                surface = top;
                climbs = is_on_top(z, top);
                bare = climbs ? base + terrain : kNotBare;
            }
            kind = kSpanRigid;
        } else if (kind == kSpanRigid) {
            kind = kSpanPiled;
            bottom = base;
            top = base + min(kVoxelFull, max(least, volume > 0 ? volume + terrain : 0));
        } else if (kind == kSpanPiled) {
            if (top == base && volume + terrain > 0) {
                top = base + min(kVoxelFull, max(least, volume + (bottom == base ? terrain : 0)));
            } else if (hangs) {
                if (is_surface(bottom, top)) {
                    surface = top;
                    bare = kNotBare;
                }
                kind = kSpanFalling;
            }
        } else {
            kind = hangs ? kSpanFalling : 0;
        }
    }
    if (kind == kSpanPiled && is_surface(bottom, top)) return top;
    return bare == kNotBare ? surface : kTerrainTop - bare;
}
