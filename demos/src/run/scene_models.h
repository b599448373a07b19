/// What a scene looks like: meshes of its bodies, its camera and its sun.
#pragma once

#include <string>
#include <vector>

#include "bsoil/render/renderer.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Grain sizes of the soil's and the terrain's surface in pictures [m], and the gloss of bodies.
inline constexpr float kSoilGrainM = 0.02f, kTerrainGrainM = 0.15f;
inline constexpr float kBodyGloss = 0.5f;

/// What a body looks like, in its frame.
struct BodyLook {
    /// A run of the mesh's indices with one texture.
    struct Part {
        std::string texture_file;
        uint32_t index_begin = 0, index_count = 0;
    };
    Mesh mesh;
    std::vector<float> places;       ///< as render::Skin::places
    std::vector<Part> parts;         ///< as render::Skin::parts
    std::vector<std::string> notes;  ///< one line each: textures that are not shown
};
/// What is drawn of a body, else its solids.
BodyLook body_look(const BodyItem& body);
/// The same with colours alone.
Mesh body_mesh(const BodyItem& body);

/// Pixels of all textures of a scene [bytes]. What is beyond shows its colour.
inline constexpr size_t kTextureBytesMost = size_t{256} << 20;

/// Meshes and textures of a scene's bodies for a renderer, in the bodies' order. notes: gets one
/// line for each file that is missing or cannot be read; what it was for shows its colour.
std::vector<render::MeshId> add_body_meshes(const Scene& scene, render::Renderer& renderer,
                                            std::vector<std::string>& notes);

/// A camera that looks straight down or up has no upper edge of its picture: its eye goes a
/// thousandth of the distance to the south, so that north is there. Others stay as they are.
void keep_off_vertical(render::Camera& camera);

/// The scene's camera, or one above a corner of the soil.
render::Camera scene_camera(const Scene& scene);

/// Where the sun is: low, on the camera's right and beyond what it looks at. So a rut of a few
/// centimetres has a bright and a dark flank, whether it runs across the picture or into it.
Vec3 sun_beside(const render::Camera& camera);

}  // namespace bsoil::scene
