// Soil that slides on, before it does: what bars its way, friction and drag take their part of its momentum, and every column says
// by how much its surface sinks as its share leaves. What slides onto it in the same pass arrives down there: no gap is left.
// Reads: surfaces, slips, cuts, stamps, coverage, terrain, all transported planes, tables. Writes: momentum, its sums, sinkages.

CONST_INT(kSlideSteepest, 262144)   // slope 4: beyond it friction is next to nothing

// Part of what lies in a voxel, down into the one below, which has room for it. Both are this lane's own. A push does not
// go along: it would stay, since neither is in excess (thesis (35), second case).
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

// What slips off a column's top makes room under what slips onto it in the same pass: no more than kSlideCreep. Lets what lies on
// such gaps down, from the surface up, and returns the height of the surface then. A fall through more is advect_soil's.
int close_gaps(int first, int top, int end) {
    int to = top >> 16;
    int z = to + 1;
    for (; z < end; ++z) {
        int from = first + z * kTileColumns;
        int under = from - kTileColumns;
        int held = state_at(kPlaneVolume, from);
        int room = kVoxelFull - coverage_at(under) - state_at(kPlaneVolume, under);
        if (held == 0 || is_solid(from) || room <= 0 || room > kSlideCreep) break;
        drop_soil(from, under, room >= held ? kOneQ16 : fraction_q16(room, held));
        to = room >= held ? z - 1 : z;
    }
    if (z == (top >> 16) + 1) return top;
    return to * kVoxelFull + min(kVoxelFull, state_at(kPlaneVolume, first + to * kTileColumns));
}

