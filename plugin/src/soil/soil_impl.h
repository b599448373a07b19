/// Soil::Impl: the state of a soil on the host's side. One file per concern implements it:
/// soil.cpp (creation, queries), step.cpp (the step), residency.cpp (tiles asleep and awake),
/// ground_bodies.cpp, fill.cpp, terrain.cpp, snapshot.cpp. What meets bodies is in src/contact/.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "bsoil/distance_lattice.h"
#include "bsoil/limits.h"
#include "bsoil/soil.h"
#include "bsoil/work_threads.h"
#include "contact/contact_voxels.h"
#include "device/device.h"
#include "soil/column_surface.h"
#include "soil/condition_log.h"
#include "soil/fill_columns.h"
#include "soil/layout.h"
#include "soil/tile_codec.h"
#include "soil/wall_thickness.h"

namespace bsoil {

// Planes that outlive a step, in the order of TileVoxels: terrain, then all transported planes.
// Coverage, owner and support are made anew from the bodies.
//
//   TileVoxels plane | state plane
//   0                | kPlaneTerrain
//   1 + i            | kTransportFirst + i    (volume, momentum x 3, force x 3, bond, materials)
inline constexpr int kKeptTerrain = 0;
inline constexpr int kKeptVolume = 1;
inline constexpr int kKeptMomentum = 2;
inline constexpr int kKeptForce = 5;
inline constexpr int kKeptBond = 8;
inline constexpr int kKeptMaterial = 9;

/// Stamps are kept within 20 bits because the tile tops share their word with them; see
/// kTileTableTop.
inline constexpr int64_t kStampWrap = (1 << 20) - 2;
/// SoilParams::step_stamp in a step.
constexpr int32_t step_stamp_of(int64_t step_index) {
    return static_cast<int32_t>(step_index % kStampWrap + 1);
}

/// The soil of a tile asleep. Tiles that hold the same share one: it never changes.
struct PackedTile {
    std::vector<uint8_t> bytes;  ///< see pack_tile()
    int top = 0;                 ///< Tile::top
    /// Heights of its surface [Q16 voxels] by column, once somebody has asked; else empty.
    mutable std::vector<int32_t> surface;
};

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

    std::span<const uint8_t> bytes() const {
        return packed ? std::span<const uint8_t>(packed->bytes) : std::span<const uint8_t>();
    }
};

/// A block of 8 x 8 x 8 voxels by its place: index of its tile * blocks per tile + z / 8.
using BlockKey = int64_t;

/// What a body's contacts hang on, as it was given.
struct GivenBody {
    Pose pose;
    Vec3 linear_velocity_m_s, angular_velocity_rad_s, center_of_mass_m;
    double contact_width_m = 0;
    bool operator==(const GivenBody& o) const;
};

/// What is known of a body from one step to the next.
struct BodyTrack {
    Pose pose;
    unsigned shape_revision = 0;
    int index = -1;  ///< of its record in the shapes buffer and of its owner marks
    bool is_static = false;
    int64_t last_step = -1;
    GivenBody given;               ///< in the last step
    std::vector<BlockKey> blocks;  ///< in which its coverage stands now, sorted
    WallShapes walls;
    SurfaceSamples surface;  ///< empty where the contact law goes by the coverage field
    int64_t last_moved_step = INT64_MIN / 2;
    bool is_ground = false;  ///< part of the terrain: see ground_bodies.cpp
    Pose ground_pose;
    std::vector<ConvexShape> ground_shapes;  ///< of ground; empty after load(), until it is seen
};

/// A body that takes part in a step, in grid axes and metres.
struct StepBody {
    const SoilBody* input = nullptr;
    BodyTrack* track = nullptr;
    Pose from, to;  ///< body frame -> grid, at the step's start and end
    bool moved = false;
    bool placed = false;         ///< not there before, not so, or not within reach
    bool turned_static = false;  ///< or movable: what rests on it rests on something else
    /// Its shapes as the soil sees them.
    const std::vector<ConvexShape>& shapes() const {
        return track->walls.shapes.empty() ? *input->shapes : track->walls.shapes;
    }
};

/// A work list whose entries lie in Buffer::block_list.
struct ListedWork : device::WorkList {
    int list_offset = 0;  ///< of group 0's entry, SoilParams::list_offset
};

struct Soil::Impl {
    SoilDef def;
    std::vector<MaterialDef> materials;
    std::vector<double> wedge_length;  ///< ContactLawDef::wedge_length_of each material
    GridFrame frame;
    Pose world_to_grid;  ///< of metres
    double kg_per_unit = 0;
    int height = 0, tiles_x = 0, tiles_y = 0, blocks_per_tile = 0, kept_planes = 0;
    std::string device_reason;
    std::unique_ptr<device::Device> device;
    std::unique_ptr<WorkThreads> work_threads;
    layout::SoilParams params{};

