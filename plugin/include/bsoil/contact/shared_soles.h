/// Soles that go on from one body to the next: the links of a track, two wheels side by side.
#pragma once

#include <span>

#include "bsoil/contact/contact_faces.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// One body's contact and its faces.
struct BodySoles {
    std::span<const ContactVoxel> voxels;
    ContactFaces* faces = nullptr;  ///< found of these voxels
};

/// Soil does not know how many bodies press on it. Soles of different bodies no further apart than
/// `gap_m` along each of two level axes and in height, on soil of one carrier, are one sole: each
/// gets the size, depth and density that they have together.
/// Cost: the bodies, and of those whose soles come near each other's their voxels, each O(n log n).
void join_soles(std::span<const BodySoles> bodies, Vec3 up, double gap_m);

}  // namespace bsoil
#pragma GCC visibility pop
