// How strong a voxel's soil is, by what has become of it. Part of kernel_common.

// Whether most of a voxel's soil was never moved.
bool is_bonded(int voxel) { return 2 * state_at(kPlaneBond, voxel) >= state_at(kPlaneVolume, voxel); }

// A word of a voxel's soil that goes by its relative density, or by none where that is fixed: word.
int word_by_density(int voxel, int soil_state, int word) {
    int loose = loose_word(voxel);
    if (loose == 0) return mixed_word(voxel, soil_state, word);
    int density = relative_density(voxel, loose, mass_at(voxel), state_at(kPlaneVolume, voxel)) * (kDensityEntries - 1);
    int entry = min(density >> 16, kDensityEntries - 2);
    int least = mixed_word(voxel, soil_state, kTableByDensity + entry);
    int next = mixed_word(voxel, soil_state, kTableByDensity + entry + 1);
    return least + mul_q16(next - least, density - entry * kOneQ16);
}

// tan(phi), Q16. Dense soil that was never moved has a peak, Bolton (1986); what moves has the critical angle.
int friction_at(int voxel, int soil_state) {
    bool has_peak = params.dilates != 0 && soil_state == kSoilBonded;
    return has_peak ? word_by_density(voxel, soil_state, kTableFriction) : mixed_word(voxel, soil_state, kTableFriction);
}

// Cohesion over unit weight of soil without water, Q16 voxels. Compaction gives moved soil some back.
int dry_strength_at(int voxel, int soil_state) {
    bool is_regained = params.regains_cohesion != 0 && soil_state == kSoilLoose;
    return is_regained ? word_by_density(voxel, soil_state, kTableStrength) : mixed_word(voxel, soil_state, kTableStrength);
}

// Cohesion over unit weight, Q16 voxels: with that of moisture, 4 S (1 - S) of its most, and the weight of the water.
int strength_at(int voxel, int soil_state) {
    int strength = dry_strength_at(voxel, soil_state);
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
