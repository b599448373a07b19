/// `bsoil run`: runs a scene and leaves tables, a summary, pictures and a snapshot behind.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "commands.h"
#include "files/json_text.h"
#include "files/own_files.h"
#include "interruption.h"
#include "opened_scene.h"
#include "run/run_checks.h"
#include "run/run_pictures.h"
#include "run/run_progress.h"
#include "run/telemetry.h"

namespace bsoil::command {
namespace {

struct RunArguments {
    OpenedScene opened;
    std::string out;
    std::string from;
    long long snapshot_every = 0;
    bool frames = false, video = false, no_pictures = false;
};

/// A bar on a terminal, a line now and then elsewhere.
class ProgressReport {
  public:
    explicit ProgressReport(const scene::SceneRun& run)
        : run_(run), first_(run.step_count()), start_(std::chrono::steady_clock::now()) {}

    void show() {
        scene::Progress at{run_.step_count(), run_.step_target(), first_, run_.time_s(), 0};
        const auto passed = std::chrono::steady_clock::now() - start_;
        at.wall_s = std::chrono::duration<double>(passed).count();
        if (!is_terminal_) {
            if (cadence_.is_due(at)) fmt::print(stderr, "{}\n", scene::progress_text(at));
            return;
        }
        const int percent = scene::percent_of(at);
        if (percent == percent_ && at.wall_s < shown_s_ + kRefreshS) return;
        percent_ = percent;
        shown_s_ = at.wall_s;
        fmt::print(stderr, "\r\033[K[{:<40}] {}",
                   std::string(static_cast<size_t>(percent * 2 / 5), '#'),
                   scene::progress_text(at));
        std::fflush(stderr);
        is_open_ = true;
    }
    /// What is printed next begins on a line of its own.
    void end_line() {
        if (is_open_) fmt::print(stderr, "\n");
        is_open_ = false;
    }

  private:
    static constexpr double kRefreshS = 1;

    const scene::SceneRun& run_;
    const long long first_;
    const std::chrono::steady_clock::time_point start_;
    const bool is_terminal_ = isatty(STDERR_FILENO) != 0;
    scene::LogCadence cadence_;
    int percent_ = -1;
    double shown_s_ = 0;
    bool is_open_ = false;
};

Status write_text(const std::string& path, const std::string& text) {
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file) return Error{path + ": cannot be written whole; look whether the disk is full"};
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

/// Takes away what an earlier run has left in the folder, so that all files of these names are this
/// run's. Of a run that goes on, frames and snapshots may be of what lies behind it, and stay.
Status remove_older_run(const std::string& folder, bool goes_on) {
    constexpr std::string_view kTables[] = {"telemetry.csv", "profiles.csv", "summary.json",
                                            "contact_sheet.png", "video.mp4"};
    const auto is_table = [&](std::string_view name) {
        return std::ranges::find(kTables, name) != std::end(kTables);
    };
    if (goes_on) return scene::remove_own_files(folder, is_table);
    const Status removed = scene::remove_own_files(folder, [&](std::string_view name) {
        return is_table(name) || name == "final.snapshot" ||
               scene::is_numbered(name, "step_", 6, ".snapshot");
    });
    if (!removed) return removed;
    return scene::remove_own_files(folder + "/frames", [](std::string_view name) {
        return scene::is_numbered(name, "", 5, ".png");
    });
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
    if (!watched) {
        return Error{path + ": was not written by bsoil run; take one of its step_*.snapshot"};
    }
    if (const Status known = checks.set_state(*watched); !known) {
        return Error{path + ": " + known.error()};
    }
    return run.load(path);
}

/// What goes wrong with the run's files is said once and remembered; the run goes on, so that the
/// other files are written.
class Mishaps {
  public:
    explicit Mishaps(ProgressReport& progress) : progress_(progress) {}
    /// Whether all is well.
    bool take(const Status& status) {
        if (status) return true;
        progress_.end_line();
        fmt::print(stderr, "{}\n", status.error());
        any_ = true;
        return false;
    }
    bool any() const { return any_; }

  private:
    ProgressReport& progress_;
    bool any_ = false;
};

/// Says each condition of the soil when it is first met.
class ConditionReport {
  public:
    explicit ConditionReport(const scene::SceneRun& run)
        : run_(run), known_(run.condition_texts().size()) {}
    void observe(ProgressReport& progress) {
        if (!run_.has_soil() || run_.action().last_report().condition_new_count == 0) return;
        for (const std::string& text : run_.condition_texts(known_)) {
            progress.end_line();
            fmt::print(stderr, "{}\n", text);
            ++known_;
        }
    }

