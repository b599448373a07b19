// Every kernel: KERNEL(name) runs shaders/<name>.glsl's `void name(int group, int lane)`.
// SCATTER kernels add to the voxels of neighbouring tiles; PLAIN ones write only their own group's tile.
PLAIN(clear_coverage)
PLAIN(voxelize_shapes)
PLAIN(apply_force)
SCATTER(propagate_force)
PLAIN(apply_flow)
PLAIN(find_support)
SCATTER(advect_soil)
SCATTER(resolve_overflow)
PLAIN(build_spans)
SCATTER(slip_soil)
PLAIN(collect_contacts)
