/// `bsoil validate`: all experiments that stand beside measurements, and the document of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>

#include "commands.h"
#include "experiment/comparison.h"
#include "experiment/comparison_text.h"
#include "experiment/experiment_load.h"
#include "experiment/page_figures.h"
#include "experiment/page_tables.h"
#include "experiment/sweep_run.h"
#include "experiment/validation_page.h"
#include "files/text_file.h"
#include "shared_files.h"

namespace bsoil::command {
namespace {

namespace fs = std::filesystem;

struct ValidateArguments {
    std::string experiments = shared_folder("experiments"), out, document;
    std::vector<std::string> only;
    int thread_count = 0;
    bool sentences = false;
};

/// The experiments of the folder that have a [validation], by name; with `only`, those named.
Result<std::vector<experiment::Experiment>> load_all(const ValidateArguments& arguments) {
    std::error_code failed;
    std::vector<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(arguments.experiments, failed)) {
        const bool wanted =
            arguments.only.empty() || std::count(arguments.only.begin(), arguments.only.end(),
                                                 entry.path().stem().string()) > 0;
        if (entry.path().extension() == ".toml" && wanted) paths.push_back(entry.path());
    }
    if (failed) return Error{arguments.experiments + ": " + failed.message()};
    std::sort(paths.begin(), paths.end());
    for (const std::string& name : arguments.only) {
        if (std::none_of(paths.begin(), paths.end(),
                         [&](const fs::path& path) { return path.stem() == name; })) {
            return Error{
                fmt::format("there is no {}.toml in {}; check the name, or give --experiments",
                            name, arguments.experiments)};
        }
    }
    std::vector<experiment::Experiment> experiments;
    for (const fs::path& path : paths) {
        auto loaded = experiment::load_experiment(path.string(), "");
        if (!loaded) return Error{loaded.error()};
        if (loaded->validation) {
            experiments.push_back(std::move(*loaded));
        } else if (!arguments.only.empty()) {
            return Error{path.string() + ": has no [validation]; name an experiment that has one"};
        }
    }
    return experiments;
}

/// Runs the points of all experiments at once, so that no core waits for the end of one of them.
/// Of each experiment its runs, or the error of the first of its points that could not be run.
std::vector<Result<std::vector<experiment::PointRun>>> run_all(
    const std::vector<experiment::Experiment>& experiments, int thread_count) {
    struct Origin {
        size_t experiment, point;
    };
    std::vector<Origin> origins;
    std::vector<const experiment::RigSetup*> setups;
    for (size_t e = 0; e < experiments.size(); ++e) {
        for (size_t p = 0; p < experiments[e].points.size(); ++p) {
            origins.push_back({e, p});
            setups.push_back(&experiments[e].points[p].setup);
        }
    }
    experiment::SweepProgress progress;
    size_t done = 0;
    progress.finished = [&](size_t i, const experiment::PointRun& run) {
        fmt::print(stderr, "{}/{}: {}, point {}, {:.1f} s\n", ++done, setups.size(),
                   fs::path(experiments[origins[i].experiment].path).stem().string(),
                   origins[i].point, run.wall_s);
    };
    std::vector<experiment::PointRun> runs = experiment::run_points(setups, thread_count, progress);
    std::vector<Result<std::vector<experiment::PointRun>>> of_experiments(
        experiments.size(), std::vector<experiment::PointRun>{});
    for (size_t i = 0; i < runs.size(); ++i) {
        const std::string where = fmt::format(
            "{}: point {}: ", experiments[origins[i].experiment].path, origins[i].point);
        for (const std::string& status : runs[i].output.status) {
            fmt::print(stderr, "{}{}\n", where, status);
        }
        auto& of_experiment = of_experiments[origins[i].experiment];
        if (!of_experiment) continue;
        if (!runs[i].error.empty()) {
            of_experiment = Error{where + runs[i].error};
        } else {
            of_experiment->push_back(std::move(runs[i]));
        }
    }
    return of_experiments;
}

Result<std::string> read_page(const fs::path& path) {
    return scene::read_file(path.string(), experiment::kPageBytesMost);
}

/// A page that a command writes its tables into.
Result<std::string> read_document(const fs::path& path) {
    auto page = read_page(path);
    if (!page) return Error{page.error() + "; its prose is written by hand, name the page"};
    return page;
}

/// The figures of the document's tables in the sentences of the pages beside and below it.
Status write_sentences(const fs::path& document) {
    const auto tables = read_document(document);
    if (!tables) return Error{tables.error()};
    const fs::path folder = document.has_parent_path() ? document.parent_path() : ".";
    std::error_code failed;
    for (const auto& entry : fs::recursive_directory_iterator(folder, failed)) {
        if (entry.path().extension() != ".md") continue;
        const auto page = read_page(entry.path());
        if (!page || !experiment::names_figures(*page)) continue;
        const auto filled = experiment::fill_figures(*page, *tables);
        if (!filled) return Error{entry.path().string() + ": " + filled.error()};
        if (*filled == *page) continue;
        const Status written = scene::replace_file(entry.path().string(), *filled);
        if (!written) return written;
    }
    if (failed) return Error{folder.string() + ": " + failed.message()};
    return Done{};
}

Status write_document(const fs::path& path,
                      const std::vector<experiment::Comparison>& comparisons) {
    const auto text = read_document(path);
    if (!text) return Error{text.error()};
    const fs::path pictures = path.stem();
    auto page = experiment::update_page(*text, comparisons, pictures.string());
    if (!page) return Error{path.string() + ": " + page.error()};
    std::error_code failed;
    fs::create_directories(path.parent_path() / pictures, failed);
    for (const experiment::Comparison& comparison : comparisons) {
        const Status written =
            scene::write_file((path.parent_path() / pictures / (comparison.name + ".svg")).string(),
                              experiment::comparison_picture(comparison));
        if (!written) return written;
    }
    if (const Status written = scene::replace_file(path.string(), *page); !written) return written;
    return write_sentences(path);
}

int run(const ValidateArguments& arguments) {
    if (arguments.sentences) {
        const Status written = write_sentences(arguments.document);
        return written ? kPassed : could_not(written.error());
    }
    auto loaded = load_all(arguments);
    if (!loaded) return could_not(loaded.error());
    std::erase_if(*loaded, [](const experiment::Experiment& e) {
        if (e.missing_data.empty()) return false;
        fmt::print("SKIP {}: {} is not there; set BULLETSOIL_DATA to the folder that has it\n",
                   e.path, e.missing_data.substr(sizeof("data:") - 1));
        return true;
    });
    if (loaded->empty()) {
        fmt::print("there is no measured data: nothing to validate\n");
        return kSkipped;
    }
    if (!arguments.document.empty()) {
        std::vector<std::string> names = {"summary"};
        for (const experiment::Experiment& e : *loaded) names.push_back(fs::path(e.path).stem());
        const Status ready = experiment::has_blocks(arguments.document, "validate", names);
        if (!ready) return could_not(ready.error());
    }
    const auto runs = run_all(*loaded, arguments.thread_count);

    int exit_code = kPassed;
    bool is_whole = true;
    std::vector<experiment::Comparison> comparisons;
    for (size_t e = 0; e < loaded->size(); ++e) {
        const experiment::Experiment& experiment = (*loaded)[e];
        if (!runs[e]) {
            could_not(runs[e].error());
            is_whole = false;
            continue;
        }
        auto comparison =
            experiment::compare(experiment, experiment::result_table(experiment, *runs[e]));
        if (!comparison) {
            could_not(comparison.error());
            is_whole = false;
            continue;
        }
        std::ranges::move(experiment::verdicts_on(*runs[e]),
                          std::back_inserter(comparison->verdicts));
        fmt::print("{}", experiment::comparison_text(*comparison));
        if (!comparison->holds()) exit_code = kFailed;
        comparisons.push_back(std::move(*comparison));
    }
    if (!arguments.out.empty()) {
        std::error_code failed;
        fs::create_directories(arguments.out, failed);
        for (const experiment::Comparison& comparison : comparisons) {
            const std::string path = arguments.out + '/' + comparison.name;
            Status written = experiment::write_csv(comparison.results, path + ".csv");
            if (written) {
                written =
                    scene::write_file(path + ".svg", experiment::comparison_picture(comparison));
            }
            if (!written) return could_not(written.error());
        }
    }
    if (!is_whole) {
        if (arguments.document.empty()) return kCouldNotRun;
        return could_not(arguments.document +
                         ": stays as it was; change the experiment that is missing and run again");
    }
    if (!arguments.document.empty()) {
        const Status written = write_document(arguments.document, comparisons);
        if (!written) return could_not(written.error());
    }
    return exit_code;
}

}  // namespace

void add_validate(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<ValidateArguments>();
    CLI::App* command = app.add_subcommand(
        "validate",
        "run the experiments that stand beside measurements: 0 all gates are met, 1 one is not, 2 "
        "could not run, 77 no measured data is there");
    command->add_option("--out", arguments->out, "folder for the tables and pictures");
    command->add_option("--only", arguments->only, "names of experiments, without .toml");
    CLI::Option* document = command->add_option(
        "--document", arguments->document,
        "page to update, as docs/validation.md; its pictures lie in a folder of its name beside "
        "it. Sentences that name a figure of it get it, in the pages beside and below it too");
    command
        ->add_flag("--sentences", arguments->sentences,
                   "run nothing: the figures in sentences, from the document's tables")
        ->needs(document);
    command->add_option("--experiments", arguments->experiments, "folder of the experiments")
        ->capture_default_str();
    command->add_option("--threads", arguments->thread_count, "points run at once; 0: all cores")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace bsoil::command
