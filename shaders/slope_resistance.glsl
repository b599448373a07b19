// What holds a slope, and up to which height a wedge of it stands: for slip_soil, and for slide_soil, which must not let soil slide
// for good where slip_soil says that it stands. At the end, what both ask before they give soil to a voxel blocks away. Part of
// kernel_common.

CONST_INT(kAnyDrop, 268435456)  // more than a grid is high

// Height of the sliding wedge (h - tan(theta) dx, Q16 voxels; negative when stable) and its acceleration over a slope.
int table_at(int curve, int table, int slope) {
    int entry = min(slope >> 12, kSlipEntries - 2);
    int start = curve * kTableWords + table + entry;
    int rest = min(slope - entry * kOneQ12, kOneQ16);
    return tables[start] + mul_q16(tables[start + 1] - tables[start], rest * 16);
}

// Whether most of a voxel's soil lies above a plane that fails. Where loose soil has no cohesion nobody asks.
bool is_failing(int voxel) {
    int slot = voxel / params.tile_voxels;
    if (spans[tile_word(kTileCut, slot)] != params.step_stamp) return false;
    int place = voxel - slot * params.tile_voxels;
    int z = place / kTileColumns;
    int cut = spans[column_word(kColumnFailing, slot * kTileColumns + place - z * kTileColumns)];
    if (cut == 0) return false;
    int below = kCutNone - cut - z * kVoxelFull - state_at(kPlaneTerrain, voxel);
    return 2 * max(0, below) < state_at(kPlaneVolume, voxel);
}

// Which of a material's tables a voxel's soil has.
int soil_state_at(int voxel) {
    if (params.keeps_cohesion != 0 && is_failing(voxel)) return kSoilFailing;
    return is_bonded(voxel) ? kSoilBonded : kSoilLoose;
}

// The curve of a voxel's soil. Cohesion holds where most of it is undisturbed. Below 0 where several materials share the voxel, or
// its water or its density changes its strength, which has no curve: kMixedBonded less its state.
CONST_INT(kMixedBonded, -1)
int curve_of(int voxel) {
    int soil_state = soil_state_at(voxel);
    int curve = kSoilStates * main_material(voxel) + soil_state;
    int table = curve * kTableWords;
    bool is_moist = water_at(voxel) > 0 && tables[table + kTableMoist] + tables[table + kTableStrength] > 0;
    bool by_density = soil_state == kSoilLoose    ? params.regains_cohesion != 0
                      : soil_state == kSoilBonded ? params.dilates != 0
                                                  : false;
    return is_moist || by_density || is_mixed(voxel) ? kMixedBonded - soil_state : curve;
}

// table_at() of wedges for tan phi and cohesion over unit weight (k, Q16 voxels) of a mixture. The flattest plane that fails has
// the slope q with, thesis (1) to (4),
//     (slope - q) (q - tan phi) / 2 = k (1 + q^2)
// Without cohesion the wedge is linear on both sides of phi; with it soil that stands counts as -1, as in the tables.
CONST_INT(kMixedStrong, 524288)    // with 8 voxels a step of 16 stands
CONST_INT(kMixedSteepest, 1048576)  // 16, where the tables end
int mixed_wedge(int friction, int strength, int any_slope) {
    int slope = min(any_slope, kMixedSteepest);
    if (strength == 0) return slope - friction;
    if (slope <= friction || strength > kMixedStrong) return -kVoxelFull;
    int half_sum = (slope + friction) / 4;
    int last = mul_q16(slope, friction) / 2 + strength;
    int square = mul_q16(half_sum, half_sum) - mul_q16(kOneQ16 / 2 + strength, last);
    if (square <= 0) return -kVoxelFull;
    return slope - fraction_q16(last, half_sum + 16 * square_root(kOneQ8 * square));
}

// What a voxel's soil has against slipping: its curve, or below 0 tan phi (Q16) and cohesion over unit weight (Q16 voxels).
struct Resistance {
    int curve;
    int friction;
    int strength;  // not looked for where no slope is steeper than phi: that stands whatever its cohesion
};

// steepest: no slope steeper than this is asked about.
Resistance resistance_of(int voxel, int steepest) {
    Resistance soil;
    soil.curve = curve_of(voxel);
    soil.friction = 0;
    soil.strength = 0;
    if (soil.curve >= 0) return soil;
    int soil_state = kMixedBonded - soil.curve;
    ivec2 dry = dry_strength_at(voxel, soil_state);
    soil.friction = dry.x;
    if (steepest > soil.friction) soil.strength = wet_strength(voxel, soil_state, dry.y);
    return soil;
}

int wedge_at(IN(Resistance) soil, int slope) {
    if (soil.curve >= 0) return table_at(soil.curve, kTableWedge, slope);
    return slope <= soil.friction ? -kVoxelFull : mixed_wedge(soil.friction, soil.strength, slope);
}

// Height of a failing wedge, Q16, up to which the soil of a voxel stands: by its place between half of its roughness and all of
// it, so that slopes stand irregularly. Soil of viscosity 1 stands whatever its slope.
int standing_wedge(int voxel, int slot, ivec3 at) {
    if (params.deposits == 0) return kSlipTolerance;
    ivec2 soil = mixed_pair(voxel, kSoilBonded, kTableRoughness);  // and kTableViscosity
    if (soil.y >= kOneQ16) return kAnyDrop;
    int chance = int(mix_bits(place_bits(grid_voxel(slot, at.x, at.y, at.z)), 15) >> 13) & kLowHalf;
    return kSlipTolerance + mul_q16(soil.x, (kOneQ16 + chance) / 2);
}

// is_listed() of a voxel that gives soil and one that takes it, which may lie blocks apart. For those who have found that some can
// go.
bool are_listed(int from, int to) {
    bool is_from_listed = is_listed(from);
    return is_listed(to) && is_from_listed;
}
