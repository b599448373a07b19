/// Reading experiments: from a TOML file to checked points of a sweep.
#pragma once

#include <string>
#include <vector>

#include "experiment.h"

namespace bsoil::experiment {

/// Reads and checks an experiment of the given rig, or of any where it is empty. `settings` are
/// "key=value" with keys as in [sweep]; they replace what the file says. The error lists every
/// mistake, one a line, as "file:line:column: text". Measured data that is absent is no error: see
/// Experiment::missing_data.
Result<Experiment> load_experiment(const std::string& path, const std::string& rig,
                                   const std::vector<std::string>& settings = {});

/// The same for a text in memory; files are looked for beside `path`.
Result<Experiment> parse_experiment(const std::string& text, const std::string& path,
                                    const std::string& rig,
                                    const std::vector<std::string>& settings = {});

/// The keys of an experiment file as a Markdown page: the content of demos/experiments/README.md.
std::string experiment_markdown();

}  // namespace bsoil::experiment
