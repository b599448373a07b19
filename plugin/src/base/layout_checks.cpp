// What stands both in the kernels' layout and in a public header says the same in both.
#include <cstdint>

#include "base/layout.h"
#include "bsoil/body.h"
#include "bsoil/limits.h"
#include "bsoil/soil.h"
#include "bsoil/soil_def.h"

namespace bsoil::layout {

template <typename Enum>
constexpr bool same(int number, Enum value) {
    return number == static_cast<int>(value);
}

static_assert(same(kKindBox, ConvexShape::Kind::box));
static_assert(same(kKindSphere, ConvexShape::Kind::sphere));
static_assert(same(kKindCapsule, ConvexShape::Kind::capsule));
static_assert(same(kKindCylinder, ConvexShape::Kind::cylinder));
static_assert(same(kKindCone, ConvexShape::Kind::cone));
static_assert(same(kKindHull, ConvexShape::Kind::hull));
static_assert(same(kKindLattice, ConvexShape::Kind::lattice));

static_assert(same(kOverflowEven, OverflowHeuristic::even));
static_assert(same(kOverflowUp, OverflowHeuristic::up));
static_assert(same(kOverflowUpSpread, OverflowHeuristic::up_spread));

static_assert(same(kStatusSpeedClamped, StatusBit::speed_clamped));
static_assert(same(kStatusContactsFull, StatusBit::contact_list_full));
static_assert(same(kStatusHeadroom, StatusBit::amount_headroom));
static_assert(same(kStatusSpansFull, StatusBit::span_list_full));

// Records lie in their strides without gaps or overlaps.
static_assert(kColumnSpans + kSpanCapacity * kSpanWords <= kColumnWays &&
              kColumnWays + 1 <= kColumnSpeed && kColumnSpeed + 2 * kSpanCapacity <= kColumnBase &&
              kColumnBase + kSpanCapacity / 2 <= kColumnWords);
static_assert(kLoadMoment + 6 == kLoadImpulse && kLoadImpulse + 6 == kLoadWalls &&
              kLoadWalls + 1 == kLoadWords);
static_assert(kResultWaterMoves + 2 <= kResultFallen && kResultFallen + 6 == kResultGround &&
              kResultGround + 6 == kResultHeader);
static_assert(kContactAt + 3 == kContactBody && kContactBody + 1 == kContactKey &&
              kContactGradient + 3 == kContactGap && kContactGap + 3 == kContactExcess &&
              kContactDensity + 1 == kContactCarrier &&
              kContactCarrier + 1 == kContactUndisturbed &&
              kContactUndisturbed + 1 == kContactLoad && kContactLoad < kContactWords);
static_assert(limits::kMaterialCapacity <= 1 << kSaturationShift &&
              int64_t{kVoxelFull} << kSaturationShift <= INT32_MAX);
static_assert(kShapeRows + 3 * kShapeRowWords == kShapeHalfExtents &&
              kShapeHalfExtents + 3 <= kShapeSizeEnd && kShapeSlantSine < kShapeSizeEnd &&
              kShapeSizeEnd == kShapeFaces && kShapeFaceCount + 1 == kShapeRounding &&
              kShapeLattice < kShapeLow && kShapeHigh + 3 <= kShapeWords);
static_assert(kFaceNormal + 3 == kFaceOffset && kFaceOffset + 1 == kFaceWords);
static_assert(kTileTableX == kTileTableNeighbours + kNeighbourCount &&
              kNeighbourCount == kNeighbourRow * kNeighbourRow);
static_assert(kLatticeIndex == kLatticeBricks + 3);
static_assert(kTableWedge + kSlipEntries <= kTableAcceleration &&
              kTableAcceleration + kSlipEntries <= kTablePassive && kTableAir < kTableByDensity &&
              kTableByDensity + kDensityEntries <= kTableCritical && kTableCritical < kTableWords);

// Headroom: what the comments of soil_layout.h promise.
static_assert(limits::kGridHeightMax < kTileTopStep);
static_assert(limits::kBodyCapacity < kOwnerRank);
static_assert(limits::kSoilSpeedMostVoxels * kVoxelFull == kSpeedMost);
static_assert(int64_t{kVoxelFull - 1} / 2 * kOwnerRank + limits::kBodyCapacity <= INT32_MAX);
static_assert(int64_t{kMassMost} / kLoadPart * limits::kGridSideMax <= INT32_MAX);
static_assert(int64_t{kPushMost} * kForceOne <= INT32_MAX);

}  // namespace bsoil::layout
