// Soil that sinks and open sides take out of the grid: the same share of all that lies in a region, with everything that
// travels with it. What is left there is what the host goes by in the next step.
// A well takes water instead, or brings some: the same share of what its region's pores let go, or have room for.
// Reads: all transported planes, sinks, tables. Writes: deltas, result.

int take_soil_lanes(int group, int half_at) { return flow_lanes(group, half_at); }

// Water units that a well may take out of a voxel, or bring to it.
int well_most(int voxel, int well) {
    int pores = pores_at(voxel);
    int water = water_at(voxel);
    return max(0, well > 0 ? pores - water : water - mul_q16(pores, mixed_word(voxel, 0, kTableResidual)));
}

void take_soil(int group, int lane) {
    int slot = flow_slot(group);
    int part = flow_part(group);
    int range = tables[part + kFlowColumns + lane];
    int high = min(range >> 16, spans[column_word(kColumnEnd, slot * kTileColumns + lane)]);
    int share = flow_word(part, kFlowShare);
    int well = flow_word(part, kFlowWell);
    int held = 0;
    for (int z = range & kLowHalf; z < high; ++z) {
        int voxel = slot * params.tile_voxels + z * kTileColumns + lane;
        if (state_at(kPlaneVolume, voxel) == 0 || block_flags[flag_index(kFlagListed, voxel >> 9)] == 0) {
            continue;
        }
        if (well != 0) {
            int most = well_most(voxel, well);
            int amount = whole_units(mul_q16(most * kOneQ4, share), voxel_chance(grid_voxel(slot, lane & 7, lane >> 3, z)));
            held += most - amount;
            if (amount == 0) continue;
            add_delta(params.water_plane, voxel, well * amount);
            add_wide(flow_sum(part, 0), amount);
            add_wide(well > 0 ? kResultWaterIn : kResultWaterOut, amount);
            mark_moved(voxel, voxel);
            continue;
        }
        ivec3 taken = ivec3(0);
        int moved = 0;
        for (int i = 0; share > 0 && i < params.transport_count; ++i) {
            int plane = kTransportFirst + i;
            int amount = mul_q16(state_at(plane, voxel), share);
            add_delta(plane, voxel, -amount);
            moved = moved | amount;
            if (plane >= kPlaneMomentumX && plane <= kPlaneMomentumZ) taken[plane - kPlaneMomentumX] = amount;
            if (is_mass(plane) && amount > 0) {
                add_wide(flow_sum(part, 2 * (plane - kPlaneMaterial)), amount);
                held -= amount;
            } else if (plane == params.water_plane && amount > 0) {
                add_wide(kResultWaterOut, amount);
            }
        }
        add_momentum_sum(kResultFallen, -taken);
        held += mass_at(voxel);
        if (moved != 0) mark_moved(voxel, voxel);
    }
    if (held > 0) add_wide(flow_sum(part, kFlowHeld), held);
}
