// The uniform block of every kernel: 32-bit integers only, so that std140 and C++ agree. One member a line.
int plane_stride;        // words of one state plane: room for tile slots * voxels of a tile + kPlanePad
int block_count;         // of all tile slots
int column_count;        // words of one array of columns: those of all tile slots + kColumnPad
int tile_voxels;         // voxels of a tile: 64 * height
int height;              // voxels up, a multiple of 8
int size_x;              // columns of the grid along x and y: those of the last tiles beyond them are a wall
int size_y;
int blocks_per_tile;     // height / 8
int material_count;
int transport_count;     // planes that move with the soil: 8 + material_count + water_count
int substep_count;       // parts of this base step
int substep;             // which of them advect_soil works on, from 0
int body_substep_count;  // parts of it in which bodies move: at most a voxel each
int resolved_most;       // speed that the most parts a step may have resolve, Q16 voxels per base step
int gravity_q16;         // gravity in Q16 voxels per base step squared; of short steps it changes by one from step to step
int arch_speed;          // sqrt(g voxel), Q16 voxels per base step: no arch is slower, soil pushed no faster rests. 0: no gravity
int push_speed;          // that of the fastest body in this step, Q16 voxels per base step; 0 where slides settle
int still_speed;         // kStillSpeed by the length of the step, Q16 voxels per base step
int arch_reach;          // voxels to the side of an arch at most; 0: there are none
int list_offset;         // where this dispatch's list starts in block_list
int overflow_heuristic;  // kOverflowEven ...
int shape_offset;        // word offset of the shape records
int contact_capacity;
int pair_offset;         // voxelize_shapes: where its (block, shape) pairs start in block_list
int body_count;
int contact_offset;      // where the contact records start in result
int pass_stamp;          // grows with every pass that moves soil
int chance;              // of voxel_chance(): the step, and which of its passes that move soil
int step_stamp;          // grows with every step
int support_stamp;       // find_support, build_spans and slip_soil look at columns with a kColumnStamp above these: that of
int spans_stamp;         // the pass before their last run
int slip_stamp;          // ... over this slip_stride
int slip_turn;           // 0 or 1, changes with every slip pass: which set of slip speeds is read
int slip_stride;         // voxels that soil slides at once in this slip pass, 1..4: tiles of one colour are two apart
int bank_friction;       // the least kTableFriction of a material, and of those with cohesion the least kTableStrength of bonded
int bank_strength;       // soil; 0 where none has any
int loose_strength;      // the least kTableStrength of loose soil of a material, 0 where one has none or takes water
int keeps_cohesion;      // 1: loose soil of a material has cohesion; 0: of none
int regains_cohesion;    // 1: compaction gives moved soil of a material cohesion; 0: of none
int fails_near;          // 1: find_failures looks where soil has just failed; 0: everywhere
int dilates;             // 1: dense soil of a material has a peak angle of friction; 0: of none
int slip_rate_least;     // share of a failing wedge that slides in a pass, Q16: kSlipRateLeast and kSlipRateMost by the length of
int slip_rate_most;      // the step
int flow_offset;         // where the words of sources and sinks start in tables, see kFlowWords
int flow_result;         // where their results start in result
int place_rows;          // columns along y of the grid, whole tiles
int place_shift;         // bits by which place_code() cuts a voxel's height
int slide_stamp;         // as slip_stamp, of slide_soil
int slides;              // 1: soil on the ground keeps its momentum until friction has taken it; 0: the ground takes it at once
int slide_count;         // slide passes in a base step
int slide_kick;          // gravity (Q24) that sets sliding soil in motion in this slip pass
int water_count;         // 1: soil takes water, and water_plane has it; 0: there is no such plane
int water_plane;
int rain_units;          // water that falls on a column in this water step, water units
int drying_units;        // water that dries off a column in it
int floor_seepage;       // water that the floor takes from a column in it, water units Q4
int water_table;         // height of the groundwater over the floor, Q16 voxels; 0: there is none
int deposits;            // 1: a material has roughness or viscosity
int air;                 // 1: a material falls in air, kTableAir
int wind_x;              // velocity of the air, Q16 voxels per base step
int wind_y;
int wind_z;
int gust;                // share by which gusts raise and lower it, Q16
int gust_cell;           // from one gust to the next, voxels
int gust_x;              // how far they have drifted, back from kGustPeriod gusts, Q8 voxels
int gust_y;
int shelter;             // voxels upwind in which something may bar the wind
