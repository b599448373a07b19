// Water in the soil, once in a water step. It drains downwards under its weight (Darcy, with unit gradient) through what
// is not full: K ((S - Sr) / (1 - Sr))^3, S being the saturation and Sr the residual one (Brooks and Corey 1964). Rain enters the
// topmost soil that nothing shelters, as far as there is room, and drying takes from the topmost soil. Suction, which falls
// linearly with S, draws water to the drier of two voxels side by side.
// Reads: coverage, terrain, support, volume, materials, water, tables. Writes: deltas, result.
int move_water_lanes(int group, int half_at) { return kAllLanes; }

// Mass units out of Q8 of them: what is less than one comes by chance, so that slow water gets on too.
int whole_units(int units_q8, int chance) { return (units_q8 + (chance >> 8)) >> 8; }

// What would drain out of a voxel, Q8.
int seepage_q8(int voxel) {
    int residual = mixed_word(voxel, 0, kTableResidual);
    int over = saturation_at(voxel) - residual;
    if (over <= 0) return 0;
    int open = fraction_q16(over, kOneQ16 - residual);
    return mul_q16(mixed_word(voxel, 0, kTableSeepage), mul_q16(open, mul_q16(open, open)));
}

// Whether there is room for anything in a voxel, and it is dispatched.
bool is_open(int voxel) { return !is_solid(voxel) && block_flags[flag_index(kFlagListed, voxel >> 9)] != 0; }

// What may come from above, as rain or out of the voxel above: half of a voxel's room. The other half is for what comes from its
// sides.
int intake_at(int voxel) { return max(0, pores_at(voxel) - water_at(voxel) + 1) / 2; }

// Suction in a voxel's pores, Q16 voxels of water; dry: of dry pores.
int suction_of(int dry, int voxel) { return mul_q16(dry, kOneQ16 - saturation_at(voxel)); }

// What the four voxels beside one draw out of it, `over` at most. seeps: see seepage_q8. moves: 1 where any does.
int draw_aside(int slot, ivec3 at, int voxel, int seeps, int chance, int over, INOUT(int) moves) {
    int dry = mixed_word(voxel, 0, kTableSuction);
    int pores = pores_at(voxel);
    int own = suction_of(dry, voxel);
    int given = 0;
    for (int k = 0; k < 4; ++k) {
        int along = 1 - (k & 2);
        int to = voxel_at(slot, at.x + ((k & 1) == 0 ? along : 0), at.y + ((k & 1) == 0 ? 0 : along), at.z);
        if (to < 0 || !is_open(to) || mass_at(to) == 0) continue;
        int dry_there = mixed_word(to, 0, kTableSuction);
        int pull = suction_of(dry_there, to) - own;
        if (pull <= 0) continue;
        // A quarter of what makes both suctions equal, so that four of them overshoot nowhere.
        int most = min(mul_q16(min(pores, pores_at(to)), fraction_q16(pull, dry + dry_there)), intake_at(to)) / 4;
        int flow = mul_q16(seeps, pull);
        if (flow > 0 && most > 0) moves = 1;
        int units = min(min(whole_units(flow, chance), most), over - given);
        if (units <= 0) continue;
        add_delta(params.water_plane, to, units);
        mark_moved(to, to);
        given += units;
    }
    return given;
}

void move_water(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int x = lane & 7;
    int y = lane >> 3;
    int first = slot * params.tile_voxels + lane;
    int rain = params.rain_units;
    int drying = params.drying_units;
    int came = 0;
    int went = 0;
    int moves = 0;
    int drips = 0;
    for (int z = params.height - 1; z >= 0; --z) {
        int voxel = first + z * kTileColumns;
        int from_above = drips;
        drips = 0;
        if (is_solid(voxel)) {
            rain = 0;  // sheltered
            continue;
        }
        int mass = mass_at(voxel);
        int water = water_at(voxel);
        if (mass + water == 0 || !is_open(voxel)) continue;
        int below = voxel - kTileColumns;
        int change = 0;
        if (state_at(kPlaneSupport, voxel) != kSupportNone) {
            int enters = max(0, min(rain, intake_at(voxel) - from_above));
            int dries = min(drying, water);
            rain -= enters;
            drying -= dries;
            came += enters;
            went += dries;
            change = enters - dries;
            water -= dries;
            // What is topmost is a layer of half a voxel at least: a thin one has no room for a shower.
            if (2 * state_at(kPlaneVolume, voxel) >= kVoxelFull) rain = drying = 0;
        }
        int leaves = 0;
        bool is_floor = z == 0;
        if (mass == 0) {
            leaves = is_floor ? 0 : water;  // soil left it behind: it falls
            moves = leaves > 0 && is_open(below) ? 1 : moves;
        } else if (water > 0) {
            int seeps = seepage_q8(voxel);
            int down = is_floor ? min(seeps, params.floor_seepage) : seeps;
            int room = is_floor ? water : (is_open(below) && mass_at(below) > 0 ? intake_at(below) : 0);
            int over = max(0, water - mul_q16(pores_at(voxel), mixed_word(voxel, 0, kTableResidual)));
            int chance = voxel_chance(grid_voxel(slot, x, y, z));
            if (down > 0 && room > 0) {
                moves = 1;
                leaves = min(min(whole_units(down, chance), over), room);
            }
            if (seeps > 0) change -= draw_aside(slot, ivec3(x, y, z), voxel, seeps, chance, over - leaves, moves);
        }
        if (leaves > 0 && is_floor) {
            went += leaves;
            change -= leaves;
        } else if (leaves > 0 && is_open(below)) {
            add_delta(params.water_plane, below, leaves);
            mark_moved(below, below);
            drips = leaves;
            change -= leaves;
        }
        if (change != 0) {
            add_delta(params.water_plane, voxel, change);
            mark_moved(voxel, voxel);
        }
    }
    if (came > 0) add_wide(kResultWaterIn, came);
    if (went > 0) add_wide(kResultWaterOut, went);
    if (moves != 0) add_wide(kResultWaterMoves, moves);
}
