// Banks of cohesive soil that fail as a whole. From a toe, a column beside which the ground rises more steeply than friction
// holds it, planes rise through the soil in 16 directions and come out at the surface n columns on. What lies above one
// slides where its weight drives it harder than friction and cohesion along the plane hold it, thesis (1) to (3) for a wedge
// of any width; over its columns, with w the height of soil above the plane and t the plane's slope:
//     sum w (t - tan phi) > (1 + t^2) sum c / gamma
// For a level top that is Culmann's bank, and with a vertical face 4 c / gamma tan(45 deg + phi / 2). Of the planes that fail
// the flattest counts, thesis (4). The soil above it loses its bond, and until the next look all cohesion: see break_bonds.
// It looks everywhere, or again where soil has just failed: ways_near().
// Reads: surfaces, single piles, intact heights, stamps, volume, bond, materials, coverage, terrain, tables, what has failed.
// Writes: cuts, toes and their ways, wanted blocks, tiles asked for.

CONST_INT(kPlaneSteepest, 12288)  // slope 3, Q12: the first plane to fail is no steeper than 45 deg + phi / 2
CONST_INT(kPlaneStepsMost, 256)   // sums over a plane stay in 31 bits
CONST_INT(kClimbMost, 32766)      // Q12 a step, more than a plane of kPlaneSteepest has: times the longest run in 31 bits
CONST_INT(kPlanesHeld, 8)         // a power of two
CONST_INT(kIntactMost, 131072)  // 512 voxels, Q8, as high as a grid may be: times kOneQ12 it stays in 31 bits
// A step goes one column on along an axis, one along both (kDiagonal), or two along one and one along the other.
CONST_INT(kSkewed, 146543)          // its length, sqrt 5, Q16
CONST_INT(kSkewedInverse, 29309)

// Length of a step by (dx, dy) out of -2..2, Q16, and one over it.
int step_length(ivec2 way) {
    int square = way.x * way.x + way.y * way.y;
    return square == 1 ? kOneQ16 : (square == 2 ? kDiagonal : kSkewed);
}
int step_inverse(ivec2 way) {
    int square = way.x * way.x + way.y * way.y;
    return square == 1 ? kOneQ16 : (square == 2 ? kDiagonalInverse : kSkewedInverse);
}

// A Q8 and a Q12 number, or two of Q12: the product as the first.
int mul_q12(int a, int b) { return mul_q16(a * 4, b * 4); }

bool has_changed(int column) { return ATOMIC_LOAD(spans[column_word(kColumnStamp, column)]) > params.slip_stamp; }

int height_over(int slot, ivec2 at, int toe) { return (ground_height(column_of(slot, at)) - toe) >> 8; }

// One step on, or here where the way ends.
int height_beyond(int slot, ivec2 at, ivec2 way, int toe) {
    step_on(slot, at, way);
    return height_over(slot, at, toe);
}

void want_tile(int slot, int z) {
    int wanted = flag_index(kFlagWanted, slot * params.blocks_per_tile + z);
    ATOMIC_MAX(block_flags[wanted], kWantedBy * params.step_stamp + kWantedByBank);
}

// Has the tiles under a plane dispatched in the next step, and the first that is asleep woken: but for those for which it was to no
// avail.
void ask_for(int slot, ivec2 at, ivec2 way, int count, int toe) {
    int z = min(toe >> 19, params.blocks_per_tile - 1);
    want_tile(slot, z);
    for (int n = 0; n < count; ++n) {
        ivec2 next = at + way;
        if (!step_on(slot, at, way)) {
            ATOMIC_OR(tile_table[slot * kTileTableWords + kTileTableAsked], 1 << (kNeighbourCount + beside(next)));
            return;
        }
        want_tile(slot, z);
    }
}

// Height of a plane over the toe in its column n, Q8.
int plane_at(int n, int start, int climb) { return mul_q12(kOneQ8 * n - kOneQ8 / 2 + start, climb); }

// What drives the soil above a plane at most (see slides_on), Q12 voxels: with the least friction that there is, but where the
// plane may pass no soil with none.
int drive_most(int from_slot, ivec2 from, ivec2 way, int toe, int count, int climb, int start) {
    int slot = from_slot;
    ivec2 at = from;
    int slope = mul_q16(climb, step_inverse(way)) * 16;
    int drive = 0;
    for (int n = 1; n < count && step_on(slot, at, way); ++n) {
        int plane = plane_at(n, start, climb);
        int single = spans[column_word(kColumnSingle, column_of(slot, at))];
        bool is_below_top = (toe + plane * kOneQ8) >> 16 < (single - 1) >> 16;
        int above = max(0, height_over(slot, at, toe) - plane);
        drive += mul_q16(above * 16, slope - (is_below_top ? params.bank_friction : 0));
    }
    return drive;
}

