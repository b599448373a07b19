/// Soil: the grid, its step and everything one can ask of it. See plugin/README.md for the step and
/// the memory map.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/condition.h"
#include "bsoil/contact/contact_law.h"
#include "bsoil/contact/known_contacts.h"
#include "bsoil/grid_frame.h"
#include "bsoil/soil_def.h"
#include "bsoil/soil_flow.h"
#include "bsoil/work_counts.h"
#include "bsoil/work_threads.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Time of each stage in a call of step() [ms]; with OpenGL by the GPU, of one or two calls before.
struct StageTimes {
    double voxelize = 0, deform = 0, advect = 0, slip = 0, contacts = 0, activity = 0;
};

/// Where soil's momentum came from and went to in a step [N s], world. The change of the sum over
/// all soil is `fallen` plus all BodyLoad::impulse_n_s less `to_ground`, as whole numbers.
struct MomentumFlow {
    Vec3 fallen_n_s;     ///< from gravity, air and sources; what sinks took away is negative
    Vec3 to_ground_n_s;  ///< to ground, terrain and the grid's ends; slopes give (negative)
};

/// What one step did.
struct StepReport {
    /// Whether a step was finished in this call. If not (SoilDef::step_budget_ms), all but
    /// conditions is of the last one that was.
    bool has_finished = true;
    int call_count = 1;  ///< calls over which that step was spread
    int substep_count = 0;
    uint32_t status_bits = 0;     ///< sticky
    int condition_new_count = 0;  ///< conditions first met in this step, the last of these:
    std::span<const Condition> conditions;  ///< Soil::conditions(); valid until the next step
    int block_active_count = 0;             ///< 8x8x8 blocks that moved or may move
    int block_dispatched_count = 0;         ///< those and their neighbours
    int tile_awake_count = 0;
    double speed_max_voxels_per_step = 0;
    StageTimes stage_ms;
    std::span<const ContactVoxel> contacts;  ///< sorted by voxel; valid until the next step
    /// Whether contacts and loads are those of the step before: nothing moved, no body, no soil.
    bool contacts_unchanged = false;
    /// Bodies that carry soil or were hit by soil that moves; valid until the next step.
    std::span<const BodyLoad> loads;
    MomentumFlow momentum;
};

/// What Soil::settle did, and what it left.
struct SettleReport {
    bool is_at_rest = false;     ///< nothing moves, nothing may start to
    int step_count = 0;          ///< steps it made
    int block_active_count = 0;  ///< 8x8x8 blocks that still move or may move
    int tile_awake_count = 0;
    uint32_t status_bits = 0;  ///< sticky, as StepReport's
    StepReport last_step;      ///< of the last step it made; as new where it made none
};

/// Totals that never change but by fills, sources and sinks, with the soil that lies buried in
/// ground bodies (see SoilBody::is_static). Units are integers: sums are exact.
struct SoilTotals {
    std::vector<int64_t> units;   ///< per material
    std::vector<double> mass_kg;  ///< per material
    /// Per material, since the soil was created: what sources have poured in, what sinks and open
    /// sides have taken out. Not what fill() and take_out() put in and took.
    std::vector<int64_t> units_in, units_out;
    /// Water in the soil, in sixteenths of these units of mass; and since the soil was created:
    /// what rain and sources have brought, what has dried, drained through the floor or gone with
    /// taken soil.
    int64_t water_units = 0, water_units_in = 0, water_units_out = 0;
};

/// What lies at one voxel, for meshing, tests and tools.
struct VoxelSample {
    double volume = 0;         ///< soil, fraction of a voxel (above 1: compressed)
    double coverage = 0;       ///< terrain and ground bodies, 0..1
    int material = 0;          ///< the one with the largest amount
    double density_kg_m3 = 0;  ///< bulk density of the dry soil: mass / volume
    double saturation = 0;     ///< share of its pores that water fills, 0..1
    Vec3 velocity_m_s;         ///< world axes
    /// Where bodies push the soil, world axes; as long as the volume they push is a fraction of a
    /// voxel.
    Vec3 push;
    double undisturbed = 0;    ///< share of the soil that was never moved, 0..1
    double body_coverage = 0;  ///< moving bodies, 0..1; more where they overlap
    bool is_active = false;    ///< its block of 8 x 8 x 8 moved or may move
};

/// How the topmost soil of a column moves along the ground.
struct GroundMotion {
    double slip_m_s = 0;  ///< down a slope that fails
    /// Of what slides on with its momentum, world axes. Only SlideMotion::run_out has that, and
    /// only where no body is in the column.
    Vec3 velocity_m_s;
};

/// Memory in use [bytes].
struct MemoryUse {
    int64_t awake_bytes = 0, asleep_bytes = 0;
    int64_t awake_voxels = 0, asleep_columns = 0;
    /// Awake: planes, and the voxel's part of what its column, block and tile have.
    double bytes_per_awake_voxel = 0, bytes_per_asleep_column = 0;
};

