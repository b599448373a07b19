/// TileTable: the tiles of a soil, asleep on the host and awake on the device.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "soil/soil_core.h"
#include "soil/tile_codec.h"

namespace bsoil {

// Planes that outlive a step, in the order of TileVoxels: terrain, then all transported planes.
// Coverage, owner and support are made anew from the bodies.
//
//   TileVoxels plane | state plane
//   0                | kPlaneTerrain
//   1 + i            | kTransportFirst + i    (volume, momentum x 3, force x 3, bond, materials,
//   water)
inline constexpr int kKeptTerrain = 0;
inline constexpr int kKeptVolume = 1;
inline constexpr int kSurfacePlanes = 2;  ///< terrain and volume: what a surface hangs on
inline constexpr int kKeptMomentum = 2;
inline constexpr int kKeptForce = 5;
inline constexpr int kKeptBond = 8;
inline constexpr int kKeptMaterial = 9;

/// Some of them, a bit for each.
using PlaneSet = uint32_t;
inline constexpr PlaneSet kAllPlanes = ~PlaneSet{0};
inline constexpr PlaneSet kMomentumPlanes = 7u << kKeptMomentum;
inline constexpr PlaneSet kForcePlanes = 7u << kKeptForce;
/// Terrain, volume, bond, materials and water.
inline constexpr PlaneSet kMatterPlanes = ~(kMomentumPlanes | kForcePlanes);
inline constexpr PlaneSet kTerrainPlane = 1u << kKeptTerrain, kVolumePlane = 1u << kKeptVolume;
inline constexpr PlaneSet kMaterialPlanes = kAllPlanes << kKeptMaterial;  ///< and water

/// The plane of the state that a kept plane is.
constexpr int state_plane_of(int kept) {
    return kept == kKeptTerrain ? layout::kPlaneTerrain : layout::kTransportFirst + kept - 1;
}

/// The soil of a tile asleep. Tiles that hold the same share one: it never changes.
struct PackedTile {
    std::vector<uint8_t> bytes;  ///< see pack_tile()
    int top = 0;                 ///< Tile::top
    /// Heights of its surface [Q16 voxels] by column, once somebody has asked; else empty.
    mutable std::vector<int32_t> surface;
};

/// Tile::top of these voxels.
int top_of(const TileVoxels& voxels);

std::shared_ptr<const PackedTile> make_packed(const TileRuns& runs);
std::shared_ptr<const PackedTile> make_packed(const TileVoxels& voxels);

/// Voxels as pack_tile() packs them, never changed.
using TileBytes = std::shared_ptr<const std::vector<uint8_t>>;

/// One tile of 8 x 8 columns.
struct Tile {
    int slot = -1;                             ///< in the device's buffers when awake
    std::shared_ptr<const PackedTile> packed;  ///< when asleep; null: nothing but air
    uint64_t revision = 1;                     ///< grows when its soil may have changed
    int top = 0;                 ///< z above the highest voxel that holds soil or terrain
    int64_t last_used_step = 0;  ///< when it was last needed awake
    bool unchecked = false;      ///< filled since its slopes were last looked at
    bool ground_due = false;     ///< a ground body came or went here in this step
    /// Ground bodies: their part of its terrain (one plane, packed), and the soil that lies buried
    /// in them (kept planes, packed). Null: none. Tiles that hold the same may share them.
    TileBytes ground, buried;

    bool is_awake() const { return slot >= 0; }
    std::span<const uint8_t> bytes() const {
        return packed ? std::span<const uint8_t>(packed->bytes) : std::span<const uint8_t>();
    }
};

/// Tiles that are read from the device together when they fall asleep. Ours: each is 0.2 MB at a
/// height of 64 voxels and waits on the host. More: memory; fewer: more waits for the device.
inline constexpr size_t kTilesARead = 16;

/// Tiles by index, row by row; null where nothing has ever been. Awake ones have a slot in the
/// device's buffers. Asks the device for more slots when they run out.
class TileTable {
  public:
    explicit TileTable(SoilCore& core) : core_(core) {}
    /// Once the grid and the device are there: no tiles, room for the first awake ones.
    Status start();
    /// Called with the index of each tile that make() has made of nothing.
    std::function<void(int index)> on_new_tile;

