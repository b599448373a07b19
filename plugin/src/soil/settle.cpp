// Which of what was filled may not stand, and letting it come to rest before anything depends on
// it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "base/check_range.h"
#include "bsoil/limits.h"
#include "soil/column_surface.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr int kNotRead = -1;
/// So few tiles asleep are not divided between threads.
constexpr size_t kTilesOfThread = 16;

/// Calls visit(tx, ty) for a tile and those around it.
template <typename Visit>
void for_each_around(const SoilCore& soil, int index, Visit&& visit) {
    const int tx = index % soil.tiles_x, ty = index / soil.tiles_x;
    for (int y = std::max(0, ty - 1); y <= std::min(soil.tiles_y - 1, ty + 1); ++y) {
        for (int x = std::max(0, tx - 1); x <= std::min(soil.tiles_x - 1, tx + 1); ++x) visit(x, y);
    }
}

/// Tops of the columns of tiles that nobody has looked at since soil was put there, and of those
/// around them. Each packed tile is looked at once however many share it.
class TopsOfTiles {
  public:
    explicit TopsOfTiles(Soil::Impl& soil) : soil_(soil), known_(soil.tiles.size(), kNotRead) {
        tops_.emplace_back();  // of bare floor
        for (size_t i = 0; i < soil.tiles.size(); ++i) {
            if (!soil.tiles[i] || !soil.tiles[i]->unchecked) continue;
            for_each_around(soil, static_cast<int>(i), [&](int tx, int ty) {
                const int index = soil.tile_index(tx, ty);
                int& known = known_[static_cast<size_t>(index)];
                if (known == kNotRead) known = place_of(index);
            });
        }
        read_asleep();
    }
    const TileTops& of(int index) const {
        return tops_[static_cast<size_t>(known_[static_cast<size_t>(index)])];
    }

  private:
    /// Of a tile's tops in tops_; of one asleep they are to be read.
    int place_of(int index) {
        if (!soil_.tiles[static_cast<size_t>(index)] && soil_.ground.is_over(index)) {
            soil_.tiles.make(index);
        }
        const Tile* tile = soil_.tiles[static_cast<size_t>(index)].get();
        if (!tile || (tile->slot < 0 && !tile->packed)) return 0;
        const auto place = static_cast<int>(tops_.size());
        if (tile->slot < 0) {
            const auto [entry, fresh] = by_content_.try_emplace(tile->packed.get(), place);
            if (!fresh) return entry->second;
            asleep_.push_back({index, place});
            tops_.emplace_back();
        } else {
            TileRuns runs;
            soil_.tiles.read_runs(index, runs);
            tops_.push_back(tile_tops(runs));
        }
        return place;
    }
    void read_asleep() {
        for_ranges(
            soil_.work_threads.get(), asleep_.size(), kTilesOfThread,
            [&](size_t first, size_t last) {
                TileRuns runs;
                for (const auto& [index, place] : std::span(asleep_).subspan(first, last - first)) {
                    soil_.tiles.read_asleep(index, runs);
                    tops_[static_cast<size_t>(place)] = tile_tops(runs);
                }
            });
    }

    struct Asleep {
        int index, place;
    };
    Soil::Impl& soil_;
    std::vector<int> known_;  ///< by tile: its place in tops_
    std::vector<TileTops> tops_;
    std::vector<Asleep> asleep_;
    std::unordered_map<const PackedTile*, int> by_content_;
};

}  // namespace

