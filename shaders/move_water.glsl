// Water in a column of soil, once in a water step. It drains downwards under its weight (Darcy, with unit gradient) through what
// is not full: K ((S - Sr) / (1 - Sr))^3, S being the saturation and Sr the residual one (Brooks and Corey 1964). Rain enters the
// topmost soil that nothing shelters, as far as there is room, and drying takes from the topmost soil.
// Reads: coverage, terrain, all transported planes, tables. Writes: deltas, result.
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
    for (int z = params.height - 1; z >= 0; --z) {
        int voxel = first + z * kTileColumns;
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
            int enters = min(rain, max(0, pores_at(voxel) - water));
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
            if (is_floor) seeps = min(seeps, params.floor_seepage);
            int room = is_floor ? water : (is_open(below) && mass_at(below) > 0 ? pores_at(below) - water_at(below) : 0);
            if (seeps > 0 && room > 0) {
                moves = 1;
                int over = water - mul_q16(pores_at(voxel), mixed_word(voxel, 0, kTableResidual));
                leaves = min(min(whole_units(seeps, voxel_chance(grid_voxel(slot, x, y, z))), max(0, over)), room);
            }
        }
        if (leaves > 0 && is_floor) {
            went += leaves;
            change -= leaves;
        } else if (leaves > 0 && is_open(below)) {
            add_delta(params.water_plane, below, leaves);
            mark_moved(below, below);
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
