/// The experiment schema: every key an experiment file may have.
#pragma once

#include "experiment.h"
#include "reading/schema_table.h"

namespace bsoil::experiment {

/// [world]: the scenes' with defaults of its own. Rigs hold strong soils with light tools, which
/// takes Bullet's solver more iterations than a scene in motion.
struct ExperimentWorld : scene::WorldItem {
    ExperimentWorld() {
        ground_plane = false;
        solver_iterations = 200;
    }
};

/// One reading of an experiment file, before the points of the sweep are made.
struct ExperimentFile : scene::SceneItem {
    std::string title, description;
    ExperimentWorld world;
    RigSetup setup;
    std::vector<std::string> rigs;  ///< names of the rig tables the file has
    std::optional<MeasuredItem> measured;
    std::vector<PlotItem> plots;
    std::vector<ExpectItem> expectations;
    std::optional<ValidationItem> validation;
};

const scene::TableSpec& experiment_schema();

/// A number, a text, or true or false as a parameter's value; nothing for lists and tables.
std::optional<Parameter> parameter_of(const std::string& name, const toml::node& value);

/// Tables of names and values, flattened: "soil.voxel_m".
void flatten(const toml::table& table, const std::string& prefix,
             const std::function<void(const std::string& path, const toml::node& value)>& visit);

}  // namespace bsoil::experiment
