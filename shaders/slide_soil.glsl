// Soil that slides on: what slip_soil or a fall has set in motion along the ground goes on until friction has taken its
// momentum, also over slopes that are stable. The voxels of a column that have momentum slide as one. Their thickness times
// their speed goes over to the columns ahead, from the top down here and from the surface up there.
// Reads: surfaces, slips, cuts, stamps, coverage, terrain, all transported planes, tables. Writes: deltas, momentum, its sums,
// stamps.

CONST_INT(kSlideGap, 4)         // voxels without momentum under which none is looked for
CONST_INT(kSlideDepth, 128)     // voxels at most that slide: sums over them stay in 31 bits
CONST_INT(kSlideSteepest, 262144)   // slope 4: beyond it friction is next to nothing
CONST_INT(kSumMost, 8192)       // of a momentum's high half: what is beyond 29 bits costs the sum's lowest

bool slides_along(int voxel) {
    return state_at(kPlaneMomentumX, voxel) != 0 || state_at(kPlaneMomentumY, voxel) != 0;
}

// By how much the ground at (x, y) is lower than `top`; kSlideWall where nothing slides there.
CONST_INT(kSlideWall, -268435456)
int slide_drop(int slot, int x, int y, int top, int thickness) {
    int column = column_at(slot, x, y);
    if (column < 0) return kSlideWall;
    int word = spans[column_word(kColumnSurface, column)];
    if (word < 0 && word > kTerrainTop) return kSlideWall;  // under a body
    int drop = top - ground_height(column);
    if (drop < -max(kVoxelFull, thickness)) return kSlideWall;
    // Where no soil can come to lie nothing slides: it would be in motion for good.
    return is_solid(voxel_at(slot, x, y, (top - drop) >> 16)) ? kSlideWall : drop;
}

// Part of what lies in a voxel, down into the one below, which has room for it. Both are this lane's own. A push does not go
// along: it would stay, since neither is in excess (thesis (35), second case).
void drop_soil(int from, int to, int fraction) {
    for (int i = 0; i < params.transport_count; ++i) {
        int plane = kTransportFirst + i;
        int held = state_at(plane, from);
        int share = fraction >= kOneQ16 ? held : mul_q16(held, fraction);
        set_state(plane, from, held - share);
        set_state(plane, to, state_at(plane, to) + share);
    }
    for (int axis = 0; axis < 3; ++axis) {
        set_state(kPlaneForceX + axis, from, 0);
        set_state(kPlaneForceX + axis, to, 0);
    }
    mark_moved(from, to);
}

// What leaves a column from the top and what arrives there in the same pass can leave a voxel half empty under others. Closes
// such gaps from the surface up, and returns the height of the surface then.
int close_gaps(int first, int top, int end) {
    int to = top >> 16;
    if (to + 1 >= end || state_at(kPlaneVolume, first + (to + 1) * kTileColumns) == 0) return top;
    for (int z = to + 1; z < end; ++z) {
        int from = first + z * kTileColumns;
        if (state_at(kPlaneVolume, from) == 0 || is_solid(from)) break;
        for (; to < z; ++to) {
            int under = first + to * kTileColumns;
            int room = kVoxelFull - coverage_at(under) - state_at(kPlaneVolume, under);
            int held = state_at(kPlaneVolume, from);
            if (room > 0) drop_soil(from, under, room >= held ? kOneQ16 : fraction_q16(room, held));
            if (room >= held) break;
        }
    }
    return to * kVoxelFull + min(kVoxelFull, state_at(kPlaneVolume, first + to * kTileColumns));
}

// The voxels of a column that slide as one.
struct Slab {
    int low;        // voxels from here
    int high;       // to here
    int rubbing;    // the highest with more than a crumb: it tells what holds the slab. A crumb has no cohesion, see is_bonded()
    int thickness;  // Q16 voxels of soil
    ivec2 speed;    // Q24 voxels a step: of short ones friction takes less than a unit of Q16
    int pace;       // length of that
};

// Along an axis, the nearest. mass: > 0
int slide_speed(int momentum, int mass) {
    int size = abs(momentum);
    int whole = size / mass;
    if (whole >= kSlideSpeedMost / 64) return sign(momentum) * kSlideSpeedMost * kOneQ8;
    return sign(momentum) * (whole * (64 * kOneQ8) + ((fraction_q16(size - whole * mass, mass) + 2) >> 2));
}

