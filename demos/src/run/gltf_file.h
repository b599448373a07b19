/// Binary glTF 2.0 (Khronos, 2021).
#pragma once

#include <string>
#include <vector>

#include "scene_models.h"

namespace bsoil::scene {

/// A mesh with a name and a place.
struct NamedMesh {
    std::string name;
    BodyLook look;
    Pose pose;
    double roughness = 1;
};

/// The bytes of a file in which each mesh is a node of its own. z_up: the world's z is up; it is
/// turned to glTF's y. Textures come along as they are. notes: gets one line for each that cannot
/// be read; what it was for shows its colour.
std::string glb(const std::vector<NamedMesh>& meshes, bool z_up, std::vector<std::string>& notes);

}  // namespace bsoil::scene