/// Deformable soil. Not thread-safe: one caller at a time; different soils may run in different
/// threads.
class Soil {
  public:
    /// The error names the field, its value and its range, or says what the device lacks.
    static Result<std::unique_ptr<Soil>> create(const SoilDef& def);
    ~Soil();

    /// Puts soil in. Only what is free of terrain and of other soil is filled. An error changes
    /// nothing.
    /// @{
    Status fill(const BoxFill& fill);
    Status fill(const CylinderFill& fill);
    Status fill(const HeightMapFill& fill);
    Status fill(const NoiseFill& fill);
    Status fill(const FunctionFill& fill);
    /// @}
    /// Fixed ground that soil cannot enter (thesis section 4.1.3). Refused where soil lies already.
    /// @{
    Status add_terrain(const DensityFunction& density);
    Status add_terrain(const TriangleMesh& closed_mesh);
    /// @}

    /// Takes out all soil, at rest or not, of the voxels whose centres are inside a convex region
    /// of the world; soil buried in ground bodies stays. What loses its hold slides from the next
    /// step on. Cost: the tiles under the region are read and written once; a tool for people, not
    /// for every step. Returns the units taken out, per material: totals() has as many less. Error:
    /// the region or pose is not valid.
    Result<std::vector<int64_t>> take_out(const ConvexShape& region, const Pose& pose);

    /// Sources and sinks, at most 64 with the open sides. They work in every step from now on; what
    /// a snapshot holds are they too. Each call between steps costs a write of all their regions.
    /// The id is unique in this soil. Error: the definition is not valid, its region has no voxel
    /// of the grid, or too many.
    /// @{
    Result<int> add_source(const SourceDef& source);
    Result<int> add_sink(const SinkDef& sink);
    /// @}
    /// Puts one somewhere else; its rate goes on. Error: as above; nothing changes.
    /// @{
    Status move_source(int id, Vec3 center_m, Vec3 direction);
    Status move_sink(int id, const Pose& pose);
    /// @}
    Status remove_flow(int id);  ///< a source or sink
    /// Mass that all sources have poured in, or all sinks and open sides have taken out. Costs
    /// nothing.
    double moved_kg(FlowWay way) const;
    Result<FlowState> flow_state(int id) const;  ///< what a source or sink has done

    /// Another definition from the next step on: sliders, a soil that dries, a test that varies one
    /// figure. `live` fields of BSOIL_SOIL_FIELDS and BSOIL_MATERIAL_FIELDS and colours may differ.
    /// Soil that is there takes on what its material is now; slopes that no longer stand fall. A
    /// snapshot then is of this definition. Cost: a look at all tiles, as after filling them, and
    /// the step after it. Error: as create(), or it names what may not differ; nothing changes.
    Status change(const SoilDef& def);
    uint64_t def_revision() const;  ///< times that change() changed something

    /// One step of SoilDef::step_s with these bodies. Bad bodies are skipped and reported in the
    /// status bits. With SoilDef::step_budget_ms a call goes on with the step in progress, and then
    /// begins one with these bodies if there is time left. What asks for the whole soil or changes
    /// it (totals, checksum, snapshots, fills, flows, change) finishes the step in progress first;
    /// samples and tiles are read as they are.
    StepReport step(std::span<const SoilBody> bodies);

    /// What a host does behind its loading screen, after the fills and before the first step. Looks
    /// at all that was filled since the last step for slopes that may not stand, which the first
    /// step would do. Then makes steps, up to steps_max, until nothing moves: as step() with
    /// `bodies` standing still where they are. Tiles that have come to rest go to sleep. The same
    /// bits as step() gives, on every backend. Cost: 1 us a tile of 8 x 8 columns that shares its
    /// content with others (level ground), 10 us one that does not, and the steps.
    /// Error: steps_max is not 0..kSettleStepsMax; then nothing changes. Or the device failed in
    /// one of the steps, as device_failure() says.
    Result<SettleReport> settle(int steps_max = 0, std::span<const SoilBody> bodies = {});

    /// What it knows of its contacts with bodies. Whoever finds forces writes it, between steps.
    /// @{
    KnownContacts& known_contacts();
    const KnownContacts& known_contacts() const;
    /// @}
    /// What a contact law has to know of this soil.
    ContactSoil contact_soil() const;

    const SoilDef& def() const;                         ///< as given to create() or change()
    const std::vector<MaterialDef>& materials() const;  ///< SoilDef::material_list()
    const GridFrame& frame() const;                     ///< where the grid lies
    std::string backend_name() const;                   ///< "cpu" or "gl"
    /// The SoilDef::thread_count threads of its host's part: for what else a caller does with it
    /// between steps. Valid as long as the soil.
    const WorkThreads& threads() const;
    std::string device_name() const;  ///< of the processor, or as the GL driver calls it
    /// What has broken the device (GPU reset or out of memory), empty while all is well; see
    /// StatusBit::device_lost. Then nothing can be read, and nothing is saved.
    std::string device_failure() const;
    int thread_count() const;  ///< of the CPU backend

