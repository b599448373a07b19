/// Files a scene names: where they are, and what is in them.
#pragma once

#include <optional>
#include <string>

#include "scene/scene.h"

namespace bsoil::scene {

/// The path of a file a scene names: "data:PATH" is looked for under $BULLETSOIL_DATA, else under
/// `shared/data` beside one of the folders above the scene; anything else relative to the scene.
/// Empty where it is not there.
std::string find_file(const std::string& name, const std::string& scene_path);

/// Triangles of an OBJ, STL or DAE file, in the file's own units and axes. All of a file's meshes
/// together.
Result<TriangleMesh> read_mesh(const std::string& path);

/// A grey PNG as heights between two limits, row-major from the image's top left. 8 and 16 bits.
Result<HeightMapFill> read_height_map(const std::string& path, double min_height_m,
                                      double max_height_m);

}  // namespace bsoil::scene
