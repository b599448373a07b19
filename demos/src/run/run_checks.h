/// The checks of a scene: what a run has to show, measured while it goes on.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene_run.h"

namespace bsoil::scene {

/// The verdict of one check.
struct CheckResult {
    enum class Verdict { pass, fail, not_reached };
    Verdict verdict = Verdict::pass;
    std::string name;    ///< "body_at_rest chassis"
    std::string figure;  ///< what was measured and what was wanted
};
/// "PASS", "FAIL", "SKIP" (the run ended before the check's time).
const char* verdict_text(CheckResult::Verdict verdict);

/// Mean slope of a heap [rad]: the line that fits heights against distance from `center_m` best,
/// between 15 and 85 % of the heap's height above the level of `center_m`. Nothing where no column
/// lies between.
std::optional<double> repose_angle_rad(const Soil& soil, Vec3 center_m);

/// Mean of evenly spaced samples and how they scatter about the straight line that fits them best.
struct Steadiness {
    double mean = 0, deviation = 0, range = 0;  ///< deviation: standard; range: highest less lowest
};
Steadiness steadiness(const std::vector<double>& samples);

/// Watches a run. `soil_conserved` is checked whether the scene asks or not.
class RunChecks {
  public:
    /// Before the first step. The run must outlive it.
    explicit RunChecks(const SceneRun& run);
    /// After every step.
    void observe();
    /// What it has seen so far, as bytes for a snapshot.
    std::vector<uint8_t> state() const;
    /// Goes on from another's. Error: bytes of other checks; then nothing changes.
    Status set_state(std::span<const uint8_t> state);
    /// After the last one.
    std::vector<CheckResult> results() const;

  private:
    /// What one check has seen so far.
    struct Watch {
        const CheckItem* item = nullptr;
        std::optional<Vec3> start_m;  ///< position at the start of the interval
        std::optional<double> value, reference;
        double peak_n = 0;
        std::vector<double> samples;  ///< one a step of the time that the check measures
    };

    static void serialize(StateStream& stream, Watch& watch);
    Watch watch(const CheckItem& item) const;
    void observe(Watch& w) const;
    CheckResult result(const Watch& w) const;
    CheckResult conserved() const;
    bool in_window(const CheckItem& item) const;
    std::optional<double> sample(const CheckItem& item) const;
    double energy_j(const CheckItem& item) const;
    // One a kind of check, or two kinds that are alike: verdict and figure.
    void judge_rest(const Watch& w, CheckResult& result) const;
    void judge_mass_in_region(const Watch& w, CheckResult& result) const;
    void judge_flow(const Watch& w, CheckResult& result) const;
    void judge_repose_angle(const Watch& w, CheckResult& result) const;
    void judge_surface_height(const Watch& w, CheckResult& result) const;
    void judge_distance(const Watch& w, CheckResult& result) const;
    void judge_peak_force(const Watch& w, CheckResult& result) const;
    void judge_steady(const Watch& w, CheckResult& result) const;
    void judge_rise(const Watch& w, CheckResult& result) const;
    void judge_height(const Watch& w, CheckResult& result) const;
    void judge_energy(const Watch& w, CheckResult& result) const;
    void judge_status(const Watch& w, CheckResult& result) const;
    bool reached(double t_s) const;

    const SceneRun& run_;
    std::vector<Watch> watches_;
};

}  // namespace bsoil::scene
