// Soil on a body that slides along under it: docs/decisions/silo_walls.md. Where what lies before it fills all room up to a wall
// nothing gives way, and the body slips under it. Part of advect_soil.

// Of the row of a voxel; where that is open, of the next one below that is not. What lies on soil that is held is not driven.
RowEnd find_hold(int slot, ivec3 from, int from_voxel, ivec2 way, int carrier) {
    ivec3 at = from;
    int voxel = from_voxel;
    RowEnd row = find_row_end(slot, at, way, carrier);
    while (row.kind == kRowOpen && at.z > 0) {
        at.z -= 1;
        voxel -= kTileColumns;
        if (state_at(kPlaneSupport, voxel) != kSupportBody + carrier || is_solid(voxel)) break;
        row = find_row_end(slot, at, way, carrier);
    }
    return row;
}

// What a wall takes of a speed along an axis, and of whom that wall is.
int held_speed(int slot, ivec3 at, int voxel, ivec2 axis, int carrier, int speed, OUT(int) wall) {
    wall = kOnGround;
    if (abs(speed) <= params.still_speed) return 0;
    RowEnd row = find_hold(slot, at, voxel, axis * sign(speed), carrier);
    wall = row.wall;
    return row.kind == kRowHeld ? sign(speed) * max(0, abs(speed) - row.speed) : 0;
}

// Holds back soil that its body drives against walls, and returns the momentum that they take. The body has given it all the same:
// that is friction on the body.
ivec3 hold_back(int slot, ivec3 at, int voxel, int carrier, int mass, INOUT(Motion) motion) {
    ivec3 taken = ivec3(0);
    for (int i = 0; i < 2; ++i) {
        ivec2 axis = ivec2(1 - i, i);
        int wall = kOnGround;
        int lost = held_speed(slot, at, voxel, axis, carrier, i == 0 ? motion.after.x : motion.after.y, wall);
        if (lost == 0) continue;
        ivec3 stopped = ivec3(axis.x * lost, axis.y * lost, 0);
        motion.after -= stopped;
        motion.drift -= stopped;
        ivec3 momentum = momentum_of(mass, stopped);
        take_momentum(wall, momentum);
        taken += momentum;
    }
    return taken;
}
