/// `bsoil run`: runs a scene and leaves tables, a summary, pictures and a snapshot behind.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "opened_scene.h"
#include "run_checks.h"
#include "run_pictures.h"
#include "telemetry.h"

namespace bsoil::command {
namespace {

struct RunArguments {
    OpenedScene opened;
    std::string out;
    std::string from;
    long long snapshot_every = 0;
    bool frames = false, video = false, no_pictures = false;
};

/// A bar on a terminal, nothing elsewhere.
class ProgressBar {
  public:
    void show(const scene::SceneRun& run) {
        if (!terminal_) return;
        const int percent = static_cast<int>(100 * run.step_count() / run.step_target());
        if (percent == percent_) return;
        percent_ = percent;
        fmt::print(stderr, "\r[{:<40}] {:3}%  {:.1f} s",
                   std::string(static_cast<size_t>(percent * 2 / 5), '#'), percent, run.time_s());
        if (percent == 100) fmt::print(stderr, "\n");
        std::fflush(stderr);
    }

  private:
    const bool terminal_ = isatty(STDERR_FILENO) != 0;
    int percent_ = -1;
};

Status write_text(const std::string& path, const std::string& text) {
    std::ofstream file(path);
    file << text;
    if (!file.flush()) return Error{path + ": cannot be written"};
    return Done{};
}

/// Prints the checks, adds them to the summary; kFailed when one failed.
int report(const std::vector<scene::CheckResult>& results, nlohmann::ordered_json& summary) {
    int exit_code = kPassed;
    summary["checks"] = nlohmann::ordered_json::array();
    for (const scene::CheckResult& result : results) {
        fmt::print("{} {}: {}\n", verdict_text(result.verdict), result.name, result.figure);
        summary["checks"].push_back({{"verdict", verdict_text(result.verdict)},
                                     {"name", result.name},
                                     {"figure", result.figure}});
        if (result.verdict == scene::CheckResult::Verdict::fail) exit_code = kFailed;
    }
    return exit_code;
}

int could_not(const std::string& text) {
    fmt::print(stderr, "{}\n", text);
    return kCouldNotRun;
}

constexpr char kChecksSection[] = "host.checks";

Status save(scene::SceneRun& run, const scene::RunChecks& checks, const std::string& path) {
    return run.save(path, {{kChecksSection, checks.state()}});
}

/// Goes on from a snapshot of the same scene.
Status restore(scene::SceneRun& run, scene::RunChecks& checks, const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const std::vector<uint8_t>* watched = find_section(*sections, kChecksSection);
    if (!watched) return Error{path + ": was not written by bsoil run"};
    if (const Status known = checks.set_state(*watched); !known)
        return Error{path + ": " + known.error()};
    return run.load(path);
}

int run(RunArguments& arguments) {
    const int opened = arguments.opened.open();
    if (opened != kPassed) return opened;
    scene::SceneRun& run = *arguments.opened.run;
    scene::RunChecks checks(run);
    if (!arguments.from.empty()) {
        const Status restored = restore(run, checks, arguments.from);
        if (!restored) return could_not(restored.error());
        if (run.finished())
            return could_not(fmt::format("{}: stands at step {}, where the run ends",
                                         arguments.from, run.step_count()));
    }
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);
    if (failed) return could_not(arguments.out + ": " + failed.message());
    auto telemetry = scene::Telemetry::create(run, arguments.out);
    if (!telemetry) return could_not(telemetry.error());
    std::unique_ptr<scene::RunPictures> pictures;
    if (!arguments.no_pictures) {
        auto made =
            scene::RunPictures::create(run, {arguments.out, arguments.frames, arguments.video});
        if (made)
            pictures = std::move(*made);
        else
            fmt::print(stderr, "{}\n",
                       made.error());  // a run without a display is a run all the same
    }
    ProgressBar bar;

    const auto picture = [&] { return pictures ? pictures->observe() : Status(Done{}); };
    telemetry->observe();
    Status pictured = picture();
    while (pictured && !run.finished()) {
        run.step();
        telemetry->observe();
        checks.observe();
        pictured = picture();
        if (arguments.snapshot_every > 0 && run.step_count() % arguments.snapshot_every == 0) {
            const Status saved =
                save(run, checks,
                     fmt::format("{}/step_{:06}.snapshot", arguments.out, run.step_count()));
            if (!saved) return could_not(saved.error());
        }
        bar.show(run);
    }
    if (pictured && pictures) pictured = pictures->finish();
    if (!pictured) return could_not(pictured.error());

    nlohmann::ordered_json summary = run.summary();
    const int exit_code = report(checks.results(), summary);
    const Status written = write_text(arguments.out + "/summary.json", summary.dump(2) + '\n');
    if (!written) return could_not(written.error());
    if (run.has_soil()) {
        const Status saved = save(run, checks, arguments.out + "/final.snapshot");
        if (!saved) return could_not(saved.error());
    }
    fmt::print("{} steps, {:.2f} s in {:.2f} s ({:.1f} steps/s) -> {}\n", run.step_count(),
               run.time_s(), summary["wall_s"].get<double>(), summary["steps_per_s"].get<double>(),
               arguments.out);
    return exit_code;
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<RunArguments>();
    CLI::App* command = app.add_subcommand(
        "run",
        "run a scene: 0 all checks pass, 1 one fails, 2 could not run, 77 its data is not there");
    arguments->opened.add_options(*command);
    command->add_option("--out", arguments->out, "folder for what the run leaves behind")
        ->required();
    command
        ->add_option("--snapshot-every", arguments->snapshot_every,
                     "OUT/step_000120.snapshot and so on, every so many steps of the soil")
        ->check(CLI::PositiveNumber);
    command->add_option("--from", arguments->from,
                        "go on from a snapshot of this scene; steps count from the scene's start");
    command->add_flag("--frames", arguments->frames, "a PNG for every 1/30 s in OUT/frames");
    command->add_flag("--video", arguments->video,
                      "the same as OUT/video.mp4, where ffmpeg is installed");
    command->add_flag("--no-pictures", arguments->no_pictures, "no pictures at all");
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace bsoil::command
