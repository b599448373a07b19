/// Faces of a contact: connected parts of a body's contact with the soil whose size the soil feels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/contact/contact_law.h"
#include "bsoil/work_threads.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What a face's sums take of one element.
struct FaceElement {
    FaceElement() = default;
    /// a, b: place on the face [m]. upright: sine between the normal and straight down.
    FaceElement(const ContactVoxel& element, double a, double b, double upright);

    double area_m2 = 0;  ///< 0: it bears nothing, and nothing of it is summed up
    double a = 0, b = 0, depth_m = 0, foot_m = 0, relative_density = 0;
};

/// What is summed up of a face's elements.
struct FaceMoments {
    double area_m2 = 0;
    /// Moments of area of the elements' places on the face, whose axes are a and b.
    double first_a = 0, first_b = 0, second_aa = 0, second_ab = 0, second_bb = 0;
    double square_m4 = 0;                            ///< sum of squared areas
    double density_m2 = 0, of_known_density_m2 = 0;  ///< sum of density times area; that area
    double depth_m = 0, foot_m = 0;                  ///< as of FaceExtent

    /// Of an element.
    void add(const FaceElement& element);
    /// Of a face that goes on.
    void add(const FaceMoments& other);
    /// Mean over what is known, 0 where nothing is.
    double relative_density() const {
        return of_known_density_m2 > 0 ? density_m2 / of_known_density_m2 : 0;
    }
    /// Sides of the rectangle with the same second moments, the shorter first [m].
    std::array<double, 2> sides_m() const;
    /// A sole is no wider than its area has room for along its length.
    FaceExtent as_sole() const;
};

/// Two unit vectors across `up` that do not depend on the body.
std::array<Vec3, 2> level_axes(Vec3 up);

/// The faces of one body's contact.
/// Soles are the connected sets of voxels that look down (is_sole(), orientation.h); seen from
/// above, so that neither a spinning wheel's frame nor the grid's direction matters, and the tracks
/// of one body are two soles. Their sides are those of the rectangle with the same second moments
/// of area, the shorter no longer than its area has room for. Walls are the other voxels, one face
/// per dominant axis of the normal in the body's frame.
class ContactFaces {
  public:
    /// Overwrites what there was. element_m: how far the voxels' middles are apart. threads: to
    /// share the work, or null. Cost: O(n log n) in the voxels.
    void find(std::span<const ContactVoxel> voxels, Quat body_to_world, const ContactLaw& law,
              double element_m, const WorkThreads* threads = nullptr);

    std::span<const FaceExtent> faces() const { return faces_; }  ///< six walls, then soles
    /// The one of a voxel of find().
    const FaceExtent& of_voxel(size_t voxel) const {
        return faces_[static_cast<size_t>(face_of_voxel_[voxel])];
    }
    /// Its place in faces().
    int index_of_voxel(size_t voxel) const { return face_of_voxel_[voxel]; }
    /// What each sole of faces() is summed up of.
    std::span<const FaceMoments> soles() const { return soles_; }
    int sole_of_voxel(size_t voxel) const;  ///< its place in soles(); -1: on a wall
    /// For a sole that goes on under other bodies: see join_soles().
    void set_sole(size_t sole, const FaceExtent& extent);

  private:
    /// Where a voxel lies on its face.
    struct Place {
        int wall = -1;         ///< its axis; -1: on a sole
        int64_t x = 0, y = 0;  ///< of a sole: element seen from above
        FaceElement element;
    };
    struct Cell {
        int64_t x = 0, y = 0;
        int voxel = 0;
        bool operator<(const Cell& o) const { return x != o.x ? x < o.x : y < o.y; }
    };
    /// Cells of one x, none further from the one before than the gap.
    struct Run {
        size_t first = 0, last = 0;  ///< cells_ from first up to before last
        int root = 0;                ///< the first run of those it is joined with
    };
    void sort_cells();
    /// Makes runs_ of cells_ and joins those that are near each other.
    void join_runs(int gap);
    int root_of(int run);

    std::vector<FaceExtent> faces_;
    std::vector<FaceMoments> soles_;
    std::vector<int> face_of_voxel_;
    std::vector<Place> places_;  ///< per voxel
    std::vector<Cell> cells_;
    std::vector<Run> runs_;
    std::vector<int> face_of_root_;
};

/// Index 0..5 of the axis +x, -x, +y, -y, +z, -z that a vector points along most.
int dominant_axis_bin(Vec3 direction);

}  // namespace bsoil
#pragma GCC visibility pop
