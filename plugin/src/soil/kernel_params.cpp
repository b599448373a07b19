#include "soil/kernel_params.h"

#include <algorithm>
#include <cmath>

#include "soil/slip_table.h"

namespace bsoil {

using namespace layout;

namespace {

/// By how many bits a voxel's height is cut so that places fit into 31 bits; see place_code() of
/// kernel_common.glsl.
int place_shift(int tiles_x, int tiles_y, int height) {
    const int64_t columns = static_cast<int64_t>(tiles_x) * tiles_y * kTileColumns;
    int shift = 0;
    while (columns * (((height - 1) >> shift) + 1) >= INT32_MAX) ++shift;
    return shift;
}

/// Strength (as kTableStrength) that bonded soil of a material has to have for find_failures to
/// leave out most of its planes, by its table. Of soil that takes water most of what it has as
/// placed: what is weaker costs time. Of soil placed dry a quarter of the most it can come to.
int32_t bank_strength_of(const MaterialDef& material, const int32_t* table) {
    if (!(material.pore_water_fraction > 0)) return table[kTableStrength];
    constexpr double kMostOf = 0.75;
    const double placed = material.placed_saturation;
    const double moist = 4 * placed * (1 - placed), dry = table[kTableStrength];
    const double strength = dry > 0 || moist > 0 ? dry + moist * table[kTableMoist]
                                                 : 0.25 / kMostOf * table[kTableMoist];
    return static_cast<int32_t>(kMostOf * strength / (1 + material.pore_water_fraction));
}

/// Strength that all loose soil of a material has. Of soil that takes water it is not known.
int32_t loose_strength_of(const MaterialDef& material, const int32_t* table) {
    if (material.pore_water_fraction > 0) return 0;
    return *std::min_element(table + kTableByDensity, table + kTableByDensity + kDensityEntries);
}

/// As much a second in steps of any length, and a unit at least.
int32_t still_speed_q16(const SoilDef& def) {
    return std::max(1, static_cast<int32_t>(std::lround(kStillSpeed * 60 * def.step_s)));
}

// The wind in the grid's frame and in voxels a step. Soil is no faster than kSpeedMost along any
// axis: a stronger wind blows as fast as that, and where it blows.
void set_wind(SoilCore& s) {
    const Vec3 wind =
        s.def.step_s / s.def.voxel_m * rotate(s.world_to_grid.rotation, s.def.wind_m_s);
    const double fastest = std::max({std::abs(wind.x), std::abs(wind.y), std::abs(wind.z)});
    const double scale = std::min(1.0 * kVoxelFull, kSpeedMost / std::max(fastest, 1.0));
    const auto word = [](double value, double most) {
        return static_cast<int32_t>(std::lround(std::clamp(value, -most, most)));
    };
    s.params.wind_x = word(wind.x * scale, kSpeedMost);
    s.params.wind_y = word(wind.y * scale, kSpeedMost);
    s.params.wind_z = word(wind.z * scale, kSpeedMost);
    s.params.gust = word(s.def.gust * kOneQ16, kOneQ16);
    s.params.gust_cell = std::max(1, word(s.def.gust_size_m / s.def.voxel_m, kGustCellMost));
    const bool is_level = s.params.wind_x != 0 || s.params.wind_y != 0;
    s.params.shelter = is_level ? word(s.def.shelter_m / s.def.voxel_m, kShelterMost) : 0;
}

// Ours: above 50 of them a step has the same gravity as the next, which is at most a hundredth off.
// Larger: soil falls too fast or too slowly; smaller: what is at hand is no longer what was
// computed at usual steps.
constexpr double kGravityOffMost = 0.01;

// Steps after which their turns begin anew, so that the products below are exact to far less than
// one. Ours: 9 minutes at 2000 Hz. Larger: they are less so after a year; smaller: what the
// rounding of a last step leaves counts.
constexpr int64_t kGravityTurns = int64_t{1} << 20;

}  // namespace

int32_t gravity_q16(const SoilDef& def, int64_t step_index) {
    const double exact = def.gravity_m_s2 * def.step_s * def.step_s / def.voxel_m * kVoxelFull;
    const auto nearest = static_cast<int32_t>(std::lround(exact));
    if (std::abs(nearest - exact) <= kGravityOffMost * exact) return nearest;
    const auto turn = static_cast<double>(step_index % kGravityTurns);
    return static_cast<int32_t>(std::llround(exact * turn) - std::llround(exact * (turn - 1)));
}

void set_kernel_params(SoilCore& s) {
    const SoilDef& def = s.def;
    SoilParams& p = s.params;
    p.tile_voxels = kTileColumns * s.height;
    p.height = s.height;
    p.size_x = s.frame.size[0];
    p.size_y = s.frame.size[1];
    p.blocks_per_tile = s.blocks_per_tile;
    p.material_count = static_cast<int>(s.materials.size());
    p.water_count = std::ranges::any_of(
        s.materials, [](const MaterialDef& m) { return m.pore_water_fraction > 0; });
    p.water_plane = p.water_count > 0 ? kPlaneMaterial + p.material_count : 0;
    p.floor_seepage = seepage_q4(def.floor_drainage_m_s, def);
    const double table_voxels = std::min(def.water_table_m / def.voxel_m, 1.0 * s.height);
    p.water_table = p.water_count > 0 ? static_cast<int>(std::lround(table_voxels * kOneQ16)) : 0;
    p.transport_count = transported_planes(p.material_count, p.water_count);
    p.gravity_q16 = gravity_q16(def, s.step_index);
    const int arch_least = def.gravity_m_s2 > 0 ? 1 : 0;  // none only without gravity
    p.arch_speed = std::max(
        arch_least,
        static_cast<int>(std::lround(
            std::sqrt(def.gravity_m_s2 * def.step_s * def.step_s / def.voxel_m) * kVoxelFull)));
    p.push_speed = 0;
    p.still_speed = still_speed_q16(def);
    p.arch_reach = def.slides == SlideMotion::run_out ? 0 : kArchReach;
    p.overflow_heuristic = static_cast<int>(def.overflow);
    p.place_rows = s.tiles_y * kTileSide;
    p.place_shift = place_shift(s.tiles_x, s.tiles_y, s.height);
    p.slides = def.slides == SlideMotion::run_out ? 1 : 0;
    set_wind(s);
    p.slide_count = 1;
    p.substep_count = 1;
    p.body_substep_count = 1;
    p.resolved_most = def.substeps_max * kVoxelFull;
    s.kept_planes = kept_planes(p.material_count, p.water_count);
}

std::vector<int32_t> make_material_tables(SoilCore& s) {
    SoilParams& p = s.params;
    std::vector<int32_t> tables;
    p.bank_friction = INT32_MAX;
    p.bank_strength = p.keeps_cohesion = p.regains_cohesion = p.dilates = p.deposits = p.air = 0;
    p.loose_strength = INT32_MAX;
    for (const MaterialDef& material : s.materials) {
        const size_t first = tables.size();
        for (const double kept :
             {1.0, material.loose_cohesion_fraction, 0.0}) {  // by kSoilBonded ...
            MaterialDef state = material;
            state.cohesion_pa *= kept;
            state.moist_cohesion_pa *= kept;
            const std::vector<int32_t> table = make_slip_table(state, s.def);
            tables.insert(tables.end(), table.begin(), table.end());
        }
        int32_t* bonded = &tables[first + kSoilBonded * size_t{kTableWords}];
        int32_t* loose = &tables[first + kSoilLoose * size_t{kTableWords}];
        std::ranges::copy(peak_frictions(material), bonded + kTableByDensity);
        if (material.dilatancy_angle_rad > 0) p.dilates = 1;
        std::ranges::copy(regained_strengths(material, s.def, loose), loose + kTableByDensity);
        const int32_t compacted = loose[kTableByDensity + kDensityEntries - 1];
        if (loose[kTableStrength] > 0 || loose[kTableMoist] > 0 || compacted > 0) {
            p.keeps_cohesion = 1;
        }
        if (material.compaction_cohesion_ratio > 0 && compacted > 0) p.regains_cohesion = 1;
        p.loose_strength = std::min(p.loose_strength, loose_strength_of(material, loose));
        p.bank_friction = std::min(p.bank_friction, bonded[kTableFriction]);
        if (material.roughness > 0 || material.viscosity > 0) p.deposits = 1;
        if (material.fall_speed_m_s > 0) p.air = 1;
        if (const int32_t strength = bank_strength_of(material, bonded); strength > 0) {
            p.bank_strength = p.bank_strength > 0 ? std::min(p.bank_strength, strength) : strength;
        }
    }
    return tables;
}

}  // namespace bsoil
