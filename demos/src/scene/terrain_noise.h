/// Rock made of noise: the terrains of kind hills and caves.
#pragma once

#include "bsoil/soil.h"
#include "scene.h"

namespace bsoil::scene {

/// The density function of a [[terrain]] of kind hills or caves: rock where it is positive;
/// its values are distances only near the surface.
/// Thesis 2.2.2, after Geiss: a height surface whose sampling point is warped by a second noise, so
/// that it overhangs, less round hollows.
DensityFunction terrain_density(const TerrainItem& terrain, UpAxis up, Vec3 floor_center_m);

/// Whether the noise of a terrain over such a soil takes no longer than somebody waits for it. The
/// error says what to change.
Status check_terrain_cost(const TerrainItem& terrain, const SoilDef& soil);

}  // namespace bsoil::scene
