// Which words belong to a voxel, for the counting kernels: included into
// plugin/src/device/cpu_kernels.cpp.

CellMap cells_of(BufferPlace buffer, const KernelParams& params) {
    if (buffer == place_of_state) return {.plane_words = params.plane_stride, .cell_words = 1};
    if (buffer == place_of_delta) return {.plane_words = 0, .cell_words = params.transport_count};
    return {};
}
