// Step 1 of the thesis' Algorithm 1: bodies into the coverage field psi. One group per (block, shape) pair.
// The share of a voxel that a shape covers is the mean over 4 x 4 x 4 sub-cells of clamp(1/2 - distance), which moves
// smoothly with the body. Only + - * on floats, all `precise`: the same bits on every backend.
// Reads: shapes, volume. Writes: coverage (sum), owner (the shape that covers most), masks, stamps.

vec3 shape_row(int offset) {
    return vec3(int_as_float(shapes[offset]), int_as_float(shapes[offset + 1]),
                int_as_float(shapes[offset + 2]));
}

float shape_number(int offset) { return int_as_float(shapes[offset]); }

float mix_exact(float low, float high, float t) {
    PRECISE float rise = high - low;
    PRECISE float part = rise * t;
    PRECISE float mixed = low + part;
    return mixed;
}

// Two neighbouring samples of a distance lattice along x, interpolated at share t between them.
float lattice_sample(int samples, int node, float t) {
    int word = shapes[samples + (node >> 1)];
    if ((node & 1) == 0) return mix_exact(float((word << 16) >> 16), float(word >> 16), t);
    return mix_exact(float(word >> 16), float((shapes[samples + (node >> 1) + 1] << 16) >> 16), t);
}

// Signed distance [voxels] at a point given in nodes of the shape's lattice.
float lattice_distance(int shape, float px, float py, float pz) {
    int lattice = shapes[shape + kShapeLattice];
    float unit = shape_number(shape + kShapeLatticeUnit);
    PRECISE float outside = float(kLatticeFar) * unit;
    int bricks_x = shapes[lattice + kLatticeBricks];
    int bricks_y = shapes[lattice + kLatticeBricks + 1];
    int bricks_z = shapes[lattice + kLatticeBricks + 2];
    float floor_x = floor(px);
    float floor_y = floor(py);
    float floor_z = floor(pz);
    int x = int(floor_x);
    int y = int(floor_y);
    int z = int(floor_z);
    if (x < 0 || y < 0 || z < 0 || x >= bricks_x * kLatticeCells || y >= bricks_y * kLatticeCells ||
        z >= bricks_z * kLatticeCells) {
        return outside;
    }
    int bx = x / kLatticeCells;
    int by = y / kLatticeCells;
    int bz = z / kLatticeCells;
    int samples = shapes[lattice + kLatticeIndex + (bz * bricks_y + by) * bricks_x + bx];
    if (samples < 0) return samples == kLatticeInside ? -outside : outside;
    samples += lattice;
    int node = ((z - bz * kLatticeCells) * kLatticeNodes + y - by * kLatticeCells) * kLatticeNodes + x - bx * kLatticeCells;
    PRECISE float tx = px - floor_x;
    PRECISE float ty = py - floor_y;
    PRECISE float tz = pz - floor_z;
    float lower = mix_exact(lattice_sample(samples, node, tx), lattice_sample(samples, node + kLatticeNodes, tx), ty);
    int above = node + kLatticeNodes * kLatticeNodes;
    float upper = mix_exact(lattice_sample(samples, above, tx), lattice_sample(samples, above + kLatticeNodes, tx), ty);
    PRECISE float distance = mix_exact(lower, upper, tz) * unit;
    return distance;
}

// How far a point is beyond a plane.
float plane_distance(vec3 p, vec3 normal, float offset) {
    PRECISE float side = p.x * normal.x + p.y * normal.y;
    side = side + p.z * normal.z;
    side = side - offset;
    return side;
}

// The same of a face of a hull.
float face_distance(int face, vec3 p) {
    return plane_distance(p, shape_row(face + kFaceNormal), shape_number(face + kFaceOffset));
}

// Four faces at once: software GL ends a kernel's loops after 65,535 rounds in all, and 252 faces at 64 sub-cells of 8 voxels
// are twice as many.
float hull_distance(int shape, vec3 p) {
    int face = shapes[shape + kShapeFaces];
    int end = face + kFaceWords * shapes[shape + kShapeFaceCount];
    float distance = -1.0e9f;
    for (; face + 3 * kFaceWords < end; face += 4 * kFaceWords) {
        float first = max(face_distance(face, p), face_distance(face + kFaceWords, p));
        float second = max(face_distance(face + 2 * kFaceWords, p), face_distance(face + 3 * kFaceWords, p));
        distance = max(distance, max(first, second));
    }
    for (; face < end; face += kFaceWords) distance = max(distance, face_distance(face, p));
    return distance;
}

