// Overflow resolution after advection, thesis section 3.2.1 and Fig. 30: soil in excess moves on by a heuristic.
// Reads: coverage, volume, all transported planes. Writes: deltas.

// Into the open ones of the 26 neighbours evenly, caught soil on its own side.
void spread_evenly(int slot, ivec3 at, int voxel, int fraction) {
    bool overrun = false;
    ivec3 out_way = is_caught(voxel) ? way_out(slot, at, voxel, overrun) : ivec3(0);
    int open_count = 0;
    for (int n = 0; n < 27; ++n) {
        ivec3 step = ivec3(n % 3 - 1, (n / 3) % 3 - 1, n / 9 - 1);
        if (n != 13 && outwards(step, out_way) >= 0 &&
            !is_closed(voxel_at(slot, at.x + step.x, at.y + step.y, at.z + step.z))) {
            open_count += 1;
        }
    }
    if (open_count == 0) return;
    for (int n = 0; n < 27; ++n) {
        ivec3 step = ivec3(n % 3 - 1, (n / 3) % 3 - 1, n / 9 - 1);
        int to = voxel_at(slot, at.x + step.x, at.y + step.y, at.z + step.z);
        if (n != 13 && outwards(step, out_way) >= 0 && !is_closed(to)) {
            move_share(voxel, to, fraction / open_count);
        }
    }
}

int resolve_overflow_lanes(int group, int half_at) {
    int block = block_list[params.list_offset + group];
    return has_overflow(block) ? mask_half(block, kMaskExcess, half_at) : 0;
}

void resolve_overflow(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        int volume = state_at(kPlaneVolume, voxel);
        if (volume == 0) continue;
        int excess = min(volume, excess_at(voxel));
        if (excess <= 0) continue;
        bool pushed = state_at(kPlaneForceX, voxel) != 0 || state_at(kPlaneForceY, voxel) != 0 ||
                      state_at(kPlaneForceZ, voxel) != 0;
        if (pushed && volume <= kPushedMost) {
            continue;  // a body's push is under way: propagate_force goes on with it in the next step
        }
        ivec3 at = ivec3(lane & 7, lane >> 3, z0 + z);
        int fraction = fraction_q16(excess, volume);
        int above = voxel_at(slot, at.x, at.y, at.z + 1);
        if (params.overflow_heuristic == kOverflowEven || is_caught(voxel) || is_closed(above)) {
            spread_evenly(slot, at, voxel, fraction);
        } else if (params.overflow_heuristic == kOverflowUp) {
            move_share(voxel, above, fraction);
        } else {
            // Weights 1 2 1 / 2 4 2 / 1 2 1 of 16; what is barred goes straight up.
            int straight = fraction;
            for (int n = 0; n < 9; ++n) {
                int dx = n % 3 - 1;
                int dy = n / 3 - 1;
                if (n == 4) continue;
                int to = voxel_at(slot, at.x + dx, at.y + dy, at.z + 1);
                int share = fraction / (dx == 0 || dy == 0 ? 8 : 16);
                if (!is_closed(to)) {
                    move_share(voxel, to, share);
                    straight -= share;
                }
            }
            move_share(voxel, above, straight);
        }
    }
}
