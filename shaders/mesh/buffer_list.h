// The buffers of the kernels that mesh the surface, in binding order. What each word means: mesh_layout.h.
//
// cases      5 words a case of marching cubes   from marching_cases() of the CPU's mesher
// tiles      header, then a record a tile       what a tile is, and where its mesh begins
// columns    a record a column of a window      what the display field holds: runs, samples inside
// runs       runs and solid runs                bottoms and tops
// work       of a tile                          which edges are crossed, counts and places
// vertices   9 words a vertex                   grid axes; the host turns them to the world's
// copies     2 words a copy of a vertex         sharp rims of the grid's sides
// triangles  3 words a triangle                 numbers of vertices within the tile
//
// Of meshes that stay on the device, tiles at places that the host chooses:
// kept_vertices  12 words a vertex              as SharedVertex has them
// kept_indices   3 words a triangle             numbers of vertices within the tile
// kept_draws     5 words a tile                 commands that draw it, written by the host
BUFFER(cases)
BUFFER(tiles)
BUFFER(columns)
BUFFER(runs)
BUFFER(work)
BUFFER(vertices)
BUFFER(copies)
BUFFER(triangles)
BUFFER(kept_vertices)
BUFFER(kept_indices)
BUFFER(kept_draws)