// Level ground sleeps from the start. What may move (hanging soil, and slopes steeper than the
// flattest angle of friction) is marked active; the step then decides.
void Soil::Impl::wake_unstable_columns() {
    tiles.any_unchecked = false;
    flows.look_anew();  // soil may have been put into a sink
    water.look_anew();  // and wet soil on dry
    double flattest = 10;
    for (const MaterialDef& material : materials) {
        flattest = std::min(flattest, std::tan(material.friction_angle_rad));
    }
    // Facets between two neighbours can be steeper than either by up to 1 / cos 22.5 deg.
    const double steep_q16 = 0.9 * flattest * kVoxelFull;
    const TopsOfTiles tops(*this);
    const auto activate_at = [&](int x, int y, int32_t z_q16) {
        const int zb = std::clamp(z_q16 / kVoxelFull / kTileSide, 0, blocks_per_tile - 1);
        lists.activate(block_key(tile_index(x / kTileSide, y / kTileSide), zb));
    };
    for (size_t i = 0; i < tiles.size(); ++i) {
        const int index = static_cast<int>(i);
        if (!tiles[i] || !tiles[i]->unchecked) continue;
        tiles[i]->unchecked = false;
        const int tx = index % tiles_x, ty = index / tiles_x;
        const TileTops& own = tops.of(index);
        for (int zb = 0; own.hangs && zb < blocks_per_tile; ++zb) {
            lists.activate(block_key(index, zb));
        }
        int32_t lowest = own.lowest_q16, highest = own.highest_q16;
        for_each_around(*this, index, [&](int nx, int ny) {
            const TileTops& other = tops.of(tile_index(nx, ny));
            lowest = std::min(lowest, other.lowest_q16);
            highest = std::max(highest, other.highest_q16);
        });
        if (highest - lowest <= steep_q16) {
            continue;  // nowhere among these tiles is a step that could be too high
        }
        for (int c = 0; c < kTileColumns; ++c) {
            const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
            if (x >= frame.size[0] || y >= frame.size[1]) continue;
            for (int n = 0; n < 9; ++n) {
                const int nx = x + n % 3 - 1, ny = y + n / 3 - 1;
                if (n == 4 || nx < 0 || ny < 0 || nx >= frame.size[0] || ny >= frame.size[1]) {
                    continue;
                }
                const TileTops& beside = tops.of(tile_index(nx / kTileSide, ny / kTileSide));
                const auto own_at = static_cast<size_t>(c);
                const auto at = static_cast<size_t>(ny % kTileSide * kTileSide + nx % kTileSide);
                const double drop = std::max(own.soil_q16[own_at] - beside.stop_q16[at],
                                             beside.soil_q16[at] - own.stop_q16[own_at]) /
                                    (n % 2 == 0 ? std::numbers::sqrt2 : 1.0);
                if (drop > steep_q16) {
                    activate_at(x, y, own.stop_q16[own_at]);
                    activate_at(nx, ny, beside.stop_q16[at]);
                }
            }
        }
    }
}

Result<SettleReport> Soil::Impl::settle(int steps_max, std::span<const SoilBody> input) {
    if (const Status in_range = check_range("steps_max", steps_max, 0, limits::kSettleStepsMax);
        !in_range) {
        return Error{in_range.error()};
    }
    finish();
    ground.meet(input);
    if (tiles.any_unchecked) wake_unstable_columns();
    std::vector<SoilBody> standing(input.begin(), input.end());
    for (SoilBody& body : standing) body.linear_velocity_m_s = body.angular_velocity_rad_s = {};
    SettleReport report;
    // Bodies that the soil has not met displace what they stand in; the ground it has met.
    report.is_at_rest = lists.active().empty() && !flows.may_work() &&
                        std::ranges::all_of(standing, [&](const SoilBody& body) {
                            const auto known = bodies.tracks().find(body.id);
                            return known != bodies.tracks().end() && known->second.is_ground;
                        });
    while (!report.is_at_rest && report.step_count < steps_max) {
        report.last_step = step(standing, 0);
        if (!device->failure().empty()) return Error{device->failure()};
        ++report.step_count;
        report.is_at_rest = lists.active().empty();
    }
    if (report.is_at_rest) {
        // What has come to rest need not wait for its time: hundreds of tiles would fall asleep in
        // one step.
        tiles.sleep_unused_since(step_index);
    }
    report.tile_awake_count = tiles.awake_count();
    report.block_active_count = static_cast<int>(lists.active().size());
    report.status_bits = conditions.bits();
    return report;
}

}  // namespace bsoil
