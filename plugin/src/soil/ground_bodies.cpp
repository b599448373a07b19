// Ground bodies: bodies that never move, which are to the soil what its terrain is.
//
// What they cover is part of the terrain of each tile, awake or asleep, so that kernels, surface
// heights and fills know it without a tile having to wake. Soil that lies where such a body appears
// is buried: it leaves the voxels, is kept with its tile, and comes back when the body goes.
#include <algorithm>
#include <cmath>

#include "soil/ground_coverage.h"
#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

// A static body that its host moves pushes soil out of its way like any other body; so many steps
// after its last move it is ground again.
constexpr int64_t kGroundAfterSteps = 30;

int clamped_tile(double voxel, int tile_count) {
    return static_cast<int>(std::clamp(std::floor(voxel / kTileSide), 0.0, tile_count - 1.0));
}

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

}  // namespace

bool Soil::Impl::GroundShape::is_over(int tx, int ty) const {
    return box.max.x > tx * kTileSide && box.max.y > ty * kTileSide &&
           box.min.x < (tx + 1) * kTileSide && box.min.y < (ty + 1) * kTileSide;
}

// Decides which of the step's bodies are ground, and brings the tiles up to date. A body that has
// been ground and now moves gives its place free, and is a body like others from this step on.
void Soil::Impl::update_ground(std::vector<StepBody>& step_bodies) {
    bool any_changed = false;
    for (StepBody& body : step_bodies) {
        BodyTrack& track = *body.track;
        if (body.moved && !body.placed) track.last_moved_step = step_index;
        const bool rests =
            body.placed ||
            (!body.moved && step_index - track.last_moved_step > kGroundAfterSteps) ||
            (!body.moved && track.is_ground);
        const bool is_ground = body.input->is_static && rests;
        if (is_ground == track.is_ground && !(is_ground && body.placed)) {
            if (is_ground && track.ground_shapes.empty()) {  // after load(): the tiles know it
                keep_ground_shapes(body);
            }
            continue;
        }
        any_changed = true;
        if (track.is_ground) {
            mark_ground(track);
            track.ground_shapes.clear();
            body.moved = true;  // soil that was buried in it has to make room
        }
        if (is_ground) {
            mark_rebuild(track.blocks, false);  // no coverage of its own any more
            track.blocks.clear();
            keep_ground_shapes(body);
            mark_ground(track);
        }
        track.is_ground = is_ground;
    }
    if (any_changed) ground_listed = contacts_known = false;
    std::erase_if(step_bodies, [](const StepBody& body) { return body.track->is_ground; });
    stamp_ground();
}

// Before the first step: bodies that will be ground in it, so that what was filled rests on them.
void Soil::Impl::meet_ground(std::span<const SoilBody> input) {
    std::vector<StepBody> fresh;
    for (const SoilBody& body : input) {
        if (!body.is_static || bodies.contains(body.id) || !accept_body(body) ||
            bodies.size() >= limits::kBodyCapacity) {
            continue;
        }
        BodyTrack& track = bodies[body.id];
        track.walls.make(*body.shapes, frame.voxel_m);
        track.index = take_body_index(body.id);
        track.pose = world_to_grid * body.pose;
        track.shape_revision = body.shape_revision;
        track.is_static = true;
        track.last_step = step_index;
        fresh.push_back({&body, &track, track.pose, track.pose, true, true});
    }
    update_ground(fresh);
}

void Soil::Impl::keep_ground_shapes(const StepBody& body) {
    BodyTrack& track = *body.track;
    track.ground_pose = body.to;
    track.ground_shapes = body.shapes();
    ground_listed = false;
}

