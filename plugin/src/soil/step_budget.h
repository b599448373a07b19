/// StepBudget: how long a call of step() may take, and how the soil keeps up with its caller.
#pragma once

#include <array>
#include <functional>
#include <limits>

#include "bsoil/work_counts.h"
#include "soil/step_pieces.h"

namespace bsoil {

class StepBudget {
  public:
    /// budget_ms 0: none.
    void begin_call(double budget_ms);
    void end_call();
    /// No limit any more in this call.
    void lift() { is_limited_ = false; }
    bool is_limited() const { return is_limited_; }
    /// Whether a piece of this kind fits into the rest of the call, by what the last one took. The
    /// first piece of a call always does, so that each call gets on.
    bool has_time_for(PieceKind kind) const;
    /// Whether the call may still wait.
    bool has_time() const { return !is_limited_ || spent_ms() < budget_ms_; }
    /// Whether a step may begin behind the one that this call has finished.
    bool may_begin() const {
        return budget_ms_ <= 0 || (is_limited_ && has_time_for(PieceKind::begin));
    }
    /// Around each piece.
    void begin_piece();
    void end_piece(PieceKind kind);

    /// A step begins in this call; how many were due since the last one did.
    int begin_step();
    /// The step in progress goes on in this call. How many calls have worked on it.
    int continue_step();
    /// What a step that is late has time for within step_spread_max calls, by what the pieces of
    /// the last one took.
    struct Room {
        int slips = std::numeric_limits<int>::max();
        int substeps = std::numeric_limits<int>::max();  ///< of bodies; at least one
    };
    /// No bounds without a budget, or in time. First the slip passes that a step of one sub-step
    /// has time for, then sub-steps.
    Room room(const SoilDef& def, const Passes& passes, int due_count) const;
    int call_count() const { return call_count_; }  ///< of the step in progress
    /// This call has finished a step at a stretch, whatever it took.
    void note_held() { ++rate_.held_count; }
    const StepRate& rate() const { return rate_; }

    /// Milliseconds since any moment. Tests give a clock of their own.
    std::function<double()> now_ms;

    StepBudget();

  private:
    double cost_ms(PieceKind kind) const { return cost_ms_[static_cast<size_t>(kind)]; }
    double spent_ms() const { return now_ms() - call_start_ms_; }

    StepRate rate_;
    double budget_ms_ = 0, call_start_ms_ = 0, piece_start_ms_ = 0;
    bool is_limited_ = false, has_worked_ = false;
    int waiting_count_ = 0;  ///< calls since a step began, this one too
    int call_count_ = 0;
    std::array<double, static_cast<size_t>(PieceKind::count)> cost_ms_{};
};

}  // namespace bsoil
