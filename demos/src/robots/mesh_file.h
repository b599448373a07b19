/// Mesh files of robots: where a URDF's file name points, and what is in the file.
#pragma once

#include <string>

#include "files/data_files.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// The path of a file that the one at `named_by` names, a URDF or one of its meshes:
/// "package://NAME/PATH" is looked for in a folder NAME beside one of the folders above that file,
/// or in such a folder itself whatever its name; "file://PATH" and PATH relative to it. what:
/// "mesh" or "texture", for the error, which lists the places.
Result<std::string> find_robot_file(const char* what, const std::string& name,
                                    const std::string& named_by);

/// Triangles of an OBJ, STL or DAE file in the file's own axes, scaled by `scale` (metres per unit
/// of the file, no component zero; mirrored where an odd number is negative: triangles are turned
/// round so that they stay outward). The error names the file and what is wrong.
/// skin: as of read_mesh().
Result<TriangleMesh> read_robot_mesh(const std::string& path, Vec3 scale, MeshSkin* skin = nullptr);

}  // namespace bsoil::scene
