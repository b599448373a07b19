// Layout shared by the kernels (GLSL 4.50) and the host (C++20): constants, planes, buffers' records.
// GLSL sees it after the prelude that defines CONST_INT; C++ includes it inside a namespace or a struct.

// --- amounts ----------------------------------------------------------------------------------------------------
// One voxel's room is kVoxelFull volume units; 2^16 keeps volume * overflow (16 x) * Q10 velocity inside 31 bits.
CONST_INT(kVoxelFull, 65536)
// Of that in each of the 4 x 4 x 4 sub-cells that coverage is summed over.
CONST_INT(kSubCellUnits, 1024)
// One with 8, 12 and 16 bits behind the point: what Q8, Q12 and Q16 say of a number here.
CONST_INT(kOneQ8, 256)
CONST_INT(kOneQ4, 16)
CONST_INT(kOneQ12, 4096)
CONST_INT(kOneQ16, 65536)
// From a column to the one across a corner: sqrt 2, Q16, and one over it.
CONST_INT(kDiagonal, 92682)
CONST_INT(kDiagonalInverse, 46341)
// The lower of two numbers in a word; of a Q16 number what is behind the point.
CONST_INT(kLowHalf, 65535)
// A bit for each column in a row of a tile.
CONST_INT(kRowMask, 255)
// More soil than this in one voxel can saturate its momentum: 16 voxels, reported as amount_headroom.
CONST_INT(kVoxelMost, 1048576)
// The mass of so much soil at most: 16 voxels of 4000 kg/m3. What more there is has no momentum.
CONST_INT(kMassMost, 2097151)
// More momentum than this no voxel has, along any axis: that of a full one of 4000 kg/m3 at 16 voxels a base step. Where more
// meets, the rest of it is lost, which is reported as amount_headroom too.
CONST_INT(kMomentumMost, 2147483647)
// A voxel at least this much covered is solid to moving soil: nothing flows in. Keeps plates of 2 voxels tight.
CONST_INT(kSolidCoverage, 32768)
// Room a resting voxel may lack and still carry what is above it (rounding crumbs): 1/32 voxel.
CONST_INT(kSupportSlack, 2048)
// The same for a load on a moving body, whose voxels are smeared by the motion: 1/2 voxel. With 1/4 a swinging bucket
// lost a quarter of its load in two seconds, with 1/2 four percent.
CONST_INT(kCarrySlack, 32768)
// Excess a body may press into a voxel before the soil flows: elastic strain, 1/16 voxel.
CONST_INT(kElasticExcess, 4096)
// Excess that soil takes up as strain instead of flowing: 1/128 voxel. Lets a push die out after some voxels of bed.
CONST_INT(kExcessTolerance, 512)
// A voxel with less free room than this bars the way of pushed soil: 1/8 voxel.
CONST_INT(kPushRoom, 8192)
// Soil under a push waits for its way to open up to this amount; beyond it overflow resolution spreads it: 2 voxels.
CONST_INT(kPushedMost, 131072)
// A voxel with more soil than this takes none from a push: pushes that meet, as in the corner of a tipping bucket, would
// pile it up beyond kVoxelMost. 4 voxels. Soil caught in a wall goes on all the same: it has to get out of there.
CONST_INT(kCrowdedLeast, 262144)
// Amounts up to this are moved whole, so that soil does not thin out into dust: 1/256 voxel.
CONST_INT(kWholeMost, 256)
// Water is counted in finer units than soil, so many in a mass unit: shares that move with soil are rounded to whole units, and
// pores hold a fraction of the soil's mass. With 1 ploughed soil of saturation 0.5 went from 0.46 to 0.51.
CONST_INT(kWaterParts, 16)
// A displaced voxel's share in a neighbour below this stays: whole units of mass carry momentum in wrong proportion when
// there are few of them, and a speck that is twice too fast costs every voxel sub-steps. 1/4096 voxel.
CONST_INT(kShareLeast, 16)
// A crumb can come with momentum that whole units of mass did not take along. It is no faster than this (Q10 voxels a base
// step): twice that in Q16 stays inside 31 bits.
CONST_INT(kCrumbSpeedMost, 8388607)
// How far the sides of an arch may be, voxels: wider openings have none. And the soil that leans on them, or carries what
// slides onto it as it falls: grains of half a voxel and less do not press on one another.
CONST_INT(kArchReach, 32)
CONST_INT(kArchLeast, 32768)
// How far the wall may be that holds a load back, voxels; beyond it what is between gives way.
CONST_INT(kHeldReach, 128)
// What falls in one is known by spans of this many voxels and more.
CONST_INT(kArchShortest, 4)
// Falling soil thinner than this does not decide how fine the step is cut: 1/16 voxel.
CONST_INT(kPacingLeast, 4096)
// Slopes closer to stability than this do not slide: 1/256 voxel of rise per voxel of run.
CONST_INT(kSlipTolerance, 256)
// Share of a failing wedge that slides in a pass (Q16) where a step of 1/60 s has two: an eighth even of soil that has just
// begun to, so that a slope is done in some passes; no more than a quarter however fast, because both columns of a slice
// may give and take. With other steps: SoilParams.
CONST_INT(kSlipRateLeast, 8192)
CONST_INT(kSlipRateMost, 16384)
// How many voxels ahead soil that is pushed looks for the free surface: a neighbouring tile reaches no further.
CONST_INT(kFreeSurfaceReach, 8)
// Velocities are Q10: 1024 = one voxel per base step. Displacements are Q16 voxels.
CONST_INT(kVelocityOne, 1024)
// Directions of forces are Q10 too, and weighted by sixteenths of the volume they push: with 16 voxels of soil (kVoxelMost)
// 2^10 * 2^16 stays inside 31 bits, and so does a sum of 31 of them.
CONST_INT(kForceOne, 1024)
CONST_INT(kForceShare, 16)
// Forces beyond this are halved before they are divided: fraction_q16 takes numbers below 2^27.
CONST_INT(kForceHalved, 67108864)
// A push before it becomes a direction (Q16 voxels a base step): times kForceOne it stays inside 31 bits.
CONST_INT(kPushMost, 1048575)
// A wall slower than this drives no soil out of itself: what the solver leaves of a body that stands (Q16 voxels in 1/60 s).
// 1/512 voxel, as what counts as still on the host. Without it a plate at rest on a thin layer went on squeezing it out. Other
// steps have as much for their length: SoilParams.
CONST_INT(kStillSpeed, 128)
// Carried soil follows the wall before it into a voxel that the wall's face crosses while the wall moves no faster than this
// (Q16 voxels at once): 0.6 voxel. Faster ones have crossed the voxel by the next step; with any speed allowed a box turning
// at up to 0.9 voxel a step lost 0.3 % through its walls.
CONST_INT(kFollowMost, 39322)
// No soil gets faster than this, whatever pushes it: 16 voxels per base step (Q16), so that a full voxel's momentum stays
// inside 31 bits.
CONST_INT(kSpeedMost, 1048576)

