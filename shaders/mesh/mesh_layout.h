// Layout shared by the kernels that mesh the surface and the host, and the constants of the display field.

// --- the display field ------------------------------------------------------------------------------------------
CONST_FLOAT(kReach, 6.0f)  // the field is linear this far from a surface [samples]
// Up to the first height difference a voxel aside tops are joined by a straight line, from the second on by an upright wall
// half way. 2.5 is 68 degrees: steeper than any slope at rest.
CONST_FLOAT(kSlopeMax, 2.5f)
CONST_FLOAT(kWallMin, 5.0f)
// Beyond this a height difference [samples] tilts normals no more.
CONST_FLOAT(kNormalReach, 2.0f)
// Soil this far below its top is seen from above [samples].
CONST_FLOAT(kBareDepth, 1.5f)
// Where soil that is hidden in terrain ends between two samples, so as not to peep out.
CONST_FLOAT(kHiddenEdge, 0.05f)

// --- tiles ------------------------------------------------------------------------------------------------------
CONST_INT(kTileSide, 8)  // columns
// Most samples one way of a tile with its neighbours' that its cells and normals read, and columns of such a window.
CONST_INT(kWindowSide, 12)
CONST_INT(kWindowColumns, 144)
// A lane each, in groups of 64.
CONST_INT(kWindowGroups, 3)
CONST_INT(kGroupLanes, 64)

// Totals in front of the tiles' records: vertices, copies and triangles of all.
CONST_INT(kTotalVertices, 0)
CONST_INT(kTotalCopies, 1)
CONST_INT(kTotalTriangles, 2)
CONST_INT(kHeaderWords, 4)
// A tile's record.
CONST_INT(kTileSpacing, 0)    // voxels from one sample to the next
CONST_INT(kTileOriginX, 1)    // first sample of its window
CONST_INT(kTileOriginY, 2)
CONST_INT(kTileFirstX, 3)     // its own cells
CONST_INT(kTileFirstY, 4)
CONST_INT(kTileLastX, 5)
CONST_INT(kTileLastY, 6)
CONST_INT(kTileColumnsAt, 7)  // in `columns`
CONST_INT(kTileWordCount, 8)  // words that hold a bit for each sample of a column
CONST_INT(kTileWorkAt, 9)     // in `work`
CONST_INT(kTileVertexAt, 10)  // what follows is the kernels' own
CONST_INT(kTileVertexCount, 11)
CONST_INT(kTileCopyAt, 12)
CONST_INT(kTileCopyCount, 13)
CONST_INT(kTileTriangleAt, 14)
CONST_INT(kTileTriangleCount, 15)
CONST_INT(kTileKeptVertexAt, 16)  // where keep_mesh puts its mesh: vertices in kept_vertices,
CONST_INT(kTileKeptIndexAt, 17)   // indices in kept_indices
CONST_INT(kTileWords, 18)

// A column's record, then the samples that are inside and those beside another material, a bit each.
CONST_INT(kColumnRunAt, 0)     // in `runs`, where its runs begin and end
CONST_INT(kColumnRunEnd, 1)
CONST_INT(kColumnSolidAt, 2)   // and its solid runs
CONST_INT(kColumnSolidEnd, 3)
CONST_INT(kColumnIsPlain, 4)   // its cell may be joined to others, see PlaneStrips
CONST_INT(kColumnFloor, 5)     // material on the floor
CONST_INT(kColumnLayerAt, 6)   // in `runs`, where its layers begin and end: none unless meshes are kept
CONST_INT(kColumnLayerEnd, 7)
CONST_INT(kColumnWords, 8)
CONST_INT(kRunBottom, 0)       // float
CONST_INT(kRunTop, 1)          // float
CONST_INT(kRunInSolid, 2)
CONST_INT(kRunLook, 3)         // in `runs`, the look of what lies bare on it
CONST_INT(kRunPlain, 4)        // and that of its material by itself
CONST_INT(kRunWords, 5)
CONST_INT(kSolidWords, 2)      // bottom and top
CONST_INT(kLayerBottom, 0)     // from this voxel up, until the next layer, the soil inside
CONST_INT(kLayerLook, 1)       // has the look at this place in `runs`
CONST_INT(kLayerWords, 2)
// What soil looks like. The materials by themselves come first in `runs`.
CONST_INT(kLookColor, 0)       // 3 floats, linear RGB
CONST_INT(kLookWetness, 3)     // float, 0..1
CONST_INT(kLookWeights, 4)     // a byte each
CONST_INT(kLookWords, 6)

// Of a tile's work: for each column and each of its three edges a record, then for each column one of its cells.
CONST_INT(kEdgesOfColumn, 3)   // up, along x, along y
CONST_INT(kEdgeFirst, 0)       // number of its first vertex; until they are placed how many there are
CONST_INT(kEdgeBits, 1)        // a bit for each sample whose edge has a vertex
CONST_INT(kCellTriangles, 0)   // place of its first one; until they are placed how many there are
CONST_INT(kCellCopies, 1)
CONST_INT(kCellWords, 2)

// --- the mesh ---------------------------------------------------------------------------------------------------
CONST_INT(kVertexPosition, 0)  // 3 floats, grid voxels
CONST_INT(kVertexOutward, 3)   // 3 floats, of any length
CONST_INT(kVertexLook, 6)      // which column's soil shows, and how: kLook...
CONST_INT(kVertexSample, 7)    // and at which sample
CONST_INT(kVertexEdge, 8)      // the edge it lies on: (sample * columns + column) * 3 + 0 up, 1 along x, 2 along y
CONST_INT(kVertexWords, 9)
CONST_INT(kLookKinds, 4)       // the column times this plus one of
CONST_INT(kLookBare, 0)        // what lies bare there
CONST_INT(kLookFloor, 1)       // the material on the floor
CONST_INT(kLookCut, 2)         // what a side of the grid cuts
CONST_INT(kCopyOf, 0)          // number of the vertex
CONST_INT(kCopySide, 1)        // outward along x and y, each -1, 0 or 1: x + 1 + 3 (y + 1)
CONST_INT(kCopyWords, 2)
CONST_INT(kTriangleWords, 3)

// A vertex that stays on the device, see SharedVertex.
CONST_INT(kKeptPosition, 0)    // 3 floats, grid voxels
CONST_INT(kKeptNormal, 3)      // 3 floats, of unit length, grid axes
CONST_INT(kKeptLook, 6)        // kLookWords
CONST_INT(kKeptWords, 12)
CONST_INT(kDrawWords, 5)       // a command of glMultiDrawElementsIndirect

// A case of marching cubes: how many triangles, then the edges of their corners.
CONST_INT(kCaseWords, 5)
CONST_INT(kCaseEdgesPerWord, 8)
CONST_INT(kCaseEdgeBits, 4)
CONST_INT(kCaseEdgeMask, 15)
