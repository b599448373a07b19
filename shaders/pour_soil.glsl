// Soil that sources pour into the grid in this step: in lumps, spread over the voxels of their regions, each as large as
// there is room. What a lump lacks is due again in the next step; the host adds that up.
// Reads: coverage, terrain, volume, sources. Writes: deltas, result.

int pour_soil_lanes(int group, int half_at) { return flow_lanes(group, half_at); }

CONST_INT(kJetAside, 1024)  // the largest number of jet_chance

// From -kJetAside to kJetAside, another for each voxel and pass; again primes of xxHash.
int jet_chance(uint seed) {
    uint bits = mix_bits(seed, 15);
    bits = (bits ^ (bits >> 13)) * 3266489917u;
    return (int(bits >> 16) & (2 * kJetAside - 1)) - (kJetAside - 1);
}

void pour_soil(int group, int lane) {
    int slot = flow_slot(group);
    int part = flow_part(group);
    int range = tables[part + kFlowColumns + lane];
    int low = range & kLowHalf;
    int high = range >> 16;
    uint count = uint(flow_word(part, kFlowCount));
    int lumps = flow_word(part, kFlowLumps);
    int plane = flow_word(part, kFlowPlane);
    int poured = 0;
    for (int z = low; z < high; ++z) {
        uint number = uint(tables[part + kFlowFirst + lane] + z - low);
        int turn = int((number * uint(flow_word(part, kFlowStride)) + uint(flow_word(part, kFlowTurn))) % count);
        int voxel = slot * params.tile_voxels + z * kTileColumns + lane;
        if (turn >= lumps || is_solid(voxel) || block_flags[flag_index(kFlagListed, voxel >> 9)] == 0) {
            continue;
        }
        int mass = flow_word(part, kFlowUnits) + (turn < flow_word(part, kFlowRest) ? 1 : 0);
        int volume = mul_q16(mass, flow_word(part, kFlowVolume));
        int room = kVoxelFull - coverage_at(voxel) - state_at(kPlaneVolume, voxel);
        if (volume > room) {
            mass = room > 0 ? mul_q16(mass, fraction_q16(room, volume)) : 0;
            volume = mul_q16(mass, flow_word(part, kFlowVolume));
        }
        if (mass <= 0) continue;
        uint seed = place_bits(ivec3(int(number), 0, 0)) ^ pass_bits();
        int across = jet_chance(seed);
        int along = jet_chance(seed + 374761393u);
        ivec3 gained = ivec3(0);
        for (int axis = 0; axis < 3; ++axis) {
            int aside = flow_word(part, kFlowAside + axis) * across + flow_word(part, kFlowAside + 3 + axis) * along;
            int speed = clamp(flow_word(part, kFlowVelocity + axis) + aside / kJetAside, -kFlowSpeedMost, kFlowSpeedMost);
            gained[axis] = mass * speed;
            add_delta(kPlaneMomentumX + axis, voxel, gained[axis]);
        }
        add_momentum_sum(kResultFallen, gained);
        add_delta(plane, voxel, mass);
        add_delta(kPlaneVolume, voxel, max(1, volume));
        int water = params.water_plane == 0 ? 0 : mul_q16(mass, flow_word(part, kFlowWater));
        if (water > 0) {
            add_delta(params.water_plane, voxel, water);
            add_wide(kResultWaterIn, water);
        }
        mark_moved(voxel, voxel);
        poured += mass;
    }
    if (poured > 0) add_wide(flow_sum(part, 2 * (plane - kPlaneMaterial)), poured);
}
