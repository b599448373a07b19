/// Mesh files of robots: where a URDF's file name points, and what is in the file.
#pragma once

#include <string>

#include "scene/scene.h"

namespace bsoil::scene {

/// The path of a mesh that the URDF at `urdf_path` names: "package://NAME/PATH" is looked for in a
/// folder NAME beside one of the folders above the URDF, or in such a folder itself whatever its
/// name; "file://PATH" and PATH relative to the URDF. The error lists the places.
Result<std::string> find_robot_mesh(const std::string& name, const std::string& urdf_path);

/// Triangles of an OBJ, STL or DAE file in the file's own axes, scaled by `scale` (metres per unit
/// of the file, no component zero; mirrored where an odd number is negative: triangles are turned
/// round so that they stay outward). The error names the file and what is wrong.
Result<TriangleMesh> read_robot_mesh(const std::string& path, Vec3 scale);

}  // namespace bsoil::scene
