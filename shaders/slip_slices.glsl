// Slices of slip_soil: which voxel of a column beside it a span's soil could slide to, and how far down that is.

// Whether soil slides from and onto a span.
bool is_ground(int column, int kind, int bottom, int top) {
    return kind == kSpanPiled || (kind == kSpanFalling && is_arched(column, bottom, top));
}

// Whether soil that falls is full where its span starts: nothing slides in below it.
bool starts_full(int slot, int x, int y, int bottom) {
    return state_at(kPlaneVolume, voxel_at(slot, x, y, bottom >> 16)) >= kVoxelFull;
}

// What a voxel of soil that falls takes, Q16 voxels: eight neighbours in each of many passes would pile up more than falls on in
// a step, and all of it would land in one voxel. Ours: the columns at the sides of an opening hand on what its middle needs, 1.6
// voxels a step over 0.6 m in voxels of 2.5 cm. Larger: lumps land; smaller: the middle of wide openings runs empty.
CONST_INT(kCrowded, 131072)

// Whether the voxel on soil that falls is full, or the one under it crowded.
bool is_crowded(int voxel) { return is_full(voxel) || state_at(kPlaneVolume, voxel - kTileColumns) > kCrowded; }

// How much a voxel takes from each neighbour at once of a span that reaches up to `top`. Where bodies or terrain cover part of it,
// its own top jumps to the voxel's end when what is left is full: see top_in_voxel(). Only soil from higher than that fills it up.
// What lay between the two heights went in and out for good. An eighth of the room, and half of that, since what is sheared may
// take up more than it did. What is too little for a share is none.
int most_taken(int target, int top) {
    int coverage = coverage_at(target);
    int slot = target / params.tile_voxels;
    int z = (target - slot * params.tile_voxels) / kTileColumns;
    if (coverage == 0 || top > (z + 1) * kVoxelFull) return kVoxelMost;
    int volume = state_at(kPlaneVolume, target);
    int most = max(0, kVoxelFull - slack_at(target, z, volume) - coverage - volume) / 16;
    return most < kShareLeast ? 0 : most;
}

// Whether nothing slides into a voxel.
bool takes_none(int target, int top) { return is_solid(target) || most_taken(target, top) == 0; }

// The voxel of a column at height z, -1 above the grid.
int voxel_of(int column, int z) {
    int lane = column & (kTileColumns - 1);
    return z < params.height ? (column >> 6) * params.tile_voxels + z * kTileColumns + lane : -1;
}

// How high soil comes to lie that slides onto a span, into the voxel at its top. A span of no height is bare terrain or a bare
// body. Its first soil lies on top of what covers the voxel, see top_in_voxel(). Else a grain on a gentle slope of bare ground
// would see a hole as deep as that cover in every column beside it, and go from one to the next for good.
int lands_at(int target, int bottom, int top) { return top == bottom && target >= 0 ? top + coverage_at(target) : top; }

// The slice between the span [bottom, top] and the column at (x, y): its drop (32), and the voxel that gets the soil. falls: that
// lies on soil that falls.
int slice_drop(int slot, int x, int y, int bottom, int top, bool on_rigid, OUT(int) target, OUT(bool) falls) {
    target = -1;
    falls = false;
    int column = column_at(slot, x, y);
    if (column < 0) return kNoDrop;
    int single = spans[column_word(kColumnSingle, column)];
    if (single != kNotSingle && min(top, single) >= bottom) {
        if (top <= single) return kNoDrop;
        target = voxel_of(column, single >> 16);
        return takes_none(target, top) ? kNoDrop : top - single;
    }
    int record = column * kColumnWords;
    int count = single != kNotSingle ? 0 : spans[record + kColumnCount];
    int ceiling = top;
    for (int i = count - 1; i >= 0; --i) {
        int at = record + kColumnSpans + i * kSpanWords;
        int other_bottom = spans[at + kSpanBottom];
        int other_top = spans[at + kSpanTop];
        int kind = spans[at + kSpanKind];
        bool is_beside = min(top, other_top) >= max(bottom, other_bottom);  // thesis (31)
        if (!is_beside || !is_ground(column, kind, other_bottom, other_top)) {
            if (kind != kSpanFalling || starts_full(slot, x, y, other_bottom) ||
                (!is_beside && is_arched(column, other_bottom, other_top))) {
                ceiling = min(top, other_bottom);
            }
            continue;
        }
        target = voxel_of(column, other_top >> 16);
        int drop = ceiling - lands_at(target, other_bottom, other_top);  // thesis (32)
        if (drop <= 0 || takes_none(target, top)) return kNoDrop;
        falls = kind == kSpanFalling;
        return falls && is_crowded(target) ? kNoDrop : drop;
    }
    // No span beside this one. On the edge of a rigid body an edge span of no height takes the soil.
    if (on_rigid) {
        target = voxel_at(slot, x, y, bottom >> 16);
        if (!is_solid(target) && !is_full(target)) return top - bottom;
    }
    target = -1;
    return kNoDrop;
}

// The same over params.slip_stride columns along (dx, dy) where the ground falls all the way, as a drop per voxel: what
// slides crosses no hollow, ridge or wall, and leaves the edge of a rigid body by single voxels only.
int way_drop(int slot, int x, int y, int dx, int dy, int bottom, int top, bool on_rigid, OUT(int) target, OUT(bool) falls) {
    int drop = 0;
    int stride = params.slip_stride;
    bool leaves = on_rigid && stride == 1;
    int k = 0;
    do {
        ++k;
        int next = slice_drop(slot, x + k * dx, y + k * dy, bottom, top, leaves, target, falls);
        if (next <= drop) return kNoDrop;
        drop = next;
    } while (k < stride);
    return stride == 1 ? drop : drop / stride;
}
