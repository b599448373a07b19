// What each voxel's soil rests on: nothing, the ground, or a body that may move. One group per tile, a lane a column.
// Soil is supported when everything below it is full, down to the floor, terrain or a body. What is mostly solid carries
// whether or not there is soil in the rest of it: nothing can fall into it. The soil in the rest of it lies on the body,
// but for what lies under a face that looks down: the body stands on that.
// Columns that have not changed since the pass before are as they were, but those with a roof: what holds it is beside them.
// Reads: coverage, owner, terrain, volume, bond, materials, water, tables, stamps. Writes: support, hollows, masks, top of the
// tile, stamps.
int find_support_lanes(int group, int half_at) { return kAllLanes; }

void note_top(int slot, int top) {
    ATOMIC_MAX(tile_table[slot * kTileTableWords + kTileTableTop], params.step_stamp * kTileTopStep + top);
}

// From `bars` on nothing in a column bars the wind.
void note_bars(int slot, int bars) {
    if (params.shelter == 0) return;
    ATOMIC_MAX(tile_table[slot * kTileTableWords + kTileTableBars], params.step_stamp * kTileTopStep + bars);
}

// Whether a voxel that stands on the ground is ground itself.
bool is_full_ground(int voxel) {
    return state_at(kPlaneCoverage, voxel) == 0 && state_at(kPlaneTerrain, voxel) == 0 &&
           state_at(kPlaneVolume, voxel) >= kVoxelFull - kSupportSlack;
}

// Whether there is nothing in a voxel.
bool is_empty(int voxel) {
    return state_at(kPlaneVolume, voxel) == 0 && state_at(kPlaneCoverage, voxel) == 0 && state_at(kPlaneTerrain, voxel) == 0;
}

// Whether bodies cover more above a voxel than below it.
bool looks_down(int voxel, int z) {
    if (z + 1 >= params.blocks_per_tile * 8) return false;
    int lower = z > 0 ? state_at(kPlaneCoverage, voxel - kTileColumns) : 0;
    return state_at(kPlaneCoverage, voxel + kTileColumns) > lower;
}

#include "soil_roofs.glsl"

void find_support(int group, int lane) {
    int entry = block_list[params.list_offset + group];
    int slot = entry_slot(entry);
    int first = entry_lowest(entry) * 8;
    int end = entry_highest(entry) * 8;
    int column = slot * params.tile_voxels + lane;
    int soil_top = column_word(kColumnSoilTop, slot * kTileColumns + lane);
    // An upper bound: what lies below is not looked at.
    int least = first;
    int hollow_word = column_word(kColumnHollow, slot * kTileColumns + lane);
    int known_hollow = params.bank_strength > 0 ? spans[hollow_word] : 0;
    bool was_hollow = known_hollow > 0;
    if (known_hollow == 0 && spans[column_word(kColumnStamp, slot * kTileColumns + lane)] <= params.support_stamp) {
        note_top(slot, max(least, spans[soil_top]));
        note_bars(slot, spans[column_word(kColumnEnd, slot * kTileColumns + lane)]);
        return;
    }
    int below = kSupportGround;
    int top = 0;
    bool is_moving = false;
    int full_word = column_word(kColumnFull, slot * kTileColumns + lane);
    int end_word = column_word(kColumnEnd, slot * kTileColumns + lane);
    int full = spans[full_word];
    int empty_from = spans[end_word];
    // A tile that woke or moved to another slot knows neither of its columns. Once found, both stay found.
    while (full < first && is_full_ground(column + full * kTileColumns)) full += 1;
    while (empty_from > end && is_empty(column + (empty_from - 1) * kTileColumns)) empty_from -= 1;
    bool sees_all = empty_from <= end;
    if (known_hollow != 0) first = 0;
    int hollow = 0;
    end = min(end, empty_from);
    if (full >= first) {
        first = full;
    } else if (first > 0) {
        first -= 1;  // its own support still holds, and tells what it hands on
        below = state_at(kPlaneSupport, column + first * kTileColumns);
    }
    int filled = first;  // z above the highest voxel that is not empty
    int bars = first;    // z above the highest that may bar the wind
    for (int z = first; z < end; ++z) {
        int voxel = column + z * kTileColumns;
        int volume = state_at(kPlaneVolume, voxel);
        int bodies = state_at(kPlaneCoverage, voxel);
        int terrain = state_at(kPlaneTerrain, voxel);
        if (volume > 0) top = z + 1;
        if (volume > 0 || bodies > 0 || terrain > 0) filled = z + 1;
        if (z == full && below == kSupportGround && is_full_ground(voxel)) full = z + 1;
        bool solid = bodies + terrain >= kSolidCoverage;
        if (solid || volume + bodies + terrain >= kVoxelFull) bars = z + 1;
        int own = below;
        if (solid) {
            below = kSupportGround;
            if (bodies > terrain) {
                int body = owner_body(state_at(kPlaneOwner, voxel));
                if (body >= 0 && shapes[body * kBodyWords + kBodyMoving] != 0) {
                    below = kSupportBody + body;
                }
            }
            if (below < kSupportBody || !looks_down(voxel, z)) own = below;
        }
        if (params.bank_strength > 0 && own == kSupportNone && !solid && volume > 0 && is_bonded(voxel)) {
            if (hollow == 0) hollow = z + 1;
            if (is_held_roof(slot, ivec3(lane & 7, lane >> 3, z), voxel)) own = below = kSupportGround;
        }
        int support = volume > 0 ? own : kSupportNone;
        int known = state_at(kPlaneSupport, voxel);
        if (support != known) {
            set_state(kPlaneSupport, voxel, support);
            // What is beside it may have changed, and not this column; or its pile may lack more or less, see slack_at().
            if (was_hollow || (support >= kSupportBody) != (known >= kSupportBody)) {
                stamp_column(slot, lane);
                ATOMIC_MAX_OWNED(block_flags[flag_index(kFlagChanged, voxel >> 9)], params.step_stamp);
            }
        }
        is_moving = is_moving || (volume > 0 && support != kSupportGround);
        if (is_moving && ((z & 7) == 7 || z == end - 1)) {
            set_in_mask(slot * params.blocks_per_tile + (z >> 3), kMaskMoving, lane, true);
            is_moving = false;
        }
        int slack = below >= kSupportBody ? kCarrySlack : kSupportSlack;
        if (!solid && volume + bodies + terrain < kVoxelFull - slack) below = kSupportNone;
    }
    if (params.bank_strength > 0) spans[hollow_word] = hollow;
    spans[full_word] = full;
    spans[end_word] = sees_all ? filled : empty_from;
    for (int z = first; top == 0 && z > 0; --z) {
        top = state_at(kPlaneVolume, column + (z - 1) * kTileColumns) > 0 ? z : 0;
    }
    spans[soil_top] = top;
    note_top(slot, max(least, top));
    note_bars(slot, sees_all ? bars : empty_from);
}