float box_distance(vec3 p, vec3 half_extents) {
    PRECISE vec3 beyond = abs(p) - half_extents;
    return max(beyond.x, max(beyond.y, beyond.z));
}

float sphere_distance(vec3 p, float radius) {
    PRECISE float square = p.x * p.x + p.y * p.y;
    square = square + p.z * p.z;
    PRECISE float distance = sqrt_exact(square) - radius;
    return distance;
}

float capsule_distance(vec3 p, float radius, float half_segment) {
    PRECISE float along = p.z - clamp(p.z, -half_segment, half_segment);
    PRECISE float square = p.x * p.x + p.y * p.y;
    square = square + along * along;
    PRECISE float distance = sqrt_exact(square) - radius;
    return distance;
}

float cylinder_distance(vec3 p, float radius, float half_height) {
    PRECISE float square = p.x * p.x + p.y * p.y;
    PRECISE float beside = sqrt_exact(square) - radius;
    PRECISE float above = abs(p.z) - half_height;
    return max(beside, above);
}

// Apex at +half_height.
float cone_distance(vec3 p, float half_height, float cosine, float sine) {
    PRECISE float square = p.x * p.x + p.y * p.y;
    float radial = sqrt_exact(square);
    PRECISE float slant = radial * cosine + (p.z - half_height) * sine;
    PRECISE float below = -half_height - p.z;
    return max(slant, below);
}

// Signed distance [voxels] of a point in the shape's frame, exact near the surface.
float shape_distance(int shape, vec3 p) {
    int kind = shapes[shape + kShapeKind];
    if (kind == kKindLattice) return lattice_distance(shape, p.x, p.y, p.z);
    if (kind == kKindHull) return hull_distance(shape, p);
    if (kind == kKindBox) return box_distance(p, shape_row(shape + kShapeHalfExtents));
    float radius = shape_number(shape + kShapeRadius);
    float half_height = shape_number(shape + kShapeHalfHeight);
    if (kind == kKindSphere) return sphere_distance(p, radius);
    if (kind == kKindCapsule) return capsule_distance(p, radius, half_height);
    if (kind == kKindCylinder) return cylinder_distance(p, radius, half_height);
    return cone_distance(p, half_height, shape_number(shape + kShapeSlantCosine),
                         shape_number(shape + kShapeSlantSine));
}

// A sub-cell's middle is up to 0.65 voxels from the voxel's. A face that is by twice as much the highest in the voxel's middle
// is so in all of them.
#define kFaceApart 1.3125f
// The outermost sub-cells' middles are 0.65 voxels from the voxel's and end 1/8 further on: beyond 0.775 all are in or all out.
#define kSubCellReach 0.8125f
// What makes them up: a sub-cell's middle is so far from the voxel's along each of the grid's axes, its end so far on, and there
// is slack for the rounding, as much as in the two above.
#define kSubCellMiddle 0.375f
#define kSubCellHalf 0.125f
#define kReachSlack 0.03125f
// Of a voxel that is covered in full.
#define kSubCellsFull 64.0f
// Between the middle of 8 voxels above each other and those of the lowest and the highest.
#define kColumnReach 3.5f

// Share of a sub-cell in a shape at this distance [voxels].
float sub_cell_share(float distance) {
    PRECISE float share = 0.5f - distance * 4.0f;
    return clamp(share, 0.0f, 1.0f);
}

// Sum over 4 x 4 x 4 sub-cells beside one of a box's three pairs of faces, far from the others: the distance to them alone tells.
// p: where the voxel's middle is along their normal; rise: how p grows along the grid's axes.
float slab_sum(float p, vec3 rise, float half_extent, float rounding) {
    PRECISE float sum = 0.0f;
    for (int sz = 0; sz < 4; ++sz) {
        PRECISE float z_part = rise.z * (float(sz) * 0.25f - 0.375f);
        for (int sy = 0; sy < 4; ++sy) {
            PRECISE float y_part = rise.y * (float(sy) * 0.25f - 0.375f);
            for (int sx = 0; sx < 4; ++sx) {
                PRECISE float x_part = rise.x * (float(sx) * 0.25f - 0.375f);
                PRECISE float q = p + x_part;
                q = q + y_part;
                q = q + z_part;
                PRECISE float distance = abs(q) - half_extent;
                distance = distance - rounding;
                sum = sum + sub_cell_share(distance);
            }
        }
    }
    return sum;
}

