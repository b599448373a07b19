/// Every fixed limit of the soil, with its meaning and what running into it does.
#pragma once

#include <cstdint>

namespace bsoil::limits {

inline constexpr int kMaterialCapacity =
    8;  ///< materials of one soil; SoilDef::validate refuses more
inline constexpr int kGridHeightMax = 512;  ///< voxels up; SoilDef::validate refuses more
inline constexpr int kGridSideMax = 16384;  ///< voxels along x or y; SoilDef::validate refuses more
/// SoilDef::floor_center_m along each axis, either way [m]; SoilDef::validate refuses more. There a
/// double still resolves 2 nm, a thousandth of what counts as still in the smallest voxels; a
/// Bullet of floats resolves a metre, so keep such worlds near their origin.
inline constexpr double kPlaceMostM = 1e7;
inline constexpr int kSettleStepsMax = 100000;  ///< steps of one Soil::settle; more are refused
/// Columns of a grid, 8192 x 8192: ground that sleeps takes up to 40 bytes a column.
/// SoilDef::validate refuses more.
inline constexpr int64_t kGridColumnsMax = int64_t{1} << 26;
/// Voxels of a grid whose terrain or soil is a density function, which is asked 27 times a voxel.
/// More are refused by Soil::fill and Soil::add_terrain.
inline constexpr int64_t kDensityVoxelsMax = int64_t{1} << 28;
/// Voxels of a grid below the top of a terrain mesh. Half a minute; more are refused by
/// Soil::add_terrain.
inline constexpr int64_t kTerrainVoxelsMax = int64_t{1} << 32;
/// Tests of a line up through the grid (four a column) against a triangle that a terrain mesh may
/// take: all lines of all tiles that each triangle's box touches. Half a minute; more are refused
/// by Soil::add_terrain.
inline constexpr int64_t kTerrainTestsMax = int64_t{1} << 33;
inline constexpr int kHeightMapSideMin = 2;  ///< heights along a side of a HeightMapFill; fewer ...
inline constexpr int kHeightMapSideMax = 32768;  ///< ... and more are refused by Soil::fill
/// Contact voxels a step. With more there are no contacts in that step, and contact_list_full.
inline constexpr int kContactCapacity = 1 << 20;
inline constexpr int kBodyCapacity =
    4096;  ///< bodies a step; those beyond are refused (shape_refused)
inline constexpr int kBodyIdMost =
    65534;  ///< SoilBody::id; larger and negative ones are refused (shape_refused)
inline constexpr int kConditionCapacity =
    256;  ///< conditions of single bodies that are kept; further ones are counted together
inline constexpr int kSoilSpeedMostVoxels =
    16;  ///< fastest soil along each axis [voxels a step]; what would be faster is held to it
inline constexpr int kHullPlaneCapacity = 256;  ///< faces of a convex hull; more set shape_refused

/// Thickness that a wall has for the soil at least [voxels]: thinner sheets are thickened to it, by
/// as much on either face. From |nx| + |ny| + |nz| voxels on (n: the normal), at most the square
/// root of 3, no way leads through it even over corners (Reveilles' standard plane); and a wall
/// that moves by a voxel has to tell soil it has run over from soil behind it. Measured
/// (docs/decisions/walls.md): walls of 1.5 voxels hold soil at rest, of 1.75 leak up to 0.5 % at a
/// voxel a step, of 2 less than 0.1 %. More would only take room from buckets.
inline constexpr double kThinnestWallVoxels = 2;

}  // namespace bsoil::limits
