/// Passes: which kernels run in which order.
#pragma once

#include "soil/work_lists.h"

namespace bsoil {

/// The stages of a step, as the diagram of plugin/README.md has them.
class Passes {
  public:
    Passes(SoilCore& core, const WorkLists& lists) : core_(core), lists_(lists) {}

    /// Once the definition is known: how fast slopes relax.
    void start();

    void voxelize();          ///< Algorithm 1 of the thesis, step 1
    void deform();            ///< thesis (18)
    void advect();            ///< thesis (19)
    void fail_banks();        ///< where soil has cohesion: which banks fail as a whole
    void slip();              ///< thesis (20)
    void slide(int passes);   ///< what slips with momentum goes on
    void collect_contacts();  ///< into Buffer::result
    /// One kernel over one list.
    void run(layout::Kernel kernel, const ListedWork& work);
    /// A kernel that writes deltas, and what adds them to the state.
    void move(layout::Kernel kernel, const ListedWork& work);

  private:
    void look(layout::Kernel kernel, PassStamps::Looker looker, const ListedWork& work);

    SoilCore& core_;
    const WorkLists& lists_;
};

}  // namespace bsoil