// Mean speed of a mass with that momentum. mass: > 0
ivec2 mean_speed(IN(MomentumSum) sum, int mass) {
    int shift = 0;
    while ((max(abs(sum.high.x), abs(sum.high.y)) >> shift) >= kSumMost || (mass >> shift) >= kRangeMost) shift += 1;
    int held = max(1, mass >> shift);
    return ivec2(slide_speed((sum.high.x << (16 - shift)) + (sum.low.x >> shift), held),
                 slide_speed((sum.high.y << (16 - shift)) + (sum.low.y >> shift), held));
}

// Those from the surface down to the lowest that has momentum; false where none has any. What is thinner than kWholeMost has no
// speed: too thin to be shared out, it would slide for good. It slips as far as it can.
bool find_slab(int first, int top, OUT(Slab) slab) {
    slab.high = (top - 1) >> 16;
    slab.low = slab.high + 1;
    slab.rubbing = slab.high;
    slab.thickness = 0;
    slab.speed = ivec2(0);
    slab.pace = 0;
    MomentumSum momentum = no_momentum();
    int gap = 0;
    for (int z = slab.high; z > slab.high - kSlideDepth && z >= 0 && gap < kSlideGap; --z) {
        int voxel = first + z * kTileColumns;
        if (is_solid(voxel)) break;
        if (slides_along(voxel)) {
            add_to_sum(momentum, ivec3(state_at(kPlaneMomentumX, voxel), state_at(kPlaneMomentumY, voxel), 0));
            slab.low = z;
            gap = 0;
        } else {
            gap += 1;
        }
    }
    int mass = 0;
    for (int z = slab.low; z <= slab.high; ++z) {
        int voxel = first + z * kTileColumns;
        int volume = state_at(kPlaneVolume, voxel);
        mass += mass_at(voxel);
        slab.thickness += volume;
        if (volume > kWholeMost) slab.rubbing = z;
    }
    if (slab.thickness > kWholeMost && mass > 0) slab.speed = mean_speed(momentum, mass);
    return slab.low <= slab.high;
}

// What friction with the ground takes of a speed, Q24. Down a slope that fails slip_soil drives it on. One that stands, with
// its tolerance or by cohesion, has friction: what slides there has to come to rest, and loses a unit at least.
int lost_to_friction(int source, int slot, ivec3 at, int slope) {
    int held = mixed_word(source, kSoilLoose, kTableFriction) + kSlipTolerance - slope;
    if (held < kSlipTolerance && wedge_at(resistance_of(source, slope), slope) <= standing_wedge(source, slot, at)) {
        held = kSlipTolerance;
    }
    if (held <= 0) return 0;
    int gravity = min(params.gravity_q16, kSlideSpeedMost) * kOneQ8 / params.slide_count;
    return max(1, mul_q16(gravity, fraction_q16(held, kOneQ16 + mul_q16(slope, slope))));
}

void take_speed(INOUT(Slab) slab, int lost) {
    if (lost >= slab.pace) {
        slab.speed = ivec2(0);
        slab.pace = 0;
        return;
    }
    ivec2 size = abs(slab.speed);
    slab.speed = sign(slab.speed) * (size - ivec2(mul_q16(lost, share_of(size.x, slab.pace)),
                                                  mul_q16(lost, share_of(size.y, slab.pace))));
    slab.pace -= lost;
}

// What drag in viscous soil leaves of it.
int kept_by_drag(int source) {
    if (mixed_word(source, 0, kTableViscosity) >= kOneQ16) return 0;
    return fraction_q16(kOneQ16, kOneQ16 + mixed_word(source, 0, kTableDrag) / params.slide_count);
}

void keep_speed(INOUT(Slab) slab, int kept) {
    slab.speed = sign(slab.speed) * ivec2(mul_q16(abs(slab.speed.x), kept), mul_q16(abs(slab.speed.y), kept));
    slab.pace = mul_q16(slab.pace, kept);
}

