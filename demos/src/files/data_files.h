/// Files a scene names: where they are, and what is in them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace bsoil::scene {

/// The path of a file a scene names: "data:PATH" is looked for under $BULLETSOIL_DATA, else under
/// `shared/data` beside one of the folders above the scene; anything else relative to the scene.
/// Empty where it is not there.
std::string find_file(const std::string& name, const std::string& scene_path);

/// Which pictures a mesh file lays on its triangles.
struct MeshSkin {
    std::vector<std::array<float, 2>> places;  ///< of each vertex: 0, 0 is the lower left corner
    std::vector<int> textures;                 ///< of each triangle, among `names`; -1: none
    std::vector<std::string> names;            ///< files, as the mesh file has them
    bool has_places = false;                   ///< somewhere
};

/// Triangles of an OBJ, STL or DAE file, in the file's own units and axes. All of a file's meshes
/// together. skin: where it is given, it is filled, and vertices with several places in textures
/// are there several times.
Result<TriangleMesh> read_mesh(const std::string& path, MeshSkin* skin = nullptr);

/// Pixels of a picture.
struct ColorPicture {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;  ///< four bytes a pixel, rows from top to bottom
};

/// A side of a texture [pixels].
inline constexpr int kTextureSideMax = 4096;

/// A PNG to lay on triangles. The error names the file and what is wrong.
Result<ColorPicture> read_texture(const std::string& path);

/// A grey PNG as heights between two limits, row-major from the image's top left. 8 and 16 bits.
Result<HeightMapFill> read_height_map(const std::string& path, double min_height_m,
                                      double max_height_m);

}  // namespace bsoil::scene
