/// Puts a scene's terrain and soil into a Soil, and tells it of the bodies' surfaces.
#pragma once

#include "bsoil/bullet/soil_action.h"
#include "bsoil/soil.h"
#include "bullet_scene.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Terrain first, then the fills, sources and sinks in the file's order. Gives the ids of the
/// sources. The error names the place in the file.
Result<std::vector<int>> fill_soil(const Scene& scene, Soil& soil);

/// Gives the bodies in the soil the tool friction and adhesion of their items. Error: what
/// SoilAction::set_options() says, with the place in the scene.
Status set_surfaces(const Scene& scene, const BulletScene& world, bullet::SoilAction& action);

}  // namespace bsoil::scene
