/// Puts a scene's terrain and soil into a Soil, and tells it of the bodies' surfaces.
#pragma once

#include "bsoil/bullet/soil_action.h"
#include "bsoil/soil.h"
#include "bullet_scene.h"
#include "scene.h"

namespace bsoil::scene {

/// Terrain first, then the fills in the file's order. The error names the place in the file.
Status fill_soil(const Scene& scene, Soil& soil);

/// The density function of a [[terrain]] of kind hills or caves: rock where it is positive;
/// its values are distances only near the surface.
/// Thesis 2.2.2, after Geiss: a height surface whose sampling point is warped by a second noise, so
/// that it overhangs, less round hollows.
DensityFunction terrain_density(const TerrainItem& terrain, UpAxis up, Vec3 floor_center_m);

/// Whether the noise of a terrain over such a soil takes no longer than somebody waits for it. The
/// error says what to change.
Status check_terrain_cost(const TerrainItem& terrain, const SoilDef& soil);

/// Gives the bodies in the soil the tool friction and adhesion of their items. Error: what
/// SoilAction::set_options() says, with the place in the scene.
Status set_surfaces(const Scene& scene, const BulletScene& world, bullet::SoilAction& action);

}  // namespace bsoil::scene
