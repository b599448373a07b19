// The lists of a step: blocks that bodies touch, blocks that may move, and the groups that kernels
// run over.
#include <algorithm>
#include <bit>
#include <cmath>

#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;

namespace {

// A block that has not changed for so many steps needs no more passes: what moves marks its block
// every step.
constexpr int64_t kAwakeSteps = 3;

/// Adds `block` to a work list being filled tile by tile.
class WorkListBuilder {
  public:
    WorkListBuilder(ListedWork& list, std::vector<int32_t>& words) : list_(list), words_(words) {
        list_.list_offset = static_cast<int>(words.size());
        list_.group_count = 0;
        for (auto& tiles : list_.tiles_by_colour) {
            tiles.clear();
        }
    }
    void begin_tile(int tx, int ty) {
        colour_ = (tx & 1) + 2 * (ty & 1);
        first_ = list_.group_count;
    }
    void add(int32_t word) {
        words_.push_back(word);
        ++list_.group_count;
    }
    void add(int32_t word, int32_t second) {
        words_.push_back(word);
        add(second);
    }
    void end_tile() {
        if (list_.group_count > first_) {
            list_.tiles_by_colour[colour_].push_back({first_, list_.group_count - first_});
        }
    }

  private:
    ListedWork& list_;
    std::vector<int32_t>& words_;
    int colour_ = 0, first_ = 0;
};

}  // namespace

// Height to which soil may reach in a tile within this step: what lies next to it, in a bucket high
// above the ground maybe, may come over.
int Soil::Impl::top_around(int tx, int ty) const {
    int top = 0;
    for (int ny = std::max(0, ty - 1); ny <= std::min(tiles_y - 1, ty + 1); ++ny) {
        for (int nx = std::max(0, tx - 1); nx <= std::min(tiles_x - 1, tx + 1); ++nx) {
            const Tile* tile = tiles[tile_index(nx, ny)].get();
            top = std::max(top, tile ? tile->top : 0);
        }
    }
    return top;
}