// --- tiles ------------------------------------------------------------------------------------------------------
CONST_INT(kTileSide, 8)
CONST_INT(kTileColumns, 64)
CONST_INT(kBlockVoxels, 512)
CONST_INT(kNeighbourAbsent, -1)
// Per resident tile in tile_table: 9 neighbour slots (row-major, dy then dx, self in the middle), tile x, tile y,
// then the top of the soil: step * kTileTopStep + z of the highest voxel with soil + 1, a maximum over columns.
CONST_INT(kTileTableWords, 16)
CONST_INT(kTileTableNeighbours, 0)
CONST_INT(kNeighbourRow, 3)     // neighbours in a row
CONST_INT(kNeighbourCount, 9)
CONST_INT(kTileTableX, 9)
CONST_INT(kTileTableY, 10)
CONST_INT(kTileTableTop, 11)
// Places of neighbours that are asleep, a bit each: asked for by those who look along the wind, above them by find_failures.
CONST_INT(kTileTableAsked, 12)
// step * kTileTopStep + a height from which on find_support found no voxel solid or full. With level wind alone.
CONST_INT(kTileTableBars, 13)
CONST_INT(kTileTopStep, 1024)   // twice the highest grid (512 voxels), so that z + 1 fits

// Tile lists: (slot * kTileWord + lowest) * kTileWord + highest: support may have changed from block `lowest` on, and
// soil reaches at most into the block below `highest`.
CONST_INT(kTileWord, 128)

