// What the kernels share: addresses, the room in a voxel, moving a share of a voxel's soil. Integers throughout.

int state_at(int plane, int voxel) { return state_word(plane * params.plane_stride + voxel); }
void set_state(int plane, int voxel, int value) { set_state_word(plane * params.plane_stride + voxel, value); }
// A voxel's deltas lie together: few voxels get any, and those in all planes.
int delta_at(int plane, int voxel) { return voxel * params.transport_count + plane - kTransportFirst; }

void add_delta(int plane, int voxel, int value) {
    if (value != 0) add_to_delta(delta_at(plane, voxel), value);
}

// Of numbers from -kMomentumMost on.
int saturated_sum(int a, int b) {
    return b > 0 ? min(a, kMomentumMost - b) + b : max(a, -kMomentumMost - b) + b;
}

ivec3 saturated(ivec3 a, ivec3 b) {
    return ivec3(saturated_sum(a.x, b.x), saturated_sum(a.y, b.y), saturated_sum(a.z, b.z));
}

int flag_index(int array, int block) { return array * params.block_count + block; }

// A block's masks: see kMaskWords. Of two words the second is that of lanes 32 to 63.
int mask_index(int block, int word) { return kFlagArrays * params.block_count + block * kMaskWords + word; }

int mask_half(int block, int mask, int half_at) { return block_flags[mask_index(block, mask + half_at)]; }

// For masks that only a block's own group changes.
void set_in_mask(int block, int mask, int lane, bool is_in) {
    int at = mask_index(block, mask + (lane >> 5));
    int bit = 1 << (lane & 31);
    bool was_in = (block_flags[at] & bit) != 0;
    if (is_in && !was_in) {
        ATOMIC_OR_OWNED(block_flags[at], bit);
    } else if (!is_in && was_in) {
        ATOMIC_AND_OWNED(block_flags[at], ~bit);
    }
}

bool has_overflow(int block) {
    return (mask_half(block, kMaskOverflow, 0) | mask_half(block, kMaskOverflow, 1)) != 0;
}

// Place in the span buffer of a column's word in one of the arrays behind all columns, and of a tile's stamp.
int column_word(int array, int column) { return params.column_count * (kColumnWords + array) + column; }
int tile_word(int array, int slot) {
    return column_word(kColumnArrays, 0) + array * (params.column_count / kTileColumns) + slot;
}
int tile_stamp(int slot) { return tile_word(kTileStamp, slot); }

// A column is to be looked at again by those who look at changed columns only.
void stamp_column(int slot, int lane) {
    int at = column_word(kColumnStamp, slot * kTileColumns + lane);
    if (ATOMIC_LOAD(spans[at]) != params.pass_stamp) {
        ATOMIC_MAX(spans[at], params.pass_stamp);
        ATOMIC_MAX(spans[tile_stamp(slot)], params.pass_stamp);
    }
}

// Soil or coverage is not what it was in voxels low..high of a column.
void note_change(int slot, int lane, int low, int high) {
    stamp_column(slot, lane);
    ATOMIC_MIN_OWNED(spans[column_word(kColumnFull, slot * kTileColumns + lane)], low);
    ATOMIC_MAX_OWNED(spans[column_word(kColumnEnd, slot * kTileColumns + lane)], high + 1);
}

// Slot of the tile at a place among a tile's neighbours, or kNeighbourAbsent.
int neighbour_slot(int slot, int place) { return tile_table[slot * kTileTableWords + kTileTableNeighbours + place]; }

// Place among them of the tile over which (x, y) lies.
int place_beside(int x, int y) { return ((y >> 3) + 1) * kNeighbourRow + (x >> 3) + 1; }
int beside(ivec2 at) { return place_beside(at.x, at.y); }

// Whether (x, y) seen from a tile is one of its own columns: then no table is asked.
bool is_in_tile(int x, int y) { return ((x | y) & ~(kTileSide - 1)) == 0; }

