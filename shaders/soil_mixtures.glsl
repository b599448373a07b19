// What a voxel's soil is made of: its materials, their means, its water. Part of kernel_common.

// Whether a plane is of mass: those behind the materials may hold something else that travels with the soil.
bool is_mass(int plane) { return plane >= kPlaneMaterial && plane < kPlaneMaterial + params.material_count; }

int mass_at(int voxel) {
    int mass = 0;
    for (int m = 0; m < params.material_count; ++m) mass += state_at(kPlaneMaterial + m, voxel);
    return mass;
}

// The material there is most of; the lowest index on a tie.
int main_material(int voxel) {
    if (params.material_count == 1) return 0;
    int best = 0;
    int most = -1;
    for (int m = 0; m < params.material_count; ++m) {
        int units = state_at(kPlaneMaterial + m, voxel);
        if (units > most) {
            most = units;
            best = m;
        }
    }
    return best;
}

// Soil of several materials: each of these words is the mean by mass of its materials' words. So is tan phi. Cohesion over unit
// weight then is the mean cohesion by volume over the mixture's own unit weight, and volumes of a mass unit add up exactly.
// soil_state: kSoilBonded ...
int mixed_word(int voxel, int soil_state, int at) {
    int main = main_material(voxel);
    int word = tables[(kSoilStates * main + soil_state) * kTableWords + at];
    if (params.material_count == 1) return word;
    int mass = mass_at(voxel);
    int mean = word;
    for (int m = 0; m < params.material_count; ++m) {
        int units = state_at(kPlaneMaterial + m, voxel);
        if (m != main && units > 0) {
            mean += mul_q16(fraction_q16(units, mass), tables[(kSoilStates * m + soil_state) * kTableWords + at] - word);
        }
    }
    return mean;
}

// The same of a word and the one behind it. On OpenGL a kernel holds a copy of this for each place that asks. Mesa's compiler
// takes more than twice as long for twice as many copies.
ivec2 mixed_pair(int voxel, int soil_state, int at) {
    int main = main_material(voxel);
    int row = (kSoilStates * main + soil_state) * kTableWords + at;
    ivec2 word = ivec2(tables[row], tables[row + 1]);
    if (params.material_count == 1) return word;
    int mass = mass_at(voxel);
    ivec2 mean = word;
    for (int m = 0; m < params.material_count; ++m) {
        int units = state_at(kPlaneMaterial + m, voxel);
        if (m != main && units > 0) {
            int share = fraction_q16(units, mass);
            row = (kSoilStates * m + soil_state) * kTableWords + at;
            mean += ivec2(mul_q16(share, tables[row] - word.x), mul_q16(share, tables[row + 1] - word.y));
        }
    }
    return mean;
}

// Whether a voxel holds more than one material.
bool is_mixed(int voxel) {
    return params.material_count > 1 && mass_at(voxel) != state_at(kPlaneMaterial + main_material(voxel), voxel);
}

// Water of a voxel's soil, water units; 0 where no soil of the grid takes any.
int water_at(int voxel) { return params.water_plane == 0 ? 0 : state_at(params.water_plane, voxel); }

// Water units out of Q4 of them: what is less than one comes by chance, so that slow water gets on too.
int whole_units(int units_q4, int chance) { return (units_q4 + (chance >> 12)) >> 4; }

// Water that the pores of a voxel's soil have room for, water units.
int pores_at(int voxel) { return mul_q16(mass_at(voxel) * kWaterParts, mixed_word(voxel, 0, kTablePores)); }

// Share of pores that water fills, Q16.
int saturation_of(int water, int pores) {
    return pores <= 0 ? 0 : (water >= pores ? kOneQ16 : fraction_q16(water, pores));
}
int saturation_at(int voxel) {
    int water = water_at(voxel);
    return saturation_of(water, water > 0 ? pores_at(voxel) : 0);
}

// Whether a share of a voxel's soil has any mass. What has none is no soil that moves: room, water or momentum alone would go on
// between two voxels for good. So a unit of it cannot be shared out: it stays, and asks for no block to be awake.
bool moves_any(int from, int fraction) {
    for (int m = 0; m < params.material_count; ++m) {
        if (mul_q16(state_at(kPlaneMaterial + m, from), fraction) != 0) return true;
    }
    return false;
}
