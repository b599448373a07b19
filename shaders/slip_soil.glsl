// Slippage, thesis (1) to (10), (31) and (32): soil slides where a slice between neighbouring columns fails.
// Slices run to all eight neighbours. The slope of the ground is that of the triangular facets between an axis neighbour
// and a diagonal one (as in Tarboton's D-infinity flow), so that a pile stands equally steep in every direction;
// with one slope per neighbour it would be too steep between them. Wedge height and acceleration against slope come
// from tables made on the host in double precision: (4) and (8).
// Soil that falls in an arch slips too, without friction: see soil_arches.glsl.
// Soil above a plane that find_failures has found failing has no cohesion: see soil_state_at().
// Reads: spans, cuts, stamps, coverage, terrain, support, all transported planes. Writes: deltas, slip speed, stamps, sums of
// momentum.

CONST_INT(kNoDrop, -1)
CONST_INT(kSlipDepth, 2)  // voxels of a column that may slide at once
CONST_INT(kSlipIntake, 65536)  // soil a column gets from each neighbour at once: all eight give half of what fits (kVoxelMost)

// Where the slip speed of a column's spans stands: two sets, one read and one written, turn by turn.
int speed_read(int record, int span) { return record + kColumnSpeed + span + params.slip_turn * kSpanCapacity; }
int speed_write(int record, int span) {
    return record + kColumnSpeed + span + (1 - params.slip_turn) * kSpanCapacity;
}

// Fastest slip of a column's spans in the pass before: beyond them all speeds are 0.
int fastest_slip(int record) {
    int fastest = 0;
    int count = spans[record + kColumnCount];
    for (int i = 0; i < count; ++i) fastest = max(fastest, spans[speed_read(record, i)]);
    return fastest;
}

// The same of the column at (x, y).
int column_speed(int slot, int x, int y) {
    int column = column_at(slot, x, y);
    return column >= 0 && spans[column_word(kColumnSlides, column)] != 0 ? fastest_slip(column * kColumnWords) : 0;
}

#include "slip_slices.glsl"

// Soil that falls bears nothing: no friction keeps it from sliding.
Resistance resistance_of_falling() {
    Resistance soil;
    soil.curve = kMixedBonded - kSoilLoose;
    soil.friction = 0;
    soil.strength = 0;
    return soil;
}

// Of a mixture: the mean by mass.
int acceleration_at(int curve, int voxel, int slope) {
    if (curve >= 0) return table_at(curve, kTableAcceleration, slope);
    int mass = mass_at(voxel);
    int mean = 0;
    for (int m = 0; m < params.material_count; ++m) {
        int share = fraction_q16(state_at(kPlaneMaterial + m, voxel), max(1, mass));  // room may be left without soil
        mean += mul_q16(share, table_at(kSoilStates * m + kMixedBonded - curve, kTableAcceleration, slope));
    }
    return mean;
}

// No facet around a column of one pile is steeper than this, whatever bars the way: the deepest drop to one of its eight
// neighbours, where those are one pile as well.
int steepest_drop(int slot, int x, int y, int top) {
    int deepest = 0;
    if (x > 0 && x < 7 && y > 0 && y < 7) {  // all in this tile
        int corner = column_word(kColumnSingle, slot * kTileColumns + (y - 1) * kTileSide + x - 1);
        for (int n = 0; n < 9; ++n) {
            int single = spans[corner + n / 3 * kTileSide + n % 3];
            deepest = max(deepest, single == kNotSingle ? kAnyDrop : top - single);
        }
        return deepest;
    }
    for (int n = 0; n < 9; ++n) {
        int column = column_at(slot, x + n % 3 - 1, y + n / 3 - 1);
        if (column >= 0) {
            int single = spans[column_word(kColumnSingle, column)];
            deepest = max(deepest, single == kNotSingle ? kAnyDrop : top - single);
        }
    }
    return deepest;
}

