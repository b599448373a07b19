/// Tracks of a scene: wheels and links turned into bodies and joints.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/scene_error.h"

namespace bsoil::scene {

/// Adds a track's bodies (`track/wheel`, `track/link_01`) and joints (`track/wheel`,
/// `track/pin_01`) to the scene. The hull has to be there; where it has no group it gets one, which
/// the links share. What is wrong with the track is added to `errors`, each with its place.
void add_track(Scene& scene, const TrackItem& track, std::vector<SchemaError>& errors);

}  // namespace bsoil::scene