// Tiles under a body that becomes ground, or was it, have to look again.
void Soil::Impl::mark_ground(const BodyTrack& track) {
    ground_listed = false;
    any_ground_due = true;
    if (track.ground_shapes.empty()) {  // it went before load() could see it again
        for (const auto& tile : tiles) {
            if (tile) tile->ground_due = true;
        }
        return;
    }
    for (const ConvexShape& shape : track.ground_shapes) {
        const Aabb box = shape_bounds(shape, track.ground_pose, frame.voxel_m);
        if (box.max.x < 0 || box.max.y < 0 || box.max.z < 0 || box.min.x > frame.size[0] ||
            box.min.y > frame.size[1] || box.min.z > height) {
            continue;
        }
        for (int ty = clamped_tile(box.min.y, tiles_y); ty <= clamped_tile(box.max.y, tiles_y);
             ++ty) {
            for (int tx = clamped_tile(box.min.x, tiles_x); tx <= clamped_tile(box.max.x, tiles_x);
                 ++tx) {
                if (Tile* tile = tiles[tile_index(tx, ty)].get()) tile->ground_due = true;
            }
        }
    }
}

const std::vector<Soil::Impl::GroundShape>& Soil::Impl::ground_list() {
    if (!ground_listed) {
        ground_shapes.clear();
        for (const auto& [id, track] : bodies) {
            for (const ConvexShape& shape : track.ground_shapes) {
                const Aabb box = shape_bounds(shape, track.ground_pose, frame.voxel_m);
                if (box.max.z > 0 && box.min.z < height) {
                    ground_shapes.push_back({&shape, track.ground_pose, box});
                }
            }
        }
        ground_listed = true;
    }
    return ground_shapes;
}

