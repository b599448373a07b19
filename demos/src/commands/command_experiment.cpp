/// `bsoil plate`, `bsoil blade`, `bsoil traction`, `bsoil shear`, `bsoil column`: the experiments
/// of terramechanics as sweeps.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>

#include "commands.h"
#include "experiment/expectation.h"
#include "experiment/experiment_load.h"
#include "experiment/page_tables.h"
#include "experiment/plot.h"
#include "experiment/sweep_run.h"
#include "files/own_files.h"
#include "files/text_file.h"

namespace bsoil::command {
namespace {

struct ExperimentArguments {
    std::string rig, path, out, document;
    std::vector<std::string> settings;
    int thread_count = 0;
    bool series = false, no_plot = false;
};

std::string point_text(const experiment::Experiment& experiment, size_t point) {
    std::string text = fmt::format("point {}", point);
    for (const experiment::Parameter& p : experiment.points[point].parameters) {
        text += fmt::format(" {}={}", p.name, p.text);
    }
    return text;
}

/// A bar on a terminal, a line for each finished point elsewhere.
experiment::SweepProgress progress_of(const experiment::Experiment& experiment) {
    experiment::SweepProgress progress;
    if (isatty(STDERR_FILENO) != 0) {
        progress.advanced = [last = -1](double fraction) mutable {
            const int percent = static_cast<int>(100 * fraction);
            if (percent == last) return;
            last = percent;
            fmt::print(stderr, "\r[{:<40}] {:3}%{}",
                       std::string(static_cast<size_t>(percent * 2 / 5), '#'), percent,
                       percent == 100 ? "\n" : "");
            std::fflush(stderr);
        };
    } else {
        progress.finished = [&experiment](size_t point, const experiment::PointRun& run) {
            fmt::print(stderr, "{}: {:.1f} s{}\n", point_text(experiment, point), run.wall_s,
                       run.error.empty() ? "" : ", failed");
        };
    }
    return progress;
}

void print_table(const experiment::CsvTable& table) {
    std::vector<size_t> widths;
    for (size_t c = 0; c < table.columns.size(); ++c) {
        widths.push_back(table.columns[c].size());
        for (const auto& row : table.rows) widths[c] = std::max(widths[c], row[c].size());
    }
    const auto print = [&](const std::vector<std::string>& cells) {
        for (size_t c = 0; c < cells.size(); ++c) {
            fmt::print("{}{:>{}}", c ? "  " : "", cells[c], widths[c]);
        }
        fmt::print("\n");
    };
    print(table.columns);
    for (const auto& row : table.rows) print(row);
}

/// Takes away what an earlier sweep has left in the folder, which may have had more points.
Status remove_older_results(const std::string& folder) {
    return scene::remove_own_files(folder, [](std::string_view name) {
        return name == "results.csv" || name == "results.gnuplot" || name == "results.svg" ||
               name == "results.png" || scene::is_numbered(name, "series_", 3, ".csv");
    });
}

int run(const ExperimentArguments& arguments) {
    auto loaded = experiment::load_experiment(arguments.path, arguments.rig, arguments.settings);
    if (!loaded) return could_not(loaded.error());
    const experiment::Experiment& experiment = *loaded;
    if (!experiment.missing_data.empty()) {
        const std::string name = experiment.missing_data.substr(sizeof("data:") - 1);
        if (experiment.points_are_missing) {
            fmt::print("SKIP {}: {} is not there; set BULLETSOIL_DATA to the folder that has it\n",
                       arguments.path, name);
            return kSkipped;
        }
        fmt::print(
            "{} is not there (set BULLETSOIL_DATA to the folder that has it): no measured "
            "values\n",
            name);
    }
    std::set<std::string> warnings;  // points that differ in their rig alone share them
    for (const experiment::Point& point : experiment.points) {
        warnings.insert(point.setup.scene.warnings.begin(), point.setup.scene.warnings.end());
    }
    for (const std::string& warning : warnings) fmt::print(stderr, "{}\n", warning);
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);
    if (failed) return could_not(arguments.out + ": " + failed.message());

    if (!arguments.document.empty()) {
        const std::string name = std::filesystem::path(experiment.path).stem().string();
        const Status ready = experiment::has_blocks(arguments.document, experiment.rig, {name});
        if (!ready) return could_not(ready.error());
    }

