/// ConditionLog: the status bits of a soil and what is known of each.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsoil/condition.h"
#include "bsoil/limits.h"
#include "bsoil/result.h"
#include "bsoil/snapshot_file.h"

namespace bsoil {

/// Keeps one Condition for each bit and body, oldest first. Allocates when it is made, not later.
class ConditionLog {
  public:
    ConditionLog();

    /// What is noted from now on happens in this step.
    void begin_step(int64_t step, double step_s);
    /// The condition is met. The first place that is given stays.
    void note(StatusBit bit, int body = -1, std::optional<Vec3> position_m = {});
    void clear();

    uint32_t bits() const { return bits_; }
    /// Whether it was ever noted, also before clear().
    bool was_met(StatusBit bit) const { return (met_bits_ & static_cast<uint32_t>(bit)) != 0; }
    /// Oldest first; those of bodies beyond kConditionCapacity count for the bit's one without a
    /// body.
    std::span<const Condition> all() const { return list_; }
    /// How many of all(), the last ones, are new since the last call.
    int take_new_count();

    /// Whether a list from a snapshot can be that of a soil that has made `step` steps; the error
    /// says what cannot be.
    static Status check(std::span<const Condition> list, int64_t step);
    /// Takes over such a list.
    void replace(std::span<const Condition> list);

  private:
    std::vector<Condition> list_;
    uint32_t bits_ = 0, met_bits_ = 0;
    int64_t step_ = 0;
    double step_s_ = 0;
    size_t told_count_ = 0;
};

/// Lists a condition for a snapshot.
void list(StateStream& stream, Condition& condition);

}  // namespace bsoil
