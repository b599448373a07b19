// Air: the wind with its gusts, what bars it, and what it takes of the speed of soil. docs/decisions/wind.md. Part of advect_soil.

// Behind what bars it the wind comes down at 15 deg, as behind dunes (Werner 1995).
CONST_INT(kShelterRise, 17560)  // tan 15 deg, Q16

// The column next to (x, y) of a tile, and the tile it is in; a tile asleep is woken for the next step.
bool step_upwind(INOUT(int) slot, INOUT(ivec2) at, ivec2 way, int z) {
    ivec2 next = at + way;
    int from = slot;
    if (!step_on(slot, at, way)) {
        ATOMIC_OR(tile_table[slot * kTileTableWords + kTileTableAsked], 1 << beside(next));
        return false;
    }
    if (slot != from) {  // stays awake as long as somebody looks
        int wanted = flag_index(kFlagWanted, slot * params.blocks_per_tile + (z >> 3));
        int word = kWantedBy * params.step_stamp + kWantedBySoil;
        if (ATOMIC_LOAD(block_flags[wanted]) != word) ATOMIC_MAX(block_flags[wanted], word);
    }
    return true;
}

// From which height on nothing in a tile bars the wind, see kTileTableBars; above the grid where find_support was not there.
int bars_below(int slot) {
    int word = tile_table[slot * kTileTableWords + kTileTableBars];
    return word / kTileTopStep == params.step_stamp ? word % kTileTopStep : kTileTopStep;
}

// Of the steps along one axis the last that surely lies in the same tile: after it the line is `room` columns further.
int last_step_inside(int step, int gone, int room) {
    int half_past = (abs(gone) + room) * kOneQ16 + kOneQ16 / 2;  // what rounds to the first column beyond
    return (half_past - 1) / max(1, abs(step));
}

// How many steps a line is certain to have taken when it is still in the tile where it is now.
int steps_inside(ivec2 step, ivec2 gone, ivec2 at) {
    int x = last_step_inside(step.x, gone.x, step.x < 0 ? at.x : kTileSide - 1 - at.x);
    int y = last_step_inside(step.y, gone.y, step.y < 0 ? at.y : kTileSide - 1 - at.y);
    return min(x, y);
}

// Whether a body, terrain or a voxel full of soil stands upwind on the line that rises by 15 deg.
bool is_sheltered(int slot, ivec3 from) {
    int most = max(abs(params.wind_x), abs(params.wind_y));
    if (most == 0) return false;
    ivec2 step = ivec2(signed_fraction_q16(-params.wind_x, most), signed_fraction_q16(-params.wind_y, most));
    int rise = mul_q16(kShelterRise, slope_length(abs(step.x), abs(step.y)));
    ivec2 at = ivec2(from.x, from.y);
    ivec2 gone = ivec2(0);
    for (int n = 1; n <= params.shelter; ++n) {
        int z = from.z + round_q16(n * rise);
        ivec2 offset = ivec2(round_q16(n * step.x), round_q16(n * step.y));
        if (z >= params.height || !step_upwind(slot, at, offset - gone, z)) return false;
        gone = offset;
        if (z >= bars_below(slot)) {  // nor does anything further on in this tile: the line rises
            n = max(n, steps_inside(step, gone, at));
            offset = ivec2(round_q16(n * step.x), round_q16(n * step.y));
            at = at + offset - gone;
            gone = offset;
            continue;
        }
        if (z >= spans[column_word(kColumnEnd, column_of(slot, at))]) continue;  // all is empty there
        int voxel = slot * params.tile_voxels + z * kTileColumns + at.y * kTileSide + at.x;
        if (is_solid(voxel) || is_full(voxel)) return is_in_grid(slot, at.x, at.y);
    }
    return false;
}

// Gusts: noise between -1 and 1 (Q16), linear between the corners of a lattice that drifts with the wind.
int gust_corner(int x, int y) {
    ivec3 corner = ivec3(x & (kGustPeriod - 1), y & (kGustPeriod - 1), 0);
    return int(mix_bits(place_bits(corner), 15) >> 15) - kOneQ16;
}
int between(int low, int high, int share) { return low + mul_q16(high - low, share); }
int gust_at(ivec3 place) {
    int cell = params.gust_cell * kOneQ8;
    int x = place.x * kOneQ8 + params.gust_x;
    int y = place.y * kOneQ8 + params.gust_y;
    int share = fraction_q16(x % cell, cell);
    int low = between(gust_corner(x / cell, y / cell), gust_corner(x / cell + 1, y / cell), share);
    int high = between(gust_corner(x / cell, y / cell + 1), gust_corner(x / cell + 1, y / cell + 1), share);
    return between(low, high, fraction_q16(y % cell, cell));
}

// Of the air around a voxel. In a part of a step it takes soil along by no more than a voxel, whichever way it blows: the next step
// has more parts.
ivec3 air_velocity(int slot, ivec3 at) {
    ivec3 wind = ivec3(params.wind_x, params.wind_y, params.wind_z);
    if (largest_component(wind) == 0 || is_sheltered(slot, at)) return ivec3(0);
    if (params.gust > 0) wind = share_of(wind, kOneQ16 + mul_q16(params.gust, gust_at(grid_voxel(slot, at.x, at.y, at.z))));
    int most = params.substep_count * kVoxelFull;
    int fastest = largest_component(wind);
    return fastest > most ? share_of(wind, fraction_q16(most, fastest)) : wind;
}

// Share of a speed (Q16, the nearest) that air takes in a part of the step, by the implicit midpoint rule. drag: the same of a
// speed that stays as it is; kAirOfStep at most
int share_in_air(int drag) { return (fraction_q16(4 * drag, 2 * kOneQ16 + drag) + 1) / 2; }

// A share of a speed, its last unit by chance. Rounded down, what is left over would blow all soil to one side: in short steps air
// takes a few units at once.
int share_by_chance(int speed, int share, int chance) {
    int rest = int(uint(speed) * uint(share)) & kLowHalf;
    return mul_q16(speed, share) + ((rest + chance) >> 16);
}

// What air changes a velocity by in a part of the step.
ivec3 taken_by_air(int slot, ivec3 at, ivec3 velocity, int share) {
    ivec3 slower = air_velocity(slot, at) - velocity;
    int chance = voxel_chance(grid_voxel(slot, at.x, at.y, at.z) + ivec3(kChanceApart, kChanceApart, 0));
    return ivec3(share_by_chance(slower.x, share, chance), share_by_chance(slower.y, share, chance),
                 share_by_chance(slower.z, share, chance));
}