// Lists of pairs, kPairWords words each: of voxelize_shapes a block and a shape over it, of pour_soil and take_soil a slot and
// the place in the tables of a region's part in its tile, of collect_small_bodies a slot and a body's index.
CONST_INT(kPairWords, 2)
CONST_INT(kPairBlock, 0)
CONST_INT(kPairShape, 1)
CONST_INT(kPairSlot, 0)
CONST_INT(kPairPart, 1)
CONST_INT(kPairBody, 1)

// Words left empty behind each plane and each array of columns. With a power of two of slots their lengths are multiples of a
// cache way, and a voxel's planes, or a column's words, would drive each other out of the cache. Whole cache lines of 16 words.
CONST_INT(kPlanePad, 80)
CONST_INT(kColumnPad, 48)       // less than a tile's columns

// --- planes of the state, each params.plane_stride words long, index = plane * plane_stride + voxel ---------------
CONST_INT(kPlaneCoverage, 0)    // bodies in this voxel, volume units, sum over shapes (not clamped)
CONST_INT(kPlaneOwner, 1)       // body that covers most: half its coverage * kOwnerRank + body index + 1; 0 = none
CONST_INT(kPlaneTerrain, 2)     // fixed terrain in this voxel, volume units, 0..kVoxelFull
CONST_INT(kPlaneSupport, 3)     // 0 falling, 1 resting on ground, 2 + b carried by body index b
CONST_INT(kPlaneVolume, 4)      // soil volume units; first transported plane
CONST_INT(kPlaneMomentumX, 5)   // sum of mass units * Q10 velocity
CONST_INT(kPlaneMomentumY, 6)
CONST_INT(kPlaneMomentumZ, 7)
CONST_INT(kPlaneForceX, 8)      // direction of the applied force, weighted by what it pushes
CONST_INT(kPlaneForceY, 9)
CONST_INT(kPlaneForceZ, 10)
CONST_INT(kPlaneBond, 11)       // volume units that were never moved: they keep their cohesion
CONST_INT(kPlaneMaterial, 12)   // mass units of material 0; material m is plane kPlaneMaterial + m
CONST_INT(kTransportFirst, 4)   // planes from here on move with the soil and have a delta plane

CONST_INT(kOwnerRank, 65536)    // body indices are below it; half of kVoxelFull - 1 times it stays inside 31 bits

CONST_INT(kSupportNone, 0)
CONST_INT(kSupportGround, 1)
CONST_INT(kSupportBody, 2)

// --- block flags: arrays of one word a block (8 x 8 x 8 voxels), array * block count + block ------------------------
CONST_INT(kFlagListed, 0)       // 1: dispatched this step, soil may flow in. Written by the host only
CONST_INT(kFlagChanged, 1)      // step in which soil last moved here
CONST_INT(kFlagWanted, 2)       // kWantedBy * step + who wanted it listed in the next step: the latest, of those the largest
CONST_INT(kFlagPending, 3)      // stamp of the last pass that left deltas here
CONST_INT(kFlagArrays, 4)
CONST_INT(kWantedBy, 2)
CONST_INT(kWantedByBank, 0)     // find_failures, see WorkLists::grant_asked()
CONST_INT(kWantedBySoil, 1)     // soil that goes there or comes from there, and those who look along the wind
// After all of them kMaskWords words a block: masks of what there is to do in it, a bit a column (two words) or a voxel. A
// pass looks at the columns of its mask and at no others, so that it costs what moves and not what is near. "May": a bit that
// is set for nothing costs a look and changes no result.
CONST_INT(kMaskWords, 32)
CONST_INT(kMaskArrived, 0)      // voxels with deltas to apply, bit z * 64 + column: 16 words
CONST_INT(kMaskPressed, 16)     // columns that may hold soil in excess, soil caught in a body, or a force
CONST_INT(kMaskExcess, 18)      // columns with soil in excess, since apply_force looked
CONST_INT(kMaskOverflow, 20)    // columns that overflowed when their block was last looked at
CONST_INT(kMaskMoving, 22)      // columns that may hold soil that does not rest, or rests with momentum
CONST_INT(kMaskBody, 24)        // columns that may be covered by bodies

