// What slides on, for slow_slides and slide_soil: the voxels of a column that have momentum along the ground slide as one, its
// slab, and go over to the columns ahead.

CONST_INT(kSlideGap, 4)         // voxels without momentum under which none is looked for
CONST_INT(kSlideDepth, 128)     // voxels at most that slide: sums over them stay in 31 bits
CONST_INT(kSlideCreep, 8192)    // height of a failing wedge that still slips where soil slides, 1/8 voxel
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
    slab.pace = slope_length(slab.speed.x, slab.speed.y);
    return slab.low <= slab.high;
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
    int wanted;    // sum of the shares
};

// To the columns that a slab slides to.
ivec2 way_ahead(IN(Slab) slab) { return ivec2(slab.speed.x < 0 ? -1 : 1, slab.speed.y < 0 ? -1 : 1); }

// The column of an arrival.
ivec2 arrival_at(int k, int x, int y, ivec2 ahead) { return ivec2(k == 1 ? x : x + ahead.x, k == 0 ? y : y + ahead.y); }

void find_arrivals(int slot, int x, int y, int top, IN(Slab) slab, OUT(Arrivals) arrivals) {
    ivec2 ahead = way_ahead(slab);
    int share_x = min(kOneQ16, abs(slab.speed.x) / params.slide_count / kOneQ8);
    int share_y = min(kOneQ16, abs(slab.speed.y) / params.slide_count / kOneQ8);
    arrivals.wanted = 0;
    for (int k = 0; k < 3; ++k) {
        ivec2 to = arrival_at(k, x, y, ahead);
        int share = k == 2   ? mul_q16(share_x, share_y)
                    : k == 0 ? mul_q16(share_x, kOneQ16 - share_y)
                             : mul_q16(share_y, kOneQ16 - share_x);
        int drop = share > 0 ? slide_drop(slot, to.x, to.y, top, slab.thickness) : kSlideWall;
        arrivals.share[k] = drop == kSlideWall ? 0 : share;
        arrivals.place[k] = top - drop;
        arrivals.wanted += arrivals.share[k];
    }
}

// How much of a slab leaves, Q16 voxels of soil.
int leaving_amount(IN(Slab) slab, IN(Arrivals) arrivals) { return mul_q16(slab.thickness, min(arrivals.wanted, kOneQ16)); }