    size_t size() const { return tiles_.size(); }
    std::unique_ptr<Tile>& operator[](size_t index) { return tiles_[index]; }
    const std::unique_ptr<Tile>& operator[](size_t index) const { return tiles_[index]; }
    auto begin() const { return tiles_.begin(); }
    auto end() const { return tiles_.end(); }
    /// The tile, made if need be.
    Tile& make(int index);
    /// Height to which soil may reach in a tile within this step: what lies next to it, in a bucket
    /// high above the ground maybe, may come over.
    int top_around(int tx, int ty) const;

    // --- awake
    int slot_count() const { return slot_count_; }
    /// Of the device's buffers, without the room for slots that there are not yet, where that costs
    /// nothing.
    int64_t memory_bytes() const;
    int awake_count() const { return slot_count_ - static_cast<int>(free_slots_.size()); }
    /// Tile index of each slot, -1 = free.
    std::span<const int> slot_tiles() const { return slot_tile_; }
    int64_t block_count() const { return int64_t{slot_count_} * core_.blocks_per_tile; }
    /// Slot of a tile, waking it if need be; -1 and a condition when the table is full.
    int wake(int index);
    /// Wakes what of these sleeps, with all threads: wake() finds them awake then, with the slots
    /// that it would have given them one by one. Those without a slot stay asleep.
    void wake_ahead(std::span<const int> indices);
    bool woke_in_this_step(int slot) const {
        return woken_step_[static_cast<size_t>(slot)] == core_.step_index;
    }
    /// As if it had woken in the step in progress, or else in the next one: what is known of
    /// supports and spans is no longer true.
    void look_anew(int slot) {
        woken_step_[static_cast<size_t>(slot)] = core_.step_index;
        is_edited_[static_cast<size_t>(slot)] = true;
    }
    /// look_anew(), and no step has looked since.
    bool is_edited(int slot) const { return is_edited_[static_cast<size_t>(slot)]; }
    /// Blocks up to which a step has last looked at its columns.
    int looked_blocks(int slot) const { return looked_blocks_[static_cast<size_t>(slot)]; }
    /// Out of a snapshot: what was known of its columns is to be found anew, as far up as a step
    /// had looked.
    void note_restored(int slot, int looked_blocks) {
        is_restored_[static_cast<size_t>(slot)] = any_restored_ = true;
        looked_blocks_[static_cast<size_t>(slot)] = looked_blocks;
    }
    bool is_restored(int slot) const { return is_restored_[static_cast<size_t>(slot)]; }
    bool any_restored() const { return any_restored_; }
    /// A step looks at all of them.
    void forget_restored();
    /// Slopes, supports and spans of all tiles, awake or asleep: what soil does has changed.
    void look_anew_at_all();
    /// Waits for the device once.
    void put_to_sleep(std::span<const int> indices);
    void sleep_idle();
    /// Waits for the device once for each kTilesARead tiles.
    void sleep_unused_since(int64_t step);
    Status grow_slots(int wanted);
    /// The neighbours of each awake tile, for the kernels; where any has woken or fallen asleep.
    void upload();
    /// upload() has to write the table again.
    void note_dirty() { is_dirty_ = true; }