// --- height spans: per column 1 count + kSpanCapacity records -----------------------------------------------------
// A machine over soil has a track, its wheel, the track again, the hull and the arm above one another: two spans a solid.
CONST_INT(kSpanCapacity, 16)
CONST_INT(kSpanWords, 3)
CONST_INT(kSpanBottom, 0)       // Q16 voxels above the floor
CONST_INT(kSpanTop, 1)
CONST_INT(kSpanKind, 2)         // kSpanRigid ...
CONST_INT(kColumnWords, 92)
CONST_INT(kColumnCount, 0)      // spans of the column
CONST_INT(kColumnSpans, 1)      // their records from the floor up, then padding up to kColumnSpeed and kColumnBase
// Of a toe of banks the ways up which planes failed at the last look in this step; kNoWays where its voxel was closed. Where loose
// soil has no cohesion nobody asks.
CONST_INT(kColumnWays, 49)
CONST_INT(kNoWays, -1)
CONST_INT(kColumnSpeed, 52)     // slip speed of span i (Q16 voxels per base step), two sets used turn by turn
// What the spans stand on, 16 bits each, two a word: index + 1 of a body that may move, 0 elsewhere; kBaseFree where no
// body covers the span's top.
CONST_INT(kColumnBase, 84)
CONST_INT(kBaseFree, 32768)
CONST_INT(kBaseBody, 32767)
// After all columns, kColumnArrays arrays of one word a column, array * columns + column.
CONST_INT(kColumnSurface, 0)    // see kCovered
CONST_INT(kColumnStamp, 1)      // pass that last changed soil, coverage or what holds a roof here, or found a slope failing
CONST_INT(kColumnSoilTop, 2)    // z of the highest voxel with soil + 1, or above it until find_support looks again
// Below kColumnFull voxels are full and uncovered and rest on the ground, from kColumnEnd on all are empty: whoever looks at a
// column looks at what lies between. find_support moves them together, what changes moves them apart.
CONST_INT(kColumnFull, 3)
CONST_INT(kColumnEnd, 4)
// Most columns are one pile from the floor up. Its top, or kNotSingle; and whether a slip speed of the column is not 0.
CONST_INT(kColumnSingle, 5)
CONST_INT(kColumnSlides, 6)
// Below this voxel all soil is bonded and of a cohesive material, or there is terrain. kIntactUnknown: build_spans looks.
CONST_INT(kColumnIntact, 7)
// kCutNone less the height (Q16) of the lowest plane on which the column's soil has just failed, 0 where none.
CONST_INT(kColumnCut, 8)
// Where kTileCut is of this step the kColumnCut that find_failures has last left, 0 where none: soil above has no cohesion.
CONST_INT(kColumnFailing, 9)
// 1 + z of the lowest soil that was never moved over a hollow, 0 where there is none or no soil has cohesion: see soil_roofs.glsl.
CONST_INT(kColumnHollow, 10)
CONST_INT(kHollowUnknown, -1)  // there: find_support looks from the floor up
// From slow_slides to slide_soil: the height (Q16) of what slides, where any may, and by how much the surface sinks as it leaves.
CONST_INT(kColumnSlideTop, 11)
CONST_INT(kColumnSinks, 12)
CONST_INT(kColumnArrays, 13)
CONST_INT(kNotSingle, -1)
CONST_INT(kIntactUnknown, -1)
CONST_INT(kCutNone, 268435456)
// After those kTileArrays arrays of one word a tile slot.
CONST_INT(kTileStamp, 0)        // the largest kColumnStamp of its columns
CONST_INT(kTileToes, 1)         // two words, a bit a column: the ground rises steeply beside it, see find_failures
CONST_INT(kTileCut, 3)          // step that last set a kColumnCut
CONST_INT(kTileFailing, 4)      // step that last set a kColumnFailing: find_failures reads it while it writes kTileCut
CONST_INT(kTileArrays, 5)
// kColumnSurface: the height of the topmost resting soil (Q16), or kCovered less that height (as if
// there were no bodies) where a body stands on it, or kTerrainTop less the height of the terrain where that covers the soil.
CONST_INT(kCovered, -1)
CONST_INT(kTerrainTop, -268435456)    // below every height: 4096 voxels
// Relative density of a contact whose soil has a fixed density.
CONST_INT(kDensityFixed, -1)
CONST_INT(kSpanRigid, 1)
CONST_INT(kSpanPiled, 2)
CONST_INT(kSpanFalling, 3)
CONST_INT(kSpanEdge, 4)         // made where it is needed: see slip_soil

