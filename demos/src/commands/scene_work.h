/// What the passes of a scene's steps have cost: their times, and what they touched.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bsoil/result.h"
#include "bsoil/work_counts.h"

namespace bsoil::command {

/// While it lives, soils made on the CPU count what their kernels touch: PassWork's last members.
class CountingKernels {
  public:
    CountingKernels();
    ~CountingKernels();
    CountingKernels(const CountingKernels&) = delete;
    CountingKernels& operator=(const CountingKernels&) = delete;

  private:
    std::string before_;
    bool was_set_ = false;
};

/// Bytes a second that a copy of much more than the caches moves here on so many threads, read and
/// written.
double copy_bytes_per_s(int thread_count);

/// The same work, timed and counted.
struct SceneWork {
    WorkCounts timed;    ///< of the steps that were timed
    WorkCounts touched;  ///< of the same steps made again by counting kernels; no passes: not made
    double step_count = 0;
    double copy_bytes_per_s = 0;
};

/// Work of the time between two counts.
WorkCounts difference(const WorkCounts& before, WorkCounts after);

/// Prints a row for each pass and a line for all of them; the same figures, by step.
nlohmann::ordered_json print_work(const SceneWork& work);

/// The figures of print_work() as a sentence and a table (Markdown).
std::string work_table(const nlohmann::ordered_json& work);

/// Puts the tables of each scene of a bench's figures into its block of a page,
/// `<!-- bsoil bench: NAME -->`, NAME that of the scene's file, and the sweeps into that named so.
/// The error says which marker the page lacks.
Result<std::string> update_tables(std::string page, const nlohmann::ordered_json& figures);

}  // namespace bsoil::command