// Whether the soil above a plane that rises by `climb` a step (Q12 voxels) slides, by what the plane passes in each of
// `count` columns. start: of the plane, columns before the first (Q8). Where it passes no soil with cohesion there is nothing to
// fall apart, and slip_soil sees to it.
bool slides_on(int slot, ivec2 at, ivec2 way, int toe, int count, int climb, int start) {
    int slope = mul_q16(climb, step_inverse(way));  // Q12
    int stretch = kOneQ12 + mul_q12(slope, slope);
    int balance = 0;  // Q12 voxels
    int most = drive_most(slot, at, way, toe, count, climb, start);  // less what holds it so far: the balance is no more
    bool any_cohesion = false;
    for (int n = 1; n <= count; ++n) {
        if (!step_on(slot, at, way)) return false;
        int plane = plane_at(n, start, climb);
        int height = toe + plane * kOneQ8 - 1;
        int z = min(height >> 16, params.height - 1);
        int voxel = slot * params.tile_voxels + z * kTileColumns + at.y * kTileSide + at.x;
        if (is_solid(voxel)) return false;
        // A voxel's bonded soil lies below the rest of it.
        bool bonded = (height & kLowHalf) < state_at(kPlaneTerrain, voxel) + state_at(kPlaneBond, voxel);
        int soil_state = bonded ? kSoilBonded : kSoilLoose;
        bool is_soil = state_at(kPlaneVolume, voxel) > 0;
        ivec2 dry = is_soil ? dry_strength_at(voxel, soil_state) : ivec2(0);
        int hold = is_soil ? mul_q16(wet_strength(voxel, soil_state, dry.y), stretch) : 0;
        int friction = dry.x;
        int above = 0;
        if (n == count) {
            hold = hold / 2;  // it comes out in the middle of this one
        } else {
            above = max(0, height_over(slot, at, toe) - plane);
            any_cohesion = any_cohesion || hold > 0;
        }
        if (n == 1) hold += mul_q16(hold, start * kOneQ8);
        balance += mul_q16(above * 16, slope * 16 - friction) - hold;
        most -= hold;
        if (most <= 0) return false;
    }
    return any_cohesion && balance > 0;
}

// Whether slides_on has to be asked: as one wedge of the weakest soil, its mean height above the plane, what drives and what
// holds it. That is no less and no more than slides_on finds where all is intact, but for rounding. Where the plane comes out there
// may be loose soil on top, or none: half a column of the run holds nothing. sum: of the heights before.
bool may_slide(int sum, int rise, int run, int length, int slope, int strength) {
    int way = mul_q16(run, length);
    int mean = (sum * 32 + rise * 16) / (run / 8) - rise / 2;
    int drive = mul_q16(mean * kOneQ8, rise - mul_q16(way, params.bank_friction));
    int hold = mul_q16(strength, way + mul_q12(rise, slope));
    hold = hold - hold / (run / (kOneQ8 / 2));
    return strength == 0 || drive > hold - hold / 16;
}

// Whether a column that has changed lies on the way up from a toe, to where that ends: half of all ways pass none.
// first_run: of the first column, Q8 steps. least: the climb at which it ends. passed: see find_plane.
bool passes_change(int from_slot, ivec2 from, ivec2 way, int toe, int least, int first_run, OUT(int) passed) {
    int slot = from_slot;
    ivec2 at = from;
    passed = 0;
    int run = first_run;
    for (int n = 1; n <= kPlaneStepsMost; ++n) {
        ivec2 next = at + way;
        if (!step_on(slot, at, way)) {
            passed = is_in_grid(slot, next.x, next.y) ? n : 0;
            return false;
        }
        int column = column_of(slot, at);
        if (has_changed(column)) return true;
        int rise = (ground_height(column) - toe) >> 8;
        if (rise * kOneQ12 < least * run) return false;
        run += kOneQ8;
    }
    return false;
}

// Planes about which slides_on has to be asked, the steepest first. The last kPlanesHeld of them are held.
struct Planes {
    int found;  // how many there are
    int columns[kPlanesHeld];
    int climbs[kPlanesHeld];
};