// Slope of the ground ahead along the speed: of the facet between the axis that it is nearer to and the diagonal, as slip_soil
// has them. drop: to the columns along x and along y.
int slope_ahead(int slot, int x, int y, int top, ivec2 ahead, ivec2 drop, IN(Slab) slab) {
    ivec2 speed = abs(slab.speed);
    bool is_x = speed.x >= speed.y;
    int along = is_x ? drop.x : drop.y;
    int across = is_x ? drop.y : drop.x;
    if (speed.x != 0 && speed.y != 0) {
        int diagonal = slide_drop(slot, x + ahead.x, y + ahead.y, top, slab.thickness);
        if (diagonal != kSlideWall) across = diagonal - along;
    }
    // By the ratio of the two: the pace of what hardly moves is a few units.
    int ratio = share_of(is_x ? speed.y : speed.x, is_x ? speed.x : speed.y);
    int length = slope_length(kOneQ16, ratio);
    return clamp(mul_q16(along, fraction_q16(kOneQ16, length)) + mul_q16(across, fraction_q16(ratio, length)), -kSlideSteepest,
                 kSlideSteepest);
}

// What bars the way takes the momentum along it, friction and drag take their part. ahead: see slide_soil().
void slow_slab(int slot, int x, int y, int top, int source, ivec2 ahead, INOUT(Slab) slab) {
    ivec2 drop = ivec2(slab.speed.x == 0 ? 0 : slide_drop(slot, x + ahead.x, y, top, slab.thickness),
                       slab.speed.y == 0 ? 0 : slide_drop(slot, x, y + ahead.y, top, slab.thickness));
    if (drop.x == kSlideWall) drop.x = slab.speed.x = 0;
    if (drop.y == kSlideWall) drop.y = slab.speed.y = 0;
    slab.pace = slope_length(slab.speed.x, slab.speed.y);
    if (slab.pace > 0) {
        int slope = slope_ahead(slot, x, y, top, ahead, drop, slab);
        take_speed(slab, lost_to_friction(source, slot, ivec3(x, y, slab.rubbing), slope));
    }
    if (params.deposits != 0 && slab.pace > 0) keep_speed(slab, kept_by_drag(source));
}

void write_speed(int first, IN(Slab) slab) {
    MomentumSum taken = no_momentum();
    for (int z = slab.low; z <= slab.high; ++z) {
        int voxel = first + z * kTileColumns;
        int mass = mass_at(voxel);
        ivec2 kept = ivec2(fine_momentum(mass, slab.speed.x), fine_momentum(mass, slab.speed.y));
        set_in_sum(voxel, ivec3(kept, state_at(kPlaneMomentumZ, voxel)), taken);
    }
    add_momentum_sums(kResultGround, taken);
}

// Where a slab goes: along x, along y, along both, as in thesis (15).
struct Arrivals {
    int share[3];  // of the slab, Q16
    int place[3];  // height at which it arrives, Q16 voxels
};

// The column of one of them.
ivec2 arrival_at(int k, int x, int y, ivec2 ahead) { return ivec2(k == 1 ? x : x + ahead.x, k == 0 ? y : y + ahead.y); }

// Returns the sum of the shares.
int find_arrivals(int slot, int x, int y, int top, ivec2 ahead, IN(Slab) slab, OUT(Arrivals) arrivals) {
    int share_x = min(kOneQ16, abs(slab.speed.x) / params.slide_count / kOneQ8);
    int share_y = min(kOneQ16, abs(slab.speed.y) / params.slide_count / kOneQ8);
    int wanted = 0;
    for (int k = 0; k < 3; ++k) {
        ivec2 to = arrival_at(k, x, y, ahead);
        int share = k == 2   ? mul_q16(share_x, share_y)
                    : k == 0 ? mul_q16(share_x, kOneQ16 - share_y)
                             : mul_q16(share_y, kOneQ16 - share_x);
        int drop = share > 0 ? slide_drop(slot, to.x, to.y, top, slab.thickness) : kSlideWall;
        arrivals.share[k] = drop == kSlideWall ? 0 : share;
        arrivals.place[k] = top - drop;
        wanted += arrivals.share[k];
    }
    return wanted;
}