// How hard gravity drives soil along the ground where it falls by `slope`: what friction leaves of it, along the slope, of that
// the part along the ground; Q16 of gravity. Of the planes through a steeper face that of Coulomb's wedge, at 45 deg + phi / 2,
// is driven hardest, by tan(45 deg - phi / 2) / 2.
int slide_push(int slope, int friction, int passive) {
    if (mul_q16(slope, passive) >= kOneQ16) return passive / 2;
    return fraction_q16(max(0, slope - friction), kOneQ16 + mul_q16(slope, slope));
}

// The eight neighbours: 0 east, 1 north-east, 2 north ... counter-clockwise. Of each two bits, of x and of y, plus 1.
CONST_INT(kWaysX, 36890)  // 2 1 0 0 0 1 2 2, the last first
CONST_INT(kWaysY, 425)    // 0 0 0 1 2 2 2 1
ivec2 way_to(int k) { return ivec2((kWaysX >> (2 * k)) & 3, (kWaysY >> (2 * k)) & 3) - 1; }

// Columns ahead at which the ground tells how deep soil slides: all of the next four, then each by a quarter further.
CONST_INT(kSlideReach, 128)

// Sets soil in motion that lies on a failing slope, as deep as a plane at phi out of the ground ahead leaves it without support.
void set_sliding(int slot, int x, int y, int top, int source, ivec2 fall, int slope) {
    int friction = mixed_word(source, kSoilLoose, kTableFriction);  // alike in all states
    int push = mul_q16(slide_push(slope, friction, mixed_word(source, kSoilLoose, kTablePassive)), params.slide_kick);  // Q24
    ivec2 gain = sign(fall) * ivec2(mul_q16(abs(fall.x), push), mul_q16(abs(fall.y), push));
    if (gain.x == 0 && gain.y == 0) return;
    // The nearest of the eight ways.
    ivec2 way = ivec2(5 * abs(fall.x) > 2 * abs(fall.y) ? sign(fall.x) : 0, 5 * abs(fall.y) > 2 * abs(fall.x) ? sign(fall.y) : 0);
    int climb = way.x == 0 || way.y == 0 ? friction : mul_q16(friction, kDiagonal);
    int base = top;
    int at_slot = slot;
    ivec2 at = ivec2(x, y);
    int next = 1;
    for (int walked = 0; next <= kSlideReach && climb * next < base && steps_on(at_slot, at, way, next - walked);) {
        base = min(base, ground_height(column_of(at_slot, at)) + climb * next);
        walked = next;
        next += max(1, next / 4);
    }
    int lowest = (top >> 16) + 1;
    int thickness = 0;
    for (int z = (top - 1) >> 16; z >= 0; --z) {
        int voxel = slot * params.tile_voxels + z * kTileColumns + y * kTileSide + x;
        // What slides already is driven as a whole.
        if (z < base >> 16 && state_at(kPlaneMomentumX, voxel) == 0 && state_at(kPlaneMomentumY, voxel) == 0) break;
        if (is_solid(voxel)) break;
        if (mass_at(voxel) == 0) continue;
        if (wedge_at(resistance_of(voxel, slope), slope) <= standing_wedge(voxel, slot, ivec3(x, y, z))) break;
        thickness += state_at(kPlaneVolume, voxel);
        lowest = z;
    }
    if (thickness <= kWholeMost) return;  // see find_slab()
    MomentumSum given = no_momentum();
    for (int z = (top - 1) >> 16; z >= lowest; --z) {
        int voxel = slot * params.tile_voxels + z * kTileColumns + y * kTileSide + x;
        int mass = mass_at(voxel);
        if (mass == 0 || !is_listed(voxel)) continue;
        ivec3 gained = ivec3(fine_momentum(mass, gain.x), fine_momentum(mass, gain.y), 0);
        add_delta(kPlaneMomentumX, voxel, gained.x);
        add_delta(kPlaneMomentumY, voxel, gained.y);
        add_to_sum(given, -gained);
        mark_moved(voxel, voxel);
    }
    add_momentum_sums(kResultGround, given);
}

