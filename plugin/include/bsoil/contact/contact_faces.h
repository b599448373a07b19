/// Faces of a contact: connected parts of a body's contact with the soil whose size the soil feels.
#pragma once

#include <numbers>
#include <span>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/contact/contact_law.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A face whose normal is no further off straight down than this cosine is a sole, any other a
/// wall.
inline constexpr double kSoleCosine = std::numbers::sqrt2 / 2;

/// The faces of one body's contact.
struct ContactFaces {
    std::vector<FaceExtent> faces;
    std::vector<int> of_voxel;  ///< index into faces, per contact voxel
};

/// Soles are the connected sets of voxels that look down (by more than 45 deg); seen from above, so
/// that neither a spinning wheel's frame nor the grid's direction matters, and the tracks of one
/// body are two soles. Their sides are those of the rectangle with the same second moments of area,
/// the shorter no longer than its area has room for.
/// Walls are the other voxels, one face per dominant axis of the normal in the body's frame.
/// element_m: how far the voxels' middles are apart. `faces` is overwritten. Cost: O(n log n) in
/// the voxels.
void find_contact_faces(std::span<const ContactVoxel> voxels, Quat body_to_world,
                        const ContactLaw& law, double element_m, ContactFaces& faces);

/// Index 0..5 of the axis +x, -x, +y, -y, +z, -z that a vector points along most.
int dominant_axis_bin(Vec3 direction);

}  // namespace bsoil
#pragma GCC visibility pop
