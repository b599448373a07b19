// What each voxel's soil rests on: nothing, the ground, or a body that may move. One group per tile, a lane a column.
// Soil is supported when everything below it is full, down to the floor, terrain or a body. What is mostly solid carries
// whether or not there is soil in the rest of it: nothing can fall into it.
// Reads: coverage, owner, terrain, volume. Writes: support, top of the tile.
void find_support(int group, int lane) {
    int entry = block_list[params.list_offset + group];
    int slot = entry_slot(entry);
    int first = entry_lowest(entry) * 8;
    int end = entry_highest(entry) * 8;
    int column = slot * params.tile_voxels + lane;
    int below = kSupportGround;
    int top = 0;
    if (first > 0) {
        top = first;  // an upper bound: what lies below is not looked at
        first -= 1;  // its own support still holds, and tells what it hands on
        below = state_at(kPlaneSupport, column + first * kTileColumns);
    }
    for (int z = first; z < end; ++z) {
        int voxel = column + z * kTileColumns;
        int volume = state_at(kPlaneVolume, voxel);
        int bodies = state_at(kPlaneCoverage, voxel);
        int terrain = state_at(kPlaneTerrain, voxel);
        if (volume > 0) {
            top = z + 1;
        }
        bool solid = bodies + terrain >= kSolidCoverage;
        if (solid) {
            below = kSupportGround;
            if (bodies > terrain) {
                int body = owner_body(state_at(kPlaneOwner, voxel));
                if (body >= 0 && shapes[body * kBodyWords + kBodyMoving] != 0) {
                    below = kSupportBody + body;
                }
            }
        }
        int support = volume > 0 ? below : kSupportNone;
        if (support != state_at(kPlaneSupport, voxel)) {
            set_state(kPlaneSupport, voxel, support);
        }
        int slack = below >= kSupportBody ? kCarrySlack : kSupportSlack;
        if (!solid && volume + bodies + terrain < kVoxelFull - slack) {
            below = kSupportNone;
        }
    }
    ATOMIC_MAX(tile_table[slot * kTileTableWords + kTileTableTop], params.step_stamp * kTileTopStep + top);
}
