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

// What goes along of an amount of a voxel's soil with `taken` of its mass: the same part, the last unit by chance. Rounded down
// each for itself, a slow sink's parts would take room and leave the mass.
int part_along(int amount, int taken, int mass, int chance) {
    if (taken == mass) return amount;
    int per_mass = fraction_q16(amount, mass);
    int rest = int(uint(per_mass) * uint(taken)) & kLowHalf;
    return min(amount, mul_q16(per_mass, taken) + (rest > chance ? 1 : 0));
}

// Takes what travels with a voxel's soil besides its mass.
void take_along(int voxel, int share, int taken, int mass, int chance) {
    ivec3 momentum = ivec3(0);
    for (int i = 0; i < params.transport_count; ++i) {
        int plane = kTransportFirst + i;
        if (is_mass(plane)) continue;
        bool is_matter = plane < kPlaneMomentumX || plane > kPlaneForceZ;
        int held = state_at(plane, voxel);
        int amount = is_matter ? part_along(held, taken, mass, chance) : mul_q16(held, share);
        add_delta(plane, voxel, -amount);
        if (plane >= kPlaneMomentumX && plane <= kPlaneMomentumZ) momentum[plane - kPlaneMomentumX] = amount;
        if (plane == params.water_plane && amount > 0) add_wide(kResultWaterOut, amount);
    }
    add_momentum_sum(kResultFallen, -momentum);
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
        int mass = mass_at(voxel);
        int taken = 0;
        for (int m = 0; m < params.material_count; ++m) {
            int amount = mul_q16(state_at(kPlaneMaterial + m, voxel), share);
            if (amount == 0) continue;
            add_delta(kPlaneMaterial + m, voxel, -amount);
            add_wide(flow_sum(part, 2 * m), amount);
            taken += amount;
        }
        held += mass - taken;
        // See moves_any(). Room without soil goes with what is taken whole.
        if (taken == 0 && (mass > 0 || share < kOneQ16 || state_at(kPlaneVolume, voxel) == 0)) continue;
        take_along(voxel, share, taken, mass, voxel_chance(grid_voxel(slot, lane & 7, lane >> 3, z)));
        mark_moved(voxel, voxel);
    }
    if (held > 0) add_wide(flow_sum(part, kFlowHeld), held);
}