    std::vector<std::unique_ptr<Tile>> tiles;  ///< tiles_x * tiles_y; null: never held anything
    std::vector<int> slot_tile;                ///< tile index of a slot, -1 = free
    std::vector<int> free_slots;
    int slot_count = 0, slot_capacity_max = 0;
    bool table_dirty = false;  ///< neighbour table has to be uploaded again
    /// Of the pass before the last slip pass over single voxels, and over several at once.
    int32_t slip_stamps[2] = {-1, -1};
    int32_t failure_stamp = -1;  ///< the same for find_failures
    std::vector<int32_t> tile_table;

    uint64_t revision_base = 0;  ///< Tile::revision of a tile that does not exist; see load()

    int64_t step_index = 0;
    std::unordered_map<BlockKey, int64_t> active;  ///< block -> step in which it last changed
    std::unordered_map<int, BodyTrack> bodies;     ///< by SoilBody::id
    std::vector<int> body_ids;                     ///< SoilBody::id by index; -1 = free
    int64_t speed_q16 = 0;  ///< fastest soil of the last step, Q16 voxels a base step
    int32_t slope_q16 = 0;  ///< steepest failing wedge that the last step left, Q16 voxels
    ConditionLog conditions;
    bool any_unchecked = false;

    std::vector<ContactVoxel> contacts;
    bool contacts_known = false;  ///< contacts and loads are of the last step; no edit came after
    std::vector<BodyLoad> loads;

    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int64_t> listed_step, rebuild_step,
        contact_step;                 ///< by device block: the last step it was in that list
    std::vector<int64_t> woken_step;  ///< by slot: when it woke
    // By slot: the last step that looked at its columns, -1 when nothing is known of them, and how
    // many blocks up; see note_stale().
    std::vector<int64_t> looked_step;
    std::vector<int> looked_blocks;
    std::vector<int32_t> block_words, flag_words, shape_words, result_head, result_words, tile_tops;
    std::vector<int32_t> tile_spans, carried_tops;
    std::vector<int32_t> mask_scratch;
    std::vector<std::pair<BlockKey, int64_t>> active_scratch;
    std::vector<std::unordered_map<BlockKey, int64_t>::node_type>
        active_spare;  ///< entries that fell out of `active`
    std::vector<std::pair<int32_t, int32_t>> pair_scratch;
    std::vector<std::pair<size_t, const ConvexShape*>> hull_scratch, lattice_scratch;
    std::vector<BlockKey> block_scratch, fresh_blocks;
    std::vector<StepBody> body_scratch;
    std::vector<Aabb> shape_boxes;
    int contacts_expected = 0;  ///< contact records that read_back() asks for
    // Tiles whose height spans the contacts need because a body carries the soil under another one:
    // those that were asked for in the last step are read with everything else.
    std::vector<int> span_slots;  ///< of tile_spans, tile by tile
    std::vector<int> span_asked;  ///< slots asked for in this step
    std::vector<int> span_place;  ///< by slot: its place in span_slots, -1 where it is not read
    mutable std::vector<device::ReadRange> read_scratch;
    ContactVoxels contact_voxels;
    std::vector<ContactBody> contact_bodies;  ///< by body index; of the step in progress
    std::vector<double> body_width_voxels;    ///< of the contact, by body index
    size_t list_words_used = 0, list_words_uploaded = 0, lists_capacity = 0;
    // Buffer::shapes: bodies, shapes and planes of the sub-step at hand, room for more of them,
    // then the lattices, which stay.
    struct LatticePlace {
        std::shared_ptr<const DistanceLattice> lattice;
        size_t offset = 0;  ///< in Buffer::shapes [words]
    };
    std::vector<LatticePlace> lattices;
    size_t shapes_capacity = 0;  ///< words before the first lattice
    int block_active_count = 0;
    ListedWork listed_work, tile_work, rebuild_work, pair_work, contact_work;
    mutable TileVoxels scratch;
    mutable TileVoxels sampled, sampled_ground;
    mutable int sampled_tile = -1;
    mutable uint64_t sampled_revision = 0;
    mutable std::vector<int32_t> sampled_coverage;  ///< of the bodies; empty: not read, or asleep
    mutable int64_t coverage_step = -1;  ///< step_index when it was read; -1: not of this tile

    // --- geometry
    int tile_index(int tx, int ty) const { return ty * tiles_x + tx; }
    Tile& tile_for(int index);
    Vec3 to_grid(Vec3 world) const { return transform(world_to_grid, world) * (1 / frame.voxel_m); }