    SoilTotals totals() const;     ///< costs a pass over everything; waits for the device
    uint64_t checksum() const;     ///< of amounts, motion and terrain; the same on every backend
    uint32_t status_bits() const;  ///< every StatusBit set since clear_status()
    /// What is known of each status bit, oldest first: one entry for each bit and body, at most
    /// kConditionCapacity; those of further bodies are counted in one without a body. Valid until
    /// the next step.
    std::span<const Condition> conditions() const;
    void clear_status();  ///< forgets all of them
    /// Notes a condition that no body has, for whoever couples the soil with bodies.
    void set_status(StatusBit bit);
    MemoryUse memory_use() const;    ///< of the soil, without the meshes
    WorkCounts work_counts() const;  ///< since it was created
    StepRate step_rate() const;      ///< since it was created
    /// Whether a step is in progress, which the next call of step() goes on with.
    bool is_stepping() const;
    int64_t voxels_total() const;  ///< of the whole grid, empty ones too

    /// Samples are read through a cache of tiles, refreshed after each step: cheap in bulk. Outside
    /// of the grid voxels, columns and tiles (of revision 0) are empty, here and below.
    VoxelSample sample(int x, int y, int z) const;
    /// As sample(), but for velocity_m_s and push, which are 0: reads half as much of a tile.
    VoxelSample sample_matter(int x, int y, int z) const;
    /// VoxelSample::velocity_m_s alone, likewise.
    Vec3 velocity_m_s(int x, int y, int z) const;
    /// Share of each material in a voxel's soil, by mass; all 0 where there is none. Read as
    /// samples are.
    std::array<double, limits::kMaterialCapacity> material_shares(int x, int y, int z) const;
    /// Of a grid column's soil, as of the last step; 0 where it rests, falls or is carried. Read as
    /// samples are.
    GroundMotion ground_motion(int x, int y) const;
    /// World height (along up, from the grid's floor) [m] of the topmost resting soil or terrain at
    /// a grid column. Soil on a ground body rests, the body itself is no surface of the soil.
    double surface_height_m(int x, int y) const;
    /// Soil inside a convex region of the world [kg], without what is buried in ground bodies; used
    /// to weigh a bucket's load.
    double mass_inside_kg(const ConvexShape& region, const Pose& pose) const;
    /// The same, per material.
    std::vector<double> masses_inside_kg(const ConvexShape& region, const Pose& pose) const;
    /// Grows each time the soil in tile (tx, ty) of 8 x 8 columns may have changed.
    uint64_t tile_revision(int tx, int ty) const;
    /// These tiles (tx, ty) are asked for next, in this order, by read_tile(), sample() and what
    /// else asks for single voxels and columns. A GPU is then waited for once for many of them (16
    /// MiB) and not two to four times for each. On the CPU that saves nothing and costs nothing.
    void read_ahead(std::span<const std::array<int, 2>> tiles) const;
    /// The whole voxel column block of tile (tx, ty) at once: fractions of a voxel, index z*64 +
    /// y*8 + x, size 64 * size[2]. For meshing: `volume` is soil, `solid` terrain and ground bodies
    /// (no moving bodies).
    void read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                   std::vector<uint8_t>& material) const;
    /// The same of the terrain alone, without ground bodies.
    void read_terrain(int tx, int ty, std::vector<float>& terrain) const;

    /// Snapshot of the whole soil: amounts, motion, density, what is active, what is known of the
    /// bodies. Versioned, compressed, checksummed; see snapshot_file.h. Error: the file cannot be
    /// written, or as checked_state().
    Status save(const std::string& path) const;
    /// Replaces this soil's state; with the same bodies (ids, shapes, shape revisions) it then goes
    /// on bit for bit as the saved one. Reads the soil of any snapshot. Error: the file is damaged,
    /// or of a soil with another grid, step, gravity or material; it names what differs and changes
    /// nothing.
    Status load(const std::string& path);
    /// The same as bytes, for hosts that keep several states in one file. None where the device has
    /// failed.
    std::vector<uint8_t> state() const;
    /// state(), where prepare() takes it. Error: a voxel holds more than it does, so that the soil
    /// would not go on from it; looked at where StatusBit::amount_headroom was ever met.
    Result<std::vector<uint8_t>> checked_state() const;
    /// Checks a state(); the function put out replaces this soil's, once, before anything else is
    /// done with the soil. Error: as load().
    Result<std::function<void()>> prepare(std::span<const uint8_t> state);
    /// Times that load() or what prepare() gave has replaced the state: reports from before are of
    /// another soil, and their lists are gone.
    uint64_t state_revision() const;

    struct Impl;

  private:
    friend struct SoilProbe;  // tests reach single stages through it
    explicit Soil(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil
#pragma GCC visibility pop