  private:
    const scene::SceneRun& run_;
    size_t known_;
};

/// Pictures, or null where there can be none and nobody asked for frames. Error: somebody did.
Result<std::unique_ptr<scene::RunPictures>> make_pictures(const scene::SceneRun& run,
                                                          const RunArguments& arguments) {
    if (arguments.no_pictures) return std::unique_ptr<scene::RunPictures>();
    auto made = scene::RunPictures::create(run, {arguments.out, arguments.frames, arguments.video});
    if (made) {
        for (const std::string& note : (*made)->notes()) fmt::print(stderr, "{}\n", note);
    }
    if (made || arguments.frames || arguments.video) return made;
    fmt::print(stderr, "{}\n", made.error());  // a run without a display is a run all the same
    return std::unique_ptr<scene::RunPictures>();
}

int run(RunArguments& arguments) {
    if (arguments.video && !scene::has_film_maker()) {
        return could_not(
            "--video needs ffmpeg, which is not in PATH; install it (apt-get install "
            "ffmpeg), or take --frames, which leaves the pictures alone");
    }
    const int opened = arguments.opened.open();
    if (opened != kPassed) return opened;
    scene::SceneRun& run = *arguments.opened.run;
    scene::RunChecks checks(run);
    if (!arguments.from.empty()) {
        const Status restored = restore(run, checks, arguments.from);
        if (!restored) return could_not(restored.error());
        if (run.finished()) {
            return could_not(
                fmt::format("{}: stands at step {}, where the run ends; raise "
                            "--steps or `duration_s`",
                            arguments.from, run.step_count()));
        }
    }
    const Interruption interruption;
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);
    if (failed) return could_not(arguments.out + ": " + failed.message());
    const Status removed = remove_older_run(arguments.out, !arguments.from.empty());
    if (!removed) return could_not(removed.error());
    auto telemetry = scene::Telemetry::create(run, arguments.out);
    if (!telemetry) return could_not(telemetry.error());
    auto pictures = make_pictures(run, arguments);
    if (!pictures) return could_not(pictures.error());

    ProgressReport progress(run);
    ConditionReport conditions(run);
    Mishaps mishaps(progress);
    const auto picture = [&] {
        if (*pictures && !mishaps.take((*pictures)->observe())) pictures->reset();
    };
    telemetry->observe();
    picture();
    while (!run.finished() && !interruption.is_asked()) {
        run.step();
        if (const std::string failure = run.failure(); !failure.empty()) {
            progress.end_line();
            mishaps.take(telemetry->finish());
            return could_not(failure);
        }
        telemetry->observe();
        checks.observe();
        picture();
        conditions.observe(progress);
        if (arguments.snapshot_every > 0 && run.step_count() % arguments.snapshot_every == 0) {
            mishaps.take(
                save(run, checks,
                     fmt::format("{}/step_{:06}.snapshot", arguments.out, run.step_count())));
        }
        progress.show();
    }
    progress.end_line();
    const bool is_cut_short = !run.finished();
    if (is_cut_short) {
        fmt::print(stderr, "interrupted at step {}; what there is is written to {}\n",
                   run.step_count(), arguments.out);
    }

    for (const std::string& text : run.shortfall_texts()) fmt::print(stderr, "{}\n", text);
    nlohmann::ordered_json summary = run.summary();
    summary["interrupted"] = is_cut_short;
    const int exit_code = report(checks.results(), summary);
    mishaps.take(write_text(arguments.out + "/summary.json", scene::json_text(summary, 2) + '\n'));
    mishaps.take(telemetry->finish());
    if (run.has_soil()) mishaps.take(save(run, checks, arguments.out + "/final.snapshot"));
    if (*pictures) mishaps.take((*pictures)->finish());
    fmt::print("{} steps, {:.2f} s in {:.2f} s ({:.1f} steps/s) -> {}\n", run.step_count(),
               run.time_s(), summary["wall_s"].get<double>(), summary["steps_per_s"].get<double>(),
               arguments.out);
    if (mishaps.any()) return kCouldNotRun;
    return is_cut_short ? kInterrupted : exit_code;
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<RunArguments>();
    CLI::App* command = app.add_subcommand("run",
                                           "run a scene: 0 all checks pass, 1 one fails, 2 could "
                                           "not run or could not write a file, 77 "
                                           "its data is not there, 130 interrupted by Ctrl-C");
    arguments->opened.add_options(*command);
    command
        ->add_option("--out", arguments->out,
                     "folder for what the run leaves behind; what an earlier run has left there "
                     "goes, other files stay")
        ->required();
    command
        ->add_option("--snapshot-every", arguments->snapshot_every,
                     "OUT/step_000120.snapshot and so on, every so many steps of the soil")
        ->check(at_least(1));
    command->add_option(
        "--from", arguments->from,
        "go on from a snapshot of this scene; steps count from the scene's start, the tables "
        "in OUT begin at the snapshot");
    CLI::Option* none =
        command->add_flag("--no-pictures", arguments->no_pictures, "no pictures at all");
    command->add_flag("--frames", arguments->frames, "a PNG for every 1/30 s in OUT/frames")
        ->excludes(none);
    command->add_flag("--video", arguments->video, "the same as OUT/video.mp4; needs ffmpeg")
        ->excludes(none);
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace bsoil::command
