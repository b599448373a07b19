// Force application, thesis (33): soil that no longer fits is pushed the way the body's surface moves.
// Where the way is barred by full soil, the push turns as soil does when it fails: outwards and up, at
// 45 deg - phi / 2 (Rankine's passive wedge), instead of running through the bed for ever.
// Where the surface recedes soil is pushed out of the body's way instead. Soil that goes with the body is not pushed.
// Reads: coverage, owner, volume, momentum, support, bodies. Writes: force, masks.
int apply_force_lanes(int group, int half_at) {
    return mask_half(block_list[params.list_offset + group], kMaskPressed, half_at);
}

void apply_force(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    int x = lane & 7;
    int y = lane >> 3;
    bool overflowed = false;
    bool exceeded = false;
    bool pressed = false;
    for (int z = 0; z < 8; ++z) {
        int voxel = block * kBlockVoxels + z * kTileColumns + lane;
        int volume = state_at(kPlaneVolume, voxel);
        int excess = volume > 0 ? excess_at(voxel) : 0;
        exceeded = exceeded || excess > 0;
        pressed = pressed || excess > 0 || (volume > 0 && is_caught(voxel));
        ivec3 out_of_body = ivec3(0);
        if (excess > 0 || (volume > 0 && is_caught(voxel))) {
            bool overrun = false;
            out_of_body = way_out(slot, ivec3(x, y, z0 + z), voxel, overrun);
            excess = overrun ? volume : excess - excess_carried_off(slot, ivec3(x, y, z0 + z), voxel, out_of_body);
        }
        if (excess <= 0) {
            // thesis (33), third case
            if (state_at(kPlaneForceX, voxel) != 0 || state_at(kPlaneForceY, voxel) != 0 ||
                state_at(kPlaneForceZ, voxel) != 0) {
                set_state(kPlaneForceX, voxel, 0);
                set_state(kPlaneForceY, voxel, 0);
                set_state(kPlaneForceZ, voxel, 0);
            }
            continue;
        }
        overflowed = true;
        int body = owner_body(state_at(kPlaneOwner, voxel));
        if (body < 0) {
            continue;  // thesis (33), second case: keeps the force it has
        }
        // thesis (33), first case
        ivec3 at = grid_voxel(slot, x, y, z0 + z);
        ivec3 push = clamp(body_velocity_at(body, at), ivec3(-kPushMost), ivec3(kPushMost));
        int speed = max(1, largest_component(push));
        int below = voxel_at(slot, x, y, z0 + z - 1);
        if (outwards(push * kForceOne / speed, out_of_body) < 0) {
            push = out_of_body;  // a wall that recedes draws no soil into itself
        } else if (push.z < 0 && !has_room(below)) {
            // Pressed down into a full bed: the soil gives way to the side, away from the body's middle.
            ivec3 out_way = at * 2 + 1 -
                            ivec3(shapes[body * kBodyWords + kBodyCenter],
                                  shapes[body * kBodyWords + kBodyCenter + 1], 0);
            int reach = max(1, max(abs(out_way.x), abs(out_way.y)));
            int down = -push.z;
            int aside_x = signed_fraction_q16(clamp(out_way.x, -reach, reach), reach);
            int aside_y = signed_fraction_q16(clamp(out_way.y, -reach, reach), reach);
            push.x += mul_q16(down, aside_x);
            push.y += mul_q16(down, aside_y);
            int far = max(kOneQ16, slope_length(aside_x, aside_y));
            push.z = mul_q16(down, mul_q16(mixed_word(voxel, 0, kTablePassive), far));
        }
        int most = largest_component(push);
        if (most > 0) {
            set_state(kPlaneForceX, voxel, push.x * kForceOne / most);
            set_state(kPlaneForceY, voxel, push.y * kForceOne / most);
            set_state(kPlaneForceZ, voxel, push.z * kForceOne / most);
        }
    }
    set_in_mask(block, kMaskPressed, lane, pressed);
    set_in_mask(block, kMaskExcess, lane, exceeded);
    set_in_mask(block, kMaskOverflow, lane, overflowed);
}