// The slot of the tile over which (x, y) lies, seen from tile `slot`; x and y in -8..15.
int slot_at(int slot, int x, int y) { return is_in_tile(x, y) ? slot : neighbour_slot(slot, place_beside(x, y)); }

// Columns that have changed since `stamp` in row y (-8..15) of tile `slot` and of those beside it: bit 8 + x, x from -8 to 15.
int changed_row(int slot, int y, int stamp) {
    int row = 0;
    for (int n = 0; n < kNeighbourRow; ++n) {
        int other = neighbour_slot(slot, ((y >> 3) + 1) * kNeighbourRow + n);
        if (other < 0 || ATOMIC_LOAD(spans[tile_stamp(other)]) <= stamp) continue;
        int first = column_word(kColumnStamp, other * kTileColumns + (y & 7) * kTileSide);
        for (int x = 0; x < kTileSide; ++x) {
            row = row | (ATOMIC_LOAD(spans[first + x]) > stamp ? 1 << (n * kTileSide + x) : 0);
        }
    }
    return row;
}

// Columns of half a tile that have changed since the pass `stamp`.
int changed_half(int slot, int half_at, int stamp) {
    if (spans[tile_stamp(slot)] <= stamp) return 0;
    int first = column_word(kColumnStamp, slot * kTileColumns + half_at * 32);
    int columns = 0;
    for (int i = 0; i < 32; ++i) {
        if (spans[first + i] > stamp) columns = columns | (1 << i);
    }
    return columns;
}

// Columns of half a tile that have changed since the pass `stamp`, or from which one lies up to `reach` columns away.
int changed_around(int slot, int half_at, int reach, int stamp) {
    bool any_changed = false;
    for (int n = 0; n < kNeighbourCount; ++n) {
        int other = neighbour_slot(slot, n);
        any_changed = any_changed || (other >= 0 && ATOMIC_LOAD(spans[tile_stamp(other)]) > stamp);
    }
    if (!any_changed) return 0;
    int lanes = 0;
    for (int y = half_at * 4 - reach; y <= half_at * 4 + 3 + reach; ++y) {
        int row = changed_row(slot, y, stamp);
        for (int i = 0; i < reach; ++i) row = row | (row << 1) | (row >> 1);
        row = (row >> kTileSide) & kRowMask;
        for (int r = max(0, y - reach - half_at * 4); r <= min(3, y + reach - half_at * 4); ++r) {
            lanes = lanes | (row << (r * kTileSide));
        }
    }
    return lanes;
}

// Parts of a tile list's entry, see kTileWord.
int entry_slot(int entry) { return entry / (kTileWord * kTileWord); }
int entry_lowest(int entry) { return (entry / kTileWord) & (kTileWord - 1); }
int entry_highest(int entry) { return entry & (kTileWord - 1); }

// The voxel at (x, y, z) seen from tile `slot`; x and y in -8..15. -1 outside of what is resident.
int voxel_at(int slot, int x, int y, int z) {
    if (z < 0 || z >= params.height) return -1;
    int other = slot_at(slot, x, y);
    if (other < 0) return -1;
    return other * params.tile_voxels + z * kTileColumns + (y & 7) * kTileSide + (x & 7);
}

// The column at (x, y) seen from tile `slot`, as an index into the span buffer; -1 when not resident.
int column_at(int slot, int x, int y) {
    int other = slot_at(slot, x, y);
    if (other < 0) return -1;
    return other * kTileColumns + (y & 7) * kTileSide + (x & 7);
}

int column_of(int slot, ivec2 at) { return slot * kTileColumns + at.y * kTileSide + at.x; }

// A step over the ground; false where there is no tile awake, and nothing has changed then.
bool step_on(INOUT(int) slot, INOUT(ivec2) at, ivec2 way) {
    ivec2 next = at + way;
    int to = slot_at(slot, next.x, next.y);
    if (to < 0) return false;
    slot = to;
    at = ivec2(next.x & 7, next.y & 7);
    return true;
}

