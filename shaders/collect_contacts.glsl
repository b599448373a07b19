// Where bodies and soil meet: one record per voxel on the surface of a body that is not small, where soil lies on its outer
// side. Normal and area come from the gradient of the coverage field; summed over a closed body it vanishes. Also the load that
// each moving body carries, and whether terrain stands beside it. Everything here is integers; what they mean in newtons is the
// host's business.
// Reads: coverage, owner, terrain, volume, bond, support, materials, water, shapes. Writes: result.

// A body's load is looked through for so many voxels. Ours: from a voxel of a tile to the end of the one beside it. Larger: a
// wider blade that leans back is met as an upright one; smaller: the top of a wide load is pushed for nothing.
CONST_INT(kPlugReach, 8)

// What a body carries of a column, before it is added to the body's load.
struct ColumnLoad {
    int body;  // -1: none
    int mass;  // in parts
    int rise;  // sum of mass times height
};

// mass * (2 at + 1), each half of it within 31 bits: lift is mass * at.
void add_mass_moment(int sum, int mass, int lift) {
    add_wide(sum, lift);
    add_wide(sum, lift + mass);
}

void add_column_load(IN(ColumnLoad) column, ivec3 place) {
    if (column.body < 0) return;
    int load = kResultHeader + column.body * kLoadWords;
    add_wide(load + kLoadMass, column.mass);
    add_mass_moment(load + kLoadMoment, column.mass, column.mass * place.x);
    add_mass_moment(load + kLoadMoment + 2, column.mass, column.mass * place.y);
    add_mass_moment(load + kLoadMoment + 4, column.mass, column.rise);
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

// The voxel that lies n voxels further out of a body.
int voxel_outwards(int slot, ivec3 at, ivec3 inwards, int n) {
    return voxel_at(slot, at.x - n * inwards.x, at.y - n * inwards.y, at.z - n * inwards.z);
}

// Height above which a column and the four beside it hold no soil, so that there is nothing to touch.
int soil_top_around(int slot, int x, int y) {
    int top = -1;
    for (int n = 0; n < 5; ++n) {
        int beside = column_at(slot, x + (n == 1 ? 1 : n == 2 ? -1 : 0), y + (n == 3 ? 1 : n == 4 ? -1 : 0));
        top = max(top, beside < 0 ? -1 : spans[column_word(kColumnSoilTop, beside)]);
    }
    return top;
}

// Adds the soil in a voxel to what the body that carries it has of the column. Sums begin anew before they leave 31 bits; of a
// voxel with more than it may hold all counts as mass, and what it may hold has a place.
void add_load(int body, int voxel, ivec3 place, INOUT(ColumnLoad) column) {
    int mass = mass_at(voxel);
    mass = (mass + min(water_at(voxel) / kWaterParts, max(0, kVoxelMost - mass))) / kLoadPart;
    int surplus = max(0, mass - kMassMost / kLoadPart);
    if (surplus > 0) add_wide(kResultHeader + body * kLoadWords + kLoadMass, surplus);
    mass -= surplus;
    if (body != column.body || column.mass + mass > kMassMost / kLoadPart) {
        add_column_load(column, place);
        column.body = body;
        column.mass = 0;
        column.rise = 0;
    }
    column.mass += mass;
    column.rise += mass * place.z;
}

// Whether terrain stands beside a voxel. The grid's ends do not count.
bool is_beside_terrain(int slot, int x, int y, int z) {
    for (int n = 0; n < 4; ++n) {
        ivec2 at = ivec2(x + (n == 0 ? 1 : n == 1 ? -1 : 0), y + (n == 2 ? 1 : n == 3 ? -1 : 0));
        int beside = voxel_at(slot, at.x, at.y, z);
        if (beside >= 0 && state_at(kPlaneTerrain, beside) >= kSolidCoverage && is_in_grid(slot, at.x, at.y)) return true;
    }
    return false;
}

// The step along an axis into the body: outwards is where coverage falls most.
ivec3 step_inwards(ivec3 gradient) {
    int most = largest_component(gradient);
    if (abs(gradient.z) == most) return ivec3(0, 0, sign(gradient.z));
    if (abs(gradient.x) == most) return ivec3(sign(gradient.x), 0, 0);
    return ivec3(0, sign(gradient.y), 0);
}

// The body whose surface is in a voxel; -1 where there is none, or a small one.
int body_beside(int slot, ivec3 at, int voxel, ivec3 inwards) {
    int inner = voxel_outwards(slot, at, inwards, -1);
    int body = owner_body(state_at(kPlaneOwner, voxel));
    if (body < 0 && inner >= 0) body = owner_body(state_at(kPlaneOwner, inner));
    return body >= 0 && shapes[body * kBodyWords + kBodyPlace] != 0 ? -1 : body;
}

// The voxel whose soil the body meets: the fullest of three outwards. It tells what that soil rests on; soil in a voxel that is
// mostly body rests on the body as much as on the ground.
int soil_outwards(int slot, ivec3 at, int voxel, ivec3 inwards, OUT(int) support) {
    int soil_voxel = voxel;
    int fullest = 0;
    support = kSupportNone;
    for (int n = 0; n <= 2; ++n) {
        int beside = voxel_outwards(slot, at, inwards, n);
        if (beside >= 0 && body_coverage(beside) < kSolidCoverage && state_at(kPlaneVolume, beside) > fullest) {
            fullest = state_at(kPlaneVolume, beside);
            soil_voxel = beside;
            support = state_at(kPlaneSupport, beside);
        }
    }
    return soil_voxel;
}

// The soil outwards. Its density is that of what is mostly of the material that the body meets; where there is no such soil, as
// behind a load of another material, that of the soil which the body meets.
SoilBeside soil_beside(int slot, ivec3 at, int body, int soil_voxel, ivec3 inwards) {
    SoilBeside found;
    found.density = kDensityFixed;
    found.undisturbed = kOneQ16;
    int material = main_material(soil_voxel);
    bool has_range = tables[kSoilStates * material * kTableWords + kTableLoose] > 0;
    if (!has_range && params.bank_strength == 0) return found;
    DensitySum sum = no_density(material);
    int held = 0;
    int bonded = 0;
    for (int n = 0; n <= shapes[body * kBodyWords + kBodyReach]; ++n) {
        int beside = voxel_outwards(slot, at, inwards, n);
        if (beside >= 0) {
            if (has_range) add_density(beside, sum);
            held += state_at(kPlaneVolume, beside);
            if (params.bank_strength > 0) bonded += state_at(kPlaneBond, beside);
        }
    }
    if (has_range) {
        if (sum.mass == 0) add_density(soil_voxel, sum);
        close_density(sum);
        found.density = density_between(sum.most_held, sum.range, sum.held);
    }
    found.undisturbed = undisturbed_share(bonded, held);
    return found;
}

// The words of a record that say how the surface lies to the soil.
void write_surface(int record, int slot, ivec3 at, int voxel, ivec3 gradient, ivec3 inwards) {
    result[record + kContactGradient] = gradient.x;
    result[record + kContactGradient + 1] = gradient.y;
    result[record + kContactGradient + 2] = gradient.z;
    // At an edge the soil beside one face says nothing of that beside the other.
    int gap = gap_beside(slot, at, voxel, inwards);
    result[record + kContactGap] = gradient.x == 0 ? gap : gap_beside(slot, at, voxel, ivec3(sign(gradient.x), 0, 0));
    result[record + kContactGap + 1] = gradient.y == 0 ? gap : gap_beside(slot, at, voxel, ivec3(0, sign(gradient.y), 0));
    result[record + kContactGap + 2] = gradient.z == 0 ? gap : gap_beside(slot, at, voxel, ivec3(0, 0, sign(gradient.z)));
    result[record + kContactExcess] = max(0, state_at(kPlaneVolume, voxel) + coverage_at(voxel) - kVoxelFull);
}

// Soil that a body carries hands on what the ground bears, where it is full from the body to soil on the ground at the same
// height: so before a blade that leans back. That soil's voxel; -1 where there is none, or where the face is as good as level.
int soil_behind_load(int slot, ivec3 at, int body, ivec3 gradient) {
    ivec3 level = step_inwards(ivec3(gradient.x, gradient.y, 0));
    if (kPlugSlope * max(abs(gradient.x), abs(gradient.y)) < abs(gradient.z)) return -1;
    for (int n = 0; n <= kPlugReach; ++n) {
        int beside = voxel_outwards(slot, at, level, n);
        if (beside < 0) return -1;
        int volume = state_at(kPlaneVolume, beside);
        int support = state_at(kPlaneSupport, beside);
        if (n > 0 && volume + coverage_at(beside) < kVoxelFull - kCarrySlack) return -1;
        if (volume > 0 && support != kSupportBody + body) return support == kSupportNone ? -1 : beside;
    }
    return -1;
}

// Whether soil on the ground fills a voxel, so that a load beside it ends there.
bool ends_load(int voxel) {
    if (voxel < 0 || state_at(kPlaneSupport, voxel) != kSupportGround) return false;
    int volume = state_at(kPlaneVolume, voxel);
    return volume > 0 && volume + coverage_at(voxel) >= kVoxelFull - kCarrySlack;
}

// Whether the lowest soil from a voxel to two above it is its body's load, and on which sides that ends at soil on the ground,
// full at the same height.
int load_over(int slot, ivec3 at, int voxel, int body) {
    for (int n = 0; n <= 2 && at.z + n < params.height; ++n) {
        int over = voxel + n * kTileColumns;
        if (body_coverage(over) >= kSolidCoverage || state_at(kPlaneVolume, over) == 0) continue;
        if (state_at(kPlaneSupport, over) != kSupportBody + body) return 0;
        int sides = ends_load(voxel_at(slot, at.x + 1, at.y, at.z + n)) ? 1 : 0;
        if (ends_load(voxel_at(slot, at.x - 1, at.y, at.z + n))) sides += 2;
        if (ends_load(voxel_at(slot, at.x, at.y + 1, at.z + n))) sides += 4;
        if (ends_load(voxel_at(slot, at.x, at.y - 1, at.z + n))) sides += 8;
        return 1 + n + (sides << kLoadSides);
    }
    return 0;
}

// Of the column that begins with a voxel, at a height: 0 where there is none.
int body_coverage_above(int foot, int z) { return foot < 0 ? 0 : body_coverage(foot + z * kTileColumns); }

// Adds a record where a voxel has a body's surface, with this gradient, and soil that meets it.
void collect_contact(int slot, ivec3 at, int voxel, ivec3 gradient) {
    ivec3 inwards = step_inwards(gradient);
    int outer = voxel_outwards(slot, at, inwards, 1);
    if (state_at(kPlaneVolume, voxel) == 0 && (outer < 0 || state_at(kPlaneVolume, outer) == 0)) return;
    int body = body_beside(slot, at, voxel, inwards);
    if (body < 0) return;
    int support = kSupportNone;
    int soil_voxel = soil_outwards(slot, at, voxel, inwards, support);
    // Soil that falls bears nothing, and what lies on a body moves with it.
    if (support == kSupportNone) return;
    if (support == kSupportBody + body) {
        soil_voxel = soil_behind_load(slot, at, body, gradient);
        if (soil_voxel < 0) return;
    }
    SoilBeside beside = soil_beside(slot, at, body, soil_voxel, inwards);
    if (support >= kSupportBody && support != kSupportBody + body &&
        is_between_walls(slot, at, body, support - kSupportBody, inwards)) {
        beside.undisturbed += kContactBetweenWalls;
    }
    int record = add_contact(grid_voxel(slot, at.x, at.y, at.z), body, soil_voxel, beside);
    if (record == 0) return;
    write_surface(record, slot, at, voxel, gradient, inwards);
    result[record + kContactLoad] = load_over(slot, at, voxel, body);
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
    int top = soil_top_around(slot, x, y);
    if (z0 > top) return;
    // body_gradient() of the whole column: the four beside it are found once.
    int east = voxel_at(slot, x + 1, y, 0);
    int west = voxel_at(slot, x - 1, y, 0);
    int north = voxel_at(slot, x, y + 1, 0);
    int south = voxel_at(slot, x, y - 1, 0);
    int first = block * kBlockVoxels + lane;
    int below = z0 > 0 ? body_coverage(first - kTileColumns) : 0;
    int here = body_coverage(first);
    ColumnLoad load;
    load.body = -1;
    load.mass = 0;
    load.rise = 0;
    for (int i = 0; i < 8 && z0 + i <= top; ++i) {
        int voxel = first + i * kTileColumns;
        int z = z0 + i;
        int above = z + 1 < params.height ? body_coverage(voxel + kTileColumns) : 0;
        ivec3 gradient = ivec3(body_coverage_above(east, z) - body_coverage_above(west, z),
                               body_coverage_above(north, z) - body_coverage_above(south, z), above - below);
        below = here;
        here = above;
        int support = state_at(kPlaneSupport, voxel);
        if (support >= kSupportBody && state_at(kPlaneVolume, voxel) > 0) {
            int body = support - kSupportBody;
            add_load(body, voxel, grid_voxel(slot, x, y, z), load);
            int walls = kResultHeader + body * kLoadWords + kLoadWalls;
            if (ATOMIC_LOAD(result[walls]) == 0 && is_beside_terrain(slot, x, y, z)) ATOMIC_OR(result[walls], 1);
        }
        if (largest_component(gradient) > 0) collect_contact(slot, ivec3(x, y, z), voxel, gradient);
    }
    add_column_load(load, grid_voxel(slot, x, y, z0));
}
