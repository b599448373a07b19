// Soil that slides on: what slip_soil or a fall has set in motion along the ground goes on until friction has taken its
// momentum, also over slopes that are stable: see slow_slides. Its thickness times its speed goes over to the columns ahead, from
// the top down here and from the surface up there, as that is when what leaves there has left.
// Reads: surfaces, sinkages, slips, stamps, coverage, terrain, all transported planes. Writes: deltas, momentum, its sums, stamps.

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

// By how much the ground of a column there is lower when what slides has left it.
int sinkage_at(int slot, ivec2 at) { return spans[column_word(kColumnSinks, column_at(slot, at.x, at.y))]; }

// The slab's shares go over, from its top down. Returns as stack_soil() does.
bool shift_slab(int slot, int x, int y, int first, IN(Slab) slab, INOUT(Arrivals) arrivals) {
    ivec2 ahead = way_ahead(slab);
    for (int k = 0; k < 3; ++k) {
        if (arrivals.share[k] > 0) arrivals.place[k] -= sinkage_at(slot, arrival_at(k, x, y, ahead));
    }
    int amount = leaving_amount(slab, arrivals);
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
            int part = mul_q16(fraction, fraction_q16(arrivals.share[k], arrivals.wanted));
            int place = arrivals.place[k];
            waits = stack_soil(slot, arrival_at(k, x, y, ahead), source, held, part, place) || waits;
            arrivals.place[k] = place;
        }
        if (waits && !is_listed(source)) return true;  // see shed_soil()
        goes = goes || waits;
    }
    return goes;
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
    int top = spans[column_word(kColumnSlideTop, column)];
    Slab slab;
    if (top <= 0 || !find_slab(first, top, slab)) return;
    if (slab.pace == 0) {  // what friction has left of its momentum is no speed any more
        write_speed(first, slab);
        return;
    }
    int source = first + slab.high * kTileColumns;
    mark_moved(source, source);
    // So many passes more: see Passes::slide_part_count.
    ATOMIC_MAX(result[kResultSlide], min(slab.pace / kOneQ8, kSlideSpeedMost));
    Arrivals arrivals;
    find_arrivals(slot, x, y, top, slab, arrivals);
    bool goes = arrivals.wanted > 0 && shift_slab(slot, x, y, first, slab, arrivals);
    // Too slow for a share to leave: unless slip_soil drives it, it is at rest. Without friction it would be in motion for good,
    // and with little for long: a unit of momentum goes in a pass, or none. What slip_soil sees may be another slope: the edge of
    // a ledge is as high as what lies on it.
    if (!goes && spans[column_word(kColumnSlides, column)] == 0) {
        slab.speed = ivec2(0);
        write_speed(first, slab);
    }
}
