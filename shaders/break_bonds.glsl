// Soil above a failing plane falls apart: it loses its bond, and with that the cohesion of soil that was never moved. What cohesion
// loose soil keeps it does not have until find_failures looks again: soil_state_at() tells so by the cut.
// Reads: cuts, bond. Writes: bond, cuts, intact heights, stamps, block flags.
int break_bonds_lanes(int group, int half_at) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    if (spans[tile_word(kTileCut, slot)] != params.step_stamp) return 0;
    int lanes = 0;
    for (int i = 0; i < 32; ++i) {
        int column = slot * kTileColumns + half_at * 32 + i;
        int words = spans[column_word(kColumnCut, column)];
        if (params.keeps_cohesion != 0) words = words | spans[column_word(kColumnFailing, column)];
        lanes = lanes | (words != 0 ? 1 << i : 0);
    }
    return lanes;
}

void break_bonds(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int cut_at = column_word(kColumnCut, slot * kTileColumns + lane);
    int cut_word = spans[cut_at];
    spans[cut_at] = 0;
    if (params.keeps_cohesion != 0) {
        spans[column_word(kColumnFailing, slot * kTileColumns + lane)] = cut_word;
        if (cut_word != 0) ATOMIC_MAX(spans[tile_word(kTileFailing, slot)], params.step_stamp);
        stamp_column(slot, lane);
    }
    if (cut_word == 0) return;
    int cut = kCutNone - cut_word;
    int column = slot * params.tile_voxels + lane;
    int end = min(params.height, spans[column_word(kColumnEnd, slot * kTileColumns + lane)]);
    int first = cut >> 16;
    bool breaks = false;
    for (int z = first; z < end; ++z) {
        int voxel = column + z * kTileColumns;
        int kept = z == first ? max(0, (cut & kLowHalf) - state_at(kPlaneTerrain, voxel)) : 0;
        if (state_at(kPlaneBond, voxel) > kept) {
            set_state(kPlaneBond, voxel, kept);
            int block = slot * params.blocks_per_tile + (z >> 3);
            ATOMIC_MAX_OWNED(block_flags[flag_index(kFlagChanged, block)], params.step_stamp);
            breaks = true;
        }
    }
    if (breaks) {
        ATOMIC_MIN_OWNED(spans[column_word(kColumnIntact, slot * kTileColumns + lane)], first);
        stamp_column(slot, lane);
    }
}
