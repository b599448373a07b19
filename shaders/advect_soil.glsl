// Ballistic motion, thesis (21) to (29): each voxel's soil is displaced by its velocity and shared out over the voxels it
// then overlaps (13) to (16); locked voxels give it back without velocity (24). Supported soil rests; soil on a moving
// body goes with the body as far as friction can take it (thesis 5.3.1 lists its absence as a defect), before the wall
// behind it and after the wall before it, but not against a wall of something else.
// Reads: all planes. Writes: deltas; the momentum of soil that rests; sums of momentum.

// thesis (24): a full voxel is locked, unless its soil is itself falling or carried away. Soil caught in a wall moves
// with the wall along it and out of it.
bool is_locked(int from, int to, ivec3 step, ivec3 out_way, bool overrun) {
    if (is_barred(from, to, step, out_way, overrun)) return true;
    return state_at(kPlaneSupport, to) == kSupportGround && is_full(to);
}

// Whole voxels as often as the drift is long: on average as far as it should. Each axis has a chance of its own, so that a crumb
// goes to a corner as often as thesis (15) has shares there. With one chance for all it went no way that is barred along its
// fastest axis: a crumb that wind pressed to a wall did not come down. at: in the grid.
CONST_INT(kChanceApart, 16384)  // the longest grid: beyond its end there are chances that no voxel has
ivec3 whole_voxels(ivec3 drift, ivec3 at) {
    ivec3 chance = ivec3(voxel_chance(at), voxel_chance(at + ivec3(kChanceApart, 0, 0)),
                         voxel_chance(at + ivec3(0, kChanceApart, 0)));
    return ivec3(abs(drift.x) > chance.x ? sign(drift.x) : 0, abs(drift.y) > chance.y ? sign(drift.y) : 0,
                 abs(drift.z) > chance.z ? sign(drift.z) : 0) *
           kVoxelFull;
}

ivec3 share_of(ivec3 amount, int share) {
    return ivec3(mul_q16(amount.x, share), mul_q16(amount.y, share), mul_q16(amount.z, share));
}

// The part of `value` from 0 to `bound`.
int towards(int value, int bound) { return clamp(value, min(0, bound), max(0, bound)); }

// Shares along the axes: the drift, but for carried soil no less than what the wall behind it has left no room for. The
// voxel's soil lies before that wall, so that a slice as thick as the drift is more of it than the drift is of a voxel.
ivec3 drift_weight(int slot, ivec3 at, int voxel, ivec3 drift) {
    ivec3 weight = abs(drift);
    int volume = state_at(kPlaneVolume, voxel);
    int excess = min(volume, volume + body_coverage(voxel) - kVoxelFull);
    if (excess <= 0 || !is_carried_here(voxel)) return weight;
    ivec3 inwards = body_gradient(slot, at.x, at.y, at.z);
    int share = fraction_q16(excess, volume);
    int most = largest_component(drift);
    ivec3 least = ivec3(mul_q16(share, fraction_q16(weight.x, most)), mul_q16(share, fraction_q16(weight.y, most)),
                        mul_q16(share, fraction_q16(weight.z, most)));
    return ivec3(sign(drift.x) * sign(inwards.x) < 0 ? max(weight.x, least.x) : weight.x,
                 sign(drift.y) * sign(inwards.y) < 0 ? max(weight.y, least.y) : weight.y,
                 sign(drift.z) * sign(inwards.z) < 0 ? max(weight.z, least.z) : weight.z);
}

// Whether the wall of a body recedes in a voxel that it covers: goes the way its coverage rises, within 60 deg.
bool is_receding(int slot, ivec3 at, int body) {
    ivec3 move = body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z)) / params.body_substep_count;
    ivec3 inwards = body_gradient(slot, at.x, at.y, at.z);
    int most = largest_component(move);
    int steep = largest_component(inwards);
    return most > 0 && most <= kFollowMost && steep > 0 &&
           is_within_60_deg(direction_q16(move, most), direction_q16(inwards, steep));
}

