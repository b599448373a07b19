// Roofs: soil that was never moved spans a hollow. Terzaghi (1943): a strip of it, B wide, is held by the shear on its two upright
// sides, whatever its height H: 2 c H >= gamma B H. Of what lies on it and was moved it bears the weight as well, which its sides
// have to hold with the height that was not. So, along one of four ways, with k = c / gamma (mean over the strip, by bond),
//     B <= 2 k (height never moved) / (height of all soil above)

CONST_INT(kRoofReach, 32)  // voxels to an abutment at most. Ours: larger, and walks are longer; smaller, and strong soil spans less

// Whether most of a voxel's room is soil that was never moved.
bool is_roof_soil(int voxel) {
    return state_at(kPlaneTerrain, voxel) + state_at(kPlaneVolume, voxel) >= kVoxelFull - kSupportSlack && is_bonded(voxel);
}

// Whether a voxel's column is full from here down to the floor or to terrain.
bool is_abutment(int voxel, int z) {
    int at = voxel;
    for (int below = z; below >= 0; --below) {
        int terrain = state_at(kPlaneTerrain, at);
        if (terrain >= kSolidCoverage) return true;
        if (state_at(kPlaneCoverage, at) > 0) return false;
        if (terrain + state_at(kPlaneVolume, at) < kVoxelFull - kSupportSlack) return false;
        at -= kTileColumns;
    }
    return true;
}

// Cohesion over unit weight of a voxel's soil by the share that was never moved, Q12 voxels.
int roof_strength(int voxel) {
    int volume = state_at(kPlaneVolume, voxel);
    int strength = wet_strength(voxel, kSoilBonded, mixed_word(voxel, kSoilBonded, kTableStrength));
    return mul_q16(strength, fraction_q16(min(state_at(kPlaneBond, voxel), volume), max(1, volume))) >> 4;
}

// Voxels from one of a roof to an abutment, or to a tile that sleeps; 0 where there is none. strength: grows by that of the
// voxels on the way.
int roof_side(int from_slot, ivec3 at, ivec2 way, INOUT(int) strength) {
    int slot = from_slot;
    ivec2 place = ivec2(at.x, at.y);
    for (int n = 1; n <= kRoofReach; ++n) {
        ivec2 next = place + way;
        // Ground that sleeps holds what it held.
        if (!step_on(slot, place, way)) return is_in_grid(slot, next.x, next.y) ? n : 0;
        int voxel = slot * params.tile_voxels + at.z * kTileColumns + place.y * kTileSide + place.x;
        if (state_at(kPlaneTerrain, voxel) >= kSolidCoverage) return is_in_grid(slot, place.x, place.y) ? n : 0;
        if (!is_roof_soil(voxel)) return 0;
        if (is_abutment(voxel, at.z)) return n;
        strength += roof_strength(voxel);
    }
    return 0;
}

// Share of the soil from a voxel up to the next hollow or to the surface that was never moved, Q16.
int undisturbed_above(int voxel, int z) {
    int bonded = 0;
    int all = 0;
    int at = voxel;
    for (int above = z; above < params.height && state_at(kPlaneVolume, at) > 0; ++above) {
        bonded += min(state_at(kPlaneBond, at), state_at(kPlaneVolume, at)) >> 8;
        all += state_at(kPlaneVolume, at) >> 8;
        at += kTileColumns;
    }
    return fraction_q16(bonded, max(1, all));
}

// Whether soil over a hollow is held as a roof: along x, along y, or along one of the diagonals.
bool is_held_roof(int slot, ivec3 at, int voxel) {
    if (!is_roof_soil(voxel)) return false;
    int share = undisturbed_above(voxel, at.z);
    for (int k = 0; k < 4; ++k) {
        ivec2 way = ivec2(k == 1 ? 0 : 1, k == 0 ? 0 : (k == 3 ? -1 : 1));
        int strength = roof_strength(voxel);
        int ahead = roof_side(slot, at, way, strength);
        int behind = ahead == 0 ? 0 : roof_side(slot, at, -way, strength);
        if (behind == 0) continue;
        int count = ahead + behind - 1;
        int span = k < 2 ? count * kOneQ12 : mul_q16(count * kOneQ12, kDiagonal);
        if (count * span <= 2 * mul_q16(strength, share)) return true;
    }
    return false;
}
