/// The soil of the oracle: a plain dense array of voxels in double precision. Everything in
/// tests/oracle is written from the thesis (Geiger 2015, chapters 2.1.2, 2.3 and 3) and the
/// deviations that each file lists, not from the kernels.
///
/// Units: lengths in voxels, time in base steps, soil in voxel volumes, mass in voxels of the
/// reference density. The vertical index grows upwards; the thesis' j grows downwards (30).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/geometry.h"
#include "bsoil/limits.h"

namespace oracle {

using bsoil::Vec3;

inline int nearest(double value) { return static_cast<int>(std::floor(value + 0.5)); }
/// Evenly spread in 0..1: of a voxel in a pass, and with pass 0 of the voxel alone. The spatial
/// hash of Teschner et al. (2003), mixed by a prime of xxHash, of which 16 bits count.
double chance(int x, int y, int z, uint32_t pass);

inline double largest(Vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// What a voxel's soil rests on.
struct Support {
    enum class Kind { falling, ground, body };
    Kind kind = Kind::falling;
    int body = -1;  ///< index into the bodies, for Kind::body
};

struct Voxel {
    double soil = 0;     ///< rho of the thesis
    double water = 0;    ///< mass of it, moves with the soil
    double bond = 0;     ///< the part of it that never moved and keeps its cohesion
    double terrain = 0;  ///< fixed part of psi
    double bodies = 0;   ///< the other part of psi, a sum over shapes (may pass 1)
    int owner = -1;      ///< index of the body that covers most
    Vec3 momentum;       ///< mass times u of the thesis
    Vec3 force;          ///< f of the thesis, of any length
    std::array<double, bsoil::limits::kMaterialCapacity> mass{};
    Support support;

    double psi() const { return std::min(1.0, terrain + bodies); }
    double total_mass() const;
    int main_material() const;  ///< the one there is most of; the first on a tie
    bool is_mixed() const;      ///< of several materials
    /// Mean by mass of what each material has. Without mass: of the first.
    double mean(const std::vector<double>& of_materials) const;
};

/// A moving or fixed body.
struct Body {
    Vec3 velocity;          ///< of its centre of mass
    Vec3 angular_velocity;  ///< radians a step
    Vec3 center;            ///< of mass
    bool moves = false;
    /// What Coulomb friction can change a speed by in one step; negative: by the soil's materials.
    double friction_speed = 0;
    double packing = 0;  ///< relative density that soil pressed by it takes up
    int reach = 0;       ///< voxels of soil beside it whose density counts for its contact
    Vec3 velocity_at(int x, int y, int z) const;  ///< v + omega x r at a voxel's middle
};

/// Numbers that the model leaves open. The tests take them from the kernels' layout, so that tuning
/// one of them does not ask for a change here.
struct Model {
    double solid_coverage = 0.5;  ///< a voxel covered so far is closed to inflow
    double support_slack = 0;     ///< room that a voxel may lack and still carry what is above it
    double carry_slack = 0;       ///< the same on a moving body
    double elastic_excess = 0;    ///< excess that stays under a body
    double excess_tolerance = 0;  ///< excess up to this does not flow
    double push_room = 0;         ///< a voxel with less free room bars the way of pushed soil
    double pushed_most = 2;    ///< soil that waits for a push to go on before it counts as overflow
    double crowded_least = 4;  ///< a voxel with more soil takes none from a push
    double voxel_most = 16;    ///< a voxel may hold so much,
    double pushes_meet = 8;    ///< and takes this part of what still fits from each push
    double still_speed = 0;    ///< a wall slower than this drives no soil out of itself
    double push_speed = 0;     ///< of the fastest body: none pushes soil faster [voxels a step]
    double push_least = 0;     ///< soil pushed no faster than this stays at rest
    int body_substeps = 1;     ///< parts of this step in which bodies move
    double follow_most = 0;    ///< carried soil follows walls up to this speed [voxels a step]
    int held_reach = 0;        ///< how far the wall may be that holds a load back
    int arch_reach = 0;        ///< how far the sides of an arch may be; 0: there are no arches
    double arch_least = 0.5;   ///< soil that leans on them, and that is a falling span
    double crowded = 2;        ///< soil of a falling voxel on which no more slides
    int roof_reach = 32;       ///< voxels from a roof's to its abutment at most
    /// Per material: cohesion over unit weight of soil that was never moved [voxels]. Empty where
    /// none has any: then there are no roofs.
    std::vector<double> cohesion_height = {};
    int arch_shortest = 1;  ///< voxels of a falling span at least, where there are arches
    double speck = 0;       ///< advected and pushed shares of a voxel's soil below this stay
    double mass_speck = 0;  ///< nor does less mass than this leave a voxel as a share
    double thin = 0;        ///< soil up to this goes whole along what bars it
    double crumb = 0;       ///< a voxel's soil up to this moves whole, and slides nowhere
    double cover_intake = 1.0 / 16;  ///< of the room beside a body that a voxel takes from a slope
    double slip_tolerance = 0;       ///< wedges not worth a slide
    double slip_overshoot = 1.0 / 64;  ///< what more than a wedge slides, see slippage.h
    int span_capacity = 5;             ///< height spans kept of a column, the uppermost
    int slip_depth = 2;                ///< voxels of a column that may slide at once
    double slip_intake = 1;            ///< voxels of soil a column gets from each neighbour at once
    double slip_rate_least = 0.125,
           slip_rate_most = 0.25;            ///< share of a wedge that slides at once
    int slip_stride = 1;                     ///< voxels that soil slides at once
    double gravity = 0;                      ///< voxels a step squared
    int substeps = 1;                        ///< parts this step is cut into
    std::vector<double> friction_angle_rad;  ///< per material
    std::vector<double> friction_speed;      ///< per material, on bodies: see Body
    /// Per material: volume of a unit of mass of loose and of compacted soil; 0 where it is fixed.
    std::vector<double> loose_volume, compacted_volume;
    std::vector<double> placed_volume;  ///< the same as placed
    /// Per material: relative density that sheared soil comes to, at least. Empty: loose.
    std::vector<double> critical_density;
    /// Cohesion of moved soil goes by its density; friction of soil that was never moved does.
    bool regains = false, dilates = false;
    /// Per material, or empty where none has any: slope above tan(phi) that stands, and the share
    /// of slides that do not take place.
    std::vector<double> roughness, viscosity;
    /// Per material, or empty where none falls in air: what air takes of its speed in a step.
    std::vector<double> air;
    Vec3 wind;                       ///< [voxels a step]
    double gust = 0;                 ///< share
    int gust_cell = 1, shelter = 0;  ///< [voxels]
    double gust_x = 0, gust_y = 0;   ///< the lattice's place [voxels]
    bool slides = false;             ///< soil keeps the momentum of its slides
    double step_s = 1.0 / 60;
    double slide_kick = 0;       ///< what drives slides in this slip pass [voxels a step squared]
    int slide_count = 1;         ///< slide passes in a step
    double slide_creep = 0.125;  ///< wedges up to this high slip where soil slides
    int slide_gap = 4, slide_depth = 128, slide_reach = 128;  ///< see sliding.h [voxels]
    double slide_speed = 16;                                  ///< none is faster [voxels a step]
    uint32_t pass = 0;  ///< number of the pass, for what chance decides
};

class Field {
  public:
    Field(int size_x, int size_y, int size_z)
        : nx(size_x),
          ny(size_y),
          nz(size_z),
          voxels_(static_cast<size_t>(size_x) * size_y * size_z) {}
    bool inside(int x, int y, int z) const {
        return x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz;
    }
    Voxel& at(int x, int y, int z) { return voxels_[(static_cast<size_t>(z) * ny + y) * nx + x]; }
    const Voxel& at(int x, int y, int z) const {
        return voxels_[(static_cast<size_t>(z) * ny + y) * nx + x];
    }
    /// Walls of the grid and voxels mostly taken by rigid things: nothing flows in.
    bool closed(const Model& model, int x, int y, int z) const {
        return !inside(x, y, z) || at(x, y, z).psi() >= model.solid_coverage;
    }
    /// Calls visit(x, y, z) for every voxel.
    template <typename Visit>
    void for_each(Visit&& visit) const {
        for (int z = 0; z < nz; ++z) {
            for (int y = 0; y < ny; ++y) {
                for (int x = 0; x < nx; ++x) visit(x, y, z);
            }
        }
    }
    const int nx, ny, nz;

  private:
    std::vector<Voxel> voxels_;
};

/// Soil beyond a voxel's room, and beyond what a body may press in elastically, that has to go;
/// none while it is within the tolerance. Inside a body (a voxel half covered by bodies) all of the
/// excess has to go.
double excess(const Model& model, const Voxel& voxel);

/// Whether most of a voxel's soil was never moved; crumbs hold nothing.
bool is_bonded(const Model& model, const Voxel& voxel);

/// Moves `share` (0..1) of a voxel's soil, with its masses and momentum, from `from` as it was to
/// `to`, where it has no bond.
void move_share(const Voxel& from_before, Voxel& from, Voxel& to, double share);

/// Volume of a unit of mass of a voxel's soil, loose and compacted: volumes of its materials add
/// up. Both 0 where the density of all of them is fixed.
struct VolumeRange {
    double loose = 0, compacted = 0;
};
VolumeRange volume_range(const Model& model, const Voxel& voxel);

/// How much more than its volume the soil of a voxel takes up once it moves freely (soil arrives no
/// denser than loose), in voxel volumes. >= 0
double swelling(const Model& model, const Voxel& voxel);

/// The same of soil that slides: no denser than critical.
double dilation(const Model& model, const Voxel& voxel);

}  // namespace oracle