// Room for soil of `from` in a voxel `to`, at (x, y, z) `at`, that is closed to it. Carried soil follows the wall before
// it into the voxel that the wall's face crosses: if it waited until that voxel is open it would be pressed up, and fall
// in late. 0 elsewhere.
int room_at_face(int slot, ivec3 at, int from, int to) {
    int body = state_at(kPlaneSupport, from) - kSupportBody;
    if (to < 0 || body < 0 || is_caught(from) || !is_caught(to) || owner_body(state_at(kPlaneOwner, to)) != body ||
        block_flags[flag_index(kFlagListed, to >> 9)] == 0 || !is_receding(slot, at, body)) {
        return 0;
    }
    return max(0, kVoxelFull - coverage_at(to) - state_at(kPlaneVolume, to));
}

// Momentum of a mass at `at` that moves with the receding wall in a voxel `to`, at `target`; zero where there is none.
ivec3 momentum_with_wall(int slot, ivec3 at, int mass, ivec3 target, int to) {
    int body = to < 0 || !is_caught(to) ? -1 : owner_body(state_at(kPlaneOwner, to));
    if (body < 0 || shapes[body * kBodyWords + kBodyMoving] == 0 || !is_receding(slot, target, body)) {
        return ivec3(0);
    }
    ivec3 velocity = body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z));
    return momentum_of(mass, clamp(velocity, ivec3(-kSpeedMost), ivec3(kSpeedMost)));
}

// The ground takes the momentum of soil that comes to lie on it. What goes along it goes on, less by friction with what the
// fall has pressed on it: see slide_soil.
void land(int voxel, ivec3 momentum) {
    int along = max(abs(momentum.x), abs(momentum.y));
    int kept = 0;
    if (params.slides != 0 && along > 0) {
        int lost = mul_q16(max(0, -momentum.z), mixed_word(voxel, kSoilLoose, kTableFriction));
        int whole = slope_length(momentum.x, momentum.y);
        kept = lost >= whole ? 0 : momentum.z == 0 ? kOneQ16 : kOneQ16 - fraction_q16(lost >> 4, (whole >> 4) + 1);
    }
    set_by_ground(voxel, ivec3(sign(momentum.x) * mul_q16(abs(momentum.x), kept),
                               sign(momentum.y) * mul_q16(abs(momentum.y), kept), 0));
}

#include "soil_air.glsl"

// --- one voxel's soil

// How soil moves in a step, voxels Q16.
struct Motion {
    ivec3 drift;
    ivec3 after;  // velocity at the step's end
};

// A body takes momentum of soil, or ground where there is none.
void take_momentum(int body, ivec3 momentum) {
    if (body < 0) {
        add_momentum_sum(kResultGround, momentum);
    } else {
        note_given(body, -momentum);
    }
}

#include "held_load.glsl"

// What of a change in a base step takes place in this part of it: in all parts together all of it, to the unit.
int in_this_part(int change) {
    int whole = change / params.substep_count;
    int rest = change - whole * params.substep_count;
    if (rest == 0) return whole;
    return whole + (rest * (params.substep + 1)) / params.substep_count - (rest * params.substep) / params.substep_count;
}

// Kick after drift, drift at the middle of the step: exact for constant gravity, thesis (29).
Motion fall_freely(int slot, ivec3 at, int voxel, ivec3 velocity) {
    int gravity = in_this_part(params.gravity_q16);
    Motion motion;
    motion.drift = velocity - ivec3(0, 0, gravity / 2);
    motion.after = velocity - ivec3(0, 0, gravity);
    int taken = params.air == 0 ? 0 : in_this_part(mixed_word(voxel, 0, kTableAir));
    if (taken > 0) {
        // Drag goes by the speed against the air, in the middle of the step: at its fall speed soil keeps its speed.
        int drag = min(taken, kAirOfStep);
        int share = share_in_air(drag);
        motion.after = velocity + taken_by_air(slot, at, velocity, share);
        int fall = gravity - mul_q16(gravity, share) / 2;
        motion.after.z -= taken > drag ? mul_q16(fall, fraction_q16(drag, taken)) : fall;
        motion.drift = (velocity + motion.after) / 2;
    }
    if (motion.after.z < -params.arch_speed) {
        int most = arch_speed(slot, at, voxel);
        motion.after.z = max(motion.after.z, -most);
        motion.drift.z = max(motion.drift.z, -most);
    }
    return motion;
}

// Whether air takes of its speed what soil in a voxel falls at: in the end it falls no faster.
bool is_slowed_by_air(int voxel) { return params.air != 0 && mixed_word(voxel, 0, kTableAir) > 0; }

