// The kernels' buffers of 32-bit integers in binding order. What each word means: soil_layout.h. The map is printed by
// tests/soil/memory_map_test.cpp from the layout, which fails where it says something else. M: materials. W: 1 where soil takes
// water, else 0. K: kept, goes to sleep with its tile. T: transported, moves with the soil.
//
// state  plane  0  coverage           4 B a voxel              bodies in the voxel, volume units, not clamped
// state  plane  1  owner              4 B a voxel              body that covers most
// state  plane  2  terrain            4 B a voxel              terrain and ground bodies, volume units [K]
// state  plane  3  support            4 B a voxel              falling, on the ground, or on a body
// state  plane  4  volume             4 B a voxel              soil, volume units [K T]
// state  plane  5  momentum x y z     12 B a voxel             mass units * Q10 velocity [K T]
// state  plane  8  force x y z        12 B a voxel             direction of the push [K T]
// state  plane 11  bond               4 B a voxel              volume units never moved [K T]
// state  plane 12  mass of material m 4 M B a voxel            mass units [K T]
// state  plane 12 + M  water          4 W B a voxel            water units, behind the materials [K T]
// delta  as planes 4 ...              32 + 4 M + 4 W B a voxel what a pass moves; zero between passes
//   state and delta                   80 + 8 M + 8 W B a voxel 88 with one dry material, 152 with 8 that take water
// tile_table                          64 B a tile              neighbours' slots, place, top of the soil
// block_list                          4 B an entry             work lists of the step
// block_flags  flags                  16 B a block             4 stamps
//              masks                  128 B a block            columns and voxels with work
// spans  records                      368 B a column           16 spans, slip speeds, bases
//        arrays                       52 B a column            surface, stamp, ends, cut ...
//        of slots                     20 B a tile              stamp, toes, cut, failing
// shapes  bodies                      64 B a body              velocity, friction ...
//         shapes                      128 B a shape            kind, place, size
//         faces of hulls              16 B a face              normal, offset
//         bricks of lattices          1024 B a brick           distances; 4 B where the surface is far
// tables                              7872 B a material        wedges and accelerations: bonded, loose, failing
//         flows                       80 B a flow              source, sink or open side, 64 at most
//         parts of flows              516 B a part             what of a flow's region lies in one tile
// result  header                      112 B                    conditions, counts, momentum
//         loads                       4096 x 60 B              soil that each body carries, momentum it gave
//         flows                       64 x 72 B                what each has moved, by material
//         contacts                    1048576 x 64 B           voxels in which bodies meet soil; 65536 at first
//
// LONG_BUFFER: may outgrow one storage block of OpenGL. Kernels reach its words by NAME_word(), set_NAME_word(), add_to_NAME()
// and raise_NAME() alone.
#ifndef LONG_BUFFER
#define LONG_BUFFER(name) BUFFER(name)
#endif
LONG_BUFFER(state)
LONG_BUFFER(delta)
BUFFER(tile_table)
BUFFER(block_list)
BUFFER(block_flags)
BUFFER(spans)
BUFFER(shapes)
BUFFER(tables)
BUFFER(result)
#undef LONG_BUFFER
