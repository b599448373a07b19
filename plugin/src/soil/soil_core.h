/// SoilCore: what all parts of a soil share.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/layout.h"
#include "bsoil/soil.h"
#include "bsoil/work_threads.h"
#include "device/device.h"
#include "soil/condition_log.h"

namespace bsoil {

/// A block of 8 x 8 x 8 voxels by its place: index of its tile * blocks per tile + z / 8.
using BlockKey = int64_t;

/// The stamp protocol. SoilParams::pass_stamp counts the passes that move soil; each leaves it with
/// the columns that it changes (kColumnStamp). A kernel that only looks for work is told the pass
/// before its last look, and leaves out the columns that have not changed since. No one else writes
/// these members of SoilParams.
class PassStamps {
  public:
    /// Who looks. Slip passes over several voxels at once see other slopes than those over one.
    enum class Looker { support, spans, failures, slip, slip_far, slide, count };

    explicit PassStamps(layout::SoilParams& params) : params_(params) {}

    /// Before the kernel of this looker runs: all that changed since it last ran.
    void begin_look(Looker looker);
    /// Before one that leaves some of it out: it is told the same, and the next look what it would
    /// have been told without it.
    void begin_partial_look(Looker looker) {
        told(looker) = last_look_[static_cast<size_t>(looker)];
    }
    /// Chances in a step hang on it and on the passes in it that move soil, and not on who has
    /// looked how often before.
    void begin_step(int64_t step_index) {
        constexpr int64_t kPassesAStep = 1024;
        params_.chance = static_cast<int32_t>(static_cast<uint32_t>(step_index * kPassesAStep));
    }
    /// Before a kernel that moves soil.
    void begin_pass() {
        ++params_.pass_stamp;
        ++params_.chance;
    }
    /// Before one that changes columns without moving soil.
    void begin_change() { ++params_.pass_stamp; }
    /// Every looker looks at everything. The columns' stamps have to be cleared as well.
    void forget();
    /// From the first pass again; the columns' stamps have to be cleared.
    void restart() { params_.pass_stamp = 0; }
    bool are_used_up() const { return params_.pass_stamp > 1 << 30; }

  private:
    int32_t& told(Looker looker);

    layout::SoilParams& params_;
    std::array<int32_t, static_cast<size_t>(Looker::count)> last_look_ = {-1, -1, -1, -1, -1, -1};
};

/// Stamps are kept within 20 bits because the tile tops share their word with them; see
/// kTileTableTop.
inline constexpr int64_t kStampWrap = (1 << 20) - 2;
/// SoilParams::step_stamp in a step.
constexpr int32_t step_stamp_of(int64_t step_index) {
    return static_cast<int32_t>(step_index % kStampWrap + 1);
}

/// Tiles x, y and blocks z, all inclusive. Without any: empty ranges.
struct BlockBox {
    int low[3] = {0, 0, 0};
    int high[3] = {-1, -1, -1};

    template <typename Visit>
    void for_each_tile(Visit&& visit) const {
        for (int ty = low[1]; ty <= high[1]; ++ty) {
            for (int tx = low[0]; tx <= high[0]; ++tx) visit(tx, ty);
        }
    }
};

/// The definition of a soil, its grid and its device, and the step that it is in.
struct SoilCore {
    SoilDef def;
    std::vector<MaterialDef> materials;
    GridFrame frame;
    Pose world_to_grid;  ///< of metres
    double kg_per_unit = 0;
    int height = 0, tiles_x = 0, tiles_y = 0, blocks_per_tile = 0, kept_planes = 0;
    std::unique_ptr<device::Device> device;
    std::unique_ptr<WorkThreads> work_threads;
    layout::SoilParams params{};
    PassStamps stamps{params};
    ConditionLog conditions;
    int64_t step_index = 0;
    int due_count = 1;  ///< steps that were due since the last one began: more by StepBudget alone
    uint64_t def_revision = 0;    ///< of def, see Soil::change()
    uint64_t state_revision = 0;  ///< see Soil::state_revision()
    // What the last step left.
    int64_t speed_q16 = 0;  ///< fastest soil, Q16 voxels a base step
    int32_t slope_q16 = 0;  ///< steepest failing wedge, Q16 voxels above a stable one
    int32_t slide_q16 = 0;  ///< fastest slide, Q16 voxels a base step

    SoilCore() = default;
    SoilCore(const SoilCore&) = delete;
    SoilCore& operator=(const SoilCore&) = delete;

    int tile_count() const { return tiles_x * tiles_y; }
    int tile_index(int tx, int ty) const { return ty * tiles_x + tx; }
    BlockKey block_key(int tile, int zb) const {
        return static_cast<BlockKey>(tile) * blocks_per_tile + zb;
    }
    Vec3 to_grid(Vec3 world) const { return transform(world_to_grid, world) * (1 / frame.voxel_m); }

    /// Tiles and blocks that a box [voxels], grown by `margin` to all sides, touches; none where
    /// the box lies outside of the grid.
    BlockBox blocks_at(const Aabb& box, double margin = 0) const;
    /// A tile and those around it.
    BlockBox tiles_around(int tx, int ty) const;

    /// Makes room for `words` words in a buffer that grows by doubling. Its content is lost then.
    /// The device is lost where it has no memory for them: no step can do without.
    void ensure_capacity(device::BufferIndex buffer, size_t& capacity, size_t words);
};

}  // namespace bsoil
