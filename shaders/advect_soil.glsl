// Ballistic motion, thesis (21) to (29): each voxel's soil is displaced by its velocity and shared out over the voxels it
// then overlaps (13) to (16); locked voxels give it back without velocity (24). Supported soil rests; soil on a moving
// body goes with the body as far as friction can take it (thesis 5.3.1 lists its absence as a defect), before the wall
// behind it and after the wall before it.
// Reads: all planes. Writes: deltas; the momentum of soil that rests.

// thesis (24): a full voxel is locked, unless its soil is itself falling or carried away. Soil caught in a wall moves
// with the wall along it and out of it.
bool is_locked(int from, int to, ivec3 step, ivec3 out_way, bool overrun) {
    if (is_barred(from, to, step, out_way, overrun)) return true;
    return state_at(kPlaneSupport, to) == kSupportGround && is_full(to);
}

// Whole voxels as often as the drift is long: on average as far as it should. `chance` is a Q16 number spread evenly
// over the passes.
ivec3 whole_voxels(ivec3 drift, int chance) {
    return ivec3(abs(drift.x) > chance ? sign(drift.x) : 0, abs(drift.y) > chance ? sign(drift.y) : 0,
                 abs(drift.z) > chance ? sign(drift.z) : 0) *
           kVoxelFull;
}

ivec3 share_of(ivec3 amount, int share) {
    return ivec3(mul_q16(amount.x, share), mul_q16(amount.y, share), mul_q16(amount.z, share));
}

ivec3 momentum_of(int mass, ivec3 velocity) {
    int half_mass = mass * (kVelocityOne / 2);
    return ivec3(mul_q16(half_mass, velocity.x * 2), mul_q16(half_mass, velocity.y * 2),
                 mul_q16(half_mass, velocity.z * 2));
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
        int lost = mul_q16(abs(momentum.z), mixed_word(voxel, 1, kTableFriction));
        int whole = slope_length(momentum.x, momentum.y);
        kept = lost >= whole ? 0 : momentum.z == 0 ? kOneQ16 : kOneQ16 - fraction_q16(lost >> 4, (whole >> 4) + 1);
    }
    set_state(kPlaneMomentumX, voxel, sign(momentum.x) * mul_q16(abs(momentum.x), kept));
    set_state(kPlaneMomentumY, voxel, sign(momentum.y) * mul_q16(abs(momentum.y), kept));
    set_state(kPlaneMomentumZ, voxel, 0);
}

// --- air

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
        ATOMIC_MAX(block_flags[flag_index(kFlagWanted, slot * params.blocks_per_tile + (z >> 3))], params.step_stamp);
    }
    return true;
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
        int voxel = slot * params.tile_voxels + z * kTileColumns + at.y * kTileSide + at.x;
        if (is_solid(voxel) || is_full(voxel)) return true;
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

// Of the air around a voxel. In a part of a step it takes soil along by no more than a voxel: the next step has more parts.
ivec3 air_velocity(int slot, ivec3 at) {
    ivec3 wind = ivec3(params.wind_x, params.wind_y, params.wind_z);
    if (largest_component(wind) == 0 || is_sheltered(slot, at)) return ivec3(0);
    if (params.gust > 0) wind = share_of(wind, kOneQ16 + mul_q16(params.gust, gust_at(grid_voxel(slot, at.x, at.y, at.z))));
    int most = params.substep_count * kVoxelFull;
    return clamp(wind, ivec3(-most), ivec3(most));
}

int advect_soil_lanes(int group, int half_at) {
    return mask_half(block_list[params.list_offset + group], kMaskMoving, half_at);
}