// Those that rise from a toe and come out of the ground before the column `end`. start: see slides_on. passed: see find_plane; what
// it is stays where the way does not end before.
void collect_planes(int from_slot, ivec2 from, ivec2 way, int toe, int least, int start, int end, OUT(Planes) planes,
                    INOUT(int) passed) {
    int slot = from_slot;
    ivec2 at = from;
    planes.found = 0;
    int length = step_length(way);
    int inverse = step_inverse(way);
    int flattest = kClimbMost;  // climb of the planes so far that come out of the ground
    int intact = kClimbMost;    // planes that climb by less pass no soil but what was never moved
    bool is_piled = true;       // all columns so far are one pile, full from the floor up
    bool any_changed = has_changed(column_of(slot, at));  // one of the columns so far
    int sum = 0;                // of the heights over the toe
    int run = start - kOneQ8 / 2;  // steps, Q8
    for (int n = 1; n < end; ++n) {
        ivec2 next = at + way;
        if (!step_on(slot, at, way)) {
            // Beyond the grid there is a wall. It holds what leans on it.
            passed = is_in_grid(slot, next.x, next.y) ? n : 0;
            return;
        }
        int column = column_of(slot, at);
        run += kOneQ8;
        int rise = (ground_height(column) - toe) >> 8;
        // A climb is rise * kOneQ12 / run. Few are new bounds: the others are compared, not divided.
        int lift = rise * kOneQ12;
        if (lift < least * run) return;
        any_changed = any_changed || has_changed(column);
        if (lift < (flattest + 1) * run) {
            flattest = lift / run;
            int slope = mul_q16(flattest, inverse);
            int strength = flattest <= intact ? params.bank_strength : (is_piled ? params.loose_strength : 0);
            if (n > 1 && any_changed && slope <= kPlaneSteepest && may_slide(sum, rise, run, length, slope, strength)) {
                int k = planes.found & (kPlanesHeld - 1);
                planes.columns[k] = n;
                planes.climbs[k] = flattest;
                planes.found += 1;
            }
        }
        sum += rise;
        if (intact > 0) {
            int whole = spans[column_word(kColumnIntact, column)] * kOneQ8 - (toe >> 8);
            int whole_lift = clamp(whole, 0, kIntactMost) * kOneQ12;
            if (whole_lift < intact * run) intact = whole_lift / run;
        }
        is_piled = is_piled && spans[column_word(kColumnSingle, column)] != kNotSingle;
    }
}

// The flattest plane on which soil slides down to a toe against the direction `way`: its columns, 0 where none fails. climb,
// start: see slides_on. passed: columns on the way up to where it ends at a tile asleep, else 0.
// A plane over columns that have not changed since the last look did not fail then, or they would have: see break_bonds and
// find_failures.
int find_plane(int slot, ivec2 at, ivec2 way, int toe, OUT(int) climb, OUT(int) start, OUT(int) passed) {
    climb = 0;
    start = 0;
    passed = 0;
    int least = mul_q16(params.bank_friction, step_length(way)) / 16 + 1;  // what climbs by less stands
    int first_slot = slot;
    ivec2 first_at = at;
    if (step_on(first_slot, first_at, way)) {
        int rise = height_over(first_slot, first_at, toe);
        // Half a column before the first where the ground goes on rising like that, 0 where it is a wall.
        int further = height_beyond(first_slot, first_at, way, toe) - rise;
        start = further <= 0 ? 0 : (further >= rise ? kOneQ8 / 2 : further * (kOneQ8 / 2) / rise);
    }
    if (!has_changed(column_of(slot, at)) && !passes_change(slot, at, way, toe, least, kOneQ8 / 2 + start, passed)) return 0;
    Planes planes;
    int end = kPlaneStepsMost + 1;
    do {
        collect_planes(slot, at, way, toe, least, start, end, planes, passed);
        // The flattest first: those before it do not count.
        for (int k = planes.found - 1; k >= max(0, planes.found - kPlanesHeld); --k) {
            int place = k & (kPlanesHeld - 1);
            end = planes.columns[place];
            if (slides_on(slot, at, way, toe, end, planes.climbs[place], start)) {
                climb = planes.climbs[place];
                return end;
            }
        }
    } while (planes.found > kPlanesHeld);
    return 0;
}

bool are_dispatched(int slot, ivec2 at, ivec2 way, int count) {
    bool all = true;
    for (int n = 1; n < count; ++n) {
        step_on(slot, at, way);
        all = all && tile_table[slot * kTileTableWords + kTileTableTop] / kTileTopStep == params.step_stamp;
    }
    return all;
}

// Whether a plane that failed at the last look passes under a column: see break_bonds.
bool has_failed(int slot, ivec2 at) {
    return spans[tile_word(kTileFailing, slot)] == params.step_stamp &&
           spans[column_word(kColumnFailing, column_of(slot, at))] != 0;
}

// Whether soil that has just failed lies up a way from a toe: at its foot, or one column on, where it has run out over the toe.
bool has_failed_up(int slot, ivec2 at, ivec2 way) {
    for (int n = 0; n < 2; ++n) {
        if (!step_on(slot, at, way)) return false;
        if (has_failed(slot, at)) return true;
    }
    return false;
}

