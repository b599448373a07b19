// Water in the soil, once in a water step. It drains downwards under its weight (Darcy, with unit gradient) through what
// is not full: K ((S - Sr) / (1 - Sr))^3, S being the saturation and Sr the residual one (Brooks and Corey 1964). Rain enters the
// topmost soil that nothing shelters, as far as there is room, and drying takes from the topmost soil. Suction, which falls
// linearly with S, draws water to the drier of two voxels side by side. Over groundwater it draws water up, too, and holds it
// there: flows then go by the difference of the heads, and groundwater fills and empties the pores below its table.
// Reads: coverage, terrain, support, volume, materials, water, tables. Writes: deltas, result.
int move_water_lanes(int group, int half_at) { return kAllLanes; }

// What would drain out of a voxel, Q4.
int seepage_q4(int voxel) {
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

// How far the middle of a layer lies below the groundwater's table, Q16 voxels. Groundwater fills the layers where that is above 0.
int depth_of(int z) { return params.water_table - (z << 16) - kOneQ16 / 2; }

// Suction in the pores of a voxel of layer z, Q16 voxels of water; dry: of dry pores. Groundwater presses against it; what its
// deeper layers press is of no account, as they are full.
int suction_of(int dry, int voxel, int z) {
    return mul_q16(dry, kOneQ16 - saturation_at(voxel)) - clamp(depth_of(z), 0, kOneQ16);
}

// Ways by which suction draws water out of a voxel: four to its sides, and up where there is groundwater.
int draw_ways() { return params.water_table > 0 ? 5 : 4; }

// Of what makes the heads of two voxels equal so much that all ways together overshoot nowhere. head: their difference.
int part_to_equal(int voxel, int to, int head, int dry) {
    return mul_q16(min(pores_at(voxel), pores_at(to)), fraction_q16(head, dry)) / draw_ways();
}

// What the voxels beside one, and the one above it, draw out of it, `over` at most. seeps: see seepage_q4. moves: 1 where any
// does.
int draw_water(int slot, ivec3 at, int voxel, int seeps, int chance, int over, INOUT(int) moves) {
    int dry = mixed_word(voxel, 0, kTableSuction);
    int own = suction_of(dry, voxel, at.z);
    int given = 0;
    for (int k = 0; k < draw_ways(); ++k) {
        int up = k / 4;
        int along = up != 0 ? 0 : 1 - (k & 2);
        int to = voxel_at(slot, at.x + ((k & 1) == 0 ? along : 0), at.y + ((k & 1) == 0 ? 0 : along), at.z + up);
        if (to < 0 || !is_open(to) || mass_at(to) == 0) continue;
        int dry_there = mixed_word(to, 0, kTableSuction);
        int pull = suction_of(dry_there, to, at.z + up) - own - up * kOneQ16;
        if (pull <= 0) continue;
        int most = min(part_to_equal(voxel, to, pull, dry + dry_there), intake_at(to) / draw_ways());
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

// What drains out of a voxel into the one below it over groundwater, where suction holds some of it: `down` is without, Q4.
// from_above: what the voxel gets from above, which it passes on.
void hold_water(int voxel, int z, int from_above, INOUT(int) down, INOUT(int) room) {
    int below = voxel - kTileColumns;
    int dry = mixed_word(voxel, 0, kTableSuction);
    int dry_below = mixed_word(below, 0, kTableSuction);
    int head = kOneQ16 + suction_of(dry_below, below, z - 1) - suction_of(dry, voxel, z);
    if (head >= kOneQ16) return;
    down = mul_q16(down, max(0, head));
    if (head > 0 && head < dry + dry_below) {
        room = min(room, from_above + part_to_equal(voxel, below, head, dry + dry_below));
    }
}

// What groundwater brings to a voxel below its table: up to what its pores have room for besides `taken`. What is too much it
// takes.
int flood(int voxel, int water, int taken, int chance, INOUT(int) moves) {
    int flow = mixed_word(voxel, 0, kTableSeepage);
    int room = max(0, intake_at(voxel) - taken);
    int excess = max(0, water - pores_at(voxel));
    if (flow > 0 && room + excess > 0) moves = 1;
    int units = whole_units(flow, chance);
    return min(units, room) - min(units, excess);
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
        bool is_flooded = depth_of(z) > 0;
        if (state_at(kPlaneSupport, voxel) != kSupportNone) {
            int enters = max(0, min(rain, intake_at(voxel) - from_above));
            int dries = min(drying, water);
            rain -= enters;
            drying -= dries;
            came += enters;
            went += dries;
            change = enters - dries;
            water -= dries;
            if (is_flooded && mass > 0) {
                int floods = flood(voxel, water, from_above + enters, voxel_chance(grid_voxel(slot, x, y, z)), moves);
                came += max(0, floods);
                went += max(0, -floods);
                change += floods;
                water += min(0, floods);
            }
            // What is topmost is a layer of half a voxel at least: a thin one has no room for a shower.
            if (2 * state_at(kPlaneVolume, voxel) >= kVoxelFull) rain = drying = 0;
        }
        int leaves = 0;
        bool is_floor = z == 0;
        bool is_over_flood = !is_floor && !is_flooded && depth_of(z - 1) > 0;
        if (mass == 0) {
            leaves = is_floor ? 0 : water;  // soil left it behind: it falls
            moves = leaves > 0 && is_open(below) ? 1 : moves;
        } else if (water > 0) {
            int seeps = seepage_q4(voxel);
            int down = !is_floor ? seeps : (is_flooded ? 0 : min(seeps, params.floor_seepage));
            bool is_on_soil = !is_floor && is_open(below) && mass_at(below) > 0;
            int room = is_floor || (is_on_soil && is_over_flood) ? water : (is_on_soil ? intake_at(below) : 0);
            if (is_on_soil && params.water_table > 0) hold_water(voxel, z, from_above, down, room);
            int over = max(0, water - mul_q16(pores_at(voxel), mixed_word(voxel, 0, kTableResidual)));
            int chance = voxel_chance(grid_voxel(slot, x, y, z));
            if (down > 0 && room > 0) {
                moves = 1;
                leaves = min(min(whole_units(down, chance), over), room);
            }
            if (seeps > 0) change -= draw_water(slot, ivec3(x, y, z), voxel, seeps, chance, over - leaves, moves);
        }
        if (leaves > 0 && (is_floor || (is_over_flood && mass > 0))) {
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