void advect_soil(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    int x = lane & 7;
    int y = lane >> 3;
    int fastest = 0;
    bool is_moving = false;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        if (state_at(kPlaneVolume, voxel) == 0) continue;
        int mass = mass_at(voxel);
        int support = state_at(kPlaneSupport, voxel);
        is_moving = is_moving || support != kSupportGround;
        ivec3 momentum = ivec3(state_at(kPlaneMomentumX, voxel), state_at(kPlaneMomentumY, voxel),
                               state_at(kPlaneMomentumZ, voxel));
        if (support == kSupportGround) {
            if (momentum.x != 0 || momentum.y != 0 || momentum.z != 0) land(voxel, momentum);
            continue;
        }
        if (mass == 0) continue;
        ivec3 velocity = soil_velocity(voxel, mass);
        ivec3 after = velocity;
        ivec3 drift = velocity;
        int gravity = params.gravity_q16 / params.substep_count;
        if (support == kSupportNone) {
            // Kick after drift, drift at the middle of the step: exact for constant gravity (29).
            drift.z -= gravity / 2;
            after.z -= gravity;
            int taken = params.air == 0 ? 0 : mixed_word(voxel, 0, kTableAir) / params.substep_count;
            if (taken > 0) {
                // Drag goes by the speed against the air, in the middle of the step: at its fall speed soil keeps its speed.
                int share = fraction_q16(taken, kOneQ16 + taken / 2);
                after = velocity + share_of(air_velocity(slot, ivec3(x, y, z0 + z)) - velocity, share);
                after.z -= gravity - mul_q16(gravity, share) / 2;
                drift = (velocity + after) / 2;
            }
        } else {
            int body = support - kSupportBody;
            ivec3 goal = body_velocity_at(body, grid_voxel(slot, x, y, z0 + z));
            int friction = shapes[body * kBodyWords + kBodyFriction];
            int hold = friction == kFrictionOfSoil ? mixed_word(voxel, 0, kTableTool) : friction * (kOneQ16 / kVelocityOne);
            int grip = hold / params.substep_count;
            after.x += clamp(goal.x - after.x, -grip, grip);
            after.y += clamp(goal.y - after.y, -grip, grip);
            after.z = max(goal.z, after.z - gravity);
            drift = after;
        }
        if (largest_component(after) > kSpeedMost) {
            note_condition(kStatusSpeedClamped, kResultSpeedPlace, grid_voxel(slot, x, y, z0 + z));
            after = clamp(after, ivec3(-kSpeedMost), ivec3(kSpeedMost));
            drift = clamp(drift, ivec3(-kSpeedMost), ivec3(kSpeedMost));
        }
        // Dust neither asks for sub-steps nor counts as clamped: rounding alone can make its speed jump.
        int volume = state_at(kPlaneVolume, voxel);
        if (volume > kPacingLeast) fastest = max(fastest, largest_component(drift));
        drift = drift / params.substep_count;
        if (largest_component(drift) > kVoxelFull) {
            if (volume > kPacingLeast) {
                note_condition(kStatusSpeedClamped, kResultSpeedPlace, grid_voxel(slot, x, y, z0 + z));
            }
            drift = clamp(drift, ivec3(-kVoxelFull), ivec3(kVoxelFull));
        }
        // Momentum after the kick, moved with the soil.
        ivec3 kick = after - velocity;
        ivec3 gained = momentum_of(mass, kick);
        if (volume <= kWholeMost) {
            drift = whole_voxels(drift, voxel_chance(grid_voxel(slot, x, y, z0 + z)));
        }
        if (drift.x == 0 && drift.y == 0 && drift.z == 0) {
            if (gained.x != 0 || gained.y != 0 || gained.z != 0) {
                add_delta(kPlaneMomentumX, voxel, gained.x);
                add_delta(kPlaneMomentumY, voxel, gained.y);
                add_delta(kPlaneMomentumZ, voxel, gained.z);
                mark_moved(voxel, voxel);
            }
            continue;
        }
        ivec3 weight = drift_weight(slot, ivec3(x, y, z0 + z), voxel, drift);
        ivec3 side = ivec3(drift.x < 0 ? -1 : 1, drift.y < 0 ? -1 : 1, drift.z < 0 ? -1 : 1);
        ivec3 total = momentum + gained;
        bool overrun = false;
        ivec3 out_way = is_caught(voxel) ? way_out(slot, ivec3(x, y, z0 + z), voxel, overrun) : ivec3(0);
        ivec3 lost = ivec3(0);   // momentum that leaves this voxel, or that what bars the way takes
        for (int corner = 1; corner < 8; ++corner) {
            ivec3 pick = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
            int wx = pick.x == 1 ? weight.x : kVoxelFull - weight.x;
            int wy = pick.y == 1 ? weight.y : kVoxelFull - weight.y;
            int wz = pick.z == 1 ? weight.z : kVoxelFull - weight.z;
            int share = mul_q16(mul_q16(wx, wy), wz);  // thesis (15)
            if (share <= 0 || (volume > kWholeMost && mul_q16(volume, share) < kShareLeast)) {
                continue;
            }
            ivec3 step = pick * side;
            ivec3 target = ivec3(x, y, z0 + z) + step;
            int to = voxel_at(slot, target.x, target.y, target.z);
            int barred = 0;
            if (is_locked(voxel, to, step, out_way, overrun)) {
                int room = room_at_face(slot, target, voxel, to);
                barred = share - min(share, fraction_q16(min(room, volume), volume));
                share -= barred;
            }
            if (barred > 0) {  // thesis (24): backflow, with zero velocity; with the wall's where that recedes
                ivec3 held = share_of(total, barred);
                ivec3 bound = share_of(momentum_with_wall(slot, ivec3(x, y, z0 + z), mass, target, to), barred);
                lost = lost + held - ivec3(towards(held.x, bound.x), towards(held.y, bound.y), towards(held.z, bound.z));
            }
            if (share <= 0) continue;
            ivec3 part = share_of(total, share);
            lost = lost + part;
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
            add_delta(kPlaneMomentumX, to, part.x);  // thesis (28): extensive, so the average comes by itself
            add_delta(kPlaneMomentumY, to, part.y);
            add_delta(kPlaneMomentumZ, to, part.z);
            mark_moved(voxel, to);
        }
        add_delta(kPlaneMomentumX, voxel, gained.x - lost.x);
        add_delta(kPlaneMomentumY, voxel, gained.y - lost.y);
        add_delta(kPlaneMomentumZ, voxel, gained.z - lost.z);
        mark_moved(voxel, voxel);
    }
    set_in_mask(block, kMaskMoving, lane, is_moving);
    if (fastest > 0) ATOMIC_MAX(result[kResultSpeed], fastest);
}
