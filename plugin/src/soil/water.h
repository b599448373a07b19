/// Water in the soil: when it moves, what rain, drying and the floor bring and take, and the
/// account of it. The kernel move_water does the moving. docs/decisions/moisture.md
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "soil/passes.h"

namespace bsoil {

/// Of a soil one of whose materials takes water; of others it does nothing.
class Water {
  public:
    Water(SoilCore& core, TileTable& tiles, WorkLists& lists, Passes& passes)
        : core_(core), tiles_(tiles), lists_(lists), passes_(passes) {}
    /// Water units that fill a voxel.
    static constexpr int kVoxelUnits = 524288;
    /// Time from one water step to the next [s]: the whole steps nearest to a second.
    static double period_s(const SoilDef& def);
    /// Whether the step in progress is a water step.
    static bool is_due(const SoilCore& core);

    /// Water of a unit of a fill's mass by layer from the bottom, up to the last in which
    /// groundwater or its capillary fringe holds more than the fill has.
    std::vector<double> per_mass_of_layers(const MaterialDef& material) const;

    bool is_there() const { return core_.params.water_count > 0; }
    int64_t units_in() const { return units_in_; }
    int64_t units_out() const { return units_out_; }

    /// Soil was put in or taken out.
    void look_anew() { is_still_ = false; }

    // --- of the step in progress
    /// Where it is a water step all soil is awake.
    void begin_step();
    void move();
    /// The result's head, and whether anything has changed in the step.
    void note_results(std::span<const int32_t> header, bool has_changed);

    // --- snapshots
    /// Empty, or what came in, what left, and whether all of it stands still.
    std::vector<int64_t> state() const;
    static bool is_state(std::span<const int64_t> state, bool has_water);
    void restart(std::span<const int64_t> state);

  private:
    /// Units of a rate [m/s] since the soil's start.
    int64_t due_units(double rate_m_s, int64_t step) const;

    SoilCore& core_;
    TileTable& tiles_;
    WorkLists& lists_;
    Passes& passes_;
    int64_t units_in_ = 0, units_out_ = 0;
    bool is_still_ = false;  ///< nothing drains until soil moves
    bool moves_ = false;     ///< this is a water step
};

}  // namespace bsoil
