/// The bodies of .bullet files as bodies of a scene.
#pragma once

#include "robots/bullet_file.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Adds the bodies `file/body` of what was found in a file to the scene, and a warning for each
/// part that is missing.
void add_bullet_bodies(Scene& scene, BulletFileItem& item, BulletFileSurvey survey);

}  // namespace bsoil::scene
