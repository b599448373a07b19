// Rows of soil that a body carries, along x or y: docs/decisions/silo_walls.md. Part of kernel_common.

// What a row ends at.
CONST_INT(kRowOpen, 0)     // room, or soil that no body carries
CONST_INT(kRowCarried, 1)  // a wall of the body itself
CONST_INT(kRowHeld, 2)     // another wall
struct RowEnd {
    int kind;
    int wall;   // its body, or kOnGround
    int speed;  // at which it recedes, Q16 voxels a base step
};

// Of the voxels along x or y from the one next to `at` on.
RowEnd find_row_end(int slot, ivec3 at, ivec2 way, int carrier) {
    RowEnd row;
    row.kind = kRowOpen;
    row.wall = kOnGround;
    row.speed = 0;
    int at_slot = slot;
    ivec2 place = ivec2(at.x, at.y);
    for (int n = 0; n < kHeldReach && row.kind == kRowOpen; ++n) {
        if (!step_on(at_slot, place, way)) {
            row.kind = kRowHeld;  // the grid's end
            break;
        }
        int voxel = at_slot * params.tile_voxels + at.z * kTileColumns + place.y * kTileSide + place.x;
        if (is_solid(voxel)) {
            bool is_body = state_at(kPlaneCoverage, voxel) > state_at(kPlaneTerrain, voxel);
            row.wall = is_body ? owner_body(state_at(kPlaneOwner, voxel)) : kOnGround;
            row.kind = row.wall == carrier ? kRowCarried : kRowHeld;
            if (row.kind == kRowHeld && row.wall >= 0) {
                ivec3 velocity = body_velocity_at(row.wall, grid_voxel(at_slot, place.x, place.y, at.z));
                row.speed = clamp(velocity.x * way.x + velocity.y * way.y, 0, kSpeedMost);
            }
        } else if (has_room(voxel) || state_at(kPlaneSupport, voxel) < kSupportBody) {
            break;
        }
    }
    return row;
}

// Whether such soil before an upright face of another body fills all up to a wall of that body: it goes where its walls go.
bool is_between_walls(int slot, ivec3 at, int body, int carrier, ivec3 inwards) {
    if (inwards.z != 0) return false;
    ivec2 way = ivec2(-inwards.x, -inwards.y);
    int at_slot = slot;
    ivec3 place = at;
    for (int n = 0; n < 2 && is_solid(voxel_at(at_slot, place.x, place.y, place.z)); ++n) {  // the wall itself
        ivec2 next = ivec2(place.x, place.y);
        if (!step_on(at_slot, next, way)) return false;
        place = ivec3(next.x, next.y, place.z);
    }
    RowEnd row = find_row_end(at_slot, place, way, carrier);
    return row.kind == kRowHeld && row.wall == body;
}