// The same of any shape, whose distance at a sub-cell's middle q is DISTANCE_AT_Q. A loop of its own for each kind of shape: the
// compiler can make vectors of it.
#define ADD_SUB_CELLS(DISTANCE_AT_Q)                                                     \
    for (int sz = 0; sz < 4; ++sz) {                                                     \
        float at_z = float(sz) * 0.25f - 0.375f;                                         \
        PRECISE vec3 z_part = vec3(rise_x.z * at_z, rise_y.z * at_z, rise_z.z * at_z);   \
        for (int sy = 0; sy < 4; ++sy) {                                                 \
            float at_y = float(sy) * 0.25f - 0.375f;                                     \
            PRECISE vec3 y_part = vec3(rise_x.y * at_y, rise_y.y * at_y, rise_z.y * at_y); \
            for (int sx = 0; sx < 4; ++sx) {                                             \
                float at_x = float(sx) * 0.25f - 0.375f;                                 \
                PRECISE vec3 q = p + vec3(rise_x.x * at_x, rise_y.x * at_x, rise_z.x * at_x); \
                q = q + y_part;                                                          \
                q = q + z_part;                                                          \
                PRECISE float distance = (DISTANCE_AT_Q) - rounding;                     \
                sum = sum + sub_cell_share(distance);                                    \
            }                                                                            \
        }                                                                                \
    }

// p: the voxel's middle in the shape's frame; rise_x: how its first coordinate grows along the grid's axes.
float hull_sum(int shape, vec3 p, vec3 rise_x, vec3 rise_y, vec3 rise_z, float rounding) {
    int first = shapes[shape + kShapeFaces];
    int count = shapes[shape + kShapeFaceCount];
    float highest = -1.0e9f;
    int nearest = first;
    for (int i = 0; i < count; ++i) {
        float side = face_distance(first + kFaceWords * i, p);
        if (side > highest) {
            highest = side;
            nearest = first + kFaceWords * i;
        }
    }
    int others = 0;  // faces that are the highest somewhere in the voxel, maybe
    int next = nearest;
    for (int i = 0; i < count; ++i) {
        int face = first + kFaceWords * i;
        if (face != nearest && face_distance(face, p) > highest - kFaceApart) {
            others += 1;
            next = face;
        }
    }
    PRECISE float sum = 0.0f;
    if (others <= 1) {
        vec3 normal = shape_row(nearest + kFaceNormal);
        vec3 next_normal = shape_row(next + kFaceNormal);
        float offset = shape_number(nearest + kFaceOffset);
        float next_offset = shape_number(next + kFaceOffset);
        ADD_SUB_CELLS(max(plane_distance(q, normal, offset), plane_distance(q, next_normal, next_offset)))
    } else {
        ADD_SUB_CELLS(hull_distance(shape, q))
    }
    return sum;
}

float shape_sum(int shape, vec3 p, vec3 rise_x, vec3 rise_y, vec3 rise_z, float rounding) {
    int kind = shapes[shape + kShapeKind];
    if (kind == kKindHull) return hull_sum(shape, p, rise_x, rise_y, rise_z, rounding);
    float radius = shape_number(shape + kShapeRadius);
    float half_height = shape_number(shape + kShapeHalfHeight);
    PRECISE float sum = 0.0f;
    if (kind == kKindBox) {
        vec3 half_extents = shape_row(shape + kShapeHalfExtents);
        ADD_SUB_CELLS(box_distance(q, half_extents))
    } else if (kind == kKindSphere) {
        ADD_SUB_CELLS(sphere_distance(q, radius))
    } else if (kind == kKindCapsule) {
        ADD_SUB_CELLS(capsule_distance(q, radius, half_height))
    } else if (kind == kKindCylinder) {
        ADD_SUB_CELLS(cylinder_distance(q, radius, half_height))
    } else if (kind == kKindCone) {
        float cosine = shape_number(shape + kShapeSlantCosine);
        float sine = shape_number(shape + kShapeSlantSine);
        ADD_SUB_CELLS(cone_distance(q, half_height, cosine, sine))
    } else {
        ADD_SUB_CELLS(shape_distance(shape, q))
    }
    return sum;
}

