/// StepPieces: a step as a list of pieces, after each of which its caller may be let go.
#pragma once

#include <cstdint>
#include <vector>

#include "soil/passes.h"

namespace bsoil {

/// Into how many parts a step is cut, so that bodies and falling soil cross at most one voxel at a
/// time, and sliding soil two.
struct Substeps {
    int of_bodies = 1;
    int of_falls = 1;   ///< of each of these
    int of_slides = 1;  ///< of each of those of bodies
    int count() const { return of_bodies * of_falls; }
    int slide_count() const { return of_bodies * of_slides; }
};

/// In the order of a step. Between two pieces every voxel has what is its own: soil is conserved,
/// and may be looked at.
enum class PieceKind : uint8_t {
    begin,
    voxelize,
    pour,
    apply_force,
    propagate_force,
    advect,
    spread_overflow,
    fail_banks,
    fail_banks_again,
    slip,
    slide,
    take,
    move_water,
    collect_contacts,
    ask,
    read,
    close,
    count
};

struct StepPiece {
    PieceKind kind{};
    int16_t part = 0;  ///< substep of voxelize and advect, pass of slip
};

class StepPieces {
  public:
    /// Of the step that begins now. All that it depends on is known: what the last step left.
    void plan(const SoilCore& core, const Passes& passes, Substeps substeps);
    bool is_open() const { return next_ < pieces_.size(); }
    StepPiece next() const { return pieces_[next_]; }
    void pass() { ++next_; }
    /// There is no step in progress any more.
    void drop() { next_ = pieces_.size(); }
    Substeps substeps() const { return substeps_; }

  private:
    void add(PieceKind kind, int count = 1);
    void add_slips(const SoilCore& core, int count);

    std::vector<StepPiece> pieces_;
    size_t next_ = 0;
    Substeps substeps_;
};

}  // namespace bsoil
