/// SoilDef: everything a soil is created from.
#pragma once

#include <functional>
#include <vector>

#include "bsoil/contact/contact_law_def.h"
#include "bsoil/geometry.h"
#include "bsoil/material.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Which world axis points up.
enum class UpAxis { y, z };
/// Where the kernels run. `automatic` takes a hardware OpenGL 4.5 device where EGL offers one, else
/// the CPU.
enum class Backend { automatic, cpu, gl };
/// How soil that does not fit leaves its voxel after advection (thesis section 3.2.1, Fig. 30).
enum class OverflowHeuristic {
    even,       ///< into all neighbours evenly
    up,         ///< one voxel up
    up_spread,  ///< into the nine voxels above, the middle one most
};

/// How a soil is made. Defaults are usable; validate() says what is wrong.
struct SoilDef {
    MaterialDef material =
        materials::dry_sand();           ///< the only material, unless `materials` has some
    std::vector<MaterialDef> materials;  ///< 1..8 materials with unique names, or empty
    /// Box of the grid along the world's axes. Rounded up to whole voxels across, to a multiple of
    /// 8 of them along up; what lies beyond its sides is a wall to the soil.
    Vec3 size_m{12, 2, 12};
    Vec3 floor_center_m{};  ///< world position of the centre of the box's bottom face; -1e7..1e7
    double yaw_rad = 0;     ///< rotation of the grid about the up axis
    double voxel_m = 0.05;  ///< edge of a voxel, 0.001..1
    UpAxis up = UpAxis::y;
    double gravity_m_s2 = 9.81;      ///< along -up, 0..30
    double step_s = 1.0 / 60;        ///< the soil's own step, 1/2000..1/20
    int propagation_iterations = 4;  ///< alpha of the thesis, 0..64
    int overflow_passes = 4;         ///< 0..64
    OverflowHeuristic overflow = OverflowHeuristic::up;
    int substeps_max = 8;   ///< sub-steps a fast step may be cut into, 1..32
    int tile_capacity = 0;  ///< awake tiles at once; 0 = all that exist, within 1 GiB
    Backend backend = Backend::automatic;
    int thread_count = 0;       ///< CPU backend; 0 = all cores. Results do not depend on it
    ContactLawDef contact_law;  ///< what soil does to bodies that press on it

    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
    /// `materials`, or the single `material`.
    std::vector<MaterialDef> material_list() const;
};

/// A function of world position [m]. Soil or terrain is where it is positive (thesis
/// section 2.2.2).
using DensityFunction = std::function<double(Vec3)>;

/// Soil put in at the start, before the first step. `material` is a name out of the SoilDef.
struct BoxFill {
    Aabb box;  ///< world axes
    std::string material;
};
/// A cylinder about the up axis.
struct CylinderFill {
    Vec3 base_center_m;
    double radius_m = 1, height_m = 1;
    std::string material;
};
/// Ground under a height image: row-major heights, stretched over the grid's whole floor.
struct HeightMapFill {
    int width = 0, height = 0;
    std::vector<float> heights_m;  ///< width x height values above the grid's floor
    std::string material;
};
/// Ground whose surface is fractal value noise: gentle dunes to rough hills.
struct NoiseFill {
    double base_m = 0.5;       ///< mean height above the grid's floor
    double amplitude_m = 0.2;  ///< half the range of the largest octave
    double wavelength_m = 4;   ///< of the largest octave
    int octaves = 4;           ///< 1..12; each half as long and `persistence` as high
    double persistence = 0.5;  ///< 0..1
    unsigned seed = 1;
    std::string material;
};
/// Soil where a density function is positive.
struct FunctionFill {
    DensityFunction density;
    std::string material;
};

/// A closed triangle mesh in world coordinates.
struct TriangleMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<int, 3>> triangles;
};

}  // namespace bsoil
#pragma GCC visibility pop
