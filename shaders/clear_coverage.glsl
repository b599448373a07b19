// Empties the coverage field of the listed blocks before their bodies are voxelized again.
// Writes: coverage, owner, masks, stamps.
int clear_coverage_lanes(int group, int half_at) {
    return mask_half(block_list[params.list_offset + group], kMaskBody, half_at);
}

void clear_coverage(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int lowest = -1;
    int highest = -1;
    bool has_soil = false;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        if (state_at(kPlaneCoverage, voxel) != 0) {
            highest = z;
            lowest = lowest < 0 ? z : lowest;
            has_soil = has_soil || state_at(kPlaneVolume, voxel) > 0;
            set_state(kPlaneCoverage, voxel, 0);
            set_state(kPlaneOwner, voxel, 0);
        }
    }
    set_in_mask(block, kMaskBody, lane, false);
    if (highest >= 0) {
        int slot = block / params.blocks_per_tile;
        int z0 = (block - slot * params.blocks_per_tile) * 8;
        note_change(slot, lane, z0 + lowest, z0 + highest);
    }
    if (has_soil) set_in_mask(block, kMaskPressed, lane, true);
}
