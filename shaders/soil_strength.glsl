// How strong a voxel's soil is, by what has become of it. Part of kernel_common.

// Whether most of a voxel's soil was never moved. Dust holds nothing, wherever it is from: what came down on a slope of loose soil
// would let that stand.
bool is_bonded(int voxel) {
    int volume = state_at(kPlaneVolume, voxel);
    return volume > kWholeMost && 2 * state_at(kPlaneBond, voxel) >= volume;
}

// Where the words of kTableByDensity stand for a voxel's soil: how far along, Q16 entries; below 0 where its strength goes by no
// density, or that is fixed.
int place_by_density(int voxel, int soil_state) {
    bool has_peak = params.dilates != 0 && soil_state == kSoilBonded;
    bool is_regained = params.regains_cohesion != 0 && soil_state == kSoilLoose;
    int loose = has_peak || is_regained ? loose_word(voxel) : 0;
    if (loose == 0) return -1;
    return relative_density(voxel, loose, mass_at(voxel), state_at(kPlaneVolume, voxel)) * (kDensityEntries - 1);
}

// tan(phi), Q16, and cohesion over unit weight of soil without water, Q16 voxels. Dense soil that was never moved has a peak,
// Bolton (1986); what moves has the critical angle, and compaction gives it some cohesion back.
ivec2 dry_strength_at(int voxel, int soil_state) {
    ivec2 dry = mixed_pair(voxel, soil_state, kTableFriction);  // and kTableStrength
    int place = place_by_density(voxel, soil_state);
    if (place < 0) return dry;
    int entry = min(place >> 16, kDensityEntries - 2);
    ivec2 words = mixed_pair(voxel, soil_state, kTableByDensity + entry);
    int word = words.x + mul_q16(words.y - words.x, place - entry * kOneQ16);
    return soil_state == kSoilBonded ? ivec2(word, dry.y) : ivec2(dry.x, word);
}

// Cohesion over unit weight, Q16 voxels, of soil that has `dry` of it without water: with that of moisture, 4 S (1 - S) of its
// most, and the weight of the water.
int wet_strength(int voxel, int soil_state, int dry) {
    int water = water_at(voxel);
    if (water <= 0) return dry;
    ivec2 wet = mixed_pair(voxel, soil_state, kTablePores);  // alike in all states, and kTableMoist
    if (dry + wet.y == 0) return 0;
    int mass = mass_at(voxel) * kWaterParts;
    int saturation = saturation_of(water, mul_q16(mass, wet.x));
    int strength = min(dry + 4 * mul_q16(wet.y, mul_q16(saturation, kOneQ16 - saturation)), kStrengthMost);
    return mass > 0 ? mul_q16(strength, fraction_q16(mass, mass + water)) : strength;
}

// Whether find_failures may take a voxel for soil as strong as params.bank_strength.
bool is_intact(int voxel) {
    if (state_at(kPlaneTerrain, voxel) >= kSolidCoverage) return true;
    int volume = state_at(kPlaneVolume, voxel);
    return volume > 0 && state_at(kPlaneBond, voxel) >= volume &&
           wet_strength(voxel, kSoilBonded, mixed_word(voxel, kSoilBonded, kTableStrength)) >= params.bank_strength;
}