// Whether a plane has failed in this step in a tile or in one beside it.
bool has_failed_around(int slot) {
    for (int n = 0; n < kNeighbourCount; ++n) {
        int other = neighbour_slot(slot, n);
        if (other >= 0 && spans[tile_word(kTileFailing, other)] == params.step_stamp) return true;
    }
    return false;
}

int find_failures_lanes(int group, int half_at) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    if (params.fails_near != 0 && !has_failed_around(slot)) return 0;
    return changed_around(slot, half_at, 2, params.slip_stamp) | spans[tile_word(kTileToes + half_at, slot)];
}

// A plane rises in one of 16 directions.
ivec2 plane_way(int k) { return ivec2(k % 5 - 2, k / 5 - 2); }

// Those in which the ground beside a column rises more steeply than friction holds it: bit k for plane_way(k).
int steep_ways(int slot, ivec2 here, int toe) {
    int along = toe + params.bank_friction;
    int diagonal = toe + mul_q16(params.bank_friction, kDiagonal);
    int skewed = toe + mul_q16(params.bank_friction, kSkewed);
    int ways = 0;
    for (int dy = -2; dy <= 2; ++dy) {
        int row = 0;
        for (int dx = -2; dx <= 2; ++dx) {
            int square = dx * dx + dy * dy;
            if (square == 0 || square == 4 || square == 8) continue;
            int first = column_at(slot, here.x + dx, here.y + dy);
            int held = square == 1 ? along : (square == 2 ? diagonal : skewed);
            if (first >= 0 && ground_height(first) > held) row = row | (1 << (dx + 2));
        }
        ways = ways | (row << (5 * dy + 10));
    }
    return ways;
}

// Of the ways up from a toe those that a look near soil which has just failed asks about. A toe on failing soil has no say: a lower
// plane passes under it. One that was a toe at the last look asks again where planes failed. To another one (kNoWays) soil has run
// out: it asks wherever such soil lies.
int ways_near(int slot, ivec2 here, int ways, int ways_failed) {
    if (has_failed(slot, here)) return 0;
    if (ways_failed != kNoWays) return ways & ways_failed;
    int near = 0;
    for (; ways != 0; ways = ways & (ways - 1)) {
        int k = lowest_bit(ways);
        if (has_failed_up(slot, here, plane_way(k))) near = near | (1 << k);
    }
    return near;
}

void find_failures(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    ivec2 here = ivec2(lane & 7, lane >> 3);
    int toe = ground_height(slot * kTileColumns + lane);
    int ways = steep_ways(slot, here, toe);
    bool is_toe = ways != 0;
    int word = tile_word(kTileToes + (lane >> 5), slot);
    int bit = 1 << (lane & 31);
    int ways_word = (slot * kTileColumns + lane) * kColumnWords + kColumnWays;
    bool is_closed_toe = is_toe && is_solid(voxel_at(slot, here.x, here.y, toe >> 16));
    if (is_closed_toe) ways = 0;  // nothing slides out there
    if (params.fails_near != 0 && ways != 0) {
        ways = ways_near(slot, here, ways, (ATOMIC_LOAD(spans[word]) & bit) != 0 ? spans[ways_word] : kNoWays);
    }
    int failing = is_closed_toe ? kNoWays : 0;
    for (; ways != 0; ways = ways & (ways - 1)) {
        int k = lowest_bit(ways);
        ivec2 way = plane_way(k);
        int climb = 0;
        int start = 0;
        int passed = 0;
        int count = find_plane(slot, here, way, toe, climb, start, passed);
        if (passed > 0) ask_for(slot, here, way, passed, toe);
        if (!are_dispatched(slot, here, way, count)) {
            ask_for(slot, here, way, count, toe);
            stamp_column(slot, lane);  // for the next look to find the plane again
            continue;
        }
        if (count > 0) failing = failing | (1 << k);
        int at_slot = slot;
        ivec2 at = here;
        for (int n = 1; n < count && step_on(at_slot, at, way); ++n) {
            int cut = toe + plane_at(n, start, climb) * kOneQ8 - 1;
            ATOMIC_MAX(spans[column_word(kColumnCut, column_of(at_slot, at))], kCutNone - cut);
            ATOMIC_MAX(spans[tile_word(kTileCut, at_slot)], params.step_stamp);
        }
    }
    if (is_toe) {
        // Else nobody asks for them, and they would tell who has looked: a plane that breaks no more bonds is not looked for again.
        if (params.keeps_cohesion != 0) spans[ways_word] = failing;
        ATOMIC_OR_OWNED(spans[word], bit);
    } else {
        ATOMIC_AND_OWNED(spans[word], ~bit);
    }
}
