// Small bodies, smaller than a voxel, and the soil that they are in: one record each, of the voxel that its middle is in or of the
// one below. Several may be in one voxel, which knows one owner, and the coverage field has hardly a trace of them. Where
// their surfaces are the host knows from their shapes: the gradient here is 0.
// One group per (tile slot, body) pair. Reads: volume, bond, support, materials, water. Writes: result.

int collect_small_bodies_lanes(int group, int half_at) { return half_at == 0 ? 1 : 0; }

void collect_small_bodies(int group, int lane) {
    int pair = params.list_offset + kPairWords * group;
    int slot = block_list[pair + kPairSlot];
    int body = block_list[pair + kPairBody];
    int place = shapes[body * kBodyWords + kBodyPlace] - 1;
    int voxel = slot * params.tile_voxels + place;
    int column = place & (kTileColumns - 1);
    ivec3 where = grid_voxel(slot, column & 7, column >> 3, place / kTileColumns);
    int below = where.z > 0 ? voxel - kTileColumns : voxel;
    int soil_voxel = state_at(kPlaneVolume, below) > state_at(kPlaneVolume, voxel) ? below : voxel;
    int support = state_at(kPlaneSupport, soil_voxel);
    // Soil that falls bears nothing, and what lies on a body moves with it.
    if (state_at(kPlaneVolume, soil_voxel) == 0 || support == kSupportNone || support == kSupportBody + body) return;
    int held = state_at(kPlaneVolume, soil_voxel);
    SoilBeside found;
    found.density = kDensityFixed;
    found.undisturbed = undisturbed_share(state_at(kPlaneBond, soil_voxel), held);
    int loose = loose_of_range(soil_voxel);
    if (loose > 0) found.density = relative_density(soil_voxel, loose, mass_at(soil_voxel), held);
    int at = add_contact(where, body, soil_voxel, found);
    if (at == 0) return;
    for (int word = kContactGradient; word <= kContactExcess; ++word) result[at + word] = 0;
    result[at + kContactLoad] = 0;
}
