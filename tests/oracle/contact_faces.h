/// The faces of a body's contact with soil, element by element and pair by pair: not in the thesis.
/// What ContactFaces sorts, joins and sums up in one go is here asked of each pair of elements and
/// of each direction.
#pragma once

#include <span>
#include <vector>

#include "bsoil/body.h"

namespace oracle {

using bsoil::ContactVoxel;
using bsoil::Quat;
using bsoil::Vec3;

/// What the search for faces is told.
struct FaceRules {
    Vec3 up{0, 0, 1};
    Quat body_to_world;
    double element_m = 0.05;  ///< between the middles of neighbouring elements
    int gap = 2;              ///< parts of a sole this many elements apart are one
};

/// A face with the elements that are of it, in order.
struct Face {
    bool is_sole = false;
    int axis = -1;  ///< of a wall: 0..5, +x, -x, +y, -y, +z, -z of the body
    std::vector<int> elements;
    double width_m = 0, length_m = 0, depth_m = 0, foot_m = 0;
    double relative_density = 0;
};

/// Soles in the order of their first elements by place, walls by their axes; without those that
/// have no element. Soles are what looks down by more than 45 deg. Cost: the square of the
/// elements.
std::vector<Face> contact_faces(std::span<const ContactVoxel> voxels, const FaceRules& rules);

}  // namespace oracle
