/// Sources, sinks and open sides of a grid: what is due in a step, which voxels it concerns, what
/// has moved. The kernels pour_soil and take_soil do the moving.
#pragma once

#include <cstdint>
#include <vector>

#include "bsoil/soil.h"
#include "soil/passes.h"

namespace bsoil {

/// The voxels of a region in one tile.
struct FlowPart {
    int tile = 0;
    int low = 0, high = 0;  ///< all its voxels are in the layers low .. high - 1
    int32_t columns[layout::kTileColumns] = {};  ///< see kFlowColumns
    int32_t first[layout::kTileColumns] = {};    ///< see kFlowFirst
    int32_t place = 0;                           ///< of its words in Buffer::tables
};

/// The voxels of a region.
struct FlowRegion {
    std::vector<FlowPart> parts;  ///< by tile
    int64_t voxel_count = 0;
};

/// What soil comes or goes by.
enum class FlowKind { source, sink, open_side, well };

/// A source, a sink or an open side, and what it has done.
struct Flow {
    int id = 0;  ///< an open side's is its bit of SoilDef::open_sides
    FlowKind kind = FlowKind::sink;
    SourceDef source;
    SinkDef sink;
    // What a snapshot holds besides:
    int64_t units = 0, missed_units = 0;  ///< see FlowState
    /// Sink: mass units that its last look left in the region, with a full voxel's for each that it
    /// does not know yet.
    int64_t held_units = 0;
    bool is_fresh = true;    ///< sink: all of its region is to be looked at
    int64_t lump_count = 0;  ///< source: lumps so far
    double since_s = 0;      ///< simulated time at which it was added

    FlowRegion region;
    double units_per_s = 0;                  ///< 0: a sink takes all
    int material = 0;                        ///< source
    int32_t words[layout::kFlowWords] = {};  ///< as the kernels get them
    bool works = false;                      ///< has something to do in this step
    int round = 0;                           ///< those of one round have no voxel in common

    double start_s() const;  ///< not before it was added
    double end_s() const { return kind == FlowKind::source ? source.end_s : sink.end_s; }
    bool takes_all() const { return kind != FlowKind::source && units_per_s == 0; }
    /// Mass units due since its start by simulated time `t_s`.
    int64_t due_units(double t_s) const;
    /// Time from when it works to when it works again.
    double every_s(const SoilDef& def) const;
    /// As many as may wait for room or soil.
    int64_t waiting_most(const SoilDef& def) const;
};

/// All of a soil.
class Flows {
  public:
    Flows(SoilCore& core, TileTable& tiles, WorkLists& lists, Passes& passes)
        : core_(core), tiles_(tiles), lists_(lists), passes_(passes) {}
    /// Once the grid is known. Their words follow these in Buffer::tables.
    void start(std::vector<int32_t> material_tables);

    // --- between steps
    /// Sources pour soil as it is now.
    void change_materials(std::vector<int32_t> material_tables);
    Result<int> add(Flow flow);
    Status change(Flow& flow, Flow to);
    Status remove(int id);
    Flow* find(int id);  ///< null: there is none
    /// Everything of a flow that follows from its definition and the grid.
    Status place(Flow& flow) const;
    /// Sinks look at all of their regions.
    void look_anew();
    /// A source, or a sink that has not looked yet.
    bool may_work() const;
    const std::vector<Flow>& all() const { return all_; }  ///< open sides, then by id
    int next_id() const { return next_id_; }
    const std::vector<int64_t>& units_in() const { return units_in_; }  ///< by material
    const std::vector<int64_t>& units_out() const { return units_out_; }
    /// All of a snapshot, each of which place() takes.
    void restart(std::vector<Flow> flows, int next_id, std::vector<int64_t> units_in,
                 std::vector<int64_t> units_out);

    // --- of the step in progress
    /// The fastest source that pours in it.
    double pouring_speed_voxels() const;
    /// What is due, and what has to be awake for it.
    void begin_step();
    void list();
    void clear_results();
    void pour();
    void take();
    void want(std::vector<device::ReadRange>& ranges);
    /// is_quiet: nothing was done, nor read.
    void note_results(bool is_quiet);

  private:
    /// Mass units of so many full voxels; a well's of their water.
    int64_t full_units(const Flow& flow, int64_t voxel_count) const;
    Result<FlowRegion> find_region(const ConvexShape& shape, const Pose& pose) const;
    Result<FlowRegion> find_source_region(const SourceDef& source) const;
    void open_sides();
    void set_rounds();
    void upload();
    double time_s() const { return static_cast<double>(core_.step_index) * core_.def.step_s; }
    void begin_source(Flow& flow);
    void begin_sink(Flow& flow);
    void activate(const FlowPart& part, int top);
    void list_parts(const Flow& flow);

    SoilCore& core_;
    TileTable& tiles_;
    WorkLists& lists_;
    Passes& passes_;
    std::vector<Flow> all_;
    int next_id_ = 1;
    std::vector<int64_t> units_in_, units_out_;
    std::vector<int32_t> material_tables_;
    bool is_placed_ = false;               ///< all their words and parts are in Buffer::tables
    std::vector<ListedWork> pour_, take_;  ///< by Flow::round
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<int32_t> words_, results_;
    std::vector<std::pair<int32_t, int32_t>> groups_;  ///< slot and place of a part
};

}  // namespace bsoil