// So many steps; false where a tile on the way is not awake.
bool steps_on(INOUT(int) slot, INOUT(ivec2) at, ivec2 way, int count) {
    int rest = count;
    while (rest > 0) {
        int room_x = way.x == 0 ? kTileSide : (way.x > 0 ? kTileSide - 1 - at.x : at.x);
        int room_y = way.y == 0 ? kTileSide : (way.y > 0 ? kTileSide - 1 - at.y : at.y);
        int inside = min(rest, min(room_x, room_y));
        at = at + way * inside;
        rest -= inside;
        if (rest > 0 && !step_on(slot, at, way)) return false;
        rest -= 1;
    }
    return true;
}

// Height of a column's ground, Q16: its soil's, or that of terrain on top of it.
int ground_height(int column) {
    int word = spans[column_word(kColumnSurface, column)];
    return word >= 0 ? word : (word <= kTerrainTop ? kTerrainTop - word : kCovered - word);
}

// psi of the thesis: bodies and terrain in a voxel.
int coverage_at(int voxel) {
    return min(kVoxelFull, state_at(kPlaneCoverage, voxel) + state_at(kPlaneTerrain, voxel));
}

// Nothing ever flows into a voxel that is outside or mostly solid.
bool is_solid(int voxel) { return voxel < 0 || coverage_at(voxel) >= kSolidCoverage; }

// Whether a voxel is dispatched in this step: whoever asks has soil to put there or to take, so it is in the next.
bool is_listed(int voxel) {
    if (block_flags[flag_index(kFlagListed, voxel >> 9)] != 0) return true;
    ATOMIC_MAX(block_flags[flag_index(kFlagWanted, voxel >> 9)], kWantedBy * params.step_stamp + kWantedBySoil);
    return false;
}
bool is_closed(int voxel) { return is_solid(voxel) || !is_listed(voxel); }

bool is_full(int voxel) { return state_at(kPlaneVolume, voxel) + coverage_at(voxel) >= kVoxelFull; }

// What a voxel of a column's pile may lack and count as full. A load on a body that moves is smeared, but for its topmost voxel:
// that carries nothing, and a top half a voxel over its soil would send some out, which came back once it had sunk.
int slack_at(int voxel, int z, int volume) {
    bool carries = volume > 0 && z + 1 < params.height && state_at(kPlaneVolume, voxel + kTileColumns) > 0;
    return carries && state_at(kPlaneSupport, voxel) >= kSupportBody ? kCarrySlack : kSupportSlack;
}

// Room for pushed soil to go to: more than what rounding leaves between resting soil.
bool has_room(int voxel) {
    return voxel >= 0 && state_at(kPlaneVolume, voxel) + coverage_at(voxel) < kVoxelFull - kPushRoom;
}

// thesis (17): soil beyond the voxel's room, 0 while it is within the tolerance: what flows then flows down to the room itself, so
// that the last units of a push do not travel for ever. Beside a body the elastic part stays (it carries the body); inside
// one nothing may stay, or a moving wall would leave some of its load behind.
int excess_at(int voxel) {
    int bodies = state_at(kPlaneCoverage, voxel);
    int excess = state_at(kPlaneVolume, voxel) - kVoxelFull + min(kVoxelFull, bodies + state_at(kPlaneTerrain, voxel));
    if (bodies >= kSolidCoverage) return max(0, excess);
    if (bodies > 0) excess -= kElasticExcess;
    return excess > kExcessTolerance ? excess : 0;
}

bool is_overflowing(int voxel) { return state_at(kPlaneVolume, voxel) > 0 && excess_at(voxel) > 0; }

#include "soil_mixtures.glsl"
#include "soil_arches.glsl"

