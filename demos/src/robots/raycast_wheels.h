/// The wheels of raycast vehicles as bodies that pictures show.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/scene_error.h"

namespace bsoil::scene {

/// Adds the wheels' bodies `vehicle/wheel` to the scene: driven, and touching nothing. The chassis
/// has to be there. What is wrong with the vehicle is added to `errors`, each with its place.
void add_raycast_wheels(Scene& scene, RaycastVehicleItem& vehicle,
                        std::vector<SchemaError>& errors);

}  // namespace bsoil::scene
