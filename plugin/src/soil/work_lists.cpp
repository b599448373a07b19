#include "soil/work_lists.h"

#include <algorithm>
#include <utility>

#include "soil/shape_bounds.h"

namespace bsoil {

using namespace layout;

namespace {

// Steps for which a block is active after its last change. What moves marks its block in every
// step.
constexpr int64_t kAwakeSteps = 3;

// Words of Buffer::block_list that a soil starts with; it grows by doubling.
constexpr size_t kListWordsAtStart = 16384;

/// Adds `block` to a work list being filled tile by tile.
class WorkListBuilder {
  public:
    WorkListBuilder(ListedWork& list, std::vector<int32_t>& words) : list_(list), words_(words) {
        list_.list_offset = static_cast<int>(words.size());
        list_.group_count = 0;
        for (auto& tiles : list_.tiles_by_colour) tiles.clear();
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

void WorkLists::start() { core_.ensure_capacity(Buffer::block_list, capacity_, kListWordsAtStart); }

// Device blocks come with every slot that the tile table grows by.
void WorkLists::fit() {
    const auto blocks = static_cast<size_t>(tiles_.block_count());
    if (listed_step_.size() != blocks) {
        for (auto* steps : {&listed_step_, &rebuild_step_, &contact_step_}) {
            steps->resize(blocks, 0);
        }
        keep_room_for(blocks);
    }
}

// Only blocks of awake tiles are active. How many are at most shows late: digging, after 13,000
// steps more of them than in any step before.
void WorkLists::keep_room_for(size_t block_count) {
    active_.reserve(block_count);
    sorted_active_.reserve(block_count);
    spare_.reserve(block_count);
    asked_.reserve((1 + kNeighbourCount) * block_count);  // and tiles beside those that are awake
    granted_.reserve((1 + kNeighbourCount) * block_count);
    while (active_.size() + spare_.size() < block_count) {
        std::unordered_map<BlockKey, int64_t> made{{0, 0}};
        spare_.push_back(made.extract(made.begin()));
    }
}

void WorkLists::find_body_blocks(const StepBody& body, bool may_wake,
                                 std::vector<BlockKey>& blocks) {
    blocks.clear();
    for (const ConvexShape& shape : body.shapes()) {
        const Aabb box = merge(shape_bounds(shape, body.from, core_.frame.voxel_m),
                               shape_bounds(shape, body.to, core_.frame.voxel_m));
        // One voxel more all around: the coverage gradient and the soil just outside.
        const BlockBox touched = core_.blocks_at(box, 1);
        touched.for_each_tile([&](int tx, int ty) {
            const int index = core_.tile_index(tx, ty);
            const Tile* tile = tiles_[index].get();
            const int top = tiles_.top_around(tx, ty);
            if (!tile || top + 2 < box.min.z || (may_wake ? tiles_.wake(index) : tile->slot) < 0) {
                return;
            }
            // Above the soil's top, with one block to spare for what is thrown up, there is
            // nothing to cover.
            const int zb_top = std::min(touched.high[2], top / kTileSide + 1);
            for (int zb = touched.low[2]; zb <= zb_top; ++zb) {
                blocks.push_back(core_.block_key(index, zb));
            }
        });
    }
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

// Where the soil's top sinks, or the body rises over it, a block leaves find_body_blocks() with
// coverage in it.
void WorkLists::keep_covered(const StepBody& body, std::span<const BlockKey> before,
                             std::vector<BlockKey>& blocks) {
    covered_blocks_.clear();
    for (const BlockKey key : before) {
        if (!std::binary_search(blocks.begin(), blocks.end(), key) && device_block(key) >= 0 &&
            touches(body, key)) {
            covered_blocks_.push_back(key);
        }
    }
    if (covered_blocks_.empty()) return;
    blocks.insert(blocks.end(), covered_blocks_.begin(), covered_blocks_.end());
    std::sort(blocks.begin(), blocks.end());
}

// As find_body_blocks() asks, however high the block is.
bool WorkLists::touches(const StepBody& body, BlockKey key) const {
    const auto tile = static_cast<int>(key / core_.blocks_per_tile);
    const int at[3] = {tile % core_.tiles_x, tile / core_.tiles_x,
                       static_cast<int>(key % core_.blocks_per_tile)};
    return std::ranges::any_of(body.shapes(), [&](const ConvexShape& shape) {
        const BlockBox touched =
            core_.blocks_at(merge(shape_bounds(shape, body.from, core_.frame.voxel_m),
                                  shape_bounds(shape, body.to, core_.frame.voxel_m)),
                            1);
        bool is_in = true;
        for (int i = 0; i < 3; ++i) {
            is_in = is_in && at[i] >= touched.low[i] && at[i] <= touched.high[i];
        }
        return is_in;
    });
}

int WorkLists::device_block(BlockKey key) const {
    const Tile* tile = tiles_[key / core_.blocks_per_tile].get();
    return tile && tile->slot >= 0
               ? tile->slot * core_.blocks_per_tile + static_cast<int>(key % core_.blocks_per_tile)
               : -1;
}

void WorkLists::mark_rebuild(const std::vector<BlockKey>& blocks, bool changes_soil) {
    fit();
    for (BlockKey key : blocks) {
        const int block = device_block(key);
        if (block >= 0) {
            rebuild_step_[block] = core_.step_index;
            if (changes_soil) activate(key);
        }
    }
}

void WorkLists::activate(BlockKey block) {
    granted_.clear();
    make_active(block);
}

// A bank asks again as soon as a tile under it is no longer listed, and in each look, whether or
// not any soil came of it before.
void WorkLists::grant_asked() {
    const auto known = static_cast<std::ptrdiff_t>(granted_.size());
    for (const BlockKey block : asked_) {
        if (!std::binary_search(granted_.begin(), granted_.begin() + known, block)) {
            granted_.push_back(block);
        }
    }
    if (std::ssize(granted_) > known) {
        std::sort(granted_.begin(), granted_.end());
        granted_.erase(std::unique(granted_.begin(), granted_.end()), granted_.end());
        for (const BlockKey block : asked_) make_active(block);
    }
    asked_.clear();
}

void WorkLists::make_active(BlockKey block) {
    if (const auto known = active_.find(block); known != active_.end()) {
        known->second = core_.step_index;
    } else if (spare_.empty()) {
        active_.emplace(block, core_.step_index);
    } else {
        auto entry = std::move(spare_.back());
        spare_.pop_back();
        entry.key() = block;
        entry.mapped() = core_.step_index;
        active_.insert(std::move(entry));
    }
}

void WorkLists::wake_active() {
    sorted_active_.clear();
    for (auto it = active_.begin(); it != active_.end();) {
        if (core_.step_index - it->second > kAwakeSteps) {
            spare_.push_back(active_.extract(it++));
        } else {
            sorted_active_.push_back(*it);
            ++it;
        }
    }
    std::sort(sorted_active_.begin(), sorted_active_.end());  // tiles wake in a fixed order
    waking_.clear();
    int last = -1;
    for (const auto& [key, step] : sorted_active_) {
        const int index = static_cast<int>(key / core_.blocks_per_tile);
        if (index == std::exchange(last, index)) continue;
        core_.tiles_around(index % core_.tiles_x, index / core_.tiles_x)
            .for_each_tile([&](int tx, int ty) {
                const Tile* tile = tiles_[core_.tile_index(tx, ty)].get();
                if (!tile || !tile->is_awake()) waking_.push_back(core_.tile_index(tx, ty));
            });
    }
    tiles_.wake_ahead(waking_);
    // By place: a tile that wakes may make the table grow, and fit() this list with it.
    for (size_t i = 0; i < sorted_active_.size(); ++i) {
        const BlockKey key = sorted_active_[i].first;
        const int index = static_cast<int>(key / core_.blocks_per_tile);
        const int zb = static_cast<int>(key % core_.blocks_per_tile);
        core_.tiles_around(index % core_.tiles_x, index / core_.tiles_x)
            .for_each_tile([&](int tx, int ty) {
                const int slot = tiles_.wake(core_.tile_index(tx, ty));
                fit();
                for (int z = std::max(0, zb - 1);
                     slot >= 0 && z <= std::min(core_.blocks_per_tile - 1, zb + 1); ++z) {
                    listed_step_[static_cast<size_t>(slot) * core_.blocks_per_tile + z] =
                        core_.step_index;
                }
            });
    }
    active_count_ = static_cast<int>(sorted_active_.size());
}

void WorkLists::mark_bodies(std::span<StepBody> bodies) {
    for (StepBody& body : bodies) {
        std::vector<BlockKey>& before = body.track->blocks;
        find_body_blocks(body, body.moved || !body.input->is_static, body_blocks_);
        if (body.moved) {
            mark_rebuild(before, true);
            mark_rebuild(body_blocks_, true);
        } else {
            fresh_blocks_.clear();
            std::set_difference(body_blocks_.begin(), body_blocks_.end(), before.begin(),
                                before.end(), std::back_inserter(fresh_blocks_));
            mark_rebuild(body.turned_static ? body_blocks_ : fresh_blocks_, false);
        }
        keep_covered(body, before, body_blocks_);
        before = body_blocks_;
    }
}

// A tile that woke just now has no coverage yet, and its bodies may not have been looked up with it
// awake.
void WorkLists::mark_woken(std::span<StepBody> bodies) {
    fit();
    for (StepBody& body : bodies) {
        std::vector<BlockKey>& blocks = body.track->blocks;
        find_body_blocks(body, false, body_blocks_);
        if (!body.input->is_static) mark_contacts(body_blocks_);
        keep_covered(body, blocks, body_blocks_);
        blocks = body_blocks_;
        for (BlockKey key : blocks) {
            const int block = device_block(key);
            if (tiles_.woke_in_this_step(block / core_.blocks_per_tile)) {
                rebuild_step_[block] = core_.step_index;
            }
        }
    }
}

// In a tile all blocks from a body's lowest up to the top of the soil: a body carries what lies on
// it, however high.
void WorkLists::mark_contacts(std::span<const BlockKey> blocks) {
    for (size_t i = 0; i < blocks.size();) {  // sorted
        const auto tile = static_cast<size_t>(blocks[i] / core_.blocks_per_tile);
        const BlockKey first = blocks[i];
        while (i + 1 < blocks.size() &&
               static_cast<size_t>(blocks[i + 1] / core_.blocks_per_tile) == tile) {
            ++i;
        }
        const BlockKey top =
            core_.block_key(static_cast<int>(tile),
                            std::min(core_.blocks_per_tile - 1, tiles_[tile]->top / kTileSide + 1));
        for (BlockKey key = first; key <= std::max(top, blocks[i]); ++key) {
            contact_step_[static_cast<size_t>(device_block(key))] = core_.step_index;
        }
        ++i;
    }
}

void WorkLists::mark_all() {
    fit();
    for (auto* steps : {&listed_step_, &rebuild_step_, &contact_step_}) {
        std::ranges::fill(*steps, core_.step_index);
    }
}

void WorkLists::build() {
    fit();
    const std::span<const int> slot_tile = tiles_.slot_tiles();
    words_.clear();
    uploaded_ = 0;
    listed_flags_.assign(static_cast<size_t>(tiles_.block_count()), 0);
    const auto build = [&](ListedWork& list, auto&& wanted) {
        WorkListBuilder builder(list, words_);
        for (int slot = 0; slot < tiles_.slot_count(); ++slot) {
            if (slot_tile[slot] < 0) continue;
            builder.begin_tile(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
            for (int zb = 0; zb < core_.blocks_per_tile; ++zb) {
                const int block = slot * core_.blocks_per_tile + zb;
                if (wanted(block)) builder.add(block);
            }
            builder.end_tile();
        }
    };
    build(listed_, [&](int block) {
        const bool listed = listed_step_[block] == core_.step_index;
        listed_flags_[block] = listed;
        return listed;
    });
    build(rebuild_, [&](int block) { return rebuild_step_[block] == core_.step_index; });
    build(contact_, [&](int block) { return contact_step_[block] == core_.step_index; });
    WorkListBuilder builder(tile_, words_);
    for (int slot = 0; slot < tiles_.slot_count(); ++slot) {
        if (slot_tile[slot] < 0) continue;
        builder.begin_tile(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
        // The lowest block in which support can have changed; all of them in a tile that has just
        // woken, or whose soil has been changed from outside.
        int lowest = tiles_.woke_in_this_step(slot) ? 0 : -1;
        for (int zb = 0; zb < core_.blocks_per_tile && lowest < 0; ++zb) {
            const size_t block = static_cast<size_t>(slot) * core_.blocks_per_tile + zb;
            lowest =
                listed_flags_[block] != 0 || rebuild_step_[block] == core_.step_index ? zb : -1;
        }
        if (lowest >= 0) tiles_[slot_tile[slot]]->last_used_step = core_.step_index;
        if (tiles_.is_edited(slot)) lowest = 0;
        if (lowest >= 0) {
            const int top =
                tiles_.top_around(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
            const int highest = std::min(core_.blocks_per_tile, top / kTileSide + 2);
            builder.add((slot * kTileWord + lowest) * kTileWord + highest);
            tiles_.note_look(slot, highest);
        }
        builder.end_tile();
    }
    list_restored();
    used_ = words_.size();
    // Nobody else sets them, and what is allocated anew is zero.
    const bool lists_any = listed_.group_count > 0;
    if (lists_any || device_lists_any_) {
        core_.device->write(Buffer::block_flags,
                            static_cast<int64_t>(kFlagListed) * listed_flags_.size(),
                            listed_flags_);
    }
    device_lists_any_ = lists_any;
}

// Once after a load. A step that slipped in them, too, would go on otherwise than the saved run:
// dust that never leaves a steep slope counts where it is looked at (kResultSlope).
void WorkLists::list_restored() {
    WorkListBuilder builder(restored_, words_);
    if (!tiles_.any_restored()) return;
    const std::span<const int> slot_tile = tiles_.slot_tiles();
    std::vector<bool> is_listed(slot_tile.size(), false);
    for (int i = 0; i < tile_.group_count; ++i) {
        const int32_t entry = words_[static_cast<size_t>(tile_.list_offset + i)];
        is_listed[static_cast<size_t>(entry / kTileWord / kTileWord)] = true;
    }
    for (int slot = 0; slot < tiles_.slot_count(); ++slot) {
        if (is_listed[static_cast<size_t>(slot)] || !tiles_.is_restored(slot)) continue;
        builder.begin_tile(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
        builder.add(slot * kTileWord * kTileWord + tiles_.looked_blocks(slot));
        builder.end_tile();
    }
    tiles_.forget_restored();
}

void WorkLists::add_list(ListedWork& list, std::span<const std::pair<int32_t, int32_t>> groups) {
    const std::span<const int> slot_tile = tiles_.slot_tiles();
    WorkListBuilder builder(list, words_);
    for (size_t i = 0; i < groups.size();) {
        const int slot = groups[i].first;
        builder.begin_tile(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
        for (; i < groups.size() && groups[i].first == slot; ++i) {
            builder.add(groups[i].first, groups[i].second);
        }
        builder.end_tile();
    }
    used_ = words_.size();
}

void WorkLists::list_small_bodies(std::span<const StepBody> bodies) {
    slot_bodies_.clear();
    for (const StepBody& body : bodies) {
        const auto place = small_body_place(core_, body);
        const Tile* tile = place ? tiles_[place->tile].get() : nullptr;
        if (tile && tile->slot >= 0) slot_bodies_.push_back({tile->slot, body.track->index});
    }
    std::sort(slot_bodies_.begin(), slot_bodies_.end());
    add_list(small_body_, slot_bodies_);
}

// (block, shape) pairs of the blocks whose coverage is made anew.
void WorkLists::build_pairs(const ShapeUpload& shapes) {
    const std::span<const int> slot_tile = tiles_.slot_tiles();
    words_.resize(used_);
    std::vector<std::pair<int32_t, int32_t>>& pairs = block_shapes_;
    pairs.clear();
    for (size_t s = 0; s < shapes.boxes().size(); ++s) {
        const BlockBox touched = core_.blocks_at(shapes.boxes()[s]);
        touched.for_each_tile([&](int tx, int ty) {
            const Tile* tile = tiles_[core_.tile_index(tx, ty)].get();
            if (!tile || tile->slot < 0) return;
            for (int zb = touched.low[2]; zb <= touched.high[2]; ++zb) {
                const int block = tile->slot * core_.blocks_per_tile + zb;
                const Vec3 middle = Vec3{tx + 0.5, ty + 0.5, zb + 0.5} * kTileSide;
                if (rebuild_step_[block] == core_.step_index && shapes.may_cover(s, middle)) {
                    pairs.push_back({block, static_cast<int32_t>(s)});
                }
            }
        });
    }
    std::sort(pairs.begin(), pairs.end());
    WorkListBuilder builder(pair_, words_);
    for (size_t i = 0; i < pairs.size();) {
        const int slot = pairs[i].first / core_.blocks_per_tile;
        builder.begin_tile(slot_tile[slot] % core_.tiles_x, slot_tile[slot] / core_.tiles_x);
        for (; i < pairs.size() && pairs[i].first / core_.blocks_per_tile == slot; ++i) {
            builder.add(pairs[i].first, pairs[i].second);
        }
        builder.end_tile();
    }
    if (words_.size() > capacity_) {
        core_.ensure_capacity(Buffer::block_list, capacity_, words_.size());
        uploaded_ = 0;
    }
    const size_t from = uploaded_;
    core_.device->write(Buffer::block_list, static_cast<int64_t>(from),
                        std::span<const int32_t>(words_).subspan(from));
    uploaded_ = used_;
}

void WorkLists::restart(std::unordered_map<BlockKey, int64_t> active,
                        std::span<const BlockKey> granted) {
    active_ = std::move(active);
    granted_.assign(granted.begin(), granted.end());
    keep_room_for(listed_step_.size());
    for (auto* steps : {&listed_step_, &rebuild_step_, &contact_step_}) {
        std::ranges::fill(*steps, 0);
    }
}

}  // namespace bsoil
