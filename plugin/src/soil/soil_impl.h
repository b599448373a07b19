/// Soil::Impl: the parts of a soil on the host's side. Each owns its state and its scratch:
///
///   SoilCore       definition, grid, device, kernel parameters, stamps, conditions
///   TileTable      tiles asleep and awake
///   BodyTable      bodies, from step to step
///   WorkLists      which blocks are active, and the lists that kernels run over
///   GroundBodies   bodies that are terrain
///   ShapeUpload    what the device is told of shapes
///   Passes         which kernels run in which order
///   Flows          sources, sinks, open sides
///   Water          what rain, drying and drainage do
///   ContactReader  contacts and loads; what meets bodies is in src/contact/
///   StepReader     what a step has changed
///   TileSampler    questions about single voxels
///   StepPieces     what is left to do of the step in progress
///   StepBudget     how long a call may work on it
///
/// step.cpp is the step out of them. soil.cpp (creation, queries), fill.cpp, terrain.cpp,
/// settle.cpp, region.cpp and snapshot.cpp change and ask the soil between steps.
#pragma once

#include <functional>
#include <string>

#include "soil/contact_reader.h"
#include "soil/fill_columns.h"
#include "soil/flows.h"
#include "soil/ground_bodies.h"
#include "soil/passes.h"
#include "soil/shape_upload.h"
#include "soil/step_budget.h"
#include "soil/step_reader.h"
#include "soil/water.h"

namespace bsoil {

struct Soil::Impl : SoilCore {
    TileTable tiles{*this};
    BodyTable bodies{*this};
    WorkLists lists{*this, tiles};
    GroundBodies ground{*this, tiles, bodies, lists};
    ShapeUpload shapes{*this};
    Passes passes{*this, lists};
    Flows flows{*this, tiles, lists, passes};
    Water water{*this, tiles, lists, passes};
    ContactReader contacts{*this, tiles, bodies, ground};
    StepReader results{*this, tiles, bodies, lists, contacts, flows};
    mutable TileSampler sampler{*this, tiles};
    mutable std::vector<int32_t> region_words;  ///< what was last read to weigh a region
    std::string device_reason;

    // --- the step in progress, and the last one that is through
    StepPieces pieces;
    StepBudget budget;
    bool is_quiet = false;
    StepReport last_report;       ///< without what report() adds
    bool is_undelivered = false;  ///< no report() has said that it is through

    // --- fill.cpp, terrain.cpp
    Result<int> material_index(const std::string& name) const;
    Status fill_with(const std::string& material, const int low[3], const int high[3],
                     const FillShape& shape);
    void begin_fill(TileFill& fill, LevelTiles& level_tiles);
    int64_t end_fill(TileFill& fill);
    Status fill_ground(const std::string& material,
                       const std::function<double(int x, int y)>& height_at);
    /// Share of the grid voxel (x, y, z), 0..1.
    using VoxelFraction = std::function<double(int x, int y, int z)>;
    /// Terrain below `z_end`; the fraction is asked for tile by tile, column by column.
    Status terrain_with(const VoxelFraction& fraction, int z_end);
    /// Whether a density function can be asked in every voxel.
    Status check_density_grid() const;

    // --- settle.cpp
    Result<SettleReport> settle(int steps_max, std::span<const SoilBody> input);
    void wake_unstable_columns();

    // --- step.cpp
    StepReport step(std::span<const SoilBody> input, double budget_ms);
    void begin_step();
    void list_work();
    void begin_pieces(std::span<const SoilBody> input);
    void run_piece(StepPiece piece);
    void close_step();
    bool go_on();
    void note_finished();
    /// Before something else is done with the whole soil: the rest of the step in progress.
    void finish();
    /// What is in progress belongs to a soil that is no more.
    void drop_step();
    StepReport report();

    // --- soil.cpp
    uint64_t checksum() const;
    /// What hangs on other planes than these is 0.
    VoxelSample sample(int x, int y, int z, PlaneSet planes) const;
};

}  // namespace bsoil