// The slices from a span to its eight neighbours.
struct Slices {
    int drop[8];    // per voxel, see way_drop()
    int target[8];  // the voxel that gets the soil
    int flow[8];    // share of what slips: of Failure's flow
    int falls;      // bit k: the voxel lies on soil that falls
};

// How a span fails.
struct Failure {
    int wedge;   // height of the highest failing wedge, Q16 voxels; 0: all stand
    int slope;   // of its facet
    int flow;    // sum of the slices' flows
    int facet[8];        // height of the wedge that fails in each facet; 0: none
    int to_diagonal[8];  // of a facet, see facet_slope()
};

// False where the ground falls to none of them.
bool find_slices(int slot, int x, int y, int bottom, int top, bool on_rigid, OUT(Slices) slices) {
    bool any_drop = false;
    slices.falls = 0;
    for (int k = 0; k < 8; ++k) {
        ivec2 way = way_to(k);
        int voxel = -1;
        bool falls = false;
        slices.drop[k] = way_drop(slot, x, y, way.x, way.y, bottom, top, on_rigid, voxel, falls);
        if (falls) slices.falls |= 1 << k;
        slices.target[k] = voxel;
        slices.flow[k] = 0;
        any_drop = any_drop || slices.drop[k] > 0;
    }
    return any_drop;
}

// Slope of the facet between an axis neighbour and a diagonal one, by the drops to them; 0 where it cannot fail.
// to_diagonal: share of its flow that goes to the diagonal one, Q16.
int facet_slope(IN(Resistance) soil, int stands, int along, int diagonal, OUT(int) to_diagonal) {
    to_diagonal = 0;
    if (along <= 0 && diagonal <= 0) return 0;
    int across = diagonal - along;
    if (along > 0 && across <= 0) return along;
    if (along <= 0 || across > along) {
        to_diagonal = kOneQ16;
        return mul_q16(diagonal, kDiagonalInverse);  // over sqrt(2)
    }
    if (wedge_at(soil, along + across / 2 + 1) <= stands) return 0;  // no slope of these two is steeper
    to_diagonal = fraction_q16(across, along);
    return slope_length(along, across);
}

// The diagonal beside a facet's axis: two facets lie on both sides of each.
int facet_diagonal(int k) {
    int axis = k & 6;  // 0 2 4 6
    return (axis + 1 + 6 * (k & 1)) & 7;
}

// Direction in which a facet falls, Q16: along its axis and across it.
ivec2 facet_dip(int k, int to_diagonal) {
    ivec2 axis_way = way_to(k & 6);
    ivec2 side_way = way_to(facet_diagonal(k)) - axis_way;
    int length = slope_length(kOneQ16, to_diagonal);
    return axis_way * fraction_q16(kOneQ16, length) + side_way * fraction_q16(to_diagonal, length);
}

// A facet counts for the direction as far as its wedge comes within one part in so many of the highest. Ours: so that noise does
// not choose between two facets that are as steep. Larger: the columns of a face along a diagonal fall to one side or the other,
// and heap up; smaller: directions are drawn to the eight ways.
CONST_INT(kDipShare, 8)

// Direction in which a span falls, Q16: the mean of the facets that are nearly as steep as the steepest. Of length 1, and less
// where those look apart by more than a right angle, as on a ridge.
ivec2 dip_of(IN(Failure) failure) {
    int band = max(1, failure.wedge / kDipShare);
    ivec2 sum = ivec2(0);
    int weights = 0;
    for (int k = 0; k < 8; ++k) {
        int weight = fraction_q16(max(0, failure.facet[k] - failure.wedge + band), band) >> 4;  // sums of 8 stay in range
        if (weight == 0) continue;
        ivec2 fall = facet_dip(k, failure.to_diagonal[k]);
        sum += sign(fall) * ivec2(mul_q16(abs(fall.x), weight), mul_q16(abs(fall.y), weight));
        weights += weight;
    }
    ivec2 mean = sign(sum) * ivec2(fraction_q16(abs(sum.x), weights), fraction_q16(abs(sum.y), weights));
    int size = slope_length(mean.x, mean.y);
    if (size == 0) return ivec2(0);
    int longer = size <= kDiagonalInverse ? kDiagonal : fraction_q16(kOneQ16, size);
    return sign(mean) * ivec2(mul_q16(abs(mean.x), longer), mul_q16(abs(mean.y), longer));
}

