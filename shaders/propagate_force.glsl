// One iteration of force propagation, thesis (34) and (35): soil in excess leaves its voxel along the applied force.
// Reads: coverage, volume, force, support, bodies, all transported planes. Writes: deltas, momentum and its sums.

// Speed along a way whose largest component is one voxel, as that component of it. Never negative.
int speed_along(ivec3 velocity, ivec3 way) {
    ivec3 along = sign(way) * velocity;
    return max(0, max(abs(way.x) == kVoxelFull ? along.x : 0,
                      max(abs(way.y) == kVoxelFull ? along.y : 0, abs(way.z) == kVoxelFull ? along.z : 0)));
}

// Soil on the ground goes as fast as a push moves it: what leaves its voxel in this part of the step, over the voxel's face.
// All of the voxel's soil does, for it makes room. No faster than the body that pushes it. Where there is none, no faster than
// what has arrived with the push, nor than the fastest body: what makes room for a body that was put into it stays at rest.
// fraction: of the soil, that leaves.
void set_in_motion(int slot, ivec3 at, int voxel, ivec3 way, int excess, int fraction) {
    if (params.push_speed <= params.arch_speed || state_at(kPlaneSupport, voxel) != kSupportGround) return;
    int mass = mass_at(voxel);
    if (mass == 0) return;
    int speed = min(min(excess, kVoxelFull) * params.body_substep_count, min(params.push_speed, kSpeedMost));
    ivec3 present = clamp(soil_velocity(voxel, mass), ivec3(-kSpeedMost), ivec3(kSpeedMost));
    int present_speed = speed_along(present, way);
    int body = owner_body(state_at(kPlaneOwner, voxel));
    if (body >= 0) {
        speed = min(speed, largest_component(body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z))));
    } else if (mul_q16(speed, fraction) > present_speed) {
        speed = fraction_q16(present_speed, fraction);
    }
    if (speed <= max(params.arch_speed, present_speed)) return;
    set_by_ground(voxel, momentum_of(mass, ivec3(mul_q16(speed, way.x), mul_q16(speed, way.y), mul_q16(speed, way.z))));
    mark_moved(voxel, voxel);  // where all ways are barred nothing else notes it
}

// A voxel takes from a push no more than one part in so many of what it may still hold (kVoxelMost). Ours: as many as it has
// neighbours along the axes, and two for what comes in across edges. Larger: soil in a closing corner leaves it later; smaller:
// pushes that meet pile up more than momentum can be told of. Voxels of six at most once brought 17 into one, in a bucket.
CONST_INT(kPushesMeet, 8)

// Sends `fraction` (Q16 of the voxel's soil) along a displacement whose largest component is one voxel, with `force` of the
// same scale; returns what could not leave. out_way: see is_barred.
int push_along(int slot, ivec3 at, int from, ivec3 way, int fraction, ivec3 force, ivec3 out_way,
               bool overrun) {
    int left = fraction;
    int held = state_at(kPlaneVolume, from);
    ivec3 weight = abs(way);
    ivec3 side = ivec3(way.x < 0 ? -1 : 1, way.y < 0 ? -1 : 1, way.z < 0 ? -1 : 1);
    for (int corner = 1; corner < 8; ++corner) {
        ivec3 pick = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        int wx = pick.x == 1 ? weight.x : kVoxelFull - weight.x;
        int wy = pick.y == 1 ? weight.y : kVoxelFull - weight.y;
        int wz = pick.z == 1 ? weight.z : kVoxelFull - weight.z;
        int share = mul_q16(mul_q16(mul_q16(fraction, wx), wy), wz);
        int moved = mul_q16(held, share);
        // As of soil that falls. Trickles kept soil awake for minutes beside bodies that had come to rest. What a wall has caught
        // leaves it to the last unit: of what a slow wall covers in a step there is no more. Soil of more than a mass unit a volume
        // unit can have a share of mass alone. That makes no room, and would go for good.
        if (moved <= 0 || (held > kWholeMost && moved < kShareLeast && !is_caught(from))) continue;
        int to = voxel_at(slot, at.x + pick.x * side.x, at.y + pick.y * side.y,
                          at.z + pick.z * side.z);
        // Asked last, since it has a block dispatched: two on both sides of soil that nothing takes would keep each other awake.
        bool is_crowded = to >= 0 && !is_caught(from) && state_at(kPlaneVolume, to) > kCrowdedLeast;
        if (is_crowded || !moves_any(from, share) || is_barred(from, to, pick * side, out_way, overrun)) continue;
        int most = to < 0 ? moved : max(0, kVoxelMost - state_at(kPlaneVolume, to)) / kPushesMeet;
        if (moved > most) {
            moved = most;
            share = fraction_q16(moved, held);
        }
        if (!move_share(from, to, share)) continue;
        // thesis (35): the force arrives weighted by what it brings; Q10 direction times sixteenths of the volume.
        ivec3 brought = (force >> 6) * (moved / kForceShare);
        add_delta(kPlaneForceX, to, brought.x);
        add_delta(kPlaneForceY, to, brought.y);
        add_delta(kPlaneForceZ, to, brought.z);
        left -= share;
    }
    return left;
}

bool is_driven(int slot, ivec3 at, int voxel) {
    int body = owner_body(state_at(kPlaneOwner, voxel));
    return body >= 0 && largest_component(body_velocity_at(body, grid_voxel(slot, at.x, at.y, at.z))) > params.still_speed;
}