// Part of a voxel's soil goes over to another column, from the height `place` up there, which it raises. Voxel by voxel, so that
// none is left half empty under others. Whether any goes, or waits for the next step to.
bool stack_soil(int slot, ivec2 to, int source, int held, int fraction, INOUT(int) place) {
    int part = fraction;
    bool goes = false;
    for (int n = 0; n < 3 && part > 0; ++n) {
        int target = voxel_at(slot, to.x, to.y, place >> 16);
        if (is_solid(target)) break;
        int room = kVoxelFull - (place & kLowHalf);
        int fits = n == 2 || room >= mul_q16(held, part) ? part : fraction_q16(room, held);
        if (moves_any(source, fits) && !are_listed(source, target)) return true;
        goes = move_soil(source, target, fits, true) || goes;
        place += fits == part ? mul_q16(held, part) : room;
        part -= fits;
    }
    return goes;
}

// The slab's shares go over, from its top down. Returns as stack_soil() does.
bool shift_slab(int slot, int x, int y, int first, ivec2 ahead, IN(Slab) slab, int wanted, INOUT(Arrivals) arrivals) {
    int amount = mul_q16(slab.thickness, min(wanted, kOneQ16));
    bool goes = false;
    for (int z = slab.high; z >= slab.low && amount > 0; --z) {
        int source = first + z * kTileColumns;
        int held = state_at(kPlaneVolume, source);
        int taken = min(amount, held);
        if (taken <= 0) continue;
        amount -= taken;
        bool waits = false;  // or goes
        int fraction = fraction_q16(taken, held);
        for (int k = 0; k < 3; ++k) {
            if (arrivals.share[k] == 0) continue;
            int part = mul_q16(fraction, fraction_q16(arrivals.share[k], wanted));
            int place = arrivals.place[k];
            waits = stack_soil(slot, arrival_at(k, x, y, ahead), source, held, part, place) || waits;
            arrivals.place[k] = place;
        }
        if (waits && !is_listed(source)) return true;  // see shed_soil()
        goes = goes || waits;
    }
    return goes;
}

// Nothing slides under a body, nor under terrain.
void stop_column(int first, int end) {
    MomentumSum taken = no_momentum();
    for (int z = 0; z < end; ++z) {
        int voxel = first + z * kTileColumns;
        if (state_at(kPlaneSupport, voxel) == kSupportGround && slides_along(voxel)) {
            set_in_sum(voxel, ivec3(0, 0, state_at(kPlaneMomentumZ, voxel)), taken);
        }
    }
    add_momentum_sums(kResultGround, taken);
}

int slide_soil_lanes(int group, int half_at) {
    return changed_half(entry_slot(block_list[params.list_offset + group]), half_at, params.slide_stamp);
}

void slide_soil(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int x = lane & 7;
    int y = lane >> 3;
    int column = slot * kTileColumns + lane;
    int first = slot * params.tile_voxels + lane;
    int top = spans[column_word(kColumnSurface, column)];
    int end = min(params.height, spans[column_word(kColumnEnd, column)]);
    if (top > 0) top = close_gaps(first, top, end);
    if (top <= 0) {
        stop_column(first, end);
        return;
    }
    Slab slab;
    if (!find_slab(first, top, slab)) return;
    ivec2 ahead = ivec2(slab.speed.x < 0 ? -1 : 1, slab.speed.y < 0 ? -1 : 1);  // to the columns that the slab slides to
    int source = first + slab.high * kTileColumns;
    slow_slab(slot, x, y, top, first + slab.rubbing * kTileColumns, ahead, slab);
    write_speed(first, slab);
    if (slab.speed.x == 0 && slab.speed.y == 0) return;
    mark_moved(source, source);
    // So many passes more: see Passes::slide_part_count.
    ATOMIC_MAX(result[kResultSlide], min(slab.pace / kOneQ8, kSlideSpeedMost));
    Arrivals arrivals;
    int wanted = find_arrivals(slot, x, y, top, ahead, slab, arrivals);
    bool goes = wanted > 0 && shift_slab(slot, x, y, first, ahead, slab, wanted, arrivals);
    // Too slow for a share to leave: unless slip_soil drives it, it is at rest. Without friction it would be in motion for good,
    // and with little for long: a unit of momentum goes in a pass, or none. What slip_soil sees may be another slope: the edge of
    // a ledge is as high as what lies on it.
    if (!goes && spans[column_word(kColumnSlides, column)] == 0) {
        slab.speed = ivec2(0);
        write_speed(first, slab);
    }
}
