// The kernels that mesh the soil's surface, in the order in which they run. See shaders/kernel_list.h for what PLAIN means.
PLAIN(count_edges)
PLAIN(place_edges)
PLAIN(make_vertices)
PLAIN(count_triangles)
PLAIN(place_triangles)
PLAIN(make_triangles)
PLAIN(keep_mesh)
