// A record of soil that a body meets. Part of kernel_common.

CONST_INT(kRangeMost, 67108864)  // 2^26 of volume: fraction_q16 takes less than twice as much

// Volume of a mass unit of the soil in a voxel once it is loose; 0 where its density is fixed.
int loose_of_range(int soil_voxel) {
    return tables[kSoilStates * main_material(soil_voxel) * kTableWords + kTableLoose] > 0 ? loose_word(soil_voxel) : 0;
}

// A part of a whole (Q16), however large both are.
int share_of(int part, int whole) {
    while (whole >= kRangeMost) {
        whole = whole / 2;
        part = part / 2;
    }
    return fraction_q16(part, max(1, whole));
}

// Relative density (Q16) of soil that fills a volume, and that would fill most_held loose and less by a range compacted.
int density_between(int most_held, int range, int held) { return share_of(clamp(most_held - held, 0, range), range); }

// Relative density (Q16) of a mass of such soil that fills a volume. loose: loose_of_range(), not 0.
int relative_density(int soil_voxel, int loose, int mass, int held) {
    int most_held = mul_q16(mass, loose);
    return density_between(most_held, max(0, most_held - mul_q16(mass, compacted_word(soil_voxel))), held);
}

// Soil of voxels that are mostly of one material, each loose and compacted by its own mixture: volumes add up. What is mostly
// of another material has no part in it: a contact has the strength of one, and how dense another is says nothing of that.
// Voxels in a row that are made of the same count as one, so that one material is rounded once.
struct DensitySum {
    ivec2 words;    // volume of a mass unit of the last such voxels, loose and compacted, Q16
    int mass;       // theirs: not yet in what follows
    int most_held;  // volume of the others once it is loose
    int range;      // and how much less it is compacted
    int held;       // volume as it is, of all
    int material;
};

DensitySum no_density(int material) {
    DensitySum sum;
    sum.words = ivec2(0);
    sum.mass = 0;
    sum.most_held = 0;
    sum.range = 0;
    sum.held = 0;
    sum.material = material;
    return sum;
}

void close_density(INOUT(DensitySum) sum) {
    int most_held = mul_q16(sum.mass, sum.words.x);
    sum.most_held += most_held;
    sum.range += max(0, most_held - mul_q16(sum.mass, sum.words.y));
    sum.mass = 0;
}

void add_density(int voxel, INOUT(DensitySum) sum) {
    int mass = mass_at(voxel);
    if (mass > 0) {  // what has no mass is of no material
        if (main_material(voxel) != sum.material) return;
        ivec2 words = mixed_pair(voxel, 0, kTableHeld);  // and kTableHeldLeast
        if (words.x != sum.words.x || words.y != sum.words.y) {
            close_density(sum);
            sum.words = words;
        }
        sum.mass += mass;
    }
    sum.held += state_at(kPlaneVolume, voxel);
}

// Share (Q16) of a volume of soil that was never moved. It matters where soil has cohesion.
int undisturbed_share(int bonded, int held) {
    return params.bank_strength == 0 ? kOneQ16 : share_of(min(bonded, held), held);
}

// What a record says of the soil beside a body.
struct SoilBeside {
    int density;      // relative density, Q16; or kDensityFixed
    int undisturbed;  // share that was never moved, Q16
};

// Where a new record begins in result, with the words that say what soil it is; 0, and a condition, where there is no room.
int add_contact(ivec3 where, int body, int soil_voxel, IN(SoilBeside) beside) {
    int index = ATOMIC_ADD(result[kResultContacts], 1);
    if (index >= params.contact_capacity) {
        ATOMIC_OR(result[kResultStatus], kStatusContactsFull);
        return 0;
    }
    int at = params.contact_offset + index * kContactWords;
    result[at + kContactAt] = where.x;
    result[at + kContactAt + 1] = where.y;
    result[at + kContactAt + 2] = where.z;
    result[at + kContactBody] = body;
    result[at + kContactMaterial] = main_material(soil_voxel) | saturation_at(soil_voxel) << kSaturationShift;
    result[at + kContactDensity] = beside.density;
    result[at + kContactUndisturbed] = beside.undisturbed;
    int support = state_at(kPlaneSupport, soil_voxel);
    result[at + kContactCarrier] = support == kSupportGround ? kOnGround : support - kSupportBody;
    return at;
}