void Soil::Impl::stamp_ground() {
    if (!any_ground_due) {
        return;
    }
    any_ground_due = false;
    // Few shapes over many tiles or many shapes over few of them: pairs serve both.
    std::vector<std::pair<int, int>> pairs;  // tile, shape; shape -1: none
    const std::vector<GroundShape>& list = ground_list();
    for (size_t i = 0; i < tiles.size(); ++i) {
        if (tiles[i] && tiles[i]->ground_due) pairs.emplace_back(static_cast<int>(i), -1);
    }
    for (size_t s = 0; s < list.size(); ++s) {
        const Aabb& box = list[s].box;
        for (int ty = clamped_tile(box.min.y, tiles_y); ty <= clamped_tile(box.max.y, tiles_y);
             ++ty) {
            for (int tx = clamped_tile(box.min.x, tiles_x); tx <= clamped_tile(box.max.x, tiles_x);
                 ++tx) {
                const Tile* tile = tiles[tile_index(tx, ty)].get();
                if (tile && tile->ground_due && list[s].is_over(tx, ty)) {
                    pairs.emplace_back(tile_index(tx, ty), static_cast<int>(s));
                }
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    GroundMemo memo;
    std::vector<int32_t> cover;
    for (size_t i = 0; i < pairs.size();) {
        const int index = pairs[i].first;
        cover.assign(static_cast<size_t>(params.tile_voxels), 0);
        for (++i; i < pairs.size() && pairs[i].first == index; ++i) {
            add_ground(list[static_cast<size_t>(pairs[i].second)], index, cover);
        }
        put_ground(index, cover, false, &memo);
    }
}

void Soil::Impl::add_ground(const GroundShape& shape, int index,
                            std::vector<int32_t>& cover) const {
    add_coverage(*shape.shape, shape.pose, frame.voxel_m,
                 {index % tiles_x * kTileSide, index / tiles_x * kTileSide, height}, cover);
}

// Of a tile that has just been made: what has been ground before it was.
void Soil::Impl::stamp_new_tile(int index) {
    std::vector<int32_t> cover;
    for (const GroundShape& shape : ground_list()) {
        if (shape.is_over(index % tiles_x, index / tiles_x)) {
            cover.resize(static_cast<size_t>(params.tile_voxels));
            add_ground(shape, index, cover);
        }
    }
    if (!cover.empty()) {
        put_ground(index, cover);
    }
}

bool Soil::Impl::is_over_ground(int index) {
    return std::any_of(ground_list().begin(), ground_list().end(), [&](const GroundShape& shape) {
        return shape.is_over(index % tiles_x, index / tiles_x);
    });
}

// The ground part of a tile's terrain becomes `cover` (may exceed a voxel). Soil buried by what was
// there comes back, soil that has no room now is buried.
void Soil::Impl::put_ground(int index, const std::vector<int32_t>& cover, bool rock_changed,
                            GroundMemo* memo) {
    Tile& tile = *tiles[index];
    if (!memo || tile.slot >= 0) {
        change_ground(index, cover, rock_changed);
        return;
    }
    // Level ground under level soil is the same in every tile.
    const GroundMemo::Content before{tile.packed, tile.ground, tile.buried};
    std::vector<GroundMemo::Entry>& known = memo->entries[before];
    for (const GroundMemo::Entry& entry : known) {
        if (entry.cover != cover) continue;
        tile.ground_due = false;
        if (entry.after != before) {
            std::tie(tile.packed, tile.ground, tile.buried) = entry.after;
            tile.top = tile.packed ? tile.packed->top : 0;
            ++tile.revision;
            tile.unchecked = tile.unchecked || entry.unchecked;
        }
        return;
    }
    const bool was_unchecked = tile.unchecked;
    tile.unchecked = false;
    change_ground(index, cover, rock_changed);
    known.push_back({cover, {tile.packed, tile.ground, tile.buried}, tile.unchecked});
    tile.unchecked = tile.unchecked || was_unchecked;
}

void Soil::Impl::change_ground(int index, const std::vector<int32_t>& cover, bool rock_changed) {
    Tile& tile = *tiles[index];
    tile.ground_due = false;
    const auto count = static_cast<size_t>(params.tile_voxels);
    const bool none = std::all_of(cover.begin(), cover.end(), [](int32_t c) { return c == 0; });
    if (none && !tile.ground) {
        return;
    }
    TileVoxels voxels;
    read_voxels(index, voxels);
    TileVoxels ground;
    read_ground(index, ground);
    if (ground.words.empty()) ground.reset(height, 1);
    bool changed = rock_changed, less = false;
    for (size_t v = 0; v < count; ++v) {
        int32_t& terrain = voxels.words[v];
        int32_t& part = ground.words[v];
        const int32_t rock = terrain - part;
        const int32_t now = std::min(cover[v], kVoxelFull - rock);
        changed = changed || now != part;
        less = less || now < part;
        part = now;
        terrain = rock + now;
    }
    if (!changed) {
        return;
    }
    if (TileVoxels back; read_buried(index, back)) {
        for (size_t w = kKeptVolume * count; w < voxels.words.size(); ++w) {
            voxels.words[w] += back.words[w];
        }
        tile.buried.reset();
    }
    TileVoxels buried;
    for (size_t v = 0; v < count; ++v) {
        const int volume = voxels.words[kKeptVolume * count + v];
        const int room = kVoxelFull - voxels.words[v];
        if (ground.words[v] == 0 || volume <= room) {
            continue;
        }
        if (buried.words.empty()) buried.reset(height, kept_planes);
        move_soil(voxels, buried, v, room > kWholeMost ? volume - room : volume, volume);
    }
    const auto bytes_of = [](const TileVoxels& packed) {
        return std::make_shared<const std::vector<uint8_t>>(pack_tile(packed));
    };
    if (!buried.words.empty()) tile.buried = bytes_of(buried);
    tile.ground = none ? nullptr : bytes_of(ground);
    write_voxels(index, voxels);
    ++tile.revision;
    if (tile.slot >= 0) {
        woken_step[tile.slot] = step_index;  // supports and spans are no longer true
    }
    if (less) {
        tile.unchecked = any_unchecked = true;  // soil may have lost what it rested on
    }
}

bool Soil::Impl::read_buried(int index, TileVoxels& out) const {
    if (!tiles[index] || !tiles[index]->buried) {
        return false;
    }
    out.reset(height, kept_planes);
    unpack_tile(*tiles[index]->buried, out);
    return true;
}

void Soil::Impl::read_ground(int index, TileVoxels& out) const {
    out.words.clear();
    if (tiles[index] && tiles[index]->ground) {
        out.reset(height, 1);
        unpack_tile(*tiles[index]->ground, out);
    }
}

}  // namespace bsoil
