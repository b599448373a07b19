/// Passes: which kernels run in which order.
#pragma once

#include <limits>

#include "soil/work_lists.h"

namespace bsoil {

/// The passes of a step, as the diagram of plugin/README.md has them. Each call is a piece of a
/// step: between two of them all that moves has arrived.
class Passes {
  public:
    Passes(SoilCore& core, const WorkLists& lists) : core_(core), lists_(lists) {}

    /// Once the definition is known: how fast slopes relax.
    void start();

    /// At the start of a step: finds what kernels remember of the columns of WorkLists::restored().
    void look_at_restored();
    void voxelize();         ///< Algorithm 1 of the thesis, step 1
    void apply_force();      ///< thesis (18), its first step
    void propagate_force();  ///< thesis (18), one iteration
    void advect();           ///< thesis (19)
    void spread_overflow();  ///< thesis (19), one pass for what does not fit
    /// Where soil has cohesion: which banks fail as a whole, everywhere.
    void fail_banks();
    /// Where loose soil keeps cohesion, before other slip passes: near what just failed.
    void fail_banks_again();
    /// Parts of a step in each of which slopes slip and slide, by what the last step left.
    int slide_part_count() const;
    /// Passes in each of so many parts.
    /// @{
    int slip_pass_count(int parts) const;
    int slide_pass_count(int parts) const;
    /// @}
    /// At most so many slip passes from now on, and no fewer than the step's length asks for.
    void limit_slips(int most) { slips_most_ = most; }
    void slip(int pass, int passes);  ///< thesis (20), pass 0..passes - 1 of a part
    void slide(int passes);           ///< what slips with momentum goes on, one of so many a step
    void collect_contacts();          ///< into Buffer::result
    /// One kernel over one list.
    void run(layout::Kernel kernel, const ListedWork& work);
    /// A kernel that writes deltas, and what adds them to the state.
    void move(layout::Kernel kernel, const ListedWork& work);

  private:
    int slip_passes_wanted() const;
    void find_failures();
    void look(layout::Kernel kernel, PassStamps::Looker looker, const ListedWork& work);

    SoilCore& core_;
    const WorkLists& lists_;
    int slips_most_ = std::numeric_limits<int>::max();
};

}  // namespace bsoil
