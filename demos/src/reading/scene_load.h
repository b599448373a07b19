/// Reading scenes: from a TOML file to a checked Scene.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace bsoil::scene {

struct SchemaError;

/// Reads and checks a scene and all files it names; robots are expanded into bodies and joints. The
/// error lists every mistake, one a line, as "file:line:column: text". Data files that are absent
/// are no error: see Scene::missing_data.
Result<Scene> load_scene(const std::string& path);

/// The same for a text in memory; files are looked for beside `path`.
Result<Scene> parse_scene(const std::string& text, const std::string& path);

/// The values of an item of the top level's [[table]] as text, defaults where the file gives none.
std::map<std::string, std::string> values_of(const std::string& table, const SceneItem& item);

/// The keys of a scene file as a Markdown page: the content of demos/scenes/README.md.
std::string schema_markdown();

/// Looks up the soil's materials, fills them into its SoilDef and checks it against the world;
/// errors are added to the list. load_scene has done so already.
void check_soil(Scene& scene, std::vector<SchemaError>& errors);

}  // namespace bsoil::scene
