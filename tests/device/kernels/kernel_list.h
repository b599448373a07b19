// Kernels that test the device layer itself; built like those of shaders/kernel_list.h.
PLAIN(probe_builtins)
PLAIN(touch_buffers)
PLAIN(mark_groups)
PLAIN(count_atomically)
PLAIN(touch_long_buffer)
SCATTER(scatter_to_neighbours)
