/// ContactReader: contacts and loads, out of what collect_contacts has left.
#pragma once

#include <vector>

#include "contact/contact_voxels.h"
#include "soil/body_table.h"
#include "soil/ground_bodies.h"
#include "soil/silo_walls.h"
#include "soil/tile_table.h"

namespace bsoil {

/// Heights of the soil's surface around contacts. Tiles asleep count as they would awake: what
/// wakes them must not change the contacts of a body at rest.
class SurfaceReader {
  public:
    SurfaceReader(SoilCore& core, TileTable& tiles, GroundBodies& ground)
        : core_(core), tiles_(tiles), ground_(ground) {}
    /// Before a step's results are read: adds what will be asked. Without contacts: nothing.
    void want(bool has_contacts, std::vector<device::ReadRange>& ranges);
    /// Surface words of a tile's columns; under a body see kCovered.
    std::span<const int32_t> of_ground(int tile);
    /// The same of the soil that a body (by its index) carries; kBare or kBareTop without any.
    std::span<const int32_t> of_carried(int tile, int carrier);
    /// Words of height spans read for the last step.
    size_t span_words() const { return spans_.size(); }

    /// The records of an awake tile's columns, until the next call.
    const int32_t* spans_of(int slot);

  private:
    SoilCore& core_;
    TileTable& tiles_;
    GroundBodies& ground_;
    std::vector<int32_t> tops_;  ///< by slot and column
    // Tiles whose height spans the contacts need because a body carries the soil under another one:
    // those that were asked for in the last step are read with everything else.
    std::vector<int32_t> spans_;
    std::vector<int> slots_;  ///< of spans_, tile by tile
    std::vector<int> asked_;  ///< slots asked for in this step
    TileRuns runs_;           ///< of a tile that is looked at
    std::vector<int> place_;  ///< by slot: its place in slots_, -1 where it is not read
    std::vector<int32_t> carried_;
};

class ContactReader {
  public:
    ContactReader(SoilCore& core, TileTable& tiles, BodyTable& bodies, GroundBodies& ground)
        : core_(core),
          tiles_(tiles),
          bodies_(bodies),
          surface_(core, tiles, ground),
          silo_walls_(core, tiles, bodies) {}
    /// Once the materials are known.
    void start();

    int capacity_most = limits::kContactCapacity;  ///< contacts of a step; tests have less
    /// Before a step's results are cleared: for the contacts of so many blocks.
    void make_room(int block_count);
    /// Before a step's results are read: adds the records that are expected.
    void want(bool has_contacts, std::vector<device::ReadRange>& ranges);
    /// header: the first words of Buffer::result, with the bodies' loads.
    void read(std::span<const int32_t> header);

    const std::vector<ContactVoxel>& contacts() const { return contacts_; }
    const std::vector<BodyLoad>& loads() const { return loads_; }
    const MomentumFlow& momentum() const { return momentum_; }
    /// Nothing has moved in this step, so no momentum has changed.
    void note_quiet();
    /// Contacts and loads are of the last step, all of them, and no edit came after.
    bool are_known() const { return are_whole_ && known_edit_ == tiles_.edit_count(); }
    void clear();
    SurfaceReader& surface() { return surface_; }

  private:
    void read_loads(std::span<const int32_t> header);
    Vec3 impulse_of(const int32_t* sums) const;
    void make_contacts();

    SoilCore& core_;
    TileTable& tiles_;
    BodyTable& bodies_;
    SurfaceReader surface_;
    SiloWalls silo_walls_;
    std::vector<double> wedge_length_;  ///< ContactLawDef::wedge_length_of each material
    std::vector<SurfaceWedge> wedges_;  ///< of each material
    std::vector<ContactVoxel> contacts_;
    std::vector<BodyLoad> loads_;
    MomentumFlow momentum_;
    bool are_whole_ = false;
    uint64_t known_edit_ = 0;
    int room_ = 0;      ///< records that Buffer::result holds
    int expected_ = 0;  ///< records that the next read asks for
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> record_words_;
    ContactVoxels voxels_;
    std::vector<ContactBody> placed_;   ///< by body index; of the step in progress
    std::vector<double> width_voxels_;  ///< of the contact, by body index
};

}  // namespace bsoil
