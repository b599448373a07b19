/// Baselines: what a run of a scene came to, kept as JSON to compare later runs with.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene_run.h"

namespace bsoil::scene {

/// The times at which a run is sampled and pictured: RecordItem::moments_s within the run, or eight
/// evenly spaced ones.
std::vector<double> sample_moments_s(const SceneRun& run);

/// Collects the baseline of a run.
class BaselineRecorder {
  public:
    explicit BaselineRecorder(const SceneRun& run);
    /// After every step.
    void observe();
    /// After the last step: steps, checksum, totals, conditions, final poses, and at each sample
    /// moment the checksum, poses and probe readings.
    nlohmann::ordered_json finish() const;

  private:
    nlohmann::ordered_json state() const;

    const SceneRun& run_;
    std::vector<double> moments_s_;
    nlohmann::ordered_json trajectory_;
};

/// Where a baseline holds what is no number: JSON has null for it. None: nowhere.
std::optional<std::string> not_a_number_in(const nlohmann::ordered_json& baseline);

/// A baseline's file. Error: it cannot be read, is none, or holds values inside each other deeper
/// than any baseline does.
Result<nlohmann::ordered_json> read_baseline(const std::string& path);

/// Every difference, one a line: where it is, both values and by how much. Numbers may differ by
/// `tolerance` times the larger of 1 and the expected value; with a tolerance above 0 checksums are
/// not compared. What is found and is no number (NaN, infinite) differs from all, itself too.
std::vector<std::string> compare_baselines(const nlohmann::ordered_json& expected,
                                           const nlohmann::ordered_json& found, double tolerance);

}  // namespace bsoil::scene
