/// `bsoil check`: a scene as a regression test.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "commands.h"
#include "files/json_text.h"
#include "opened_scene.h"
#include "run/baseline.h"

namespace bsoil::command {
namespace {

constexpr size_t kDifferencesShown = 20;

struct CheckArguments {
    OpenedScene opened;
    std::string baseline;
    double tolerance = 0;
    bool update = false;
};

int write_baseline(const std::string& path, const nlohmann::ordered_json& json) {
    std::ofstream file(path);
    file << scene::json_text(json, 1) << '\n';
    if (!file.flush()) {
        fmt::print(stderr, "{}: cannot be written; check its folder and the disk\n", path);
        return kCouldNotRun;
    }
    fmt::print("{} written\n", path);
    return kPassed;
}

int check(CheckArguments& arguments) {
    nlohmann::ordered_json expected;
    if (!arguments.update) {
        auto read = scene::read_baseline(arguments.baseline);
        if (!read) {
            fmt::print(stderr, "{}\n", read.error());
            return kCouldNotRun;
        }
        expected = std::move(*read);
        if (expected.contains("steps") && arguments.opened.step_count == 0) {
            arguments.opened.step_count = expected["steps"].get<long long>();
        }
    }
    const int opened = arguments.opened.open();
    if (opened != kPassed) return opened;
    scene::SceneRun& run = *arguments.opened.run;
    scene::BaselineRecorder recorder(run);
    while (!run.finished()) {
        run.step();
        if (const std::string failure = run.failure(); !failure.empty()) return could_not(failure);
        recorder.observe();
    }
    const nlohmann::ordered_json found = recorder.finish();
    if (arguments.update) {
        const auto where = scene::not_a_number_in(found);
        if (!where) return write_baseline(arguments.baseline, found);
        return could_not(fmt::format(
            "{}: not written, {} is no number; look at where telemetry.csv of `bsoil run` "
            "has the first",
            arguments.baseline, *where));
    }

    const std::vector<std::string> differences =
        scene::compare_baselines(expected, found, arguments.tolerance);
    for (size_t i = 0; i < std::min(differences.size(), kDifferencesShown); ++i) {
        fmt::print("{}\n", differences[i]);
    }
    if (differences.size() > kDifferencesShown) {
        fmt::print("... and {} more\n", differences.size() - kDifferencesShown);
    }
    fmt::print("{} {}: {} differences from {}\n", differences.empty() ? "PASS" : "FAIL",
               arguments.opened.path, differences.size(), arguments.baseline);
    return differences.empty() ? kPassed : kFailed;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<CheckArguments>();
    CLI::App* command = app.add_subcommand(
        "check",
        "run a scene and compare it with a baseline: 0 equal, 1 different, 2 could not run");
    arguments->opened.add_options(*command);
    command->add_option("--against", arguments->baseline, "the baseline (JSON)")->required();
    command
        ->add_option(
            "--tolerance", arguments->tolerance,
            "accept numbers off by this share of max(1, value); checksums are then not compared")
        ->check(at_least(0))
        ->capture_default_str();
    command->add_flag("--update", arguments->update, "write the baseline instead of comparing");
    command->callback([arguments, &exit_code] { exit_code = check(*arguments); });
}

}  // namespace bsoil::command
