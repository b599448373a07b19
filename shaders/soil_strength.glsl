// How strong a voxel's soil is: cohesion by what has become of it. Part of kernel_common.

// Whether most of a voxel's soil was never moved.
bool is_bonded(int voxel) { return 2 * state_at(kPlaneBond, voxel) >= state_at(kPlaneVolume, voxel); }

// Cohesion over unit weight of moved soil, Q16 voxels: by its relative density where compaction gives it some back.
int loose_strength_at(int voxel) {
    int loose = params.regains_cohesion == 0 ? 0 : loose_word(voxel);
    if (loose == 0) return mixed_word(voxel, kSoilLoose, kTableStrength);
    int density = relative_density(voxel, loose, mass_at(voxel), state_at(kPlaneVolume, voxel)) * (kRegainedEntries - 1);
    int entry = min(density >> 16, kRegainedEntries - 2);
    int least = mixed_word(voxel, kSoilLoose, kTableRegained + entry);
    int next = mixed_word(voxel, kSoilLoose, kTableRegained + entry + 1);
    return least + mul_q16(next - least, density - entry * kOneQ16);
}

// Cohesion over unit weight, Q16 voxels: with that of moisture, 4 S (1 - S) of its most, and the weight of the water.
int strength_at(int voxel, int soil_state) {
    int strength = soil_state == kSoilLoose ? loose_strength_at(voxel) : mixed_word(voxel, soil_state, kTableStrength);
    int water = water_at(voxel);
    if (water <= 0) return strength;
    int moist = mixed_word(voxel, soil_state, kTableMoist);
    if (strength + moist == 0) return 0;
    int saturation = saturation_at(voxel);
    int mass = mass_at(voxel) * kWaterParts;
    strength = min(strength + 4 * mul_q16(moist, mul_q16(saturation, kOneQ16 - saturation)), kStrengthMost);
    return mass > 0 ? mul_q16(strength, fraction_q16(mass, mass + water)) : strength;
}

// Whether find_failures may take a voxel for soil as strong as params.bank_strength.
bool is_intact(int voxel) {
    if (state_at(kPlaneTerrain, voxel) >= kSolidCoverage) return true;
    int volume = state_at(kPlaneVolume, voxel);
    return volume > 0 && state_at(kPlaneBond, voxel) >= volume - kIntactSlack &&
           strength_at(voxel, kSoilBonded) >= params.bank_strength;
}
