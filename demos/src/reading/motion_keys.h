/// What the keys of a [[motion]] have to be, beyond what the schema's table says of each.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/scene_error.h"

namespace bsoil::scene {

/// The mistakes in a motion's keys and rounds. joint: that it moves; null for a body, or where it
/// is not known.
std::vector<SchemaError> motion_key_errors(const MotionItem& motion, const JointItem* joint);

}  // namespace bsoil::scene
