// Arches: soil that falls between soil at rest leans on it, and falls no faster than from an arch over the opening. Hagen (1852)
// and Beverloo (1961) have a speed of sqrt(g D) from that. Over an opening of radius R Janda, Zuriguel and Maza (2012) measured
// v^2 = 2 g R (1 - r^2 / R^2): with the ways a and b to the two sides, v^2 = 2 g d, d being their harmonic mean.

// Voxels from one at `at` to soil at rest, over voxels full of soil that falls; 0 where there is none.
int arch_side(int slot, ivec3 at, ivec2 way) {
    ivec2 place = ivec2(at.x, at.y);
    for (int n = 1; n <= params.arch_reach; ++n) {
        if (!step_on(slot, place, way)) return 0;
        int voxel = slot * params.tile_voxels + at.z * kTileColumns + place.y * kTileSide + place.x;
        if (state_at(kPlaneVolume, voxel) < kArchLeast) return 0;
        if (state_at(kPlaneSupport, voxel) == kSupportGround) return n;
    }
    return 0;
}

// 2 d of the sides along an axis, voxels Q16; 0 where one is missing.
int arch_along(int slot, ivec3 at, ivec2 way) {
    int ahead = arch_side(slot, at, way);
    int behind = ahead == 0 ? 0 : arch_side(slot, at, -way);
    return behind == 0 ? 0 : (2 * ahead - 1) * (2 * behind - 1) * kOneQ16 / (ahead + behind - 1);
}

// Along x or y, whichever is less.
int arch_at(int slot, ivec3 at) {
    int along_x = arch_along(slot, at, ivec2(1, 0));
    int along_y = arch_along(slot, at, ivec2(0, 1));
    return along_x == 0 ? along_y : along_y == 0 ? along_x : min(along_x, along_y);
}

// Whether soil that falls in a column, between two heights (Q16), is in an arch somewhere.
bool is_arched(int column, int bottom, int top) {
    int slot = column / kTileColumns;
    int lane = column - slot * kTileColumns;
    for (int z = (top - 1) >> 16; z >= bottom >> 16; --z) {
        if (arch_at(slot, ivec3(lane & 7, lane >> 3, z)) > 0) return true;
    }
    return false;
}

// How fast soil may fall, Q16 voxels a base step.
int arch_speed(int slot, ivec3 at, int voxel) {
    if (state_at(kPlaneVolume, voxel) < kArchLeast) return kSpeedMost;
    int twice = arch_at(slot, at);
    return twice == 0 ? kSpeedMost : min(kSpeedMost, mul_q16(params.arch_speed, square_root(twice * kOneQ8) * 16));
}
