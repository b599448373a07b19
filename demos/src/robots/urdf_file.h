/// Reading a URDF file with errors that name the file and the element.
#pragma once

#include <urdf_world/types.h>

#include <string>

#include "bsoil/result.h"

namespace bsoil::scene {

/// A tree of links below one root. `$(optenv NAME VALUE)`, which xacro leaves behind, is read as
/// VALUE. Refused: what is no XML or no URDF, a link that is the child of two joints or of itself
/// over some way (a loop), two roots, more than 1000 links.
Result<urdf::ModelInterfaceSharedPtr> read_urdf(const std::string& path);

}  // namespace bsoil::scene
