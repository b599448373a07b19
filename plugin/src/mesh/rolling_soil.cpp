#include "mesh/rolling_soil.h"

#include <algorithm>
#include <cmath>

namespace bsoil::mesh {
namespace {

/// Slower soil looks as if it rested [m/s]: a voxel of 5 cm takes a second.
constexpr double kRollLeast = 0.05;
/// From this speed on soil rolls with all its grains [m/s]: a person walks as fast.
constexpr double kRollFull = 1.0;
/// A slope that exceeds the stable one by this much [voxels a voxel] rolls with all its grains. A
/// heap of 5 cm voxels that comes to rest then moves as much as a layer of 4 mm does at 1.5 m/s.
/// What slips is in proportion to it.
constexpr double kSteepFull = 0.06;
constexpr double kAmountLeast = 1.0 / 256;  ///< half a grain
/// Tops further apart [voxels] tilt the surface no more, as on both sides of a blade.
constexpr float kStepMost = 3.0f;
constexpr double kFlat = 1e-3;  ///< a smaller gradient has no direction

/// Of the column's topmost soil; null: there is none.
const Run* top_run(const GridColumns& grid, int x, int y) {
    if (x < 0 || y < 0 || x >= grid.size[0] || y >= grid.size[1]) return nullptr;
    const TileColumns& tile =
        grid.tiles[static_cast<size_t>((y / kTileSide) * grid.tile_count[0] + x / kTileSide)];
    const auto runs = tile.runs.column(y % kTileSide * kTileSide + x % kTileSide);
    return runs.empty() ? nullptr : &runs.back();
}

/// Rise of the surface over a voxel along an axis, from the neighbours that hold soil.
double rise_along(const GridColumns& grid, int x, int y, int axis, float top) {
    double sum = 0;
    int count = 0;
    for (const int side : {-1, 1}) {
        const Run* run = top_run(grid, x + (axis == 0 ? side : 0), y + (axis == 1 ? side : 0));
        if (!run) continue;
        sum += side * static_cast<double>(std::clamp(run->top - top, -kStepMost, kStepMost));
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

/// At which a material stands: loose, and as rough as its smoothest half.
double standing_slope(const std::vector<MaterialDef>& materials, uint8_t material) {
    const MaterialDef& def = materials[std::min<size_t>(material, materials.size() - 1)];
    return std::tan(def.friction_angle_rad) + 0.5 * def.roughness;
}

Vec3 level_part(const GridFrame& frame, Vec3 velocity_m_s) {
    const Vec3 up = rotate(frame.grid_to_world.rotation, {0, 0, 1});
    return velocity_m_s - dot(velocity_m_s, up) * up;
}

bool is_moving(const GridFrame& frame, const GroundMotion& motion) {
    return std::max(motion.slip_m_s, length(level_part(frame, motion.velocity_m_s))) >= kRollLeast;
}

/// The highest voxel that a run reaches into.
int top_voxel(const Run& run) { return std::max(0, static_cast<int>(std::ceil(run.top)) - 1); }

}  // namespace

void read_motions(const GridColumns& grid, const TileSource& source, int tx, int ty,
                  std::vector<ColumnMotion>& motions) {
    motions.clear();
    for (int c = 0; c < kTileColumns; ++c) {
        const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
        const Run* run = top_run(grid, x, y);
        if (!run) continue;
        const GroundMotion motion = source.ground_motion(x, y);
        if (!is_moving(source.frame(), motion)) continue;
        motions.resize(kTileColumns);
        motions[static_cast<size_t>(c)] = {motion,
                                           source.dust_at(x, y, top_voxel(*run), run->material)};
    }
}

void find_rolling_soil(const GridColumns& grid, const TileSource& source, int tx, int ty,
                       std::span<const ColumnMotion> motions, std::vector<RollingSoil>& rolling) {
    rolling.clear();
    const GridFrame& frame = source.frame();
    const Quat& turn = frame.grid_to_world.rotation;
    for (size_t c = 0; c < motions.size(); ++c) {
        const int x = tx * kTileSide + static_cast<int>(c) % kTileSide;
        const int y = ty * kTileSide + static_cast<int>(c) / kTileSide;
        const auto [slip_m_s, momentum_m_s] = motions[c].motion;
        const Run* run = top_run(grid, x, y);
        if (!run || !is_moving(frame, motions[c].motion)) continue;
        const Vec3 level_m_s = level_part(frame, momentum_m_s);
        const double rise_x = rise_along(grid, x, y, 0, run->top),
                     rise_y = rise_along(grid, x, y, 1, run->top);
        const double gradient = std::hypot(rise_x, rise_y);
        const double stretch = std::hypot(1.0, gradient);
        const double level_speed = length(level_m_s);
        const double steep =
            (gradient - standing_slope(source.materials(), run->material)) / kSteepFull;
        const double amount = std::max(std::min(1.0, slip_m_s / kRollFull) * std::min(1.0, steep),
                                       std::min(1.0, level_speed / kRollFull));
        if (amount < kAmountLeast) continue;
        RollingSoil soil;
        soil.amount = static_cast<float>(amount);
        soil.normal = (1 / stretch) * rotate(turn, {-rise_x, -rise_y, 1});
        if (level_speed >= slip_m_s) {
            soil.velocity_m_s = momentum_m_s - dot(momentum_m_s, soil.normal) * soil.normal;
        } else if (gradient > kFlat) {
            soil.velocity_m_s = (slip_m_s / (gradient * stretch)) *
                                rotate(turn, {-rise_x, -rise_y, -gradient * gradient});
        } else {
            continue;
        }
        soil.center_m = frame.to_world({x + 0.5, y + 0.5, static_cast<double>(run->top)});
        soil.side_m = static_cast<float>(frame.voxel_m);
        soil.color = run->look.color;
        soil.dust = motions[c].dust;
        soil.seed = static_cast<uint32_t>(y * grid.size[0] + x);
        rolling.push_back(soil);
    }
}

}  // namespace bsoil::mesh