// A place of the grid in the shape's frame.
vec3 place_in_shape(vec3 rise_x, vec3 rise_y, vec3 rise_z, vec3 offset, vec3 at) {
    PRECISE vec3 p = vec3(rise_x.x * at.x, rise_y.x * at.x, rise_z.x * at.x) +
                     vec3(rise_x.y * at.y, rise_y.y * at.y, rise_z.y * at.y);
    p = p + vec3(rise_x.z * at.z, rise_y.z * at.z, rise_z.z * at.z);
    p = p + offset;
    return p;
}

// How far a box's sub-cells' middles lie from the voxel's, along the box's own axes: no more than a voxel's that turns as it may,
// and in a box that lies along the grid little more than half of that.
vec3 box_reach(vec3 rise_x, vec3 rise_y, vec3 rise_z) {
    return vec3(abs(rise_x.x) + abs(rise_x.y) + abs(rise_x.z), abs(rise_y.x) + abs(rise_y.y) + abs(rise_y.z),
                abs(rise_z.x) + abs(rise_z.y) + abs(rise_z.z)) *
               kSubCellMiddle +
           vec3(kReachSlack);
}

// Whether half a column's voxels, whose middle is at p, are all further off the shape than a sub-cell's reach.
// rise: how a place in the shape's frame moves up the column; reach: of a box.
bool is_column_beside(int shape, vec3 p, vec3 rise, vec3 reach, float rounding) {
    int kind = shapes[shape + kShapeKind];
    if (kind == kKindLattice) {
        return false;  // they know distances only so far
    }
    if (kind == kKindBox) {
        vec3 beyond = abs(p) - shape_row(shape + kShapeHalfExtents) - abs(rise) * kColumnReach - reach;
        return max(beyond.x, max(beyond.y, beyond.z)) - rounding > kSubCellHalf;
    }
    if (kind == kKindHull) {
        int first = shapes[shape + kShapeFaces];
        int count = shapes[shape + kShapeFaceCount];
        float furthest = -1.0e9f;
        for (int i = 0; i < count; ++i) {
            int face = first + kFaceWords * i;
            PRECISE float along = abs(plane_distance(rise, shape_row(face + kFaceNormal), 0.0f)) * kColumnReach;
            furthest = max(furthest, face_distance(face, p) - along);
        }
        return furthest - rounding > kSubCellReach;
    }
    return shape_distance(shape, p) - rounding > kColumnReach + kSubCellReach;
}

// Sum over a voxel's sub-cells. p: its middle in the shape's frame; rise_x: how the first coordinate grows along the grid's axes.
float covered_sum(int shape, vec3 p, vec3 rise_x, vec3 rise_y, vec3 rise_z, float rounding) {
    PRECISE float middle = shape_distance(shape, p) - rounding;
    if (middle >= kSubCellReach) return 0.0f;
    if (middle <= -kSubCellReach) return kSubCellsFull;
    return shape_sum(shape, p, rise_x, rise_y, rise_z, rounding);
}

// The same of a box. A face that is the highest in all sub-cells tells alone.
float covered_sum_of_box(int shape, vec3 p, vec3 reach, vec3 rise_x, vec3 rise_y, vec3 rise_z, float rounding) {
    vec3 half_extents = shape_row(shape + kShapeHalfExtents);
    vec3 beyond = abs(p) - half_extents;
    vec3 low = beyond - reach;
    vec3 high = beyond + reach;
    if (max(low.x, max(low.y, low.z)) - rounding >= kSubCellHalf) return 0.0f;
    if (max(high.x, max(high.y, high.z)) - rounding <= -kSubCellHalf) return kSubCellsFull;
    if (low.x > max(high.y, high.z)) return slab_sum(p.x, rise_x, half_extents.x, rounding);
    if (low.y > max(high.x, high.z)) return slab_sum(p.y, rise_y, half_extents.y, rounding);
    if (low.z > max(high.x, high.y)) return slab_sum(p.z, rise_z, half_extents.z, rounding);
    return shape_sum(shape, p, rise_x, rise_y, rise_z, rounding);
}

