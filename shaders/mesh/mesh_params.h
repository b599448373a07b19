// The uniform block of the kernels that mesh the surface. One member a line.
int size_x;  // voxels of the grid
int size_y;
int size_z;
int tile_count;   // tiles of this dispatch
int close_floor;  // 1: with the faces on the grid's floor
int vertex_capacity;  // what there is room for in the buffers
int copy_capacity;
int triangle_capacity;