// What friction with the ground takes of a speed, Q24. What lets rough soil stand steeper than phi holds what slides there, too.
// Down a slope that fails slip_soil drives it on. One that stands, with its tolerance or by cohesion, has friction: what slides
// there has to come to rest, and loses a unit at least.
int lost_to_friction(int source, int slot, ivec3 at, int slope) {
    int standing = standing_wedge(source, slot, at);
    int held = mixed_word(source, kSoilLoose, kTableFriction) + min(standing, kSlideSteepest) - slope;
    if (held < kSlipTolerance && wedge_at(resistance_of(source, slope), slope) <= standing) held = kSlipTolerance;
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

// How high the soil on top of a column whose surface is at `top` lies over what it rests on: the floor, a body or terrain.
int height_on_ledge(int column, int top) {
    int record = column * kColumnWords;
    for (int i = spans[record + kColumnCount] - 1; i >= 0; --i) {
        int at = record + kColumnSpans + i * kSpanWords;
        if (spans[at + kSpanKind] == kSpanPiled && spans[at + kSpanTop] == top) return top - spans[at + kSpanBottom];
    }
    return top;
}

// Slope of the ground ahead along the speed: of the facet between the axis that it is nearer to and the diagonal, as slip_soil
// has them. drop: to the columns along x and along y. most: of all drops. At the edge of a ledge soil falls as far as it is high
// there, for slip_soil too: what lies on the ledge has friction with it, however deep the ground lies beyond.
int slope_ahead(int slot, int x, int y, int top, int most, ivec2 ahead, ivec2 drop, IN(Slab) slab) {
    ivec2 speed = abs(slab.speed);
    bool is_x = speed.x >= speed.y;
    int along = min(most, is_x ? drop.x : drop.y);
    int across = min(most, is_x ? drop.y : drop.x);
    if (speed.x != 0 && speed.y != 0) {
        int diagonal = slide_drop(slot, x + ahead.x, y + ahead.y, top, slab.thickness);
        if (diagonal != kSlideWall) across = min(most, diagonal) - along;
    }
    // By the ratio of the two: the pace of what hardly moves is a few units.
    int ratio = share_of(is_x ? speed.y : speed.x, is_x ? speed.x : speed.y);
    int length = slope_length(kOneQ16, ratio);
    return clamp(mul_q16(along, fraction_q16(kOneQ16, length)) + mul_q16(across, fraction_q16(ratio, length)), -kSlideSteepest,
                 kSlideSteepest);
}

// What bars the way takes the momentum along it, friction and drag take their part. on_ledge: see slope_ahead.
void slow_slab(int slot, int x, int y, int top, int on_ledge, int source, INOUT(Slab) slab) {
    ivec2 ahead = way_ahead(slab);
    ivec2 drop = ivec2(slab.speed.x == 0 ? 0 : slide_drop(slot, x + ahead.x, y, top, slab.thickness),
                       slab.speed.y == 0 ? 0 : slide_drop(slot, x, y + ahead.y, top, slab.thickness));
    if (drop.x == kSlideWall) drop.x = slab.speed.x = 0;
    if (drop.y == kSlideWall) drop.y = slab.speed.y = 0;
    slab.pace = slope_length(slab.speed.x, slab.speed.y);
    if (slab.pace > 0) {
        int slope = slope_ahead(slot, x, y, top, on_ledge, ahead, drop, slab);
        take_speed(slab, lost_to_friction(source, slot, ivec3(x, y, slab.rubbing), slope));
    }
    if (params.deposits != 0 && slab.pace > 0) keep_speed(slab, kept_by_drag(source));
}

// Nothing slides under a body, nor under terrain. What has come there in this step has no support until find_support looks: it is
// stopped by the look after that, which nothing else may ask for.
void stop_column(int slot, int lane, int first, int end) {
    MomentumSum taken = no_momentum();
    for (int z = 0; z < end; ++z) {
        int voxel = first + z * kTileColumns;
        if (!slides_along(voxel)) continue;
        int support = state_at(kPlaneSupport, voxel);
        if (support == kSupportGround) set_in_sum(voxel, ivec3(0, 0, state_at(kPlaneMomentumZ, voxel)), taken);
        if (support == kSupportNone) stamp_column(slot, lane);
    }
    add_momentum_sums(kResultGround, taken);
}

// By how much the surface sinks as the slab's share leaves from its top down. It must not go by which blocks are listed: soil from
// a snapshot has others.
int sinkage_of(int slot, int x, int y, int first, int top, IN(Slab) slab) {
    Arrivals arrivals;
    find_arrivals(slot, x, y, top, slab, arrivals);
    int left = leaving_amount(slab, arrivals);
    if (left == 0) return 0;
    int z = slab.high;
    for (; z >= slab.low && state_at(kPlaneVolume, first + z * kTileColumns) <= left; --z) {
        left -= state_at(kPlaneVolume, first + z * kTileColumns);
    }
    if (z < 0) return top;
    return max(0, top - z * kVoxelFull - min(kVoxelFull, max(0, state_at(kPlaneVolume, first + z * kTileColumns) - left)));
}

int slow_slides_lanes(int group, int half_at) {
    return changed_half(entry_slot(block_list[params.list_offset + group]), half_at, params.slide_stamp);
}

void slow_slides(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int x = lane & 7;
    int y = lane >> 3;
    int column = slot * kTileColumns + lane;
    int first = slot * params.tile_voxels + lane;
    int top = spans[column_word(kColumnSurface, column)];
    int end = min(params.height, spans[column_word(kColumnEnd, column)]);
    int closed = top <= 0 ? top : close_gaps(first, top, end);
    int sinkage = 0;
    Slab slab;
    if (top <= 0) {
        stop_column(slot, lane, first, end);
    } else if (find_slab(first, closed, slab)) {
        int on_ledge = height_on_ledge(column, top) - (top - closed);
        slow_slab(slot, x, y, closed, on_ledge, first + slab.rubbing * kTileColumns, slab);
        write_speed(first, slab);
        if (slab.pace > 0) sinkage = sinkage_of(slot, x, y, first, closed, slab);
    }
    spans[column_word(kColumnSlideTop, column)] = closed;
    spans[column_word(kColumnSinks, column)] = top - closed + sinkage;
}