// What friction takes of a level speed that is missing: of all its ways the same. Along an axis to the unit; aslant a unit at least
// where there is any, or what little friction there is would never end a slide.
ivec2 gripped(ivec2 missing, int grip) {
    if (missing.x == 0 || missing.y == 0) return clamp(missing, ivec2(-grip), ivec2(grip));
    int size = slope_length(missing.x, missing.y);
    if (size <= grip) return missing;
    int share = fraction_q16(grip, size);
    ivec2 taken = ivec2(sign(missing.x) * mul_q16(abs(missing.x), share), sign(missing.y) * mul_q16(abs(missing.y), share));
    if (grip == 0 || taken.x != 0 || taken.y != 0) return taken;
    return abs(missing.x) >= abs(missing.y) ? ivec2(sign(missing.x), 0) : ivec2(0, sign(missing.y));
}

// Soil on a body goes with it as far as friction can take it.
Motion go_with_body(int slot, ivec3 at, int voxel, int body, ivec3 velocity) {
    ivec3 goal = body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z));
    int friction = shapes[body * kBodyWords + kBodyFriction];
    int hold = friction == kFrictionOfSoil ? mixed_word(voxel, 0, kTableTool) : friction;
    int grip = in_this_part(hold);
    ivec2 taken = gripped(ivec2(goal.x - velocity.x, goal.y - velocity.y), grip);
    Motion motion;
    motion.after = ivec3(velocity.x + taken.x, velocity.y + taken.y,
                         max(goal.z, velocity.z - in_this_part(params.gravity_q16)));
    motion.drift = motion.after;
    return motion;
}

Motion slow_enough(int slot, ivec3 at, Motion motion) {
    if (largest_component(motion.after) <= kSpeedMost) return motion;
    note_condition(kStatusSpeedClamped, kResultSpeedPlace, grid_voxel(slot, at.x, at.y, at.z));
    Motion slower;
    slower.after = clamp(motion.after, ivec3(-kSpeedMost), ivec3(kSpeedMost));
    slower.drift = clamp(motion.drift, ivec3(-kSpeedMost), ivec3(kSpeedMost));
    return slower;
}

// How far soil drifts in a part of the step: a voxel at most. What a body throws in this step has not asked for parts, and is late
// by what is beyond; it has them from the next step on. Dust neither asks for parts nor counts as clamped: rounding alone can make
// its speed jump. Nor does what two parcels of dust may have come together to: neither has asked in the step before.
ivec3 drift_in_substep(int slot, ivec3 at, int volume, ivec3 drift_in_step, INOUT(int) fastest) {
    int speed = largest_component(drift_in_step);
    if (volume > kPacingLeast) fastest = max(fastest, speed);
    if (volume > 2 * kPacingLeast && speed > params.resolved_most) {
        note_condition(kStatusSpeedClamped, kResultSpeedPlace, grid_voxel(slot, at.x, at.y, at.z));
    }
    ivec3 drift = drift_in_step / params.substep_count;
    drift = clamp(drift, ivec3(-kVoxelFull), ivec3(kVoxelFull));
    return volume <= kWholeMost ? whole_voxels(drift, grid_voxel(slot, at.x, at.y, at.z)) : drift;
}

void add_momentum(int voxel, ivec3 momentum) {
    add_delta(kPlaneMomentumX, voxel, momentum.x);
    add_delta(kPlaneMomentumY, voxel, momentum.y);
    add_delta(kPlaneMomentumZ, voxel, momentum.z);
}

// Parts of a parcel's momentum: to seven corners, each in what goes on and what is barred. A bound, no choice: larger loses
// nothing that soil ever has; smaller may be passed by rounding.
CONST_INT(kSharesMost, 16)

// A voxel's soil that drifts.
struct Parcel {
    ivec3 at;
    int voxel;
    int volume;
    int mass;
    ivec3 momentum;  // after the kick, moved with the soil
    ivec3 out_way;   // see way_out()
    bool overrun;
    bool falls;      // rests on nothing
};

// A share of it goes over to another voxel, with its momentum: that is extensive, so the average comes by itself, thesis (28).
void carry_share(int voxel, int to, int share, ivec3 momentum) {
    int moved_volume = 0;
    int moved_mass = 0;
    for (int i = 0; i < params.transport_count; ++i) {
        int plane = kTransportFirst + i;
        if (plane >= kPlaneMomentumX && plane <= kPlaneMomentumZ) continue;
        int units = mul_q16(state_at(plane, voxel), share);  // thesis (23)
        add_delta(plane, voxel, -units);
        if (plane == kPlaneVolume) {
            moved_volume = units;
        } else if (plane != kPlaneBond) {
            add_delta(plane, to, units);
        }
        if (is_mass(plane)) moved_mass += units;
    }
    add_delta(kPlaneVolume, to, loosened(voxel, moved_volume, moved_mass));
    add_momentum(to, momentum);
    mark_moved(voxel, to);
}