    // --- residency.cpp
    /// Slot of a tile, waking it if need be; -1 and status when the table is full.
    int wake(int index);
    void put_to_sleep(int index);
    void sleep_idle_tiles();
    void sleep_tiles_unused_since(int64_t step);
    Status grow_slots(int wanted);
    Status allocate_slots(int count);
    void upload_tile_table();
    /// Reads a tile, awake or asleep, into `out`.
    void read_voxels(int index, TileVoxels& out) const;
    /// Adds a tile's words of a plane of the state to read_scratch.
    /// Nothing is known of what a tile's columns hold: they are to be looked at anew.
    void note_stale(int slot, bool may_be_covered);
    void stamp_columns(int slot);
    /// One word for all columns of a tile in one of the arrays kColumnSurface ...
    void write_columns(int slot, int array, int32_t word);
    /// Columns have no stamps any more: all are to be looked at anew.
    void forget_stamps();
    void want_plane(int plane, int slot, std::span<int32_t> words) const;
    void write_voxels(int index, const TileVoxels& in);
    /// The same as runs; a tile that does not exist is made.
    TileRuns read_runs(int index);
    /// Puts the soil of a packed tile into a tile, awake or asleep.
    void write_packed(int index, std::shared_ptr<const PackedTile> in);
    const TileVoxels& sampled_voxels(int index) const;
    /// Of that tile, by voxel; empty where no body covers any.
    std::span<const int32_t> body_coverage_of_sampled() const;
    /// Surface heights of a tile's columns [Q16 voxels], awake (as read_back() found them) or
    /// asleep; under a body see kCovered.
    std::span<const int32_t> surface_heights(int index);
    /// The same of the soil that a body (by its index) carries; kBare or kBareTop without any.
    std::span<const int32_t> carried_surface(int index, int carrier);
    const int32_t* spans_of(int slot);
    void activate(BlockKey block);

    // --- ground_bodies.cpp
    /// A shape of a ground body.
    struct GroundShape {
        const ConvexShape* shape = nullptr;
        Pose pose;  ///< body -> grid, metres
        Aabb box;   ///< voxels
        bool is_over(int tx, int ty) const;
    };
    /// What tiles asleep that held the same became under the same cover.
    struct GroundMemo {
        using Content = std::tuple<std::shared_ptr<const PackedTile>, TileBytes, TileBytes>;
        struct Entry {
            std::vector<int32_t> cover;
            Content after;
            bool unchecked = false;
        };
        std::map<Content, std::vector<Entry>> entries;
    };
    std::vector<GroundShape> ground_shapes;
    bool ground_listed = true;  ///< ground_shapes are those of `bodies`
    bool any_ground_due = false;
    void update_ground(std::vector<StepBody>& step_bodies);
    void meet_ground(std::span<const SoilBody> input);
    void keep_ground_shapes(const StepBody& body);
    void mark_ground(const BodyTrack& track);
    const std::vector<GroundShape>& ground_list();
    void stamp_ground();
    void stamp_new_tile(int index);
    void add_ground(const GroundShape& shape, int index, std::vector<int32_t>& cover) const;
    /// rock_changed: look for buried soil even where the ground is as before.
    void put_ground(int index, const std::vector<int32_t>& cover, bool rock_changed = false,
                    GroundMemo* memo = nullptr);
    void change_ground(int index, const std::vector<int32_t>& cover, bool rock_changed);
    bool is_over_ground(int index);
    /// The soil that ground bodies have buried in a tile; false: none.
    bool read_buried(int index, TileVoxels& out) const;
    /// The ground bodies' part of a tile's terrain, one plane; no words: none.
    void read_ground(int index, TileVoxels& out) const;

    // --- fill.cpp, terrain.cpp
    Result<int> material_index(const std::string& name) const;
    Status fill_with(const std::string& material, const int low[3], const int high[3],
                     const FillShape& shape);
    Status fill_ground(const std::string& material,
                       const std::function<double(int x, int y)>& height_at);
    /// Share of the grid voxel (x, y, z), 0..1.
    using VoxelFraction = std::function<double(int x, int y, int z)>;
    /// Terrain below `z_end`; the fraction is asked for tile by tile, column by column.
    Status terrain_with(const VoxelFraction& fraction, int z_end);
    /// Whether a density function can be asked in every voxel.
    Status check_density_grid() const;
    void wake_unstable_columns();

    // --- settle.cpp
    Result<SettleReport> settle(int steps_max, std::span<const SoilBody> input);

    // --- step.cpp
    StepReport step(std::span<const SoilBody> input);
    bool accept_body(const SoilBody& body);
    int take_body_index(int id);
    double body_reach_voxels(const StepBody& body) const;
    void find_body_blocks(const StepBody& body, bool may_wake, std::vector<BlockKey>& blocks);
    int device_block(BlockKey key) const;
    int top_around(int tx, int ty) const;
    void mark_rebuild(const std::vector<BlockKey>& blocks, bool changes_soil);
    void list_active_blocks();
    void build_work_lists();
    void upload_bodies(std::span<const StepBody> step_bodies, double t);
    void upload_shapes();
    bool place_lattices();
    const LatticePlace* place_of(const ConvexShape& shape) const;
    bool may_cover(size_t shape, const Vec3& block_middle) const;
    void build_pairs();
    void ensure_capacity(device::BufferIndex buffer, size_t& capacity, size_t words);
    void dispatch(layout::Kernel kernel, const ListedWork& work);
    void run_deformation();
    void run_advection();
    void run_failures();
    void set_slip_rates();
    void run_slippage();
    void read_back();
    void read_results(std::span<const StepBody> step_bodies);
    void note_kernel_conditions();
    void read_activity();
    void wake_neighbours(int index, int32_t asked);

    uint64_t checksum() const;
};

}  // namespace bsoil
