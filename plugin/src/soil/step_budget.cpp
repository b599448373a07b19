#include "soil/step_budget.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace bsoil {
namespace {

// Of the calls' time, what pieces fill: the next one often does not fit into what is left.
constexpr double kUsedShare = 0.75;

double steady_ms() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

StepBudget::StepBudget() : now_ms(steady_ms) {}

void StepBudget::begin_call(double budget_ms) {
    ++rate_.due_count;
    ++waiting_count_;
    budget_ms_ = budget_ms;
    is_limited_ = budget_ms > 0;
    has_worked_ = false;
    if (is_limited_) call_start_ms_ = now_ms();
}

void StepBudget::end_call() {
    // Not of the first step, which has none.
    if (budget_ms_ > 0) rate_.call_most_ms = std::max(rate_.call_most_ms, spent_ms());
}

bool StepBudget::has_time_for(PieceKind kind) const {
    if (!is_limited_ || !has_worked_) return true;
    return spent_ms() + cost_ms_[static_cast<size_t>(kind)] <= budget_ms_;
}

void StepBudget::begin_piece() {
    has_worked_ = true;
    if (is_limited_) piece_start_ms_ = now_ms();
}

void StepBudget::end_piece(PieceKind kind) {
    if (is_limited_) cost_ms_[static_cast<size_t>(kind)] = now_ms() - piece_start_ms_;
}

StepBudget::Room StepBudget::room(const SoilDef& def, const Passes& passes, int due_count) const {
    if (!is_limited_ || due_count == 1) return {};
    const auto fitting = [](double room_ms, double each_ms) {
        return static_cast<int>(std::clamp(room_ms / std::max(each_ms, 1e-9), 0.0, 1e6));
    };
    const double substep_ms = cost_ms(PieceKind::voxelize) + cost_ms(PieceKind::apply_force) +
                              def.propagation_iterations * cost_ms(PieceKind::propagate_force) +
                              cost_ms(PieceKind::advect) +
                              def.overflow_passes * cost_ms(PieceKind::spread_overflow);
    const double slip_ms = cost_ms(PieceKind::slip) + cost_ms(PieceKind::fail_banks_again);
    const double room_ms =
        kUsedShare * budget_ms_ * def.step_spread_max - cost_ms(PieceKind::begin) -
        cost_ms(PieceKind::fail_banks) - passes.slide_pass_count(1) * cost_ms(PieceKind::slide) -
        cost_ms(PieceKind::collect_contacts) - cost_ms(PieceKind::read) - cost_ms(PieceKind::close);
    Room out;
    out.slips = fitting(room_ms - substep_ms, slip_ms);
    const double slips_ms = std::min(passes.slip_pass_count(1), out.slips) * slip_ms;
    out.substeps = std::max(1, fitting(room_ms - slips_ms, substep_ms));
    return out;
}

int StepBudget::begin_step() {
    ++rate_.begun_count;
    call_count_ = 1;
    rate_.call_count_most = std::max(rate_.call_count_most, call_count_);
    return std::max(1, std::exchange(waiting_count_, 0));
}

int StepBudget::continue_step() {
    rate_.call_count_most = std::max(rate_.call_count_most, ++call_count_);
    return call_count_;
}

}  // namespace bsoil