// Bits for chance, alike on all devices: of a place (Teschner et al. 2003), of this pass, and mixed (the primes of xxHash).
uint place_bits(ivec3 at) { return uint(at.x) * 73856093u ^ uint(at.y) * 19349663u ^ uint(at.z) * 83492791u; }
uint pass_bits() { return uint(params.chance) * 2654435761u; }
uint mix_bits(uint bits, int shift) { return (bits ^ (bits >> shift)) * 2246822519u; }
// Q16: a number of each voxel's own, in each pass another, so that crumbs do not move in step.
int voxel_chance(ivec3 at) { return int(mix_bits(place_bits(at) ^ pass_bits(), 15) >> 13) & kLowHalf; }

// The nearest whole number.
int round_q16(int value) { return (value + kOneQ16 / 2) >> 16; }
ivec3 round_q16(ivec3 value) { return (value + kOneQ16 / 2) >> 16; }

// Q16 quotient of a signed number of up to 27 bits.
int signed_fraction_q16(int part, int whole) {
    return part < 0 ? -fraction_q16(-part, whole) : fraction_q16(part, whole);
}

// Volume of a mass unit of a voxel's soil once it is loose, and once it is compacted, Q16. The first is 0 where density is fixed.
int compacted_word(int voxel) { return mixed_word(voxel, 0, kTableHeldLeast); }
int loose_word(int voxel) {
    if (!is_mixed(voxel)) return tables[kSoilStates * main_material(voxel) * kTableWords + kTableLoose];
    ivec2 held = mixed_pair(voxel, 0, kTableHeld);  // and kTableHeldLeast
    return held.x > held.y ? held.x : 0;
}

#include "contact_record.glsl"
#include "soil_strength.glsl"

// Volume that `mass` out of `voxel` takes up once it has been moved: no less than as loose soil.
int loosened(int voxel, int volume, int mass) {
    return max(volume, mul_q16(mass, loose_word(voxel)));
}

// Volume that it takes up once it has been sheared: what dilates comes to its critical density, not to the loosest.
int sheared(int voxel, int volume, int mass) {
    int loose = loose_word(voxel);
    if (params.dilates != 0 && loose > 0) {
        loose -= mul_q16(loose - compacted_word(voxel), mixed_word(voxel, kSoilLoose, kTableCritical));
    }
    return max(volume, mul_q16(mass, loose));
}

void mark_arrived(int voxel) {
    int at = mask_index(voxel >> 9, kMaskArrived + ((voxel >> 5) & 15));
    int bit = 1 << (voxel & 31);
    if ((ATOMIC_LOAD(block_flags[at]) & bit) == 0) ATOMIC_OR(block_flags[at], bit);
    ATOMIC_MAX(block_flags[flag_index(kFlagPending, voxel >> 9)], params.pass_stamp);
    ATOMIC_MAX(block_flags[flag_index(kFlagChanged, voxel >> 9)], params.step_stamp);
}

// Notes for apply_flow() that there are deltas in these voxels.
void mark_moved(int from, int to) {
    mark_arrived(from);
    if (from != to) mark_arrived(to);
}

// Moves `fraction` (Q16) of everything that travels with the soil. What one voxel loses the other gets, but for the bond:
// soil that moves has lost it. Soil that is pushed keeps its density, soil that slides loosens. False where no mass would move.
bool move_soil(int from, int to, int fraction, bool slides) {
    if (!moves_any(from, fraction)) return false;
    int volume = 0;
    int mass = 0;
    for (int i = 0; i < params.transport_count; ++i) {
        int plane = kTransportFirst + i;
        int share = mul_q16(state_at(plane, from), fraction);
        add_delta(plane, from, -share);
        if (plane == kPlaneVolume) {
            volume = share;
        } else if (plane != kPlaneBond) {
            add_delta(plane, to, share);
        }
        if (is_mass(plane)) mass += share;
    }
    add_delta(kPlaneVolume, to, slides ? sheared(from, volume, mass) : volume);
    mark_moved(from, to);
    return true;
}

bool move_share(int from, int to, int fraction) { return move_soil(from, to, fraction, false); }