// What bars the way takes momentum: a wall is its body's, the rest is ground.
void take_at_wall(int to, ivec3 momentum) {
    take_momentum(to < 0 || !is_caught(to) ? kOnGround : owner_body(state_at(kPlaneOwner, to)), momentum);
}

// A share of a parcel goes a step on, as far as nothing bars it. Returns the momentum that leaves its voxel, or that what bars
// the way takes.
ivec3 give_share(int slot, IN(Parcel) parcel, ivec3 step, int wanted) {
    ivec3 target = parcel.at + step;
    int to = voxel_at(slot, target.x, target.y, target.z);
    int share = wanted;
    ivec3 lost = ivec3(0);
    if (is_locked(parcel.voxel, to, step, parcel.out_way, parcel.overrun)) {
        int room = room_at_face(slot, target, parcel.voxel, to);
        share = min(wanted, fraction_q16(min(room, parcel.volume), parcel.volume));
    }
    int barred = wanted - share;
    if (barred > 0) {  // thesis (24): backflow, with zero velocity; with the wall's where that recedes
        ivec3 held = share_of(parcel.momentum, barred);
        ivec3 bound = share_of(momentum_with_wall(slot, parcel.at, parcel.mass, target, to), barred);
        lost = held - ivec3(towards(held.x, bound.x), towards(held.y, bound.y), towards(held.z, bound.z));
        take_at_wall(to, lost);
    }
    if (share <= 0) return lost;
    ivec3 part = share_of(parcel.momentum, share);
    carry_share(parcel.voxel, to, share, part);
    return lost + part;
}

// Which of the two voxels along each axis a corner is, 0 to 7: 1 for the one that soil drifts to.
ivec3 corner_pick(int corner) { return ivec3(corner & 1, (corner >> 1) & 1, corner >> 2); }

// What of a parcel drifts to a corner, Q16; 0 where that is too little, or may have no mass.
int corner_share(ivec3 weight, ivec3 pick, int volume, int mass) {
    int wx = pick.x == 1 ? weight.x : kVoxelFull - weight.x;
    int wy = pick.y == 1 ? weight.y : kVoxelFull - weight.y;
    int wz = pick.z == 1 ? weight.z : kVoxelFull - weight.z;
    int share = mul_q16(mul_q16(wx, wy), wz);  // thesis (15)
    if (share <= 0 || share >= kOneQ16 || volume <= kWholeMost) return max(0, share);
    return mul_q16(volume, share) < kShareLeast || mul_q16(mass, share) < params.material_count ? 0 : share;
}

// Whether a drift along an axis is so little that it may give a corner no share: of the corners that it could, one has an eighth
// of it.
bool is_scant(IN(Parcel) parcel, int weight) {
    return weight > 0 &&
           (mul_q16(parcel.volume, weight / 8) < kShareLeast || mul_q16(parcel.mass, weight / 8) < params.material_count);
}

// Axes along which a parcel that falls goes by whole voxels, by chance; bit k for axis k. All where it is a crumb, or no share can
// leave its voxel: each is too little, or of thin soil barred. The vertical alone where shares go aside and none comes down: wind
// blew soil to a ledge again and again, which slid back from there. Thick soil gets on once it is a little faster, if no air keeps
// it from that.
CONST_INT(kAllAxes, 7)
CONST_INT(kVertical, 4)
int axes_by_chance(int slot, IN(Parcel) parcel, ivec3 weight, ivec3 side) {
    if (parcel.volume <= kWholeMost) return kAllAxes;
    if (!is_scant(parcel, weight.x) && !is_scant(parcel, weight.y) && !is_scant(parcel, weight.z)) return 0;
    int given = 0;
    bool leaves = false;
    for (int corner = 1; corner < 8; ++corner) {
        if (corner_share(weight, corner_pick(corner), parcel.volume, parcel.mass) == 0) continue;
        if (parcel.volume > kPacingLeast && !is_slowed_by_air(parcel.voxel)) return 0;
        given = given | corner;
        if (leaves) continue;
        ivec3 step = corner_pick(corner) * side;
        int to = voxel_at(slot, parcel.at.x + step.x, parcel.at.y + step.y, parcel.at.z + step.z);
        leaves = !is_locked(parcel.voxel, to, step, parcel.out_way, parcel.overrun);
    }
    return leaves ? kVertical - (given & kVertical) : kAllAxes;
}

