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

/// Soil does not know how many bodies press on it. Soles of different bodies that have elements
/// beside each other, at one height and on soil of one carrier, are one sole: each gets the size,
/// depth and density that they have together. Elements are beside each other where the way between
/// their middles is no longer than one and a half of their sides.
/// Cost: O(n log n) in the bodies that lie apart and in the voxels of those that do not. threads:
/// to share the work, or null.
void join_soles(std::span<const BodySoles> bodies, Vec3 up, const WorkThreads* threads = nullptr);

}  // namespace bsoil
#pragma GCC visibility pop