// Which facets around a span fail, the worst of them, and how much each gives to whom. stands: see standing_wedge().
Failure find_failure(IN(Resistance) soil, int stands, INOUT(Slices) slices) {
    Failure failure;
    failure.wedge = 0;
    failure.slope = 0;
    failure.flow = 0;
    for (int k = 0; k < 8; ++k) {
        failure.facet[k] = 0;
        int axis = k & 6;
        int diagonal = facet_diagonal(k);
        int to_diagonal = 0;
        int slope = facet_slope(soil, stands, slices.drop[axis], slices.drop[diagonal], to_diagonal);
        if (slope == 0) continue;
        int wedge = wedge_at(soil, slope);
        if (wedge <= stands) continue;
        if (wedge > failure.wedge) {
            failure.wedge = wedge;
            failure.slope = slope;
        }
        failure.facet[k] = wedge;
        failure.to_diagonal[k] = to_diagonal;
        wedge = wedge >> 4;  // sums of 8 stay in range
        int part = mul_q16(wedge, to_diagonal);
        slices.flow[diagonal] += part;
        slices.flow[axis] += wedge - part;
        failure.flow += wedge;
    }
    return failure;
}

// Whether viscous soil does not slip in this pass.
bool is_held_up(int slot, int source, ivec3 at) {
    int viscosity = params.deposits == 0 ? 0 : mixed_word(source, kSoilBonded, kTableViscosity);
    return viscosity > 0 && viscosity > voxel_chance(grid_voxel(slot, at.x, at.y, at.z));
}

// The fastest slip in a column and those around it.
int fastest_around(int slot, int x, int y) {
    int fastest = 0;
    for (int k = 0; k < 9; ++k) {
        fastest = max(fastest, column_speed(slot, x + k % 3 - 1, y + k / 3 - 1));
    }
    return fastest;
}

// How much more than its wedge slides to rest, Q16 voxels. Ours: 1/64. Sand stops 1 to 2 deg below the angle at which it starts
// (Jaeger, Liu and Nagel 1989): 1/64 voxel a column is 0.7 deg at 30, and what ends a slide leaves half of that at most. Without
// it the last excess goes on from column to column as heat does. Larger: piles end flatter, and a scoop keeps less; smaller:
// slopes creep for longer. It was chosen with all of that seen, see docs/decisions/rest.md. Where soil keeps the momentum of its
// slides, that carries them past the slope at which they would stop.
CONST_INT(kSlipOvershoot, 1024)

// The same of the soil in a voxel. Where friction is next to nothing it is less, or a slope that lost it would fail the other way.
int overshoot_of(int source, int kind) {
    if (kind == kSpanFalling || params.slip_stride > 1 || params.slides != 0) return 0;
    return min(kSlipOvershoot, mixed_word(source, kSoilLoose, kTableFriction) / 4);
}

// How much slips of a wedge, thesis (10).
int slip_amount(int wedge, int speed, int flow_sum, IN(Slices) slices) {
    int rate = min(max(speed / params.substep_count, params.slip_rate_least), params.slip_rate_most);
    // As if columns that far apart were neighbours.
    int amount = min(mul_q16(wedge, rate) * params.slip_stride, kSlipDepth * kVoxelFull) + 1;
    int most_flow = 0;
    for (int k = 0; k < 8; ++k) most_flow = max(most_flow, slices.flow[k]);
    return amount > kSlipIntake ? min(amount, fraction_q16(kSlipIntake, fraction_q16(most_flow, flow_sum))) : amount;
}

