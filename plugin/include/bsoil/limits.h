/// Every fixed limit of the soil, with its meaning and what running into it does.
#pragma once

namespace bsoil::limits {

inline constexpr int kMaterialCapacity =
    8;  ///< materials of one soil; SoilDef::validate refuses more
inline constexpr int kGridHeightMax = 512;  ///< voxels up; SoilDef::validate refuses more
inline constexpr int kGridSideMax = 16384;  ///< voxels along x or y; SoilDef::validate refuses more
inline constexpr int kHeightMapSideMin = 2;  ///< heights along a side of a HeightMapFill; fewer ...
inline constexpr int kHeightMapSideMax = 32768;  ///< ... and more are refused by Soil::fill
inline constexpr int kContactCapacity =
    65536;  ///< contact voxels a step; more set contact_list_full
inline constexpr int kBodyCapacity =
    4096;  ///< bodies a step; those beyond are refused (shape_refused)
inline constexpr int kHullPlaneCapacity = 256;  ///< faces of a convex hull; more set shape_refused

/// A wall thinner than this many voxels lets soil through somewhere; a DistanceLattice has none.
/// Voxels whose centres lie within half of it of a plane are covered by half and more, and so
/// closed to flow; from a thickness of |nx| + |ny| + |nz| voxels on (n: the normal), at most the
/// square root of 3, no way leads between them even over corners (Reveilles' standard plane).
inline constexpr double kThinnestWallVoxels = 1.75;

}  // namespace bsoil::limits
