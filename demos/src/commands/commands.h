/// The subcommands of `bsoil`. Each adds its options to the command line and returns its exit code
/// through `exit_code`.
#pragma once

#include <optional>
#include <string>

#include "bsoil/soil_def.h"

namespace CLI {
class App;
}

namespace bsoil::command {

/// Exit codes of all commands; ctest takes kSkipped as its SKIP_RETURN_CODE.
inline constexpr int kPassed = 0;
inline constexpr int kFailed = 1;         ///< a check failed, a baseline differs
inline constexpr int kCouldNotRun = 2;    ///< bad arguments, a scene with mistakes, no device
inline constexpr int kInterrupted = 130;  ///< Ctrl-C: what there was is written
inline constexpr int kSkipped = 77;       ///< the scene's data is not there

/// Prints what went wrong; kCouldNotRun.
int could_not(const std::string& why);

void add_run(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_view(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_bench(CLI::App& app, int& exit_code);
void add_import_bekker(CLI::App& app, int& exit_code);
/// plate, blade, traction, shear, column and experiment-keys.
void add_experiments(CLI::App& app, int& exit_code);
void add_validate(CLI::App& app, int& exit_code);
void add_scene_keys(CLI::App& app, int& exit_code);

/// Where the kernels run: the options --backend, --threads and --mesher, which several commands
/// have.
struct DeviceOptions {
    std::string backend = "auto";
    int thread_count = 0;
    std::string mesher;
    void add_to(CLI::App& app);
    Backend chosen() const;
    /// None: where the soil is computed.
    std::optional<Backend> chosen_mesher() const;
};

}  // namespace bsoil::command