int body_coverage(int voxel) {
    return voxel < 0 ? 0 : min(kVoxelFull, state_at(kPlaneCoverage, voxel));
}

// Central differences of the bodies' coverage: points into the body, as long as twice the area of its surface here.
ivec3 body_gradient(int slot, int x, int y, int z) {
    if (x > 0 && x < 7 && y > 0 && y < 7 && z > 0 && z < params.height - 1) {  // all in this tile
        int voxel = slot * params.tile_voxels + z * kTileColumns + y * kTileSide + x;
        return ivec3(body_coverage(voxel + 1) - body_coverage(voxel - 1),
                     body_coverage(voxel + kTileSide) - body_coverage(voxel - kTileSide),
                     body_coverage(voxel + kTileColumns) - body_coverage(voxel - kTileColumns));
    }
    return ivec3(body_coverage(voxel_at(slot, x + 1, y, z)) - body_coverage(voxel_at(slot, x - 1, y, z)),
                 body_coverage(voxel_at(slot, x, y + 1, z)) - body_coverage(voxel_at(slot, x, y - 1, z)),
                 body_coverage(voxel_at(slot, x, y, z + 1)) - body_coverage(voxel_at(slot, x, y, z - 1)));
}

// Velocity of body `body` (index + 1 in the owner plane is not used here) at a voxel; Q16 voxels a base step.
ivec3 body_velocity_at(int body, ivec3 voxel) {
    int base = body * kBodyWords;
    ivec3 center = ivec3(shapes[base + kBodyCenter], shapes[base + kBodyCenter + 1],
                         shapes[base + kBodyCenter + 2]);
    ivec3 arm = clamp(voxel * 2 + 1 - center, ivec3(-kArmMost), ivec3(kArmMost));
    ivec3 angular = ivec3(shapes[base + kBodyAngular], shapes[base + kBodyAngular + 1],
                          shapes[base + kBodyAngular + 2]);
    ivec3 turn = ivec3(angular.y * arm.z - angular.z * arm.y, angular.z * arm.x - angular.x * arm.z,
                       angular.x * arm.y - angular.y * arm.x);
    ivec3 linear = ivec3(shapes[base + kBodyLinear], shapes[base + kBodyLinear + 1],
                         shapes[base + kBodyLinear + 2]);
    return linear + (turn >> 1);
}

ivec3 grid_voxel(int slot, int x, int y, int z) {
    return ivec3(tile_table[slot * kTileTableWords + kTileTableX] * kTileSide + x,
                 tile_table[slot * kTileTableWords + kTileTableY] * kTileSide + y, z);
}

// Whether the grid has the column (x, y) of tile `slot`, or it only fills up the last tile. Such columns are rock and no body
// is ever marked in them, so that what looks at them from inside sees what it sees where there is no tile: a wall.
bool is_in_grid(int slot, int x, int y) {
    ivec3 at = grid_voxel(slot, x, y, 0);
    return at.x >= 0 && at.y >= 0 && at.x < params.size_x && at.y < params.size_y;
}

// A voxel's place in one word, above 0, which grows along x, then y, then z.
int place_code(ivec3 at) {
    int levels = ((params.height - 1) >> params.place_shift) + 1;
    return (at.x * params.place_rows + at.y) * levels + (at.z >> params.place_shift) + 1;
}

// Sets a status bit and leaves the last place of this step where that was so.
void note_condition(int bit, int place_word, ivec3 at) {
    ATOMIC_OR(result[kResultStatus], bit);
    ATOMIC_MAX(result[place_word], place_code(at));
}

int owner_body(int owner) { return (owner & (kOwnerRank - 1)) - 1; }