// Stops a parcel where something bars a step of whole voxels: its momentum along these axes goes to what bars it, and `lost` grows
// by it. Whether it does.
bool stops_at_wall(int slot, ivec3 step, ivec3 axes, INOUT(Parcel) parcel, INOUT(ivec3) lost) {
    if (step.x == 0 && step.y == 0 && step.z == 0) return false;
    ivec3 target = parcel.at + step;
    int to = voxel_at(slot, target.x, target.y, target.z);
    if (!is_locked(parcel.voxel, to, step, parcel.out_way, parcel.overrun)) return false;
    ivec3 held = parcel.momentum * axes;
    ivec3 bound = momentum_with_wall(slot, parcel.at, parcel.mass, target, to);
    ivec3 taken = held - ivec3(towards(held.x, bound.x), towards(held.y, bound.y), towards(held.z, bound.z));
    take_at_wall(to, taken);
    parcel.momentum = parcel.momentum - taken;
    lost = lost + taken;
    return true;
}

// Which axes a parcel goes along by whole voxels, of those by chance: what bars one of them stops it along that one. Where only
// the corner is barred it has met an edge, and comes down before it: what the wind drives onto a ledge by a voxel in each step
// met that edge whenever it fell, stopped there, and never came down.
ivec3 whole_step(int slot, ivec3 wanted, INOUT(Parcel) parcel, INOUT(ivec3) lost) {
    ivec3 step = wanted;
    // One call for all three and the corner: a compiler copies what it calls to each place.
    for (int axis = 0; axis < 4; ++axis) {
        ivec3 tried = ivec3(axis == 0 ? step.x : 0, axis == 1 ? step.y : 0, axis == 2 ? step.z : 0);
        ivec3 stopped = abs(tried);
        if (axis == 3 && step.z != 0) {
            tried = step;
            stopped = ivec3(abs(step.x), abs(step.y), 0);
        }
        if (stops_at_wall(slot, tried, stopped, parcel, lost)) step = step - step * stopped;
    }
    return step;
}

// Shares a parcel out over the seven voxels that it overlaps beside its own, thesis (13) to (16). Returns the momentum it loses.
ivec3 spread_soil(int slot, IN(Parcel) given, ivec3 drift) {
    Parcel parcel = given;
    ivec3 weight = drift_weight(slot, parcel.at, parcel.voxel, drift);
    ivec3 side = ivec3(drift.x < 0 ? -1 : 1, drift.y < 0 ? -1 : 1, drift.z < 0 ? -1 : 1);
    // Thin soil that falls slowly, or along a wall that wind presses it to, goes as crumbs do. They keep what they have along a
    // wall: one that wind pressed into a corner lost there what it fell with, again and again, and hardly came down.
    int by_chance = parcel.falls ? axes_by_chance(slot, parcel, weight, side) : 0;
    ivec3 lost = ivec3(0);
    if (by_chance != 0) {
        ivec3 pick = corner_pick(by_chance);
        ivec3 whole = whole_voxels(drift, grid_voxel(slot, parcel.at.x, parcel.at.y, parcel.at.z)) / kVoxelFull;
        weight = weight * (ivec3(1) - pick) + abs(whole_step(slot, whole * pick, parcel, lost)) * kVoxelFull;
    }
    // First who gets any: so lanes that run together give together, each to its own next corner.
    int left = 0;
    for (int corner = 1; corner < 8; ++corner) {
        if (corner_share(weight, corner_pick(corner), parcel.volume, parcel.mass) != 0) left = left | (1 << corner);
    }
    for (; left != 0; left = left & (left - 1)) {
        ivec3 pick = corner_pick(lowest_bit(left));
        lost = lost + give_share(slot, parcel, pick * side, corner_share(weight, pick, parcel.volume, parcel.mass));
    }
    return lost;
}

