// Every kernel: KERNEL(name) runs shaders/<name>.glsl's `void name(int group, int lane)` for the lanes that its
// `int name_lanes(int group, int half_at)` asks for: a bit a lane, half_at 0 for the lanes 0 to 31 and 1 for the others.
// kAllLanes where all have work. What a lane changes must not
// change who else of its group is asked for: on a GPU each lane asks for itself, whenever it comes to run.
// SCATTER kernels add to the voxels of neighbouring tiles; PLAIN ones write only their own group's tile.
PLAIN(clear_coverage)
PLAIN(voxelize_shapes)
PLAIN(pour_soil)
SCATTER(move_water)
PLAIN(apply_force)
SCATTER(propagate_force)
PLAIN(apply_flow)
PLAIN(find_support)
SCATTER(advect_soil)
SCATTER(resolve_overflow)
PLAIN(build_spans)
PLAIN(find_failures)
PLAIN(break_bonds)
PLAIN(slow_slides)
SCATTER(slide_soil)
SCATTER(slip_soil)
PLAIN(take_soil)
PLAIN(collect_contacts)
PLAIN(collect_small_bodies)