// --- shapes buffer: params.body_count bodies, then shape records from params.shape_offset -------------------------
CONST_INT(kBodyWords, 16)
CONST_INT(kBodyLinear, 0)       // velocity of the centre of mass, Q16 voxels per base step, 3
CONST_INT(kBodyAngular, 3)      // Q16 radians per base step, 3
CONST_INT(kBodyCenter, 6)       // centre of mass, Q1 voxels (half voxels), 3
CONST_INT(kArmMost, 8191)       // of a body's rotation, half voxels: times 2 rad a base step (Q16), twice, stays in 31 bits
CONST_INT(kBodyFriction, 9)     // its own friction with soil times gravity: Q16 velocity change a base step
CONST_INT(kFrictionOfSoil, -1)  // instead: the body has none of its own, and soil brings its kTableTool
CONST_INT(kBodyMoving, 10)
CONST_INT(kBodyPacking, 11)     // relative density (Q16) that soil pressed on by this body takes up
CONST_INT(kBodyReach, 12)       // voxels of soil beside this body whose density counts for its contact
CONST_INT(kBodyReachMost, 8)    // a neighbouring tile reaches no further
CONST_INT(kBodyPlace, 13)       // 1 + place in its tile of the voxel with a small body's middle; 0: not small
CONST_INT(kShapeWords, 32)
CONST_INT(kShapeKind, 0)        // kKindBox ...
CONST_INT(kShapeBody, 1)
CONST_INT(kShapeRows, 2)        // 12 floats: rows of the 3 x 4 transform grid voxels -> shape frame (voxel units)
CONST_INT(kShapeRowWords, 4)    // of one of them
// Its size in voxels, floats, from word 14 on, by kind:
CONST_INT(kShapeHalfExtents, 14)    // box: along x, y, z
CONST_INT(kShapeRadius, 14)         // sphere, capsule, cylinder; cone: of its base
CONST_INT(kShapeHalfHeight, 15)     // capsule: of the segment; cylinder, cone
CONST_INT(kShapeSlantCosine, 16)    // cone: the slanted face's normal, radially and upwards
CONST_INT(kShapeSlantSine, 17)
CONST_INT(kShapeLatticeUnit, 14)    // lattice: a sample's unit
CONST_INT(kShapeSizeEnd, 20)
CONST_INT(kShapeFaces, 20)      // hull: place of the first face in the shapes buffer, kFaceWords each
CONST_INT(kShapeFaceCount, 21)
CONST_INT(kShapeRounding, 22)   // float
CONST_INT(kShapeLattice, 23)    // lattice: its place in the shapes buffer; the rows lead to its nodes
CONST_INT(kShapeLow, 24)        // grid voxels that it may cover: the lowest x, y, z, then the highest
CONST_INT(kShapeHigh, 27)
CONST_INT(kKindBox, 0)          // ConvexShape::Kind
CONST_INT(kKindSphere, 1)
CONST_INT(kKindCapsule, 2)
CONST_INT(kKindCylinder, 3)
CONST_INT(kKindCone, 4)
CONST_INT(kKindHull, 5)
CONST_INT(kKindLattice, 6)
CONST_INT(kFaceWords, 4)        // of a hull's face, floats
CONST_INT(kFaceNormal, 0)       // x, y, z
CONST_INT(kFaceOffset, 3)       // voxels along the normal
// A distance lattice: bricks along x, y, z; per brick (x fastest) the place of its samples from the lattice's start, or
// kLatticeInside or kLatticeOutside where the surface is far; the samples. A brick spans kLatticeCells cells and has the
// 8 x 8 x 8 nodes at their corners (those on its faces are its neighbours' as well), x fastest, two 16-bit samples a
// word, the low half first. A sample of kLatticeFar is as far as distances are known.
CONST_INT(kLatticeBricks, 0)    // bricks along x, y, z
CONST_INT(kLatticeCells, 7)
CONST_INT(kLatticeNodes, 8)     // along an edge of a brick
CONST_INT(kLatticeIndex, 3)
CONST_INT(kLatticeBrickWords, 256)
CONST_INT(kLatticeOutside, -1)
CONST_INT(kLatticeInside, -2)
CONST_INT(kLatticeFar, 32000)