// Soil that slides onto soil that falls in an arch takes part in its motion: dense soil does not thin out as it flows, and what
// slides has come down a slope. The ground gives what its speed lacks. source: the voxel that it is from.
void fall_along(int source, int target, int mass) {
    int falling = state_at(kPlaneVolume, target) >= kArchLeast ? target : target - kTileColumns;
    int held = mass_at(falling);
    if (held <= 0) return;
    int faster = soil_velocity(falling, held).z - soil_velocity(source, mass_at(source)).z;
    ivec3 given = momentum_of(mass, ivec3(0, 0, clamp(faster, -kSpeedMost, 0)));
    add_delta(kPlaneMomentumZ, target, given.z);
    add_momentum_sum(kResultGround, -given);
}

// Moves an amount of a span's soil along its slices, from the top down, a voxel at a time. What is held up waits: it is no soil at
// rest for all that, and its block stays awake, as long as any of it could move. Whether any goes, or waits to.
bool shed_soil(int slot, int x, int y, int bottom, int top, int wanted, int kind, int curve, bool waits, IN(Failure) failure,
               IN(Slices) slices) {
    int amount = wanted;
    bool goes = false;
    int lowest = max(bottom >> 16, ((top - 1) >> 16) - kSlipDepth);
    for (int z = (top - 1) >> 16; z >= lowest && amount > 0; --z) {
        int source = voxel_at(slot, x, y, z);
        int held = state_at(kPlaneVolume, source);
        int taken = min(amount, held);
        if (taken <= 0) continue;
        int below = curve_of(source);
        if (kind != kSpanFalling && (below != curve || below < 0) &&
            wedge_at(resistance_of(source, failure.slope), failure.slope) <= standing_wedge(source, slot, ivec3(x, y, z))) {
            break;  // what lies on top slides off it
        }
        // A face can be higher than the blocks around what moves. Deltas beyond them would be lost.
        bool asks = false;
        amount -= taken;
        int fraction = fraction_q16(taken, held);
        for (int k = 0; k < 8; ++k) {
            if (slices.flow[k] <= 0) continue;
            int part = mul_q16(fraction, fraction_q16(slices.flow[k], failure.flow));
            int most = most_taken(slices.target[k], top);
            if (most < mul_q16(held, part)) part = fraction_q16(most, held);
            if (!moves_any(source, part) || is_solid(slices.target[k])) continue;
            goes = true;
            if (!are_listed(source, slices.target[k])) {
                asks = true;
                continue;
            }
            if (waits) {
                ATOMIC_MAX(block_flags[flag_index(kFlagChanged, source >> 9)], params.step_stamp);
                return true;
            }
            move_soil(source, slices.target[k], part, true);
            if (((slices.falls >> k) & 1) != 0) fall_along(source, slices.target[k], mul_q16(mass_at(source), part));
        }
        if (asks && !is_listed(source)) return true;
    }
    return goes;
}

