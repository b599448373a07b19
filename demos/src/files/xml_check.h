/// A look at XML before a recursive parser gets it.
#pragma once

#include <string>

#include "bsoil/result.h"

namespace bsoil::scene {

/// Elements inside each other. Robots need 6, meshes of robots with all their links 30.
inline constexpr int kXmlDepthCapacity = 100;
/// Nodes that a COLLADA file has once every <instance_node> stands for what it names: a file of a
/// few kilobytes can name its nodes over and over.
inline constexpr int kXmlNodeCapacity = 100'000;

/// Error: elements are nested deeper than the capacity, or parsers may not agree where a
/// declaration ends. Bad syntax is the parser's to refuse.
Status check_xml_depth(const std::string& xml);

/// Error: <instance_node> elements stand for more nodes than the capacity, or for themselves.
Status check_node_instances(const std::string& collada);

}  // namespace bsoil::scene
