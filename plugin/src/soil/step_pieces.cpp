#include "soil/step_pieces.h"

namespace bsoil {

void StepPieces::add(PieceKind kind, int count) {
    for (int part = 0; part < count; ++part) {
        pieces_.push_back({kind, static_cast<int16_t>(part)});
    }
}

/// Slip passes from one look everywhere for banks of loose soil to the next. Ours, seen with 2, 3,
/// 4, 8 and one look a step. Larger: a bank that fails beside one that slides waits, and columns of
/// 4.9 to 19.6 kPa no longer rest the steeper the more cohesion they have. Smaller costs time.
constexpr int kBankLookPasses = 8;

// What a plane through loose soil lets go stops before the pass in which it does not fail any more.
void StepPieces::add_slips(const SoilCore& core, int count) {
    for (int pass = 0; pass < count; ++pass) {
        const bool has_looked = pieces_.back().kind == PieceKind::fail_banks;
        if (core.params.keeps_cohesion != 0 && !has_looked) {
            const bool is_everywhere = pass > 0 && pass % kBankLookPasses == 0;
            add(is_everywhere ? PieceKind::fail_banks : PieceKind::fail_banks_again);
        }
        pieces_.push_back({PieceKind::slip, static_cast<int16_t>(pass)});
    }
}

void StepPieces::plan(const SoilCore& core, const Passes& passes, Substeps substeps) {
    pieces_.clear();
    next_ = 0;
    substeps_ = substeps;
    const int slips = passes.slip_pass_count(substeps.of_slides);
    const int slides = passes.slide_pass_count(substeps.slide_count());
    for (int s = 0; s < substeps.of_bodies; ++s) {
        pieces_.push_back({PieceKind::voxelize, static_cast<int16_t>(s)});
        if (s == 0) add(PieceKind::pour);
        add(PieceKind::apply_force);
        add(PieceKind::propagate_force, core.def.propagation_iterations);
        for (int f = 0; f < substeps.of_falls; ++f) {
            const int part = s * substeps.of_falls + f;
            pieces_.push_back({PieceKind::advect, static_cast<int16_t>(part)});
            add(PieceKind::spread_overflow, core.def.overflow_passes);
        }
        if (s == 0 && core.params.bank_strength > 0) add(PieceKind::fail_banks);
        // Bodies go further in a step that is late, in as many more sub-steps as the steps had that
        // it stands for. For it to be cheaper than those, slopes slide once in it.
        if (core.due_count > 1 && s + 1 < substeps.of_bodies) continue;
        for (int part = 0; part < substeps.of_slides; ++part) {
            add_slips(core, slips);
            add(PieceKind::slide, slides);
        }
    }
    for (const PieceKind kind :
         {PieceKind::take, PieceKind::move_water, PieceKind::collect_contacts, PieceKind::ask,
          PieceKind::read, PieceKind::close}) {
        add(kind);
    }
}

}  // namespace bsoil
