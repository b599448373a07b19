// Where bodies and soil meet: one record per voxel on the surface of a body that is not small, where soil lies on its outer
// side. Normal and area come from the gradient of the coverage field; summed over a closed body it vanishes. Also the load that
// each moving body carries. Everything here is integers; what they mean in newtons is the host's business.
// Reads: coverage, owner, volume, support, materials, water, shapes. Writes: result.

// mass * (2 at + 1), each half of it within 31 bits.
void add_mass_moment(int sum, int mass, int at) {
    add_wide(sum, mass * at);
    add_wide(sum, mass * (at + 1));
}

// Room that the soil in a voxel and in the one outwards of it leaves there, Q16 voxels.
int gap_beside(int slot, ivec3 at, int voxel, ivec3 inwards) {
    int gap = kVoxelFull - coverage_at(voxel) - state_at(kPlaneVolume, voxel);
    int outer = voxel_at(slot, at.x - inwards.x, at.y - inwards.y, at.z - inwards.z);
    if (outer >= 0) gap += kVoxelFull - coverage_at(outer) - state_at(kPlaneVolume, outer);
    return max(0, gap);
}

// Columns of half a block that bodies may cover, in the tile that many tiles on along x and y. None outside of what is resident.
int body_half(int slot, int dx, int dy, int level, int half_at) {
    int other = neighbour_slot(slot, (dy + 1) * kNeighbourRow + dx + 1);
    return other < 0 ? 0 : mask_half(other * params.blocks_per_tile + level, kMaskBody, half_at);
}

// Where there is a body in the voxel or in one of the six beside it, or soil that a body may carry.
int collect_contacts_lanes(int group, int half_at) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int level = block - slot * params.blocks_per_tile;
    int here = mask_half(block, kMaskBody, half_at);
    int lanes = here | mask_half(block, kMaskMoving, half_at);
    if (level > 0) lanes = lanes | mask_half(block - 1, kMaskBody, half_at);
    if (level + 1 < params.blocks_per_tile) {
        lanes = lanes | mask_half(block + 1, kMaskBody, half_at);
    }
    // Bit 8 y + x of a half: its neighbours along x, then along y.
    lanes = lanes | ((here & 0x7f7f7f7f) << 1) | ((here >> 1) & 0x7f7f7f7f);
    lanes = lanes | ((body_half(slot, -1, 0, level, half_at) >> 7) & 0x01010101);
    lanes = lanes | ((body_half(slot, 1, 0, level, half_at) & 0x01010101) << 7);
    int before = half_at == 1 ? mask_half(block, kMaskBody, 0) : body_half(slot, 0, -1, level, 1);
    int behind = half_at == 0 ? mask_half(block, kMaskBody, 1) : body_half(slot, 0, 1, level, 0);
    lanes = lanes | (here << 8) | ((before >> 24) & kRowMask);
    lanes = lanes | ((here >> 8) & 0x00ffffff) | (behind << 24);
    return lanes;
}

