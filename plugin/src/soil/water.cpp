#include "soil/water.h"

#include <algorithm>
#include <cmath>

#include "base/kernels.h"
#include "soil/slip_table.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

static_assert(Water::kVoxelUnits ==
              kVoxelFull * 1000 / static_cast<int>(kReferenceDensity) * kWaterParts);

namespace {

/// Steps from one water step to the next: a second. Water is slow beside what slides.
int64_t period(const SoilDef& def) { return std::max<int64_t>(1, std::llround(1 / def.step_s)); }

}  // namespace

double Water::period_s(const SoilDef& def) { return static_cast<double>(period(def)) * def.step_s; }

bool Water::is_due(const SoilCore& core) { return core.step_index % period(core.def) == 0; }

int64_t Water::due_units(double rate_m_s, int64_t step) const {
    const double time_s = static_cast<double>(step) * core_.def.step_s;
    return static_cast<int64_t>(std::floor(rate_m_s * time_s / core_.frame.voxel_m * kVoxelUnits));
}

// S = 1 - h / H at a height h over the table, H being the suction of dry pores: nothing flows.
std::vector<double> Water::per_mass_of_layers(const MaterialDef& material) const {
    std::vector<double> layers;
    const double reach = suction_q16(material, core_.def);
    for (int z = 0; core_.params.water_table > 0 && z < core_.height; ++z) {
        const double above = (z + 0.5) * kOneQ16 - core_.params.water_table;
        const double held = above < 0 ? 1 : above < reach ? 1 - above / reach : 0;
        if (held <= material.placed_saturation) break;
        layers.push_back(held * material.pore_water_fraction);
    }
    return layers;
}

void Water::begin_step() {
    moves_ = false;
    if (!is_there() || !is_due(core_)) return;
    const auto due = [&](double rate_m_s) {
        return static_cast<int32_t>(due_units(rate_m_s, core_.step_index) -
                                    due_units(rate_m_s, core_.step_index - period(core_.def)));
    };
    core_.params.rain_units = due(core_.def.rain_m_s);
    core_.params.drying_units = due(core_.def.drying_m_s);
    moves_ = !is_still_ || core_.params.rain_units + core_.params.drying_units > 0;
    for (size_t i = 0; moves_ && i < tiles_.size(); ++i) {
        const Tile* tile = tiles_[i].get();
        for (int z = 0; tile && z < tile->top; z += kTileSide) {
            lists_.activate(core_.block_key(static_cast<int>(i), z / kTileSide));
        }
    }
}

void Water::move() {
    if (moves_) passes_.move(Kernel::move_water, lists_.tiles());
}

void Water::note_results(std::span<const int32_t> header, bool has_changed) {
    if (!is_there()) return;
    units_in_ += wide_sum(&header[kResultWaterIn]);
    units_out_ += wide_sum(&header[kResultWaterOut]);
    if (moves_) is_still_ = wide_sum(&header[kResultWaterMoves]) == 0;
    if (has_changed) is_still_ = false;
}

std::vector<int64_t> Water::state() const {
    if (!is_there()) return {};
    return {units_in_, units_out_, is_still_ ? 1 : 0};
}

bool Water::is_state(std::span<const int64_t> state, bool has_water) {
    if (!has_water) return state.empty();
    return state.size() == 3 && state[0] >= 0 && state[1] >= 0 && (state[2] == 0 || state[2] == 1);
}

void Water::restart(std::span<const int64_t> state) {
    units_in_ = state.empty() ? 0 : state[0];
    units_out_ = state.empty() ? 0 : state[1];
    is_still_ = !state.empty() && state[2] == 1;
}

}  // namespace bsoil
