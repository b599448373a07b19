#include "soil/ground_bodies.h"

#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"
#include "soil/ground_coverage.h"
#include "soil/shape_bounds.h"

namespace bsoil {

using namespace layout;

namespace {

// A static body that its host moves pushes soil aside like any other body. This is how many steps
// after its last move it is ground again.
constexpr int64_t kGroundAfterSteps = 30;

/// Takes `part` of `whole` parts of a voxel's soil out of `from`.
void move_soil(TileVoxels& from, TileVoxels& to, size_t voxel, int part, int whole) {
    const size_t plane_words = from.words.size() / static_cast<size_t>(from.plane_count);
    for (int p = kKeptVolume; p < from.plane_count; ++p) {
        int32_t& word = from.words[static_cast<size_t>(p) * plane_words + voxel];
        const bool moves_on = p == kKeptVolume || p >= kKeptBond;  // not momentum and force
        const auto share = static_cast<int32_t>(int64_t{word} * part / whole);
        word -= share;
        if (moves_on) to.words[static_cast<size_t>(p) * plane_words + voxel] += share;
    }
}

/// Tiles asleep that are changed at a time. Ours: a few for each thread of any machine. Larger:
/// more covers, 20 kB each, are kept until then; smaller: threads wait for the last.
constexpr size_t kBatchTiles = 256;

}  // namespace

bool GroundBodies::Shape::is_over(int tx, int ty) const {
    return box.max.x > tx * kTileSide && box.max.y > ty * kTileSide &&
           box.min.x < (tx + 1) * kTileSide && box.min.y < (ty + 1) * kTileSide;
}

void GroundBodies::update(std::vector<StepBody>& step_bodies) {
    bool any_changed = false;
    for (StepBody& body : step_bodies) {
        BodyTrack& track = *body.track;
        if (body.moved && !body.placed) track.last_moved_step = core_.step_index;
        const bool rests =
            body.placed ||
            (!body.moved && core_.step_index - track.last_moved_step > kGroundAfterSteps) ||
            (!body.moved && track.is_ground);
        const bool is_ground = body.input->is_static && rests;
        if (is_ground == track.is_ground && !(is_ground && body.placed)) {
            if (is_ground && track.ground_shapes.empty()) {  // after load(): the tiles know it
                keep_shapes(body);
            }
            continue;
        }
        any_changed = true;
        if (track.is_ground) {
            mark(track);
            track.ground_shapes.clear();
            body.moved = true;  // soil that was buried in it has to make room
        }
        if (is_ground) {
            lists_.mark_rebuild(track.blocks, false);  // no coverage of its own any more
            track.blocks.clear();
            keep_shapes(body);
            mark(track);
        }
        track.is_ground = is_ground;
    }
    if (any_changed) {
        is_listed_ = false;
        tiles_.note_edit();
    }
    std::erase_if(step_bodies, [](const StepBody& body) { return body.track->is_ground; });
    stamp();
}

void GroundBodies::meet(std::span<const SoilBody> input) {
    std::vector<StepBody> fresh;
    for (const SoilBody& body : input) {
        if (!body.is_static || bodies_.knows(body.id) || !bodies_.accept(body) ||
            bodies_.tracks().size() >= limits::kBodyCapacity) {
            continue;
        }
        BodyTrack& track = bodies_.add(body);
        fresh.push_back({&body, &track, track.pose, track.pose, true, true});
    }
    update(fresh);
}

void GroundBodies::keep_shapes(const StepBody& body) {
    BodyTrack& track = *body.track;
    track.ground_pose = body.to;
    track.ground_shapes = body.shapes();
    is_listed_ = false;
}

// Tiles under a body that becomes ground, or was it, have to look again.
void GroundBodies::mark(const BodyTrack& track) {
    is_listed_ = false;
    any_due_ = true;
    if (track.ground_shapes.empty()) {  // it went before load() could see it again
        for (const auto& tile : tiles_) {
            if (tile) tile->ground_due = true;
        }
        return;
    }
    for (const ConvexShape& shape : track.ground_shapes) {
        core_.blocks_at(shape_bounds(shape, track.ground_pose, core_.frame.voxel_m))
            .for_each_tile([&](int tx, int ty) {
                if (Tile* tile = tiles_[core_.tile_index(tx, ty)].get()) tile->ground_due = true;
            });
    }
}

const std::vector<GroundBodies::Shape>& GroundBodies::shapes() {
    if (!is_listed_) {
        shapes_.clear();
        for (const auto& [id, track] : bodies_.tracks()) {
            for (const ConvexShape& shape : track.ground_shapes) {
                const Aabb box = shape_bounds(shape, track.ground_pose, core_.frame.voxel_m);
                if (box.max.z > 0 && box.min.z < core_.height) {
                    shapes_.push_back({&shape, track.ground_pose, box});
                }
            }
        }
        is_listed_ = true;
    }
    return shapes_;
}

void GroundBodies::stamp() {
    if (!any_due_) return;
    // Few shapes over many tiles or many shapes over few of them: pairs serve both.
    std::vector<std::pair<int, int>> pairs;  // tile, shape; shape -1: none
    const std::vector<Shape>& list = shapes();
    for (size_t i = 0; i < tiles_.size(); ++i) {
        if (tiles_[i] && tiles_[i]->ground_due) pairs.emplace_back(static_cast<int>(i), -1);
    }
    for (size_t s = 0; s < list.size(); ++s) {
        core_.blocks_at(list[s].box).for_each_tile([&](int tx, int ty) {
            const int index = core_.tile_index(tx, ty);
            const Tile* tile = tiles_[index].get();
            if (tile && tile->ground_due && list[s].is_over(tx, ty)) {
                pairs.emplace_back(index, static_cast<int>(s));
            }
        });
    }
    std::sort(pairs.begin(), pairs.end());
    Memo memo;
    Batch batch;
    Cover cover;
    for (size_t i = 0; i < pairs.size();) {
        const int index = pairs[i].first;
        cover.assign(static_cast<size_t>(core_.params.tile_voxels), 0);
        for (++i; i < pairs.size() && pairs[i].first == index; ++i) {
            add(list[static_cast<size_t>(pairs[i].second)], index, cover);
        }
        put_later(index, cover, memo, batch);
        if (batch.jobs.size() == kBatchTiles) put_all(memo, batch);
    }
    put_all(memo, batch);
    any_due_ = false;  // not before: without memory some are still due
}

void GroundBodies::add(const Shape& shape, int index, std::vector<int32_t>& cover) const {
    add_coverage(
        *shape.shape, shape.pose, core_.frame.voxel_m,
        {index % core_.tiles_x * kTileSide, index / core_.tiles_x * kTileSide, core_.height},
        cover);
}

void GroundBodies::stamp_new_tile(int index) {
    std::vector<int32_t> cover;
    for (const Shape& shape : shapes()) {
        if (shape.is_over(index % core_.tiles_x, index / core_.tiles_x)) {
            cover.resize(static_cast<size_t>(core_.params.tile_voxels));
            add(shape, index, cover);
        }
    }
    if (!cover.empty()) put(index, cover);
}

bool GroundBodies::is_over(int index) {
    return std::any_of(shapes().begin(), shapes().end(), [&](const Shape& shape) {
        return shape.is_over(index % core_.tiles_x, index / core_.tiles_x);
    });
}

auto GroundBodies::Memo::find(const Cover& cover) -> const Cover* {
    // Under level ground all are the same.
    if (last && *last == cover) return last;
    uint64_t hash = 0xcbf29ce484222325ull;
    for (const int32_t word : cover) hash = (hash ^ static_cast<uint32_t>(word)) * 0x100000001b3ull;
    const auto [first, end] = covers.equal_range(hash);
    for (auto known = first; known != end; ++known) {
        if (*known->second == cover) return last = known->second.get();
    }
    // Uneven ground is another in every tile, and the 20 kB of each are remembered for nothing.
    constexpr size_t kCoversMost = 1000;
    if (covers.size() == kCoversMost) return nullptr;
    return last = covers.emplace(hash, std::make_unique<const Cover>(cover))->second.get();
}

auto GroundBodies::Memo::find(const Content& before, const Cover* cover) -> Entry* {
    const auto known = entries.find(before);
    if (known == entries.end()) return nullptr;
    const auto entry = std::ranges::find(known->second, cover, &Entry::cover);
    return entry == known->second.end() ? nullptr : &*entry;
}

void GroundBodies::put(int index, const Cover& cover, bool rock_changed) {
    change(index, outcome_of(index, cover, rock_changed));
}

// Level ground under level soil is the same in every tile.
void GroundBodies::put_later(int index, const Cover& cover, Memo& memo, Batch& batch) {
    const Tile& tile = *tiles_[index];
    if (tile.slot >= 0) {
        put(index, cover, false);
        return;
    }
    Batch::Job job{index, memo.find(cover), nullptr, {}};
    if (!job.cover) {
        job.own = std::make_unique<Cover>(cover);
        job.cover = job.own.get();
    } else {
        const Memo::Content before{tile.packed, tile.ground, tile.buried};
        if (const Memo::Entry* entry = memo.find(before, job.cover)) {
            if (entry->is_known) {
                take(index, *entry);
            } else {
                batch.same.emplace_back(index, job.cover);
            }
            return;
        }
        memo.entries[before].push_back({job.cover, false, {}, false});
    }
    batch.jobs.push_back(std::move(job));
}

// Tiles asleep know nothing of each other: only what is found is put into the table in order.
void GroundBodies::put_all(Memo& memo, Batch& batch) {
    for_ranges(core_.work_threads.get(), batch.jobs.size(), 1, [&](size_t first, size_t last) {
        for (Batch::Job& job : std::span(batch.jobs).subspan(first, last - first)) {
            job.outcome = outcome_of(job.index, *job.cover, false);
        }
    });
    for (Batch::Job& job : batch.jobs) {
        const Tile& tile = *tiles_[job.index];
        const Memo::Content before{tile.packed, tile.ground, tile.buried};
        const bool is_less = job.outcome.is_less;
        change(job.index, std::move(job.outcome));
        if (job.own) continue;
        Memo::Entry& entry = *memo.find(before, job.cover);
        entry = {job.cover, true, {tile.packed, tile.ground, tile.buried}, is_less};
    }
    for (const auto& [index, cover] : batch.same) {
        const Tile& tile = *tiles_[index];
        take(index, *memo.find({tile.packed, tile.ground, tile.buried}, cover));
    }
    batch.jobs.clear();
    batch.same.clear();
}

void GroundBodies::take(int index, const Memo::Entry& entry) {
    Tile& tile = *tiles_[index];
    tile.ground_due = false;
    if (entry.after == Memo::Content{tile.packed, tile.ground, tile.buried}) return;
    std::tie(tile.packed, tile.ground, tile.buried) = entry.after;
    tile.top = tile.packed ? tile.packed->top : 0;
    ++tile.revision;
    tile.unchecked = tile.unchecked || entry.unchecked;
}

auto GroundBodies::outcome_of(int index, const Cover& cover, bool rock_changed) const -> Outcome {
    const Tile& tile = *tiles_[index];
    const auto count = static_cast<size_t>(core_.params.tile_voxels);
    const bool none = std::all_of(cover.begin(), cover.end(), [](int32_t c) { return c == 0; });
    Outcome out;
    if (none && !tile.ground) return out;
    TileVoxels voxels;
    tiles_.read_voxels(index, voxels);
    TileVoxels ground;
    tiles_.read_ground(index, ground);
    if (ground.words.empty()) ground.reset(core_.height, 1);
    out.is_changed = rock_changed;
    for (size_t v = 0; v < count; ++v) {
        int32_t& terrain = voxels.words[v];
        int32_t& part = ground.words[v];
        const int32_t rock = terrain - part;
        const int32_t now = std::min(cover[v], kVoxelFull - rock);
        out.is_changed = out.is_changed || now != part;
        out.is_less = out.is_less || now < part;
        part = now;
        terrain = rock + now;
    }
    if (!out.is_changed) return out;
    if (TileVoxels back; tiles_.read_buried(index, back)) {
        for (size_t w = kKeptVolume * count; w < voxels.words.size(); ++w) {
            voxels.words[w] += back.words[w];
        }
    }
    TileVoxels buried;
    for (size_t v = 0; v < count; ++v) {
        const int volume = voxels.words[kKeptVolume * count + v];
        const int room = kVoxelFull - voxels.words[v];
        if (ground.words[v] == 0 || volume <= room) continue;
        if (buried.words.empty()) buried.reset(core_.height, core_.kept_planes);
        move_soil(voxels, buried, v, room > kWholeMost ? volume - room : volume, volume);
    }
    const auto bytes_of = [](const TileVoxels& packed) {
        return std::make_shared<const std::vector<uint8_t>>(pack_tile(packed));
    };
    if (!buried.words.empty()) out.buried = bytes_of(buried);
    if (!none) out.ground = bytes_of(ground);
    if (tile.slot < 0) {
        out.packed = make_packed(voxels);
    } else {
        out.voxels = std::move(voxels);
    }
    return out;
}

void GroundBodies::change(int index, Outcome&& outcome) {
    Tile& tile = *tiles_[index];
    tile.ground_due = false;
    if (!outcome.is_changed) return;
    if (tile.slot < 0) {
        tiles_.write_packed(index, std::move(outcome.packed));
    } else {
        tiles_.write_voxels(index, outcome.voxels);
    }
    tile.ground = std::move(outcome.ground);
    tile.buried = std::move(outcome.buried);
    ++tile.revision;
    if (outcome.is_less) {
        tile.unchecked = tiles_.any_unchecked = true;  // soil may have lost what it rested on
    }
}

void GroundBodies::restart() {
    shapes_.clear();
    is_listed_ = false;
}

}  // namespace bsoil