void collect_contacts(int group, int lane) {
    int block = block_list[params.list_offset + group];
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    int x = lane & 7;
    int y = lane >> 3;
    if (!is_in_grid(slot, x, y)) return;
    // Above all soil here and beside there is nothing to touch.
    int top = -1;
    for (int n = 0; n < 5; ++n) {
        int beside = column_at(slot, x + (n == 1 ? 1 : n == 2 ? -1 : 0), y + (n == 3 ? 1 : n == 4 ? -1 : 0));
        top = max(top, beside < 0 ? -1 : spans[column_word(kColumnSoilTop, beside)]);
    }
    for (int i = 0; i < 8 && z0 + i <= top; ++i) {
        int z = z0 + i;
        int voxel = block * kBlockVoxels + i * kTileColumns + lane;
        int support = state_at(kPlaneSupport, voxel);
        if (support >= kSupportBody && state_at(kPlaneVolume, voxel) > 0) {
            int load = kResultHeader + (support - kSupportBody) * kLoadWords;
            int mass = mass_at(voxel);
            mass = (mass + min(water_at(voxel), max(0, kVoxelMost - mass))) / kLoadPart;
            ivec3 at = grid_voxel(slot, x, y, z);
            add_wide(load + kLoadMass, mass);
            add_mass_moment(load + kLoadMoment, mass, at.x);
            add_mass_moment(load + kLoadMoment + 2, mass, at.y);
            add_mass_moment(load + kLoadMoment + 4, mass, at.z);
        }
        ivec3 gradient = body_gradient(slot, x, y, z);
        int most = largest_component(gradient);
        if (most == 0) continue;
        // Outwards is where coverage falls.
        ivec3 inwards = ivec3(0);
        if (abs(gradient.z) == most) {
            inwards.z = sign(gradient.z);
        } else if (abs(gradient.x) == most) {
            inwards.x = sign(gradient.x);
        } else {
            inwards.y = sign(gradient.y);
        }
        int outer = voxel_at(slot, x - inwards.x, y - inwards.y, z - inwards.z);
        int inner = voxel_at(slot, x + inwards.x, y + inwards.y, z + inwards.z);
        int body = owner_body(state_at(kPlaneOwner, voxel));
        if (body < 0 && inner >= 0) body = owner_body(state_at(kPlaneOwner, inner));
        if (body < 0 || shapes[body * kBodyWords + kBodyPlace] != 0) continue;
        // What the soil here rests on is told by the fullest of three voxels on the way out; soil in a voxel that is
        // mostly body rests on the body as much as on the ground.
        int soil_voxel = voxel;
        support = kSupportNone;
        int fullest = 0;
        for (int k = 0; k <= 2; ++k) {
            int beside = voxel_at(slot, x - k * inwards.x, y - k * inwards.y, z - k * inwards.z);
            if (beside >= 0 && body_coverage(beside) < kSolidCoverage &&
                state_at(kPlaneVolume, beside) > fullest) {
                fullest = state_at(kPlaneVolume, beside);
                soil_voxel = beside;
                support = state_at(kPlaneSupport, beside);
            }
        }
        int volume = state_at(kPlaneVolume, voxel) + (outer < 0 ? 0 : state_at(kPlaneVolume, outer));
        // Soil that falls bears nothing, and what lies on a body moves with it.
        if (volume == 0 || support == kSupportNone || support == kSupportBody + body) continue;
        // Relative density of the soil along the way out, as if it were all of one kind.
        int density = kDensityFixed;
        int loose = loose_of_range(soil_voxel);
        if (loose > 0) {
            int mass = 0;
            int held = 0;
            for (int k = 0; k <= shapes[body * kBodyWords + kBodyReach]; ++k) {
                int beside = voxel_at(slot, x - k * inwards.x, y - k * inwards.y, z - k * inwards.z);
                if (beside >= 0) {
                    mass += mass_at(beside);
                    held += state_at(kPlaneVolume, beside);
                }
            }
            density = relative_density(soil_voxel, loose, mass, held);
        }
        int at = add_contact(grid_voxel(slot, x, y, z), body, soil_voxel, density);
        if (at == 0) continue;
        result[at + kContactGradient] = gradient.x;
        result[at + kContactGradient + 1] = gradient.y;
        result[at + kContactGradient + 2] = gradient.z;
        // At an edge the soil beside one face says nothing of that beside the other.
        ivec3 here = ivec3(x, y, z);
        int gap = gap_beside(slot, here, voxel, inwards);
        result[at + kContactGap] = gradient.x == 0 ? gap : gap_beside(slot, here, voxel, ivec3(sign(gradient.x), 0, 0));
        result[at + kContactGap + 1] = gradient.y == 0 ? gap : gap_beside(slot, here, voxel, ivec3(0, sign(gradient.y), 0));
        result[at + kContactGap + 2] = gradient.z == 0 ? gap : gap_beside(slot, here, voxel, ivec3(0, 0, sign(gradient.z)));
        result[at + kContactExcess] = max(0, state_at(kPlaneVolume, voxel) + coverage_at(voxel) - kVoxelFull);
    }
}