// Blocks of awake (or, for bodies that can move soil, waking) tiles that the body's shapes touch
// and that are near soil.
void Soil::Impl::find_body_blocks(const StepBody& body, bool may_wake,
                                  std::vector<BlockKey>& blocks) {
    blocks.clear();
    for (const ConvexShape& shape : body.shapes()) {
        const Aabb box = merge(shape_bounds(shape, body.from, frame.voxel_m),
                               shape_bounds(shape, body.to, frame.voxel_m));
        if (box.max.x < 0 || box.max.y < 0 || box.max.z < 0 || box.min.x > frame.size[0] ||
            box.min.y > frame.size[1] || box.min.z > height) {
            continue;
        }
        // One voxel more all around: the coverage gradient and the soil just outside.
        const int tx0 = clamped_floor((box.min.x - 1) / kTileSide, 0, tiles_x - 1);
        const int tx1 = clamped_floor((box.max.x + 1) / kTileSide, 0, tiles_x - 1);
        const int ty0 = clamped_floor((box.min.y - 1) / kTileSide, 0, tiles_y - 1);
        const int ty1 = clamped_floor((box.max.y + 1) / kTileSide, 0, tiles_y - 1);
        const int zb0 = clamped_floor((box.min.z - 1) / kTileSide, 0, blocks_per_tile - 1);
        const int zb1 = clamped_floor((box.max.z + 1) / kTileSide, 0, blocks_per_tile - 1);
        for (int ty = ty0; ty <= ty1; ++ty) {
            for (int tx = tx0; tx <= tx1; ++tx) {
                const int index = tile_index(tx, ty);
                const Tile* tile = tiles[index].get();
                const int top = top_around(tx, ty);
                if (!tile || top + 2 < box.min.z || (may_wake ? wake(index) : tile->slot) < 0) {
                    continue;
                }
                // Above the soil's top, with one block to spare for what is thrown up, there is
                // nothing to cover.
                const int zb_top = std::min(zb1, top / kTileSide + 1);
                for (int zb = zb0; zb <= zb_top; ++zb) {
                    blocks.push_back(static_cast<BlockKey>(index) * blocks_per_tile + zb);
                }
            }
        }
    }
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

int Soil::Impl::device_block(BlockKey key) const {
    const Tile* tile = tiles[key / blocks_per_tile].get();
    return tile && tile->slot >= 0
               ? tile->slot * blocks_per_tile + static_cast<int>(key % blocks_per_tile)
               : -1;
}

void Soil::Impl::mark_rebuild(const std::vector<BlockKey>& blocks, bool changes_soil) {
    for (BlockKey key : blocks) {
        const int block = device_block(key);
        if (block >= 0) {
            rebuild_step[block] = step_index;
            if (changes_soil) {
                activate(key);
            }
        }
    }
}

void Soil::Impl::activate(BlockKey block) {
    if (const auto known = active.find(block); known != active.end()) {
        known->second = step_index;
    } else if (active_spare.empty()) {
        active.emplace(block, step_index);
    } else {
        auto entry = std::move(active_spare.back());
        active_spare.pop_back();
        entry.key() = block;
        entry.mapped() = step_index;
        active.insert(std::move(entry));
    }
}

void Soil::Impl::list_active_blocks() {
    std::vector<std::pair<BlockKey, int64_t>>& entries = active_scratch;
    entries.clear();
    for (auto it = active.begin(); it != active.end();) {
        if (step_index - it->second > kAwakeSteps) {
            active_spare.push_back(active.extract(it++));
        } else {
            entries.push_back(*it);
            ++it;
        }
    }
    std::sort(entries.begin(), entries.end());  // tiles wake in a fixed order
    for (const auto& [key, changed] : entries) {
        const int index = static_cast<int>(key / blocks_per_tile);
        const int zb = static_cast<int>(key % blocks_per_tile);
        const int tx = index % tiles_x, ty = index / tiles_x;
        for (int ny = std::max(0, ty - 1); ny <= std::min(tiles_y - 1, ty + 1); ++ny) {
            for (int nx = std::max(0, tx - 1); nx <= std::min(tiles_x - 1, tx + 1); ++nx) {
                const int slot = wake(tile_index(nx, ny));
                for (int z = std::max(0, zb - 1);
                     slot >= 0 && z <= std::min(blocks_per_tile - 1, zb + 1); ++z) {
                    listed_step[static_cast<size_t>(slot) * blocks_per_tile + z] = step_index;
                }
            }
        }
    }
    block_active_count = static_cast<int>(entries.size());
}

void Soil::Impl::build_work_lists() {
    block_words.clear();
    flag_words.assign(static_cast<size_t>(slot_count) * blocks_per_tile, 0);
    const auto build = [&](ListedWork& list, auto&& wanted) {
        WorkListBuilder builder(list, block_words);
        for (int slot = 0; slot < slot_count; ++slot) {
            if (slot_tile[slot] < 0) {
                continue;
            }
            builder.begin_tile(slot_tile[slot] % tiles_x, slot_tile[slot] / tiles_x);
            for (int zb = 0; zb < blocks_per_tile; ++zb) {
                const int block = slot * blocks_per_tile + zb;
                if (wanted(block)) {
                    builder.add(block);
                }
            }
            builder.end_tile();
        }
    };
    build(listed_work, [&](int block) {
        const bool listed = listed_step[block] == step_index;
        flag_words[block] = listed;
        return listed;
    });
    build(rebuild_work, [&](int block) { return rebuild_step[block] == step_index; });
    build(contact_work, [&](int block) { return contact_step[block] == step_index; });
    WorkListBuilder builder(tile_work, block_words);
    for (int slot = 0; slot < slot_count; ++slot) {
        if (slot_tile[slot] < 0) {
            continue;
        }
        builder.begin_tile(slot_tile[slot] % tiles_x, slot_tile[slot] / tiles_x);
        // The lowest block in which support can have changed; all of them in a tile that has just
        // woken.
        int lowest = woken_step[slot] == step_index ? 0 : -1;
        for (int zb = 0; zb < blocks_per_tile && lowest < 0; ++zb) {
            const size_t block = static_cast<size_t>(slot) * blocks_per_tile + zb;
            lowest = flag_words[block] != 0 || rebuild_step[block] == step_index ? zb : -1;
        }
        if (lowest >= 0) {
            const int top = top_around(slot_tile[slot] % tiles_x, slot_tile[slot] / tiles_x);
            const int highest = std::min(blocks_per_tile, top / kTileSide + 2);
            builder.add((slot * kTileWord + lowest) * kTileWord + highest);
            if (looked_step[slot] != step_index - 1 || looked_blocks[slot] != highest) {
                stamp_columns(slot);
            }
            looked_step[slot] = step_index;
            looked_blocks[slot] = highest;
            tiles[slot_tile[slot]]->last_used_step = step_index;
        }
        builder.end_tile();
    }
    list_words_used = block_words.size();
    device->write(Buffer::block_flags, static_cast<int64_t>(kFlagListed) * flag_words.size(),
                  flag_words);
}

// Whether a shape may cover voxels of the block whose middle this is [voxels]. It stands in a box
// of its own frame, and a hull behind its faces; a lattice is not asked.
bool Soil::Impl::may_cover(size_t shape, const Vec3& block_middle) const {
    constexpr double kReach = 1;  // of a distance beyond a shape's surface: 0.775 in the kernel
    const int32_t* record =
        &shape_words[static_cast<size_t>(params.shape_offset) + shape * kShapeWords];
    const auto kind = static_cast<ConvexShape::Kind>(record[kShapeKind]);
    const auto number = [&](int at) { return double{std::bit_cast<float>(record[at])}; };
    const double size[3] = {number(kShapeSize), number(kShapeSize + 1), number(kShapeSize + 2)};
    const double reach = number(kShapeRounding) + kReach;
    using Kind = ConvexShape::Kind;
    if (kind == Kind::lattice) {
        return true;
    }
    double middle[3];
    double half[3];  // the block's half extents along the shape's axes
    for (int i = 0; i < 3; ++i) {
        const int row = kShapeRows + 4 * i;
        const Vec3 axis{number(row), number(row + 1), number(row + 2)};
        middle[i] = dot(axis, block_middle) + number(row + 3);
        half[i] = kTileSide / 2.0 * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
    }
    if (kind == Kind::hull) {
        // The block's corners along a face's normal, in the shape's frame.
        const Vec3 columns[3] = {
            {number(kShapeRows), number(kShapeRows + 4), number(kShapeRows + 8)},
            {number(kShapeRows + 1), number(kShapeRows + 5), number(kShapeRows + 9)},
            {number(kShapeRows + 2), number(kShapeRows + 6), number(kShapeRows + 10)}};
        for (int i = 0; i < record[kShapePlanes + 1]; ++i) {
            const int32_t* face =
                &shape_words[static_cast<size_t>(record[kShapePlanes] + kFaceWords * i)];
            const auto word = [&](int at) { return double{std::bit_cast<float>(face[at])}; };
            const Vec3 normal{word(0), word(1), word(2)};
            const double side = dot(normal, Vec3{middle[0], middle[1], middle[2]}) - word(3);
            const double width = std::abs(dot(normal, columns[0])) +
                                 std::abs(dot(normal, columns[1])) +
                                 std::abs(dot(normal, columns[2]));
            if (side - kTileSide / 2.0 * width > reach) {
                return false;
            }
        }
        return true;
    }
    const bool is_box = kind == Kind::box;
    const double top = is_box                  ? size[2]
                       : kind == Kind::sphere  ? size[0]
                       : kind == Kind::capsule ? size[0] + size[1]
                                               : size[1];
    const double extents[3] = {size[0], is_box ? size[1] : size[0], top};
    for (int i = 0; i < 3; ++i) {
        if (std::abs(middle[i]) - half[i] - extents[i] > reach) {
            return false;
        }
    }
    return true;
}

// (block, shape) pairs of the blocks whose coverage is made anew.
void Soil::Impl::build_pairs() {
    block_words.resize(list_words_used);
    std::vector<std::pair<int32_t, int32_t>>& pairs = pair_scratch;
    pairs.clear();
    for (size_t s = 0; s < shape_boxes.size(); ++s) {
        const Aabb& box = shape_boxes[s];
        if (box.max.x < 0 || box.max.y < 0 || box.max.z < 0 || box.min.x > frame.size[0] ||
            box.min.y > frame.size[1] || box.min.z > height) {
            continue;
        }
        const int tx0 = clamped_floor(box.min.x / kTileSide, 0, tiles_x - 1);
        const int tx1 = clamped_floor(box.max.x / kTileSide, 0, tiles_x - 1);
        const int ty0 = clamped_floor(box.min.y / kTileSide, 0, tiles_y - 1);
        const int ty1 = clamped_floor(box.max.y / kTileSide, 0, tiles_y - 1);
        const int zb0 = clamped_floor(box.min.z / kTileSide, 0, blocks_per_tile - 1);
        const int zb1 = clamped_floor(box.max.z / kTileSide, 0, blocks_per_tile - 1);
        for (int ty = ty0; ty <= ty1; ++ty) {
            for (int tx = tx0; tx <= tx1; ++tx) {
                const Tile* tile = tiles[tile_index(tx, ty)].get();
                if (!tile || tile->slot < 0) {
                    continue;
                }
                for (int zb = zb0; zb <= zb1; ++zb) {
                    const int block = tile->slot * blocks_per_tile + zb;
                    const Vec3 middle = Vec3{tx + 0.5, ty + 0.5, zb + 0.5} * kTileSide;
                    if (rebuild_step[block] == step_index && may_cover(s, middle)) {
                        pairs.push_back({block, static_cast<int32_t>(s)});
                    }
                }
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    WorkListBuilder builder(pair_work, block_words);
    for (size_t i = 0; i < pairs.size();) {
        const int slot = pairs[i].first / blocks_per_tile;
        builder.begin_tile(slot_tile[slot] % tiles_x, slot_tile[slot] / tiles_x);
        for (; i < pairs.size() && pairs[i].first / blocks_per_tile == slot; ++i) {
            builder.add(pairs[i].first, pairs[i].second);
        }
        builder.end_tile();
    }
    if (block_words.size() > lists_capacity) {
        ensure_capacity(Buffer::block_list, lists_capacity, block_words.size());
        list_words_uploaded = 0;
    }
    const size_t from = list_words_uploaded;
    device->write(Buffer::block_list, static_cast<int64_t>(from),
                  std::span<const int32_t>(block_words).subspan(from));
    list_words_uploaded = list_words_used;
}

}  // namespace bsoil
