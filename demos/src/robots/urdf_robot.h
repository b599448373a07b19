/// Robots: a URDF turned into bodies and joints of a scene.
#pragma once

#include <string>

#include "scene/scene.h"

namespace bsoil::scene {

/// Reads the URDF at `path` and adds the robot's bodies (`robot/link`) and joints (`robot/joint`)
/// to the scene. Links joined by fixed joints become one body named after the topmost of them that
/// has a mass or a solid; a floating joint leaves a body of its own. Collision boxes, cylinders and
/// spheres are taken as they are, meshes as the scene says. A root link without mass and solid
/// stands for the world; one whose mass the file gives as 0 stands still. What the file has and a
/// run leaves out (damping and friction of joints), and inertias that fit no solid of the link's
/// size, are added to the scene's warnings. The error names the file and the element, or the place
/// in the scene.
Status add_robot(Scene& scene, const RobotItem& robot, const std::string& path);

}  // namespace bsoil::scene
