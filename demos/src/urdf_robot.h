/// Robots: a URDF turned into bodies and joints of a scene.
#pragma once

#include <string>

#include "scene.h"

namespace bsoil::scene {

/// Reads the URDF at `path` and adds the robot's bodies (`robot/link`) and joints (`robot/joint`)
/// to the scene. Links joined by fixed joints become one body named after the topmost of them that
/// has a mass or a solid. Collision boxes, cylinders and spheres are taken as they are, meshes as
/// their convex hull. `$(optenv NAME VALUE)`, which xacro leaves behind, is read as VALUE. The
/// error names what the file lacks.
Status add_robot(Scene& scene, const RobotItem& robot, const std::string& path);

}  // namespace bsoil::scene