// --- sources and sinks: behind the materials' tables, from params.flow_offset on, kFlowWords each; then their parts -----
CONST_INT(kFlowCapacity, 64)    // sources, sinks and open sides together
CONST_INT(kFlowWords, 20)
CONST_INT(kFlowPlane, 0)        // source: plane of its material
CONST_INT(kFlowCount, 1)        // voxels of its region
CONST_INT(kFlowLumps, 2)        // of these, into how many it pours in this step
CONST_INT(kFlowUnits, 3)        // mass units that it pours into each
CONST_INT(kFlowRest, 4)         // of these, into how many it pours one more
CONST_INT(kFlowTurn, 5)         // voxel i gets lump number (i * kFlowStride + kFlowTurn) modulo kFlowCount, where there is one
CONST_INT(kFlowStride, 6)
CONST_INT(kFlowVolume, 7)       // volume of a mass unit, Q16
CONST_INT(kFlowVelocity, 8)     // Q10 voxels per base step, 3
CONST_INT(kFlowAside, 11)       // largest velocity aside of it, two vectors, 6
CONST_INT(kFlowShare, 17)       // sink: share (Q16) of the soil in its region that it takes
CONST_INT(kFlowWater, 18)       // source: water units that a mass unit of soil brings, Q16
CONST_INT(kFlowWell, 19)        // sink: 0, or a well that takes water, -1, or brings it, 1
CONST_INT(kFlowVoxelsMost, 65536)    // of a source: i * kFlowStride stays within 32 bits
CONST_INT(kFlowSpeedMost, 8192)      // of a source: a full voxel's momentum stays within 31 bits
// A part is what of a region lies in one tile: which of them, by column its voxels low | high << 16 (low..high - 1), and by
// column the number of the first of them.
CONST_INT(kFlowPartWords, 129)
CONST_INT(kFlowColumns, 1)
CONST_INT(kFlowFirst, 65)
// In the result buffer from params.flow_result on: 64-bit sums of the mass units that each has moved, by material, and of
// what a sink has left in its region.
CONST_INT(kFlowResultWords, 18)
CONST_INT(kFlowHeld, 16)

