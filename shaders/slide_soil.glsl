// Soil that slides on: what slip_soil or a fall has set in motion along the ground goes on until friction has taken its
// momentum, also over slopes that are stable. The voxels of a column that have momentum slide as one. Their thickness times
// their speed goes over to the columns ahead, from the top down here and from the surface up there.
// Reads: surfaces, stamps, coverage, terrain, all transported planes, tables. Writes: deltas, momentum, stamps.

CONST_INT(kSlideGap, 4)         // voxels without momentum under which none is looked for
CONST_INT(kSlideDepth, 128)     // voxels at most that slide: sums over them stay in 31 bits
CONST_INT(kSlideSteepest, 262144)   // slope 4: beyond it friction is next to nothing
CONST_INT(kSlideSpeedMost, 1048576)

int slide_soil_lanes(int group, int half_at) {
    return changed_half(entry_slot(block_list[params.list_offset + group]), half_at, params.slide_stamp);
}

void stop_voxel(int voxel) {
    set_state(kPlaneMomentumX, voxel, 0);
    set_state(kPlaneMomentumY, voxel, 0);
}

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
    return drop < -max(kVoxelFull, thickness) ? kSlideWall : drop;
}

// Part of what lies in a voxel, down into the one below. Both are this lane's own.
void drop_soil(int from, int to, int fraction) {
    for (int i = 0; i < params.transport_count; ++i) {
        int plane = kTransportFirst + i;
        int held = state_at(plane, from);
        int share = fraction >= kOneQ16 ? held : mul_q16(held, fraction);
        set_state(plane, from, held - share);
        set_state(plane, to, state_at(plane, to) + share);
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

void slide_soil(int group, int lane) {
    int slot = entry_slot(block_list[params.list_offset + group]);
    int x = lane & 7;
    int y = lane >> 3;
    int column = slot * kTileColumns + lane;
    int first = slot * params.tile_voxels + lane;
    int top = spans[column_word(kColumnSurface, column)];
    int end = min(params.height, spans[column_word(kColumnEnd, column)]);
    if (top > 0) top = close_gaps(first, top, end);
    int high = top > 0 ? (top - 1) >> 16 : -1;
    int low = high + 1;
    int mass = 0;
    int thickness = 0;
    int sum_x = 0;  // of momentum, 128ths
    int sum_y = 0;
    int gap = 0;
    for (int z = high; z > high - kSlideDepth && z >= 0 && gap < kSlideGap; --z) {
        int voxel = first + z * kTileColumns;
        if (is_solid(voxel)) break;
        if (slides_along(voxel)) {
            sum_x += state_at(kPlaneMomentumX, voxel) / kSlideDepth;
            sum_y += state_at(kPlaneMomentumY, voxel) / kSlideDepth;
            low = z;
            gap = 0;
        } else {
            gap += 1;
        }
    }
    for (int z = 0; top <= 0 && z < end; ++z) {  // nothing slides under a body, nor under terrain
        int voxel = first + z * kTileColumns;
        if (state_at(kPlaneSupport, voxel) == kSupportGround && slides_along(voxel)) stop_voxel(voxel);
    }
    if (low > high) return;
    for (int z = low; z <= high; ++z) {
        int voxel = first + z * kTileColumns;
        mass += mass_at(voxel);
        thickness += state_at(kPlaneVolume, voxel);
    }
    ivec2 speed = ivec2(0);
    if (mass > 0) {
        speed = clamp(ivec2(signed_fraction_q16(sum_x, mass * 8), signed_fraction_q16(sum_y, mass * 8)),
                      ivec2(-kSlideSpeedMost), ivec2(kSlideSpeedMost));
    }
    // What bars the way takes the momentum along it.
    ivec2 ahead = ivec2(speed.x < 0 ? -1 : 1, speed.y < 0 ? -1 : 1);
    int drop_x = speed.x == 0 ? 0 : slide_drop(slot, x + ahead.x, y, top, thickness);
    int drop_y = speed.y == 0 ? 0 : slide_drop(slot, x, y + ahead.y, top, thickness);
    if (drop_x == kSlideWall) speed.x = 0;
    if (drop_y == kSlideWall) speed.y = 0;
    int pace = slope_length(speed.x, speed.y);
    if (pace > 0) {
        // Down a slope that fails slip_soil drives it on.
        int slope = clamp(mul_q16(speed.x == 0 ? 0 : drop_x, fraction_q16(abs(speed.x), pace)) +
                              mul_q16(speed.y == 0 ? 0 : drop_y, fraction_q16(abs(speed.y), pace)),
                          -kSlideSteepest, kSlideSteepest);
        int source = first + high * kTileColumns;
        int held = mixed_word(source, is_bonded(source) ? 0 : 1, kTableFriction) - slope;
        if (held > 0) {
            int gravity = params.gravity_q16 / params.slide_count;
            int lost = mul_q16(gravity, fraction_q16(held, kOneQ16 + mul_q16(slope, slope))) + 1;
            int kept = lost >= pace ? 0 : fraction_q16(pace - lost, pace);
            speed = ivec2(sign(speed.x) * mul_q16(abs(speed.x), kept), sign(speed.y) * mul_q16(abs(speed.y), kept));
            pace = mul_q16(pace, kept);
        }
    }
    if (params.deposits != 0 && pace > 0) {
        int source = first + high * kTileColumns;
        bool is_fixed = mixed_word(source, 0, kTableViscosity) >= kOneQ16;
        int kept = is_fixed ? 0 : fraction_q16(kOneQ16, kOneQ16 + mixed_word(source, 0, kTableDrag) / params.slide_count);
        speed = ivec2(sign(speed.x) * mul_q16(abs(speed.x), kept), sign(speed.y) * mul_q16(abs(speed.y), kept));
        pace = mul_q16(pace, kept);
    }
    for (int z = low; z <= high; ++z) {
        int voxel = first + z * kTileColumns;
        int held = mass_at(voxel) * 64;
        set_state(kPlaneMomentumX, voxel, mul_q16(held, speed.x * 16));
        set_state(kPlaneMomentumY, voxel, mul_q16(held, speed.y * 16));
    }
    if (speed.x == 0 && speed.y == 0) return;
    mark_moved(first + high * kTileColumns, first + high * kTileColumns);
    ATOMIC_MAX(result[kResultSlope], min(pace, kSlideSpeedMost) / 2 - kOneQ16 / 4);  // so many passes more: see Passes::slip
    int share_x = min(kOneQ16, abs(speed.x) / params.slide_count);
    int share_y = min(kOneQ16, abs(speed.y) / params.slide_count);
    int share[3];  // of what slides: along x, along y, along both, as in thesis (15)
    int place[3];  // height at which it arrives
    int wanted = 0;
    for (int k = 0; k < 3; ++k) {
        int to_x = k == 1 ? x : x + ahead.x;
        int to_y = k == 0 ? y : y + ahead.y;
        share[k] = k == 2   ? mul_q16(share_x, share_y)
                   : k == 0 ? mul_q16(share_x, kOneQ16 - share_y)
                            : mul_q16(share_y, kOneQ16 - share_x);
        int drop = share[k] > 0 ? slide_drop(slot, to_x, to_y, top, thickness) : kSlideWall;
        if (drop == kSlideWall) share[k] = 0;
        place[k] = top - drop;
        wanted += share[k];
    }
    if (wanted == 0) return;
    int amount = mul_q16(thickness, min(wanted, kOneQ16));
    for (int z = high; z >= low && amount > 0; --z) {
        int source = first + z * kTileColumns;
        int held = state_at(kPlaneVolume, source);
        int taken = min(amount, held);
        if (taken <= 0) continue;
        amount -= taken;
        int fraction = fraction_q16(taken, held);
        for (int k = 0; k < 3; ++k) {
            if (share[k] == 0) continue;
            int part = mul_q16(fraction, fraction_q16(share[k], wanted));
            // Voxel by voxel up from the surface there, so that none is left half empty under others.
            for (int n = 0; n < 3 && part > 0; ++n) {
                int target = voxel_at(slot, k == 1 ? x : x + ahead.x, k == 0 ? y : y + ahead.y, place[k] >> 16);
                if (is_closed(target)) break;
                int room = kVoxelFull - (place[k] & kLowHalf);
                int fits = n == 2 || room >= mul_q16(held, part) ? part : fraction_q16(room, held);
                move_soil(source, target, fits, true);
                place[k] += fits == part ? mul_q16(held, part) : room;
                part -= fits;
            }
        }
    }
}