    const std::vector<experiment::PointRun> runs =
        experiment::run_sweep(experiment, arguments.thread_count, progress_of(experiment));
    if (const Status removed = remove_older_results(arguments.out); !removed) {
        return could_not(removed.error());
    }
    for (size_t i = 0; i < runs.size(); ++i) {
        if (!runs[i].error.empty()) {
            return could_not(point_text(experiment, i) + ": " + runs[i].error);
        }
        for (const std::string& status : runs[i].output.status) {
            fmt::print(stderr, "{}: {}\n", point_text(experiment, i), status);
        }
        if (!arguments.series) continue;
        const Status written =
            experiment::write_csv(experiment::series_table(runs[i].output),
                                  fmt::format("{}/series_{:03}.csv", arguments.out, i));
        if (!written) return could_not(written.error());
    }
    const experiment::CsvTable results = experiment::result_table(experiment, runs);
    const Status written = experiment::write_csv(results, arguments.out + "/results.csv");
    if (!written) return could_not(written.error());
    print_table(results);
    if (!arguments.no_plot) {
        const Status drawn = experiment::draw_plot(experiment, results, arguments.out);
        if (!drawn) fmt::print(stderr, "{}\n", drawn.error());
    }

    if (!arguments.document.empty()) {
        const auto page = scene::read_file(arguments.document, experiment::kPageBytesMost);
        if (!page) return could_not(page.error());
        const auto updated = experiment::update_results(*page, experiment, results);
        if (!updated) return could_not(arguments.document + ": " + updated.error());
        const Status kept = scene::replace_file(arguments.document, *updated);
        if (!kept) return could_not(kept.error());
    }

    int exit_code = kPassed;
    std::vector<experiment::Verdict> verdicts = experiment::verdicts_on(runs);
    std::ranges::move(experiment::check_expectations(experiment, results),
                      std::back_inserter(verdicts));
    for (const experiment::Verdict& verdict : verdicts) {
        using Kind = experiment::Verdict::Kind;
        fmt::print("{} {}\n",
                   verdict.kind == Kind::pass   ? "PASS"
                   : verdict.kind == Kind::fail ? "FAIL"
                                                : "SKIP",
                   verdict.text);
        if (verdict.kind == Kind::fail) exit_code = kFailed;
    }
    fmt::print("{} points -> {}\n", runs.size(), arguments.out);
    return exit_code;
}

void add_experiment(CLI::App& app, const std::string& rig, const std::string& help,
                    int& exit_code) {
    auto arguments = std::make_shared<ExperimentArguments>();
    arguments->rig = rig;
    CLI::App* command = app.add_subcommand(
        rig, help +
                 ": 0 all expectations hold, 1 one does not, 2 could not run, 77 its data is "
                 "not there");
    command->add_option("file", arguments->path, "the experiment (TOML)")->required();
    command->add_option("--out", arguments->out, "folder for the results")->required();
    command
        ->add_option("--set", arguments->settings,
                     "key=value instead of what the file says, as soil.voxel_m=0.01")
        ->allow_extra_args(false);
    command->add_option("--threads", arguments->thread_count, "points run at once; 0: all cores")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command->add_flag("--series", arguments->series,
                      "OUT/series_000.csv ...: all steps of each point");
    command->add_option(
        "--document", arguments->document,
        "page to update, between <!-- bsoil " + rig + ": NAME OF THE FILE --> and <!-- end -->");
    command->add_flag("--no-plot", arguments->no_plot, "no plot");
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace

void add_experiments(CLI::App& app, int& exit_code) {
    add_experiment(app, "plate", "press plates into soil", exit_code);
    add_experiment(app, "blade", "draw blades through soil", exit_code);
    add_experiment(app, "traction", "drive a wheel over soil", exit_code);
    add_experiment(app, "shear", "shear soil under a normal stress", exit_code);
    add_experiment(app, "column", "let columns of soil come down", exit_code);
    CLI::App* keys =
        app.add_subcommand("experiment-keys", "print every key an experiment file may have");
    keys->add_flag("--markdown")->description("as a Markdown page (the only form there is)");
    keys->callback([&exit_code] {
        fmt::print("{}", experiment::experiment_markdown());
        exit_code = kPassed;
    });
}

}  // namespace bsoil::command