// Moves the soil of a voxel that does not rest on the ground.
void advect_voxel(int slot, ivec3 at, int voxel, int support, ivec3 momentum, INOUT(int) fastest) {
    int mass = mass_at(voxel);
    if (mass == 0) return;
    ivec3 velocity = soil_velocity(voxel, mass);
    Motion motion = support == kSupportNone ? fall_freely(slot, at, voxel, velocity)
                                            : go_with_body(slot, at, voxel, support - kSupportBody, velocity);
    motion = slow_enough(slot, at, motion);
    ivec3 gained = momentum_of(mass, motion.after - velocity);
    if (support == kSupportNone) {
        add_momentum_sum(kResultFallen, gained);
    } else {
        note_given(support - kSupportBody, gained);
        gained = saturated(gained, -hold_back(slot, at, voxel, support - kSupportBody, mass, motion));
    }
    int volume = state_at(kPlaneVolume, voxel);
    ivec3 drift = drift_in_substep(slot, at, volume, motion.drift, fastest);
    ivec3 lost = ivec3(0);
    if (drift.x != 0 || drift.y != 0 || drift.z != 0) {
        Parcel parcel;
        parcel.at = at;
        parcel.voxel = voxel;
        parcel.volume = volume;
        parcel.mass = mass;
        // Its shares are rounded down, each by less than one: all together they still are no less than -kMomentumMost.
        parcel.momentum = max(saturated(momentum, gained), ivec3(kSharesMost - kMomentumMost));
        parcel.overrun = false;
        parcel.falls = support == kSupportNone;
        parcel.out_way = is_caught(voxel) ? way_out(slot, at, voxel, parcel.overrun) : ivec3(0);
        lost = spread_soil(slot, parcel, drift);
    } else if (gained.x == 0 && gained.y == 0 && gained.z == 0 &&
               (support != kSupportNone || largest_component(motion.drift) == 0)) {
        return;  // what falls at its fall speed gains nothing, and waits for its chance awake
    }
    add_momentum(voxel, saturated(gained, -lost));
    mark_moved(voxel, voxel);
}

// Soil on the ground that moves away from it faster than gravity brings it back leaves it, where the way is open.
bool leaves_ground(int slot, ivec3 at, int voxel, ivec3 momentum) {
    int mass = mass_at(voxel);
    if (momentum.z <= 0 || mass == 0 || is_caught(voxel)) return false;
    ivec3 velocity = soil_velocity(voxel, mass);
    if (velocity.z <= in_this_part(params.gravity_q16)) return false;
    int most = min(largest_component(velocity), kSpeedMost);
    ivec3 step = round_q16(direction_q16(clamp(velocity, ivec3(-kSpeedMost), ivec3(kSpeedMost)), most));
    int to = voxel_at(slot, at.x + step.x, at.y + step.y, at.z + step.z);
    return !is_locked(voxel, to, step, ivec3(0), false);
}

// The next voxel of a column, from `from` on, with soil that does not lie on the ground at rest; 8 where there is none.
int next_stirred(int block, int lane, int from) {
    int z = from;
    while (z < 8) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        if (state_at(kPlaneVolume, voxel) != 0) {
            if (state_at(kPlaneSupport, voxel) != kSupportGround) break;
            if (state_at(kPlaneMomentumX, voxel) != 0 || state_at(kPlaneMomentumY, voxel) != 0 ||
                state_at(kPlaneMomentumZ, voxel) != 0) {
                break;
            }
        }
        z += 1;
    }
    return z;
}

int advect_soil_lanes(int group, int half_at) {
    return mask_half(block_list[params.list_offset + group], kMaskMoving, half_at);
}

void advect_soil(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    int fastest = 0;
    bool is_moving = false;
    for (int z = next_stirred(block, lane, 0); z < 8; z = next_stirred(block, lane, z + 1)) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        int support = state_at(kPlaneSupport, voxel);
        ivec3 momentum = momentum_at(voxel);
        if (support == kSupportGround && leaves_ground(slot, ivec3(lane & 7, lane >> 3, z0 + z), voxel, momentum)) {
            support = kSupportNone;
        }
        if (support != kSupportGround) {
            is_moving = true;
            advect_voxel(slot, ivec3(lane & 7, lane >> 3, z0 + z), voxel, support, momentum, fastest);
        } else {
            land(voxel, momentum);
        }
    }
    set_in_mask(block, kMaskMoving, lane, is_moving);
    if (fastest > 0) ATOMIC_MAX(result[kResultSpeed], fastest);
}
