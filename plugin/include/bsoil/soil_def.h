/// SoilDef: everything a soil is created from.
#pragma once

#include <functional>
#include <vector>

#include "bsoil/contact/contact_law_def.h"
#include "bsoil/geometry.h"
#include "bsoil/limits.h"
#include "bsoil/material.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Which world axis points up.
enum class UpAxis { y, z };
/// Where the kernels run. `automatic` takes a hardware OpenGL 4.5 device where EGL offers one, else
/// the CPU.
enum class Backend { automatic, cpu, gl };
/// A bit for each side of the grid's box along the world's axes, before SoilDef::yaw_rad turns it.
enum OpenSide : int {
    kOpenLowX = 1,
    kOpenHighX = 2,
    kOpenLowY = 4,
    kOpenHighY = 8,
    kOpenLowZ = 16,
    kOpenHighZ = 32,
    kOpenSideLast = kOpenHighZ
};
/// How soil that does not fit leaves its voxel after advection (thesis section 3.2.1, Fig. 30).
enum class OverflowHeuristic {
    even,       ///< into all neighbours evenly
    up,         ///< one voxel up
    up_spread,  ///< into the nine voxels above, the middle one most
};

/// What becomes of the momentum of soil that slides down a slope.
enum class SlideMotion {
    settle,   ///< none: soil comes to rest at its angle of friction, as if let down slowly
    run_out,  ///< it goes on along the ground until friction has taken it
};

/// How a soil is made. Defaults are usable; validate() says what is wrong. Its fields stand once
/// more in BSOIL_SOIL_FIELDS below, which is what reads, checks, saves and documents them.
struct SoilDef {
    MaterialDef material =
        materials::dry_sand();           ///< the only material, unless `materials` has some
    std::vector<MaterialDef> materials;  ///< 1..8 materials with unique names, or empty
    /// box of the grid along the world's axes; rounded up to whole voxels: at most 16384 to either
    /// side, 6.7e7 columns (8192 x 8192), 512 up. Along up it is rounded to a multiple of 8 voxels;
    /// what lies beyond its sides is a wall to the soil.
    Vec3 size_m{12, 2, 12};
    Vec3 floor_center_m{};  ///< centre of the box's bottom face, -1e7..1e7
    double yaw_rad = 0;     ///< rotation of the grid about the up axis, -7..7
    double voxel_m = 0.05;  ///< edge of a voxel, 0.001..1
    UpAxis up = UpAxis::y;  ///< world axis that points up
    /// gravity along -up, 0..30; 0: soil neither falls nor slides. In a step it is whole units of
    /// 1/65536 voxel. Where they are few (steps below 1 / 500 s with voxels of 5 cm, 1 / 110 s with
    /// 1 m) it changes by a unit from step to step, so that its mean is right. Friction of bodies
    /// with what they carry is rounded to 64 such units: of a coefficient of 0.4 a quarter is lost
    /// at 240 Hz with 5 cm, and all of it at 240 Hz with 20 cm and at 2000 Hz with 5 cm
    double gravity_m_s2 = 9.81;
    double step_s = 1.0 / 60;  ///< the soil's own step, 1/2000..1/20
    /// alpha of the thesis: iterations of force propagation a step, 0..64
    int propagation_iterations = 4;
    int overflow_passes = 4;  ///< passes that spread soil which does not fit, 0..64
    /// how soil that does not fit leaves its voxel
    OverflowHeuristic overflow = OverflowHeuristic::up;
    /// sides of the grid, OpenSide bits, over whose edge soil falls out of it, 0..63
    int open_sides = 0;
    SlideMotion slides = SlideMotion::settle;  ///< what becomes of the momentum of slides
    /// water that falls on soil that takes some, 0..1e-3; 1e-5 is 36 mm an hour
    double rain_m_s = 0;
    double drying_m_s = 0;          ///< water that dries off the ground's surface, 0..1e-3
    double floor_drainage_m_s = 0;  ///< water that the grid's floor lets through, 0..1
    /// groundwater up to this height over the grid's floor, 0..1000; 0: none. Soil below is full of
    /// water
    double water_table_m = 0;
    Vec3 wind_m_s{};  ///< velocity of the air, along the world's axes, -50..50
    /// share by which gusts raise and lower the wind, 0..1; they drift with it
    double gust = 0;
    double gust_size_m = 5;  ///< from one gust to the next, 0.01..1000; at most 1024 voxels
    /// so far behind what bars it there is no wind, 0..100; at most 128 voxels
    double shelter_m = 5;
    int substeps_max = 8;  ///< sub-steps a fast step may be cut into, 1..32
    /// tiles of 8 x 8 columns awake at the same time, 0..4194304, but no more than fit into 8 GiB;
    /// 0: all that fit into 1 GiB
    int tile_capacity = 0;
    /// time that a call of step() may take, 0..1000; 0: as long as it takes. A step that needs more
    /// goes on in the next calls, and the soil's time slows down. With it, results depend on the
    /// machine
    double step_budget_ms = 0;
    /// calls over which a budget may spread a step, 2..1000; the last one finishes it
    int step_spread_max = 8;
    Backend backend = Backend::automatic;  ///< where the kernels run
    /// threads of the CPU backend, 0..1024; 0: all cores. Results do not depend on it
    int thread_count = 0;
    ContactLawDef contact_law;  ///< what soil does to bodies that press on it

    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
    /// `materials`, or the single `material`.
    std::vector<MaterialDef> material_list() const;
};