int largest_component(ivec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

// Soil in a voxel that bodies cover by half or more is caught in a wall: it may leave it on the side it came from only.
bool is_caught(int voxel) { return state_at(kPlaneCoverage, voxel) >= kSolidCoverage; }

// Outside of the grid or mostly fixed terrain.
bool is_rock(int voxel) { return voxel < 0 || state_at(kPlaneTerrain, voxel) >= kSolidCoverage; }

// How far a step leads out, any scale; negative: further into the wall.
int outwards(ivec3 step, ivec3 out_way) { return step.x * out_way.x + step.y * out_way.y + step.z * out_way.z; }

// Difference of the bodies' coverage along an axis. There is no way out through rock or the grid's ends: they count as
// covered at least as much as what is on this side of them.
int coverage_change(int voxel, int ahead, int behind) {
    bool shut_ahead = is_rock(ahead);
    bool shut_behind = is_rock(behind);
    if (shut_ahead) return shut_behind ? 0 : max(0, body_coverage(voxel) - body_coverage(behind));
    if (shut_behind) return min(0, body_coverage(ahead) - body_coverage(voxel));
    return body_coverage(ahead) - body_coverage(behind);
}

// As body_gradient, with an eye to where soil can go.
ivec3 wall_gradient(int slot, ivec3 at) {
    int voxel = voxel_at(slot, at.x, at.y, at.z);
    return ivec3(coverage_change(voxel, voxel_at(slot, at.x + 1, at.y, at.z), voxel_at(slot, at.x - 1, at.y, at.z)),
                 coverage_change(voxel, voxel_at(slot, at.x, at.y + 1, at.z), voxel_at(slot, at.x, at.y - 1, at.z)),
                 coverage_change(voxel, voxel_at(slot, at.x, at.y, at.z + 1), voxel_at(slot, at.x, at.y, at.z - 1)));
}

// The way out of the body for the soil in a voxel that it covers: where its coverage falls, as it was before the body's
// last move. Walls move by up to a voxel at once, and in the middle of a thin one the gradient of now may point to the
// far side. The field of before at a voxel is the field of now as far on as the body has moved; between the two voxels
// on either side it is interpolated. Zero where there is no way to prefer.
// overrun: the body has moved so far over the voxel that the far side is nearer now.
ivec3 way_out(int slot, ivec3 at, int voxel, OUT(bool) overrun) {
    ivec3 inwards = wall_gradient(slot, at);
    ivec3 now = inwards;
    int body = owner_body(state_at(kPlaneOwner, voxel));
    if (body >= 0 && shapes[body * kBodyWords + kBodyMoving] != 0) {
        ivec3 move = clamp(body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z)) / params.body_substep_count,
                           ivec3(-kVoxelFull), ivec3(kVoxelFull));
        int most = largest_component(move);
        if (most > 0) {
            // The nearest of the 26 directions that does not end in rock.
            move.x = is_rock(voxel_at(slot, at.x + sign(move.x), at.y, at.z)) ? 0 : move.x;
            move.y = is_rock(voxel_at(slot, at.x, at.y + sign(move.y), at.z)) ? 0 : move.y;
            move.z = is_rock(voxel_at(slot, at.x, at.y, at.z + sign(move.z))) ? 0 : move.z;
            int longest = max(1, largest_component(move));
            ivec3 ahead = at + (2 * move) / longest - move / longest;
            if (is_rock(voxel_at(slot, ahead.x, ahead.y, ahead.z))) ahead = at;
            ivec3 change = wall_gradient(slot, ahead) - inwards;
            inwards += ivec3(mul_q16(change.x, most), mul_q16(change.y, most), mul_q16(change.z, most));
        }
    }
    overrun = outwards(now / 8, inwards / 8) < 0;
    return -inwards;
}

// Whether soil that leaves `from` by `step` is barred. Caught soil goes on through the wall by the way out, or across it to
// where there is no more of it; nothing else enters a wall.
bool is_barred(int from, int to, ivec3 step, ivec3 out_way, bool overrun) {
    if (is_caught(from)) {
        int gain = outwards(step, out_way);
        if (gain < 0) return true;
        if (to >= 0 && is_caught(to) && state_at(kPlaneTerrain, to) < kSolidCoverage &&
            (overrun || body_coverage(to) <= body_coverage(from)) && block_flags[flag_index(kFlagListed, to >> 9)] != 0) {
            return false;
        }
    }
    return is_closed(to);
}