    // --- what tiles hold
    /// Reads a tile, awake or asleep, into `out`.
    void read_voxels(int index, TileVoxels& out) const;
    /// A tile asleep, as runs: far less than its voxels. False, and `runs` as it was, for one
    /// awake.
    bool read_asleep(int index, TileRuns& runs) const;
    /// Only the first planes of what read_voxels() reads.
    void read_planes(int index, int plane_count, TileVoxels& out) const;
    /// What read_voxels() would read of these planes of a tile awake, to be read together with
    /// more.
    void want_voxels(int index, PlaneSet planes, TileVoxels& out,
                     std::vector<device::ReadRange>& ranges) const;
    void write_voxels(int index, const TileVoxels& in);
    /// The same as runs, in the place of those that are there; a tile that does not exist is made.
    void read_runs(int index, TileRuns& runs);
    /// Puts the soil of a packed tile into a tile, awake or asleep.
    void write_packed(int index, std::shared_ptr<const PackedTile> in);
    /// The words of a plane of the state in a slot, to be read or written.
    device::ReadRange plane_range(int plane, int slot, std::span<int32_t> words) const {
        return {layout::Buffer::state, plane_offset(plane, slot), words};
    }
    int64_t plane_offset(int plane, int slot) const {
        return int64_t{plane} * core_.params.plane_stride +
               int64_t{slot} * core_.params.tile_voxels;
    }
    /// Words of Buffer::spans: the records of a slot's columns; one of the arrays kColumnSurface
    /// ... from a slot on; a word of the slot itself out of kTileStamp ...
    int64_t spans_offset(int slot) const {
        return int64_t{slot} * layout::kTileColumns * layout::kColumnWords;
    }
    int64_t column_array_offset(int array, int slot) const {
        return int64_t{layout::kColumnWords + array} * core_.params.column_count +
               int64_t{slot} * layout::kTileColumns;
    }
    int64_t tile_array_offset(int array, int slot) const {
        return int64_t{layout::kColumnWords + layout::kColumnArrays} * core_.params.column_count +
               int64_t{array} * slot_count_ + slot;
    }
    /// The soil that ground bodies have buried in a tile; false: none.
    bool read_buried(int index, TileVoxels& out) const;
    /// The ground bodies' part of a tile's terrain, one plane; no words: none.
    void read_ground(int index, TileVoxels& out) const;
    /// Grows with everything that changes what a contact hangs on, outside of the kernels.
    uint64_t edit_count() const { return edit_count_; }
    void note_edit() { ++edit_count_; }
    /// Tile::revision of a tile that does not exist.
    uint64_t revision_base() const { return revision_base_; }
    /// As if the soil of all tiles had changed, for whoever draws it.
    void note_all_revised();
    /// Some tile is Tile::unchecked.
    bool any_unchecked = false;

    // --- what kernels remember of columns
    /// Nothing is known of what a tile's columns hold: they are to be looked at anew.
    void note_stale(int slot, bool may_be_covered);
    /// As if all of its columns had changed in the last pass.
    void stamp_columns(int slot);
    /// This step looks at a tile up to a block; at all of its columns where the last step did not.
    void note_look(int slot, int blocks_up);
    /// One word for all columns of a tile in one of the arrays kColumnSurface ...
    void write_columns(int slot, int array, int32_t word);
    /// No column has a stamp any more, and no kernel has looked.
    void forget_stamps();
    /// No tiles, all slots free, revisions beyond all that there were.
    void clear();

  private:
    static constexpr int kNeverUsed = -1;

    bool take_slot(int index);
    void unpack_filled(int index, TileVoxels& low) const;
    /// Puts a tile's lowest levels into the slot that it has taken; above there is nothing.
    void fill_slot(Tile& tile, const TileVoxels& low);
    Status expect_large();
    Status allocate_slots(int count);
    void want_planes(int index, int plane_count, PlaneSet planes, TileVoxels& out,
                     std::vector<device::ReadRange>& ranges) const;