// Lets span i of a column slip where it fails; whether it has a speed then. steepest: no facet around it is steeper.
// slid: the column has speeds of the pass before.
bool slip_span(int slot, int lane, int i, int bottom, int top, int kind, int steepest, bool is_topmost, bool slid) {
    ivec3 at = ivec3(lane & 7, lane >> 3, (top - 1) >> 16);
    int source = voxel_at(slot, at.x, at.y, at.z);
    Resistance soil = kind == kSpanFalling ? resistance_of_falling() : resistance_of(source, steepest);
    int stands = standing_wedge(source, slot, at);
    if (wedge_at(soil, steepest) <= stands) return false;  // the steeper a slope, the higher its wedge
    int column = slot * kTileColumns + lane;
    int record = column * kColumnWords;
    bool on_rigid = bottom > 0 && kind == kSpanPiled;
    Slices slices;
    if (!find_slices(slot, at.x, at.y, bottom, top, on_rigid, slices)) return false;
    Failure failure = find_failure(soil, stands, slices);
    if (failure.wedge == 0) return false;
    if (kind != kSpanFalling) ATOMIC_MAX(result[kResultSlope], failure.wedge);
    // Even where nothing can leave: the next pass looks again. Others may see this mark in this pass or in the next: where
    // nothing fails looking changes nothing.
    stamp_column(slot, lane);
    bool waits = is_held_up(slot, source, at);
    int wedge = failure.wedge + overshoot_of(source, kind);
    // What slides with its momentum slips so little that it keeps that. On a ridge it has no way to slide, and slips.
    if (params.slides != 0 && is_topmost && spans[column_word(kColumnSurface, column)] == top) {
        ivec2 fall = dip_of(failure);
        if (params.slide_kick > 0 && !waits) set_sliding(slot, at.x, at.y, top, source, fall, failure.slope);
        int aside = max(0, kOneQ16 - slope_length(fall.x, fall.y));
        wedge = min(wedge, kSlideCreep + mul_q16(wedge, aside));
    }
    // thesis (9), and no more than a quarter of the wedge at once.
    int faster = acceleration_at(soil.curve, source, failure.slope) / params.substep_count;
    // Of short steps in large voxels that is less than a unit. See the end of slide_soil(): by its speed it knows what is driven.
    if (params.slides != 0) faster = max(1, faster);
    // Soil that slides on into this column brings its speed along. What is as fast as can be without it need not look.
    int speed = slid ? spans[speed_read(record, i)] : 0;
    if (speed + faster < kOneQ16) speed = max(speed, fastest_around(slot, at.x, at.y));
    speed = min(speed + faster, kOneQ16);
    int amount = slip_amount(wedge, speed, failure.flow, slices);
    bool goes = shed_soil(slot, at.x, at.y, bottom, top, amount, kind, soil.curve, waits, failure, slices);
    // What is too little for a share at the full rate will not go at any: it stands, and drives nothing.
    bool is_stuck = !goes && speed >= min(kOneQ16, params.slip_rate_most * params.substep_count);
    if (waits || is_stuck) return false;
    spans[speed_write(record, i)] = speed;
    return speed != 0;
}

// A slope fails or stands by its own column and those it could slide to. Where none of them has changed since a pass looked over
// the same way, and it stood, it stands. Without gravity all do.
int slip_soil_lanes(int group, int half_at) {
    if (params.arch_speed == 0) return 0;
    return changed_around(entry_slot(block_list[params.list_offset + group]), half_at, params.slip_stride, params.slip_stamp);
}

void slip_soil(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int column = slot * kTileColumns + lane;
    int record = column * kColumnWords;
    int single = spans[column_word(kColumnSingle, column)];
    bool is_single = single != kNotSingle;
    int slides_at = column_word(kColumnSlides, column);
    bool slid = spans[slides_at] != 0;
    // Others read these speeds in this pass: as long as one is not 0 the column slides. The next pass has to end it.
    bool slides = slid && fastest_slip(record) > 0;
    if (slides) stamp_column(slot, lane);
    int count = is_single ? 1 : spans[record + kColumnCount];
    for (int i = 0; i < count; ++i) {
        int at = record + kColumnSpans + i * kSpanWords;
        int bottom = is_single ? 0 : spans[at + kSpanBottom];
        int top = is_single ? single : spans[at + kSpanTop];
        if (slid) spans[speed_write(record, i)] = 0;
        int kind = is_single ? kSpanPiled : spans[at + kSpanKind];
        if (top <= bottom || !is_ground(column, kind, bottom, top)) continue;
        int steepest = is_single && params.slip_stride == 1 ? steepest_drop(slot, lane & 7, lane >> 3, top) : kAnyDrop;
        if (steepest <= 0) continue;
        slides = slip_span(slot, lane, i, bottom, top, kind, steepest, i == count - 1, slid) || slides;
    }
    if (slides != slid) spans[slides_at] = slides ? 1 : 0;
}
