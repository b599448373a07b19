/// StepReader: the results of a step, read back with one wait for the device.
#pragma once

#include <span>
#include <vector>

#include "soil/contact_reader.h"
#include "soil/flows.h"
#include "soil/work_lists.h"

namespace bsoil {

class StepReader {
  public:
    StepReader(SoilCore& core, TileTable& tiles, BodyTable& bodies, WorkLists& lists,
               ContactReader& contacts, Flows& flows)
        : core_(core),
          tiles_(tiles),
          bodies_(bodies),
          lists_(lists),
          contacts_(contacts),
          flows_(flows) {}

    /// Asks for the results, behind all work so far.
    void ask();
    /// Waits for them, where Device::is_read_done() does not say that they are there. After it:
    /// conditions that the kernels noted, the speed and slope that the step left, contacts and
    /// loads.
    void read();
    /// What of the soil has changed in the step read: active blocks, revisions and tops of tiles.
    /// Whether any has.
    bool note_activity();
    /// The head of what the kernels have left in Buffer::result.
    std::span<const int32_t> header() const { return header_; }

  private:
    void note_kernel_conditions();
    void wake_neighbours(int index, int32_t asked);

    SoilCore& core_;
    TileTable& tiles_;
    BodyTable& bodies_;
    WorkLists& lists_;
    ContactReader& contacts_;
    Flows& flows_;
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> header_, flag_words_, table_words_;
    std::vector<device::ReadRange> ranges_;
};

}  // namespace bsoil
