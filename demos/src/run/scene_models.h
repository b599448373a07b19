/// What a scene looks like: meshes of its bodies, its camera and its sun.
#pragma once

#include "bsoil/render/renderer.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Grain sizes of the soil's and the terrain's surface in pictures [m], and the gloss of bodies.
inline constexpr float kSoilGrainM = 0.02f, kTerrainGrainM = 0.15f;
inline constexpr float kBodyGloss = 0.5f;

/// What a body looks like, in its frame: what is drawn of it, else its solids.
Mesh body_mesh(const BodyItem& body);

/// The scene's camera, or one above a corner of the soil.
render::Camera scene_camera(const Scene& scene);

/// Where the sun is: low, on the camera's right and beyond what it looks at. So a rut of a few
/// centimetres has a bright and a dark flank, whether it runs across the picture or into it.
Vec3 sun_beside(const render::Camera& camera);

}  // namespace bsoil::scene