    SoilCore& core_;
    std::vector<std::unique_ptr<Tile>> tiles_;
    uint64_t revision_base_ = 0, edit_count_ = 0;
    std::vector<int> slot_tile_, free_slots_;
    int slot_count_ = 0, slot_capacity_ = 0;
    /// The large buffers have room for all slots from the start: nothing of them moves when there
    /// are more.
    bool keeps_places_ = false;
    bool is_dirty_ = false;
    std::vector<int64_t> woken_step_;  ///< by slot: when it woke
    std::vector<bool> is_edited_;      ///< by slot
    std::vector<bool> is_restored_;    ///< by slot
    bool any_restored_ = false;
    /// By slot: above so many levels its kept planes are zero while no tile has it; kNeverUsed: all
    /// of its words are.
    std::vector<int> filled_levels_;
    /// By slot: the last step that looked at its columns, -1 when nothing is known of them, and how
    /// many blocks up; see note_stale().
    std::vector<int64_t> looked_step_;
    std::vector<int> looked_blocks_;
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> neighbour_words_, column_words_;
    TileVoxels voxels_;
    std::vector<TileVoxels> sleepers_, unpacked_;
    std::vector<int> falling_asleep_, waking_;
    mutable std::vector<device::ReadRange> ranges_;
};

/// The last tile that somebody asked about, read once for many questions.
class TileSampler {
  public:
    TileSampler(const SoilCore& core, const TileTable& tiles) : core_(core), tiles_(tiles) {}
    /// Other planes than these may hold anything.
    const TileVoxels& voxels(int index, PlaneSet planes = kAllPlanes);
    /// These tiles are asked for next, in this order and before the next step: they are read many
    /// at once.
    void read_ahead(std::vector<int> indices) {
        wanted_ = std::move(indices);
        wanted_step_ = core_.step_index;
    }
    /// Height of a column's surface, ColumnFill::top_q16. Reads no more of the tile than it needs.
    int32_t top_q16(int index, int column);
    /// Of the tile of voxels(): the part of its terrain that belongs to ground bodies; no words:
    /// none.
    const TileVoxels& ground() const { return whole_.read.ground; }
    /// Of that tile, by voxel, what movable bodies cover; empty where none does.
    std::span<const int32_t> body_coverage();
    /// Of that tile, by column, the slip speed of its fastest span [Q16 voxels a base step]; empty
    /// where nothing slips.
    std::span<const int32_t> slip_speeds();
    void forget() {
        whole_.read.index = surface_.index = -1;
        ahead_.clear();
        wanted_.clear();
        tops_.clear();
    }

  private:
    /// A tile as it was at a revision.
    struct Read {
        TileVoxels voxels, ground;
        int index = -1;
        uint64_t revision = 0;
    };
    /// All of a tile, with what its columns and the bodies in it do.
    struct Whole {
        Read read;
        PlaneSet planes = 0;  ///< of `read`
        /// SoilCore::step_index when its momentum and force could be read: what comes to rest does
        /// not always make a new revision.
        int64_t motion_step = -1;
        std::vector<int32_t> coverage, slip_speeds;
        /// SoilCore::step_index when they were read; -1: not of this tile.
        int64_t coverage_step = -1, slip_step = -1;
    };
    bool is_of_now(const Read& read, int index) const {
        return index == read.index && revision_of(index) == read.revision;
    }
    /// Reads terrain and volume of a tile where they may have changed.
    void renew_surface(int index);
    void read_missing(PlaneSet planes);
    /// Whether what moves the tile's soil is that of this step.
    bool is_motion_of_now(const Whole& whole) const;
    /// Reads a tile that is asked for next, and those that follow it, with one wait; whether it
    /// did.
    bool fetch(int index);
    /// From words of slides and records, see kColumnSlides.
    void note_slip_speeds(Whole& whole, std::span<const int32_t> slides,
                          std::span<const int32_t> records) const;
    uint64_t revision_of(int index) const;
    int32_t find_top_q16(int index, int column);
    /// The tile of voxels() where `words` of it have to be read anew, in the first call of a step;
    /// null where they are known or where it sleeps and has none.
    const Tile* awake_tile_to_read(int64_t& step, std::vector<int32_t>& words) const;

    /// The surface of a tile's columns that somebody has asked for, at a revision.
    struct Tops {
        uint64_t revision = 0, known = 0;  ///< known: a bit a column
        std::array<int32_t, 64> q16{};
    };

    const SoilCore& core_;
    const TileTable& tiles_;
    Whole whole_;
    Read surface_;                        ///< only kSurfacePlanes
    std::vector<int> wanted_;             ///< tiles that are asked for next
    int64_t wanted_step_ = -1;            ///< SoilCore::step_index then
    std::vector<Whole> ahead_;            ///< some of them
    std::unordered_map<int, Tops> tops_;  ///< by tile index
    // Scratch.
    std::vector<int32_t> slide_words_, record_words_;
    std::vector<device::ReadRange> ranges_;
};

}  // namespace bsoil
