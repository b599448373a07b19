// Helpers of the test kernels.

int lane_index(int group, int lane) { return group * 64 + lane; }