// --- result buffer ------------------------------------------------------------------------------------------------
CONST_INT(kResultStatus, 0)
CONST_INT(kResultSpeed, 1)      // largest displacement a base step, Q16 voxels
CONST_INT(kResultContacts, 2)   // number of contact records wanted
CONST_INT(kResultSlope, 3)      // highest wedge that the last slip pass still found failing, Q16 voxels
CONST_INT(kResultSlide, 7)      // fastest slide, Q16 voxels a base step, kSlideSpeedMost at most
CONST_INT(kSlideSpeedMost, 1048576)
// Of water, 64-bit sums of water units in this step: what came into the grid, what left it, how many voxels more will drain.
CONST_INT(kResultWaterIn, 8)
CONST_INT(kResultWaterOut, 10)
CONST_INT(kResultWaterMoves, 12)
// Where a condition was met: the largest place_code() of this step, 0 = nowhere.
CONST_INT(kResultSpeedPlace, 4)
CONST_INT(kResultHeadroomPlace, 5)
CONST_INT(kResultSpansPlace, 6)
// Momentum of this step, 64-bit sums along x, y, z in units of the momentum planes. What soil has gained is the sum of what fell to
// it and of what bodies have given it, less what ground has taken.
CONST_INT(kResultFallen, 16)    // from gravity, air and sources; less what sinks take along
CONST_INT(kResultGround, 22)    // what ground, terrain and the grid's ends took; slopes give, which counts as less
CONST_INT(kResultHeader, 28)    // then per body the load it carries, kLoadWords each, then the contact records
CONST_INT(kLoadWords, 15)       // 64-bit sums (low, high), then kLoadWalls
CONST_INT(kLoadMass, 0)         // parts of mass units
CONST_INT(kLoadMoment, 2)       // the same times 2x + 1, then 2y + 1, then 2z + 1: the middle of a voxel in half voxels
CONST_INT(kLoadImpulse, 8)      // momentum that the body has given soil along x, y, z, beside what bears the soil's weight
CONST_INT(kLoadWalls, 14)       // 1: some of it is beside a column of terrain
CONST_INT(kLoadPart, 16)        // parts are 16ths, rounded down, so that kMassMost of them times 16384 voxels stays in 31 bits
CONST_INT(kContactWords, 16)    // 64 bytes: no two threads write to one cache line
CONST_INT(kContactAt, 0)        // voxel x, y, z
CONST_INT(kContactBody, 3)      // index
CONST_INT(kContactKey, 4)       // words up to here tell a record from all others of a step
CONST_INT(kContactGradient, 4)  // of the bodies' coverage x, y, z: see body_gradient
CONST_INT(kContactGap, 7)       // room that the soil leaves along x, y, z, Q16 voxels
CONST_INT(kContactExcess, 10)   // soil and bodies beyond the voxel's room, volume units
CONST_INT(kContactMaterial, 11) // | saturation of its pores (Q16) << kSaturationShift
CONST_INT(kSaturationShift, 4)
CONST_INT(kContactDensity, 12)  // relative density, Q16; or kDensityFixed
CONST_INT(kContactCarrier, 13)  // body index of what the soil rests on, or kOnGround
CONST_INT(kContactUndisturbed, 14)  // share of the soil that was never moved, Q16; 1 where no soil has cohesion
CONST_INT(kContactBetweenWalls, 131072)  // added to it: see is_between_walls()
// A face pushes no load before it where the level part of its normal is less than one in so many of the part that looks up.
// Ours: 14 deg; blades are steeper, and floors that bear soil are flatter. Larger: floors push what lies before them;
// smaller: flat blades meet nothing.
CONST_INT(kPlugSlope, 4)
CONST_INT(kContactLoad, 15)     // the body's load over the voxel: 0, or 1 + how far up | sides << kLoadSides; see load_over()
CONST_INT(kLoadSides, 2)        // a bit each for +x, -x, +y, -y
CONST_INT(kOnGround, -1)