// Confined soil yields towards the free surface by the shorter way: level, or rising at 45 deg - phi / 2 as Rankine's
// passive wedge does, whichever way it lies to the grid. Looked for as far as the neighbouring tile reaches.
ivec3 way_to_free_surface(int slot, ivec3 at, ivec3 way, int rise) {
    int most = max(abs(way.x), abs(way.y));
    if (most == 0) return ivec3(0, 0, kVoxelFull);
    ivec3 level = ivec3(signed_fraction_q16(way.x, most), signed_fraction_q16(way.y, most), 0);
    ivec3 rising = ivec3(level.x, level.y, rise);
    for (int k = 1; k <= kFreeSurfaceReach; ++k) {
        ivec3 ahead = round_q16(level * k);
        int flat_voxel = voxel_at(slot, at.x + ahead.x, at.y + ahead.y, at.z);
        if (has_room(flat_voxel)) return level;
        int high_voxel = voxel_at(slot, at.x + ahead.x, at.y + ahead.y, at.z + round_q16(rise * k));
        if (has_room(high_voxel)) return rising;
    }
    return rising;
}

// Soil pressed by a body is compacted before it flows: up to the relative density that belongs to the body's pressure,
// and half of that one voxel further on. Returns the volume that is gone.
int compact(int slot, ivec3 at, int voxel, int excess, ivec3 way) {
    int loose = loose_word(voxel);
    if (loose == 0) return 0;
    int body = owner_body(state_at(kPlaneOwner, voxel));
    int packing = 0;
    if (body >= 0) {
        packing = shapes[body * kBodyWords + kBodyPacking];
    } else {
        ivec3 from = at - round_q16(way);
        int behind = voxel_at(slot, from.x, from.y, from.z);
        body = behind < 0 ? -1 : owner_body(state_at(kPlaneOwner, behind));
        packing = body < 0 ? 0 : shapes[body * kBodyWords + kBodyPacking] / 2;
    }
    int volume = state_at(kPlaneVolume, voxel);
    int dense = loose - mul_q16(loose - compacted_word(voxel), packing);
    int gone = min(excess, volume - max(1, mul_q16(mass_at(voxel), dense)));  // the last unit would come back
    if (gone <= 0) return 0;
    add_delta(kPlaneVolume, voxel, -gone);
    add_delta(kPlaneBond, voxel, -mul_q16(state_at(kPlaneBond, voxel), fraction_q16(gone, volume)));
    mark_moved(voxel, voxel);
    return gone;
}

int propagate_force_lanes(int group, int half_at) {
    int block = block_list[params.list_offset + group];
    return has_overflow(block) ? mask_half(block, kMaskPressed, half_at) : 0;
}

void propagate_force(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        int volume = state_at(kPlaneVolume, voxel);
        if (volume == 0) continue;
        int excess = min(volume, excess_at(voxel));
        ivec3 at = ivec3(lane & 7, lane >> 3, z0 + z);
        ivec3 out_way = ivec3(0);
        bool overrun = false;
        bool caught = is_caught(voxel);
        if (caught || (excess > 0 && is_carried_here(voxel))) {
            ivec3 out_of_body = way_out(slot, at, voxel, overrun);
            overrun = caught && overrun;
            excess = overrun ? volume : excess - excess_carried_off(slot, at, voxel, out_of_body);
            out_way = caught ? out_of_body : ivec3(0);
        }
        ivec3 force = ivec3(state_at(kPlaneForceX, voxel), state_at(kPlaneForceY, voxel),
                            state_at(kPlaneForceZ, voxel));
        int most = largest_component(force);
        if (excess <= 0 || most == 0) continue;
        while (most >= kForceHalved) {
            force = force / 2;
            most = most / 2;
        }
        // thesis (34): the largest component becomes one voxel, so that the excess leaves for good.
        ivec3 way = direction_q16(force, most);
        excess -= compact(slot, at, voxel, excess, way);
        if (excess <= 0) continue;
        int fraction = fraction_q16(excess, volume);
        ivec3 next = at + round_q16(way);
        int ahead = voxel_at(slot, next.x, next.y, next.z);
        int rise = min(kVoxelFull, mul_q16(mixed_word(voxel, 0, kTablePassive), slope_length(way.x, way.y)));
        if (way.z < rise && !has_room(ahead)) way = way_to_free_surface(slot, at, way, rise);
        ivec3 exit = ivec3(0);
        int steep = largest_component(out_way);
        if (steep > 0) exit = direction_q16(out_way, steep);
        set_in_motion(slot, at, voxel, way, excess, fraction);
        // The force stays with nothing: what could not leave gets a new one from apply_force or from inflow.
        int left = fraction;
        if (steep == 0 || is_within_60_deg(way, exit)) {
            left = push_along(slot, at, voxel, way, fraction, way, out_way, overrun);
        }
        if (left > 0 && way.z > 0 && max(abs(way.x), abs(way.y)) == kVoxelFull) {
            way.z = 0;  // a body above: slip out sideways
            left = push_along(slot, at, voxel, way, left, way, out_way, overrun);
        }
        if (left > 0 && steep > 0 && is_driven(slot, at, voxel)) {
            // Out of the wall by the shortest way, or straight where that is barred; the push goes on outside.
            left = push_along(slot, at, voxel, exit, left, way, out_way, overrun);
            if (left > 0) {
                push_along(slot, at, voxel, sign(exit) * ((abs(exit) >> 16) << 16), left, way, out_way, overrun);
            }
        }
    }
}
