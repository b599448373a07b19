/// Solids of any form, as signed distances on a sparse lattice.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "bsoil/geometry.h"
#include "bsoil/result.h"
#include "bsoil/soil_def.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// How a DistanceLattice is made.
struct LatticeDef {
    double voxel_m = 0.05;  ///< edge of the voxels of the soil it is for, 0.001..1
    double margin_m = 0;    ///< added all around the solid (a collision margin), 0..1e5
    /// What lies outside of this box is left out: for solids much larger than the soil.
    Aabb region{{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                 -std::numeric_limits<double>::infinity()},
                {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                 std::numeric_limits<double>::infinity()}};
};

/// A solid of any form in its own frame (metres): the signed distance to its surface, negative
/// inside, sampled at points half a voxel apart near the surface and interpolated between them;
/// farther away only inside or outside is known. Flat faces are exact to 1/10000 voxel;
/// right-angled edges are rounded by up to a quarter of the spacing, sharper ones by up to the
/// spacing. Never changes; share it between bodies and soils.
///
/// Memory: 1 KiB for each cube of 3.5 voxels that the surface passes through, and 4 bytes for each
/// other one of the box around the solid. Where that would be more than 64 MiB the spacing is
/// doubled, up to two voxels; then creation fails.
class DistanceLattice {
  public:
    using LatticeResult = Result<std::shared_ptr<const DistanceLattice>>;  ///< of creation

    /// The solid of a triangle mesh. Triangles that share edges (corners at the very same place are
    /// one) are a part. A part without open edges is solid: inside is where the winding number, of
    /// all such parts together, is above zero (signed crossings of rays along the three axes, by
    /// majority); parts may overlap, and a part turned inside out within another is a cavity.
    /// Triangles may be wound either way. A part with open edges is a plate around its triangles;
    /// but one that closing its gaps (up to a tenth of its surface) makes a shell of plates thinner
    /// than a wall on the mean, as published meshes often are, counts as closed.
    ///
    /// A plate, and a solid where it is thinner (both its faces within) is made as thick as it
    /// takes to stop soil: limits::kThinnestWallVoxels, half of it to either side; its rims stay
    /// where they are. Thicker solids keep their surface.
    ///
    /// The error names a coordinate that is not finite or beyond 1e5 m, an index out of range, no
    /// triangle, no area, or more memory than the limit. Cost: some 20 us a triangle and 100 us a
    /// cube of 3.5 voxels on the surface.
    static LatticeResult from_mesh(const TriangleMesh& mesh, const LatticeDef& def);

    /// The solid where `distance_m` is negative. It must grow by no more than 1 m a metre, and not
    /// be negative outside of `bounds`. Called from one thread, some 500 times a cube of 3.5
    /// voxels on the surface.
    static LatticeResult from_distance(const std::function<double(Vec3)>& distance_m,
                                       const Aabb& bounds, const LatticeDef& def);

    ~DistanceLattice();

    /// Signed distance as the soil sees it; far from the surface no more than +-far_m().
    double distance_m(Vec3 point) const;

    /// The face that a point is nearest to.
    struct Face {
        double distance_m = 0;  ///< above the face, negative inside
        Vec3 normal{0, 0, 1};   ///< unit, outward
    };
    /// Of the mesh itself, at full accuracy, or from the gradient of the lattice. Microseconds.
    Face nearest_face(Vec3 point) const;

    const Aabb& bounds() const;    ///< of the solid, within LatticeDef::region
    double spacing_m() const;      ///< between sampled points
    double far_m() const;          ///< distances are known up to here, >= 1.25 voxels
    int64_t memory_bytes() const;  ///< of the lattice
    /// The triangles as given, with corners at one place merged; empty from a distance function.
    const TriangleMesh& mesh() const;

    /// For the kernels: see kLattice... in shaders/soil_layout.h.
    std::span<const int32_t> words() const;
    Vec3 origin() const;       ///< of node (0, 0, 0)
    double quantum_m() const;  ///< of a sample

  private:
    struct Data;
    explicit DistanceLattice(std::unique_ptr<const Data> data);
    std::unique_ptr<const Data> data_;
};

}  // namespace bsoil
#pragma GCC visibility pop