// --- tables buffer: per material a table for each state of its soil -------------------------------------------------
CONST_INT(kSoilBonded, 0)       // never moved
CONST_INT(kSoilLoose, 1)        // moved: what cohesion it keeps
CONST_INT(kSoilFailing, 2)      // above a plane that fails: none
CONST_INT(kSoilStates, 3)
CONST_INT(kSlipEntries, 257)    // slope 0..16 voxels of rise per voxel, step 1/16
CONST_INT(kTableWords, 656)
CONST_INT(kTableWedge, 0)       // kSlipEntries heights of the sliding wedge, then as many accelerations
CONST_INT(kTableAcceleration, 320)

CONST_INT(kTablePassive, 600)   // tan(45 deg - phi / 2), Q16: how steeply confined soil yields towards the surface
CONST_INT(kTableLoose, 601)     // volume of a mass unit of loose soil, Q16; 0: density is fixed
CONST_INT(kTableCompacted, 602) // ... of compacted soil
CONST_INT(kTableFriction, 603)  // tan(phi), Q16
CONST_INT(kTableStrength, 604)  // cohesion over unit weight, Q16 voxels; kStrengthLeast to kStrengthMost, or 0
CONST_INT(kTableHeld, 605)      // as kTableLoose, where density is fixed as placed: for soil of several materials
CONST_INT(kTableHeldLeast, 606) // as kTableCompacted, likewise
CONST_INT(kTableTool, 607)      // friction with bodies times gravity: Q16 velocity change a base step
CONST_INT(kTableRoughness, 608) // slope above tan(phi), Q16, up to which soil still stands
CONST_INT(kTableViscosity, 609) // share of the slides that do not take place, Q16
CONST_INT(kTableDrag, 610)      // of slides with momentum, in a base step: Q16 part of their speed; kDragMost at most
CONST_INT(kTablePores, 611)     // water that pores hold, of the soil's mass, Q16
CONST_INT(kTableMoist, 612)     // the most cohesion that moisture gives over the dry soil's unit weight, as kTableStrength
CONST_INT(kTableResidual, 613)  // saturation below which water does not drain, Q16
CONST_INT(kTableSeepage, 614)   // what drains out of a saturated voxel in a water step, water units, Q4
CONST_INT(kTableSuction, 615)   // suction of dry pores, as a height of water: Q16 voxels, kSuctionMost at most
CONST_INT(kTableAir, 616)       // what air takes of the speed of falling soil in a base step: Q16 part of it; kAirMost at most
CONST_INT(kTableByDensity, 617) // over relative density, kDensityEntries: of bonded soil tan(phi), of loose soil as kTableStrength
CONST_INT(kDensityEntries, 33)  // relative density 0..1, step 1/32: within 0.6 % of what lies between
CONST_INT(kTableCritical, 650)  // relative density at which the soil shears without a change of volume, Q16; 0: loose
CONST_INT(kSuctionMost, 4194304)    // 64 voxels
CONST_INT(kAirMost, 67108864)       // 1024: fraction_q16 takes numbers below twice that
CONST_INT(kAirOfStep, 131072)       // 2: from there on soil takes up the air's speed within a step
CONST_INT(kGustCellMost, 1024)
CONST_INT(kGustPeriod, 1024)        // gusts, after which they repeat: a power of two
CONST_INT(kShelterMost, 128)
CONST_INT(kDragMost, 1048576)       // 16: what viscosity 1 - 1e-7 has in a 60th of a second
CONST_INT(kStrengthLeast, 256)      // 1/256 voxel: the rounding of sums over a bank's columns is no hundredth of it
CONST_INT(kStrengthMost, 8388608)   // 128 voxels: a wall of 512, the highest grid, stands

// --- ways of overflow (values of OverflowHeuristic) ------------------------------------------------------------------
CONST_INT(kOverflowEven, 0)
CONST_INT(kOverflowUp, 1)
CONST_INT(kOverflowUpSpread, 2)

// --- status bits the kernels set (values of StatusBit) --------------------------------------------------------------
CONST_INT(kStatusSpeedClamped, 2)
CONST_INT(kStatusContactsFull, 32)
CONST_INT(kStatusHeadroom, 64)
CONST_INT(kStatusSpansFull, 256)