// Columns of half a block within the shape's bounds.
int voxelize_shapes_lanes(int group, int half_at) {
    int pair = params.pair_offset + kPairWords * group;
    int slot = block_list[pair + kPairBlock] / params.blocks_per_tile;
    int shape = params.shape_offset + block_list[pair + kPairShape] * kShapeWords;
    ivec3 corner = grid_voxel(slot, 0, half_at * 4, 0);
    int x0 = clamp(shapes[shape + kShapeLow] - corner.x, 0, 8);
    int x1 = clamp(shapes[shape + kShapeHigh] - corner.x, -1, 7);
    int y0 = clamp(shapes[shape + kShapeLow + 1] - corner.y, 0, 4);
    int y1 = clamp(shapes[shape + kShapeHigh + 1] - corner.y, -1, 3);
    int row = x1 < x0 ? 0 : ((1 << (x1 + 1)) - 1) & ~((1 << x0) - 1);
    int lanes = 0;
    for (int y = y0; y <= y1; ++y) lanes = lanes | (row << (y * 8));
    return lanes;
}

void voxelize_shapes(int group, int lane) {
    int pair = params.pair_offset + kPairWords * group;
    int block = block_list[pair + kPairBlock];
    int shape = params.shape_offset + block_list[pair + kPairShape] * kShapeWords;
    int slot = block / params.blocks_per_tile;
    int z0 = (block - slot * params.blocks_per_tile) * 8;
    int x = lane & 7;
    int y = lane >> 3;
    if (!is_in_grid(slot, x, y)) return;
    ivec3 corner = grid_voxel(slot, x, y, z0);
    vec3 column_x = shape_row(shape + kShapeRows);       // rows of the transform: grid voxels -> shape
    vec3 column_y = shape_row(shape + kShapeRows + kShapeRowWords);
    vec3 column_z = shape_row(shape + kShapeRows + 2 * kShapeRowWords);
    vec3 offset = vec3(shape_number(shape + kShapeRows + 3), shape_number(shape + kShapeRows + kShapeRowWords + 3),
                       shape_number(shape + kShapeRows + 2 * kShapeRowWords + 3));
    float rounding = shape_number(shape + kShapeRounding);
    int body = shapes[shape + kShapeBody];
    int lowest = -1;
    int highest = -1;
    bool has_soil = false;

    int kind = shapes[shape + kShapeKind];
    vec3 reach = box_reach(column_x, column_y, column_z);
    int low = max(0, shapes[shape + kShapeLow + 2] - z0);
    int high = min(7, shapes[shape + kShapeHigh + 2] - z0);
    vec3 column_middle = vec3(float(corner.x) + 0.5f, float(corner.y) + 0.5f, float(corner.z) + 4.0f);
    vec3 rise = vec3(column_x.z, column_y.z, column_z.z);
    if (high > low &&
        is_column_beside(shape, place_in_shape(column_x, column_y, column_z, offset, column_middle), rise, reach, rounding)) {
        return;
    }
    for (int z = low; z <= high; ++z) {
        vec3 at = vec3(float(corner.x) + 0.5f, float(corner.y) + 0.5f, float(corner.z + z) + 0.5f);
        vec3 p = place_in_shape(column_x, column_y, column_z, offset, at);
        PRECISE float sum = kind == kKindBox
                                ? covered_sum_of_box(shape, p, reach, column_x, column_y, column_z, rounding)
                                : covered_sum(shape, p, column_x, column_y, column_z, rounding);
        PRECISE float units = sum * float(kSubCellUnits) + 0.5f;
        int covered = int(units);
        if (covered > 0) {
            int voxel = block * kBlockVoxels + z * kTileColumns + lane;
            add_to_state(kPlaneCoverage * params.plane_stride + voxel, covered);
            int key = min(covered, kVoxelFull - 1) / 2 * kOwnerRank + body + 1;
            raise_state(kPlaneOwner * params.plane_stride + voxel, key);
            highest = z;
            lowest = lowest < 0 ? z : lowest;
            has_soil = has_soil || state_at(kPlaneVolume, voxel) > 0;
        }
    }
    if (highest >= 0) {
        set_in_mask(block, kMaskBody, lane, true);
        note_change(slot, lane, z0 + lowest, z0 + highest);
    }
    if (has_soil) set_in_mask(block, kMaskPressed, lane, true);
}
