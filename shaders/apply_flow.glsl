// Adds the deltas of the pass before to the state and empties them. Only voxels that got some; which of the others in their
// block overflow is known.
// Reads: deltas, masks. Writes: all transported planes, masks, stamps, sums of momentum.

bool is_in_mask(int block, int mask, int lane) {
    return ((mask_half(block, mask, lane >> 5) >> (lane & 31)) & 1) != 0;
}

// Columns of half a block in which a voxel got deltas.
int arrived_half(int block, int half_at) {
    int columns = 0;
    for (int z = 0; z < 8; ++z) columns = columns | mask_half(block, kMaskArrived + 2 * z, half_at);
    return columns;
}

// Voxels of a column that got deltas, a bit each.
int arrived_levels(int block, int lane) {
    int levels = 0;
    for (int z = 0; z < 8; ++z) levels = levels | (is_in_mask(block, kMaskArrived + 2 * z, lane) ? 1 << z : 0);
    return levels;
}

int apply_flow_lanes(int group, int half_at) {
    int block = block_list[params.list_offset + group];
    if (block_flags[flag_index(kFlagPending, block)] != params.pass_stamp) return 0;
    return arrived_half(block, half_at) | mask_half(block, kMaskExcess, half_at) |
           mask_half(block, kMaskOverflow, half_at);
}

void apply_flow(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    bool overflowed = false;
    bool pressed = false;
    int lowest = -1;
    int weakest = -1;  // the lowest that is not intact
    int highest = -1;
    for (int levels = arrived_levels(block, lane); levels != 0; levels = levels & (levels - 1)) {
        int z = lowest_bit(levels);
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        set_in_mask(block, kMaskArrived + 2 * z, lane, false);
        highest = z;
        lowest = lowest < 0 ? z : lowest;
        int arrived = 0;
        bool saturated = false;
        for (int i = 0; i < params.transport_count; ++i) {
            int at = delta_at(kTransportFirst + i, voxel);
            int change = delta_word(at);
            if (change != 0) {
                set_delta_word(at, 0);
                int sum = saturated_sum(state_at(kTransportFirst + i, voxel), change);
                saturated = saturated || abs(sum) == kMomentumMost;
                set_state(kTransportFirst + i, voxel, sum);
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
                set_by_ground(voxel, ivec3(0));
            } else if (volume <= 0) {
                set_state(kPlaneVolume, voxel, 1);
            }
            if (params.bank_strength > 0 && weakest < 0 && !is_intact(voxel)) weakest = z;
            if (volume > kVoxelMost || saturated) {
                note_condition(kStatusHeadroom, kResultHeadroomPlace, grid_voxel(slot, lane & 7, lane >> 3, z0 + z));
            }
        }
        if (is_overflowing(voxel)) {
            overflowed = true;
            continue;
        }
        pressed = pressed || (state_at(kPlaneVolume, voxel) > 0 && is_caught(voxel));
        if (arrived == 1) {
            set_state(kPlaneForceX, voxel, 0);  // thesis (35), second case
            set_state(kPlaneForceY, voxel, 0);
            set_state(kPlaneForceZ, voxel, 0);
        }
    }
    bool was_overflowing = is_in_mask(block, kMaskExcess, lane);
    if (highest >= 0) {
        note_change(slot, lane, z0 + lowest, z0 + highest);
        if (weakest >= 0) {
            ATOMIC_MIN_OWNED(spans[column_word(kColumnIntact, slot * kTileColumns + lane)], z0 + weakest);
        }
        ATOMIC_MAX_OWNED(spans[column_word(kColumnSoilTop, slot * kTileColumns + lane)], z0 + highest + 1);
        set_in_mask(block, kMaskMoving, lane, true);
        for (int z = 0; z < 8 && was_overflowing && !overflowed; ++z) {
            overflowed = is_overflowing(block * kBlockVoxels + z * kTileColumns + lane);
        }
        set_in_mask(block, kMaskExcess, lane, overflowed);
    } else {
        overflowed = was_overflowing;
    }
    if (pressed || overflowed) set_in_mask(block, kMaskPressed, lane, true);
    set_in_mask(block, kMaskOverflow, lane, overflowed);
}
