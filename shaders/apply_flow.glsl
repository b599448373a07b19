// Adds the deltas of the pass before to the state and empties them. Only blocks that got some.
// Reads: deltas. Writes: all transported planes, and whether the block overflows.
void apply_flow(int group, int lane) {
    int block = block_list[params.list_offset + group];
    if (block_flags[flag_index(kFlagPending, block)] != params.pass_stamp) {
        return;
    }
    bool overflowed = false;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        int arrived = 0;
        for (int i = 0; i < params.transport_count; ++i) {
            int at = i * params.plane_stride + voxel;
            int change = delta[at];
            if (change != 0) {
                delta[at] = 0;
                set_state(kTransportFirst + i, voxel, state_at(kTransportFirst + i, voxel) + change);
                arrived = 1;
            }
        }
        if (arrived == 1) {
            // Rounding can leave a few units of mass without room, or motion without mass.
            int mass = mass_at(voxel);
            int volume = state_at(kPlaneVolume, voxel);
            if (mass == 0) {
                set_state(kPlaneVolume, voxel, 0);
                set_state(kPlaneBond, voxel, 0);
                set_state(kPlaneMomentumX, voxel, 0);
                set_state(kPlaneMomentumY, voxel, 0);
                set_state(kPlaneMomentumZ, voxel, 0);
            } else if (volume <= 0) {
                set_state(kPlaneVolume, voxel, 1);
            }
            if (volume > kVoxelMost) {
                int slot = block / params.blocks_per_tile;
                note_condition(kStatusHeadroom, kResultHeadroomPlace,
                               grid_voxel(slot, lane & 7, lane >> 3,
                                          (block % params.blocks_per_tile) * 8 + z));
            }
        }
        if (state_at(kPlaneVolume, voxel) > 0 && excess_at(voxel) > 0) {
            overflowed = true;
        } else if (arrived == 1) {
            set_state(kPlaneForceX, voxel, 0);  // thesis (35), second case
            set_state(kPlaneForceY, voxel, 0);
            set_state(kPlaneForceZ, voxel, 0);
        }
    }
    ATOMIC_MAX(block_flags[flag_index(kFlagApplied, block)], params.pass_stamp);
    if (overflowed) {
        ATOMIC_MAX(block_flags[flag_index(kFlagOverflow, block)], params.pass_stamp);
    }
}
