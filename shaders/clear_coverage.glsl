// Empties the coverage field of the listed blocks before their bodies are voxelized again.
// Writes: coverage, owner.
void clear_coverage(int group, int lane) {
    int base = block_list[params.list_offset + group] * kBlockVoxels + lane;
    for (int z = 0; z < 8; ++z) {
        set_state(kPlaneCoverage, base + z * kTileColumns, 0);
        set_state(kPlaneOwner, base + z * kTileColumns, 0);
    }
}
