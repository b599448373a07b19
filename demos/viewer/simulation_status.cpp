/// What a simulation says of itself beside the picture.
#include <fmt/format.h>

#include <algorithm>

#include "simulation.h"

namespace bsoil::viewer {
namespace {

int64_t sum_of(const std::vector<int64_t>& units) {
    int64_t sum = 0;
    for (const int64_t u : units) sum += u;
    return sum;
}

}  // namespace

void Simulation::fill_status(RunStatus& status) const {
    status.time_s = run_->time_s();
    status.step_count = run_->step_count();
    status.step_s = run_->step_s();
    status.is_finished = run_->finished();
    status.failure = run_->failure();
    status.steps_per_s = steps_per_s_;
    status.soil_ms = soil_ms_;
    status.bullet_ms = std::max(0.0, step_ms_ - soil_ms_);
    status.mesh_ms = mesh_ms_;
    const auto& bodies = run_->bullet().bodies();
    for (size_t b = 0; b < bodies.size(); ++b) {
        status.forces_n.push_back(length(run_->readings()[b].force_n));
    }
    for (const scene::SceneJoint& joint : run_->bullet().joints()) {
        status.levers.push_back({joint.position});
    }
    if (hand_->held()) {
        for (const scene::SceneBody& body : bodies) {
            if (body.object == hand_->held()) status.hand_text = body.name;
        }
    }
    if (run_->has_soil()) {
        const StepReport& report = run_->action().last_report();
        status.stage_ms = report.stage_ms;
        status.block_active_count = report.block_active_count;
        status.tile_awake_count = report.tile_awake_count;
        status.contact_count = static_cast<int>(report.contacts.size());
        status.units_text =
            fmt::format("{} at the start, {} in, {} out", sum_of(run_->totals_at_start().units),
                        sum_of(units_in_), sum_of(units_out_));
        for (const scene::ProbeItem& probe : scene_.probes) {
            status.loads_kg.push_back(probe.kind == "mass_inside" ? run_->probe_mass_kg(probe)
                                                                  : 0.0);
        }
        status.conditions = run_->condition_texts();
    }
    status.conditions.insert(status.conditions.begin(), notes_.begin(), notes_.end());
    status.note_count = notes_.size();
}

}  // namespace bsoil::viewer