ivec3 momentum_at(int voxel) {
    return ivec3(state_at(kPlaneMomentumX, voxel), state_at(kPlaneMomentumY, voxel), state_at(kPlaneMomentumZ, voxel));
}

// Q16 voxels a base step. mass: of the voxel's soil, > 0
ivec3 soil_velocity(int voxel, int mass) {
    ivec3 momentum = momentum_at(voxel);
    ivec3 whole = momentum / mass;
    ivec3 rest = momentum - whole * mass;
    return clamp(whole, ivec3(-kCrumbSpeedMost), ivec3(kCrumbSpeedMost)) * 64 + (rest * 64) / mass;
}

// Soil in a voxel that the body it rests on covers in part.
bool is_carried_here(int voxel) {
    int support = state_at(kPlaneSupport, voxel);
    return support >= kSupportBody && owner_body(state_at(kPlaneOwner, voxel)) == support - kSupportBody;
}

int dot_q16(ivec3 a, ivec3 b) { return mul_q16(a.x, b.x) + mul_q16(a.y, b.y) + mul_q16(a.z, b.z); }

// Q16 directions.
bool is_within_60_deg(ivec3 a, ivec3 b) {
    int along = dot_q16(a, b);
    return along > 0 && 4 * mul_q16(along, along) >= mul_q16(dot_q16(a, a), dot_q16(b, b));
}

// Largest component one voxel (Q16). most: that component's size, > 0
ivec3 direction_q16(ivec3 v, int most) {
    return ivec3(signed_fraction_q16(v.x, most), signed_fraction_q16(v.y, most), signed_fraction_q16(v.z, most));
}

// Excess that soil beside the body that carries it makes room for by its own motion: up to a slice as thick as it moves
// in this step. It goes before the wall behind it and needs no push, where what is ahead of it is open and carried too.
int excess_carried_off(int slot, ivec3 at, int voxel, ivec3 out_way) {
    int mass = mass_at(voxel);
    if (mass <= 0 || !is_carried_here(voxel)) return 0;
    ivec3 velocity = clamp(soil_velocity(voxel, mass), ivec3(-kSpeedMost), ivec3(kSpeedMost));  // a crumb's is anything
    ivec3 drift = velocity / params.body_substep_count;
    int most = largest_component(drift);
    if (most == 0 || outwards(drift * kForceOne / most, out_way) <= 0) return 0;
    ivec3 step = (2 * drift) / most - drift / most;
    int ahead = voxel_at(slot, at.x + step.x, at.y + step.y, at.z + step.z);
    if (ahead < 0 || is_caught(ahead) || state_at(kPlaneSupport, ahead) != state_at(kPlaneSupport, voxel)) {
        return 0;
    }
    return min(most, kVoxelFull);
}

#include "momentum_ledger.glsl"
#include "load_rows.glsl"
#include "slope_resistance.glsl"
#include "slides.glsl"

// What pour_soil and take_soil run over. A group is a part of a source's or a sink's region: its tile's slot, and the place of its
// words in the tables.
int flow_slot(int group) { return block_list[params.list_offset + kPairWords * group + kPairSlot]; }
int flow_part(int group) { return block_list[params.list_offset + kPairWords * group + kPairPart]; }
int flow_word(int part, int word) { return tables[params.flow_offset + tables[part] * kFlowWords + word]; }
int flow_sum(int part, int word) { return params.flow_result + tables[part] * kFlowResultWords + word; }

// Columns in which the part has voxels.
int flow_lanes(int group, int half_at) {
    int first = flow_part(group) + kFlowColumns + half_at * 32;
    int columns = 0;
    for (int i = 0; i < 32; ++i) columns = columns | (tables[first + i] != 0 ? 1 << i : 0);
    return columns;
}
