// Soil that sinks and open sides take out of the grid: the same share of all that lies in a region, with everything that
// travels with it. What is left there is what the host goes by in the next step.
// Reads: all transported planes, sinks. Writes: deltas, result.

// A group is a part of a region: its tile's slot, and the place of its words in the tables.
int take_slot(int group) { return block_list[params.list_offset + 2 * group]; }
int take_part(int group) { return block_list[params.list_offset + 2 * group + 1]; }

int take_word(int part, int word) { return tables[params.flow_offset + tables[part] * kFlowWords + word]; }
int take_result(int part, int word) { return params.flow_result + tables[part] * kFlowResultWords + word; }

// Columns in which the part has voxels.
int take_soil_lanes(int group, int half_at) {
    int first = take_part(group) + kFlowColumns + half_at * 32;
    int columns = 0;
    for (int i = 0; i < 32; ++i) columns = columns | (tables[first + i] != 0 ? 1 << i : 0);
    return columns;
}

void take_soil(int group, int lane) {
    int slot = take_slot(group);
    int part = take_part(group);
    int range = tables[part + kFlowColumns + lane];
    int high = min(range >> 16, spans[column_word(kColumnEnd, slot * kTileColumns + lane)]);
    int share = take_word(part, kFlowShare);
    int held = 0;
    for (int z = range & 65535; z < high; ++z) {
        int voxel = slot * params.tile_voxels + z * kTileColumns + lane;
        if (state_at(kPlaneVolume, voxel) == 0 || block_flags[flag_index(kFlagListed, voxel >> 9)] == 0) {
            continue;
        }
        int moved = 0;
        for (int i = 0; share > 0 && i < params.transport_count; ++i) {
            int plane = kTransportFirst + i;
            int amount = mul_q16(state_at(plane, voxel), share);
            add_delta(plane, voxel, -amount);
            moved = moved | amount;
            if (is_mass(plane) && amount > 0) {
                add_wide(take_result(part, 2 * (plane - kPlaneMaterial)), amount);
                held -= amount;
            }
        }
        held += mass_at(voxel);
        if (moved != 0) mark_moved(voxel, voxel);
    }
    if (held > 0) add_wide(take_result(part, kFlowHeld), held);
}