// clang-format off
/// The fields of a SoilDef besides its materials and its contact law: FIELD(name, least, most, use,
/// what it is, what else to know or ""). use: `state` where a snapshot means something by it, `live`
/// where besides Soil::change() takes another value while the soil runs, `run` where results do not
/// depend on it. `pace`: results depend on it, change() takes another value, and no snapshot minds.
/// An enumeration goes from 0 to its last value. Where least is
/// most, validate() checks the field together with others.
#define BSOIL_SOIL_FIELDS(FIELD)                                                                   \
    FIELD(size_m, 0, 0, state, "box of the grid along the world's axes",                           \
          "rounded up to whole voxels: at most 16384 to either side, 6.7e7 columns (8192 x 8192), " \
          "512 up")                                                                                \
    FIELD(voxel_m, 0.001, 1, state, "edge of a voxel", "")                                         \
    FIELD(floor_center_m, -limits::kPlaceMostM, limits::kPlaceMostM, state,                        \
          "centre of the box's bottom face", "")                                                   \
    FIELD(yaw_rad, -7, 7, state, "rotation of the grid about the up axis", "")                     \
    FIELD(up, 0, 1, state, "world axis that points up", "")                                        \
    FIELD(gravity_m_s2, 0, 30, state, "gravity along -up", "")                                     \
    FIELD(step_s, 1.0 / 2000, 1.0 / 20, state, "the soil's own step", "")                          \
    FIELD(propagation_iterations, 0, 64, live,                                                     \
          "alpha of the thesis: iterations of force propagation a step", "")                       \
    FIELD(overflow_passes, 0, 64, live, "passes that spread soil which does not fit", "")          \
    FIELD(overflow, 0, 2, live, "how soil that does not fit leaves its voxel", "")                 \
    FIELD(open_sides, 0, 63, state,                                                                \
          "sides of the grid, OpenSide bits, over whose edge soil falls out of it", "")            \
    FIELD(slides, 0, 1, state, "what becomes of the momentum of slides", "")                       \
    FIELD(rain_m_s, 0, 1e-3, live, "water that falls on soil that takes some", "")                 \
    FIELD(drying_m_s, 0, 1e-3, live, "water that dries off the ground's surface", "")              \
    FIELD(floor_drainage_m_s, 0, 1, live, "water that the grid's floor lets through", "")          \
    FIELD(water_table_m, 0, 1000, live,                                                            \
          "groundwater up to this height over the grid's floor",                                   \
          "0: none. Soil below is full of water")                                                  \
    FIELD(wind_m_s, -50, 50, live, "velocity of the air, along the world's axes", "")              \
    FIELD(gust, 0, 1, live, "share by which gusts raise and lower the wind",                       \
          "they drift with it")                                                                    \
    FIELD(gust_size_m, 0.01, 1000, live, "from one gust to the next", "at most 1024 voxels")       \
    FIELD(shelter_m, 0, 100, live, "so far behind what bars it there is no wind",                  \
          "at most 128 voxels")                                                                    \
    FIELD(substeps_max, 1, 32, live, "sub-steps a fast step may be cut into", "")                  \
    FIELD(tile_capacity, 0, 1 << 22, run, "tiles of 8 x 8 columns awake at the same time",         \
          "0: all that fit into 1 GiB")                                                            \
    FIELD(step_budget_ms, 0, 1000, pace, "time that a call of step() may take",                    \
          "0: as long as it takes. A step that needs more goes on in the next calls, and the "     \
          "soil's time slows down. With it, results depend on the machine")                        \
    FIELD(step_spread_max, 2, 1000, pace, "calls over which a budget may spread a step",           \
          "the last one finishes it")                                                              \
    FIELD(backend, 0, 2, run, "where the kernels run", "")                                         \
    FIELD(thread_count, 0, 1024, run, "threads of the CPU backend",                                \
          "0: all cores. Results do not depend on it")
// clang-format on

/// A function of world position [m]. Soil or terrain is where it is positive (thesis
/// section 2.2.2).
using DensityFunction = std::function<double(Vec3)>;

/// Soil put in, at the start or while the soil runs. `material` is a name out of the SoilDef;
/// empty: its first.
struct BoxFill {
    Aabb box;  ///< world axes; min below max on each
    std::string material;
};
/// A cylinder about the up axis.
struct CylinderFill {
    Vec3 base_center_m;
    double radius_m = 1, height_m = 1;  ///< each 1e-6..1e6
    std::string material;
};
/// Ground under a height image: row-major heights, stretched over the grid's whole floor. A row
/// runs along the world's x, and rows follow each other along z (y where z is up), before
/// SoilDef::yaw_rad turns the grid. The first value lies at the low end of both.
struct HeightMapFill {
    int width = 0, height = 0;     ///< values in a row, and rows, each 2..32768
    std::vector<float> heights_m;  ///< width x height values above the grid's floor, finite
    std::string material;
};
/// Ground whose surface is fractal value noise: gentle dunes to rough hills.
struct NoiseFill {
    double base_m = 0.5;       ///< mean height above the grid's floor, 0..1e4
    double amplitude_m = 0.2;  ///< half the range of the largest octave, 0..1e4
    double wavelength_m = 4;   ///< of the largest octave, 1e-3..1e6
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
