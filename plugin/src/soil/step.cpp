// The step on the host's side: which bodies, which blocks, which kernels in which order.
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

// A body counts as still until it has moved this far since its coverage was last made [voxels]: a
// machine that rocks by micrometres on its tracks is not voxelized anew in every step. Well below
// what the contact forces resolve.
constexpr double kStillVoxels = 1.0 / 512;
// Whole units of mass and momentum do not go into quite equal parts: falling soil can be so much
// faster in a step than gravity makes it [voxels a step].
constexpr double kSpeedMargin = 1.0 / 8;

// Slippage passes a step. One pass levels a slope over a voxel; a second makes a metre of loose
// sand come to rest in about a second, as it does.
constexpr int kSlipPasses = 2;
// More of them, one for each so much (Q16 voxels) that the steepest slope stands above a stable
// one.
constexpr int kSlopePerPass = 8192;
constexpr int kSlipPassesMost = 16;
// In these passes soil slides so far at once [m]. A slope carries off what is pushed onto it in
// proportion to the square of that way: with a way of one voxel heaps were the steeper, the finer
// the grid.
constexpr double kSlipWay = 0.04;
constexpr int kSlipStrideMost = kTileSide / 2;  // from opposite sides into one tile, apart

// Contact records read with everything else are those of the step before and so many more: a
// second read is for the step in which a body lands.
constexpr int kContactsMore = 64;

/// Stages as StageTimes has them.
enum Stage { kVoxelize, kDeform, kAdvect, kSlip, kContacts, kActivity };

StageTimes stage_times(std::span<const double> ms) {
    return {ms[kVoxelize], ms[kDeform], ms[kAdvect], ms[kSlip], ms[kContacts], ms[kActivity]};
}

int32_t to_q16(double value, double limit) {
    return static_cast<int32_t>(std::lround(std::clamp(value, -limit, limit) * 65536));
}

Pose interpolate(const Pose& a, const Pose& b, double t) {
    Quat q = b.rotation;
    if (a.rotation.x * q.x + a.rotation.y * q.y + a.rotation.z * q.z + a.rotation.w * q.w < 0) {
        q = {-q.x, -q.y, -q.z, -q.w};
    }
    // Sub-steps turn by little: the normalized chord follows the arc.
    Quat r{a.rotation.x + (q.x - a.rotation.x) * t, a.rotation.y + (q.y - a.rotation.y) * t,
           a.rotation.z + (q.z - a.rotation.z) * t, a.rotation.w + (q.w - a.rotation.w) * t};
    const double n = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
    return {a.position + (b.position - a.position) * t, {r.x / n, r.y / n, r.z / n, r.w / n}};
}

Aabb merge(const Aabb& a, const Aabb& b) {
    return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
            {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

int clamped_floor(double value, int low, int high) {
    return static_cast<int>(
        std::floor(std::clamp(value, static_cast<double>(low), static_cast<double>(high))));
}

/// Which voxels the shape may cover. A distance counts up to 1/8 voxel beyond its sub-cell's
/// middle, which is 3/8 from the voxel's along each axis. What is sharp is further off its corner
/// than off its faces: there all voxels count.
void put_voxel_bounds(const ConvexShape& shape, const Aabb& box, int32_t* record) {
    using Kind = ConvexShape::Kind;
    constexpr double kReach = 1.5;
    constexpr int kFar = 1 << 20;
    const bool is_blunt = shape.kind == Kind::box || shape.kind == Kind::sphere ||
                          shape.kind == Kind::capsule || shape.kind == Kind::cylinder;
    const double low[3] = {box.min.x, box.min.y, box.min.z};
    const double high[3] = {box.max.x, box.max.y, box.max.z};
    for (int axis = 0; axis < 3; ++axis) {
        record[kShapeLow + axis] =
            is_blunt ? clamped_floor(low[axis] - kReach, -kFar, kFar) : -kFar;
        record[kShapeHigh + axis] =
            is_blunt ? clamped_floor(high[axis] + kReach, -kFar, kFar) : kFar;
    }
}

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

int64_t wide_sum(const int32_t* words) {
    return static_cast<int64_t>(static_cast<uint64_t>(static_cast<uint32_t>(words[1])) << 32 |
                                static_cast<uint32_t>(words[0]));
}

}  // namespace

bool GivenBody::operator==(const GivenBody& o) const {
    const auto same = [](Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
    const Quat &a = pose.rotation, &b = o.pose.rotation;
    return same(pose.position, o.pose.position) && a.x == b.x && a.y == b.y && a.z == b.z &&
           a.w == b.w && same(linear_velocity_m_s, o.linear_velocity_m_s) &&
           same(angular_velocity_rad_s, o.angular_velocity_rad_s) &&
           same(center_of_mass_m, o.center_of_mass_m) && contact_width_m == o.contact_width_m;
}

void Soil::Impl::dispatch(Kernel kernel, const ListedWork& work) {
    if (work.group_count == 0) {
        return;
    }
    params.list_offset = work.list_offset;
    params.pair_offset = work.list_offset;
    device->dispatch(static_cast<int>(kernel), words_of(params), work);
}

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

// Body and shape records for the bodies at share t of the step.
void Soil::Impl::upload_bodies(std::span<const StepBody> step_bodies, double t) {
    const int body_count = static_cast<int>(body_ids.size());
    params.body_count = body_count;
    params.shape_offset = body_count * kBodyWords;
    shape_words.assign(static_cast<size_t>(params.shape_offset), 0);
    body_width_voxels.assign(static_cast<size_t>(body_count), 0);
    const double per_step = def.step_s / frame.voxel_m;
    for (const StepBody& body : step_bodies) {
        const SoilBody& in = *body.input;
        int32_t* record = &shape_words[static_cast<size_t>(body.track->index) * kBodyWords];
        if (!in.is_static) {
            const Vec3 linear = rotate(world_to_grid.rotation, in.linear_velocity_m_s) * per_step;
            const Vec3 angular =
                rotate(world_to_grid.rotation, in.angular_velocity_rad_s) * def.step_s;
            const Vec3 center = to_grid(in.center_of_mass_m) * 2;
            const double components[9] = {linear.x,  linear.y, linear.z, angular.x, angular.y,
                                          angular.z, center.x, center.y, center.z};
            for (int i = 0; i < 6; ++i) {
                record[kBodyLinear + i] = to_q16(components[i], i < 3 ? 64 : 2);
            }
            for (int i = 6; i < 9; ++i) {
                record[kBodyLinear + i] =
                    static_cast<int32_t>(std::lround(std::clamp(components[i], -1e6, 1e6)));
            }
            record[kBodyMoving] = 1;
            record[kBodyPacking] = static_cast<int32_t>(
                std::lround(relative_density_under(in.contact_pressure_pa) * kVoxelFull));
        }
        body_width_voxels[static_cast<size_t>(body.track->index)] =
            std::max(0.0, in.contact_width_m) / frame.voxel_m;
        record[kBodyReach] = static_cast<int32_t>(std::lround(
            std::clamp(in.contact_width_m / 2 / frame.voxel_m, 1.0, 1.0 * kBodyReachMost)));
        record[kBodyFriction] = static_cast<int32_t>(
            std::lround((in.surface.friction >= 0 ? std::min(in.surface.friction, 2.0)
                                                  : materials[0].tool_friction) *
                        def.gravity_m_s2 * def.step_s * per_step * kVelocityOne));
    }
    const auto put_float = [&](size_t at, double value) {
        shape_words[at] = std::bit_cast<int32_t>(static_cast<float>(value));
    };
    shape_boxes.clear();
    const double inverse_voxel = 1 / frame.voxel_m;
    std::vector<std::pair<size_t, const ConvexShape*>>& hulls = hull_scratch;
    hulls.clear();
    lattice_scratch.clear();
    for (const StepBody& body : step_bodies) {
        const Pose pose = interpolate(body.from, body.to, t);
        for (const ConvexShape& shape : body.shapes()) {
            const size_t record = shape_words.size();
            shape_words.resize(record + kShapeWords, 0);
            shape_words[record + kShapeKind] = static_cast<int32_t>(shape.kind);
            shape_words[record + kShapeBody] = body.track->index;
            const Pose to_grid_m = pose * shape.local;
            const Pose from_grid = inverse(to_grid_m);
            const Vec3 columns[3] = {rotate(from_grid.rotation, {1, 0, 0}),
                                     rotate(from_grid.rotation, {0, 1, 0}),
                                     rotate(from_grid.rotation, {0, 0, 1})};
            Vec3 offset = from_grid.position * inverse_voxel;
            double per_voxel = 1;
            if (shape.kind == ConvexShape::Kind::lattice) {
                // The rows of a lattice lead to its nodes.
                per_voxel = frame.voxel_m / shape.lattice->spacing_m();
                offset = (from_grid.position - shape.lattice->origin()) *
                         (1 / shape.lattice->spacing_m());
            }
            const double rows[12] = {columns[0].x * per_voxel, columns[1].x * per_voxel,
                                     columns[2].x * per_voxel, offset.x,
                                     columns[0].y * per_voxel, columns[1].y * per_voxel,
                                     columns[2].y * per_voxel, offset.y,
                                     columns[0].z * per_voxel, columns[1].z * per_voxel,
                                     columns[2].z * per_voxel, offset.z};
            for (size_t i = 0; i < 12; ++i) {
                put_float(record + kShapeRows + i, rows[i]);
            }
            const double r = shape.radius_m * inverse_voxel,
                         h = shape.half_height_m * inverse_voxel;
            const size_t size = record + kShapeSize;
            if (shape.kind == ConvexShape::Kind::box) {
                put_float(size, shape.half_extents_m.x * inverse_voxel);
                put_float(size + 1, shape.half_extents_m.y * inverse_voxel);
                put_float(size + 2, shape.half_extents_m.z * inverse_voxel);
            } else if (shape.kind == ConvexShape::Kind::lattice) {
                put_float(size, shape.lattice->quantum_m() * inverse_voxel);
                lattice_scratch.push_back({record, &shape});
            } else {
                put_float(size, r);
                put_float(size + 1, h);
                const double slant = std::sqrt(r * r + 4 * h * h);
                if (slant > 0) {
                    put_float(size + 2, 2 * h / slant);
                    put_float(size + 3, r / slant);
                }
            }
            put_float(record + kShapeRounding, shape.rounding_m * inverse_voxel);
            if (shape.kind == ConvexShape::Kind::hull) {
                hulls.push_back({record, &shape});
            }
            shape_boxes.push_back({shape_bounds(shape, pose, frame.voxel_m)});
            put_voxel_bounds(shape, shape_boxes.back(), &shape_words[record]);
        }
    }
    for (const auto& [record, shape] : hulls) {
        shape_words[record + kShapePlanes] = static_cast<int32_t>(shape_words.size());
        shape_words[record + kShapePlanes + 1] = static_cast<int32_t>(shape->planes.size());
        for (const Plane& plane : shape->planes) {
            const size_t at = shape_words.size();
            shape_words.resize(at + kFaceWords);
            put_float(at, plane.normal.x);
            put_float(at + 1, plane.normal.y);
            put_float(at + 2, plane.normal.z);
            put_float(at + 3, plane.offset * inverse_voxel);
        }
    }
    upload_shapes();
}

const Soil::Impl::LatticePlace* Soil::Impl::place_of(const ConvexShape& shape) const {
    const auto found =
        std::find_if(lattices.begin(), lattices.end(),
                     [&](const LatticePlace& place) { return place.lattice == shape.lattice; });
    return found == lattices.end() ? nullptr : &*found;
}

// Makes room for the words of this sub-step and for its lattices behind them; those of former steps
// that it does not need are dropped. False where the device has no memory for them.
bool Soil::Impl::place_lattices() {
    std::vector<LatticePlace> wanted;
    size_t capacity = shapes_capacity;
    if (shape_words.size() > capacity) {
        capacity = std::max(shape_words.size(), 2 * capacity);
    }
    size_t end = capacity;
    for (const auto& entry : lattice_scratch) {
        const auto& lattice = entry.second->lattice;
        const bool is_new = std::none_of(wanted.begin(), wanted.end(), [&](const auto& place) {
            return place.lattice == lattice;
        });
        if (is_new) {
            wanted.push_back({lattice, end});
            end += lattice->words().size();
        }
    }
    lattices.clear();
    shapes_capacity = 0;
    if (end > INT32_MAX || !device->allocate(Buffer::shapes, static_cast<int64_t>(end))) {
        return false;
    }
    shapes_capacity = capacity;
    lattices = std::move(wanted);
    for (const LatticePlace& place : lattices) {
        device->write(Buffer::shapes, static_cast<int64_t>(place.offset), place.lattice->words());
    }
    return true;
}

void Soil::Impl::upload_shapes() {
    const bool all_placed =
        std::all_of(lattice_scratch.begin(), lattice_scratch.end(),
                    [&](const auto& entry) { return place_of(*entry.second) != nullptr; });
    bool has_lattices = true;
    if (!all_placed || (shape_words.size() > shapes_capacity && !lattices.empty())) {
        has_lattices = place_lattices();
    }
    if (!has_lattices) {
        // All of them are one that holds nothing.
        for (const auto& [record, shape] : lattice_scratch) {
            conditions.note(StatusBit::shape_refused,
                            body_ids[static_cast<size_t>(shape_words[record + kShapeBody])]);
            shape_words[record + kShapeLattice] = static_cast<int32_t>(shape_words.size());
        }
        shape_words.resize(shape_words.size() + kLatticeIndex, 0);
    } else {
        for (const auto& [record, shape] : lattice_scratch) {
            shape_words[record + kShapeLattice] = static_cast<int32_t>(place_of(*shape)->offset);
        }
    }
    ensure_capacity(Buffer::shapes, shapes_capacity, shape_words.size());
    device->write(Buffer::shapes, 0, shape_words);
}

void Soil::Impl::ensure_capacity(device::BufferIndex buffer, size_t& capacity, size_t words) {
    if (words > capacity) {
        capacity = std::max(words, 2 * capacity);
        // Growing a small buffer can only fail when the host is out of memory; then the next step
        // finds it empty.
        if (!device->allocate(buffer, static_cast<int64_t>(capacity))) {
            conditions.note(StatusBit::tile_table_full);
            capacity = 0;
        }
    }
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
                    if (rebuild_step[block] == step_index) {
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

// thesis (18)
void Soil::Impl::run_deformation() {
    ++params.pass_stamp;
    dispatch(Kernel::apply_force, listed_work);
    for (int i = 0; i < def.propagation_iterations; ++i) {
        ++params.pass_stamp;
        dispatch(Kernel::propagate_force, listed_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

// thesis (19)
void Soil::Impl::run_advection() {
    dispatch(Kernel::find_support, tile_work);
    params.support_stamp = params.pass_stamp;
    ++params.pass_stamp;
    dispatch(Kernel::advect_soil, listed_work);
    dispatch(Kernel::apply_flow, listed_work);
    for (int i = 0; i < def.overflow_passes; ++i) {
        ++params.pass_stamp;
        dispatch(Kernel::resolve_overflow, listed_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

// Which banks fail as a whole. What falls apart slides in the passes that follow.
void Soil::Impl::run_failures() {
    dispatch(Kernel::build_spans, tile_work);
    params.spans_stamp = params.pass_stamp;
    params.slip_stamp = failure_stamp;
    failure_stamp = params.pass_stamp;
    ++params.pass_stamp;
    dispatch(Kernel::find_failures, tile_work);
    dispatch(Kernel::break_bonds, tile_work);
}

// thesis (20)
void Soil::Impl::run_slippage() {
    // Bodies build slopes up at so many voxels a step: the steeper the step before has left them,
    // the more passes. The last ones go by single voxels, which smooths what the long ways left.
    const int passes =
        std::clamp(kSlipPasses + slope_q16 / kSlopePerPass, kSlipPasses, kSlipPassesMost);
    const int stride_most =
        std::clamp(static_cast<int>(std::lround(kSlipWay / frame.voxel_m)), 1, kSlipStrideMost);
    for (int pass = 0; pass < passes; ++pass) {
        const int stride = pass < passes - kSlipPasses ? stride_most : 1;
        int32_t& slip_stamp = slip_stamps[stride > 1];
        params.slip_stride = stride;
        params.slip_stamp = slip_stamp;
        dispatch(Kernel::build_spans, tile_work);
        params.spans_stamp = params.pass_stamp;
        slip_stamp = params.pass_stamp;
        ++params.pass_stamp;
        params.slip_turn = 1 - params.slip_turn;
        if (pass == passes - 1) {
            device->fill_zero(Buffer::result, kResultSlope, 1);
        }
        dispatch(Kernel::slip_soil, tile_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

bool Soil::Impl::accept_body(const SoilBody& body) {
    if (!is_finite(body.pose) || !is_finite(body.linear_velocity_m_s) ||
        !is_finite(body.angular_velocity_rad_s) || !is_finite(body.center_of_mass_m) ||
        !std::isfinite(body.contact_pressure_pa) || !std::isfinite(body.contact_width_m)) {
        conditions.note(
            StatusBit::pose_not_finite, body.id,
            is_finite(body.center_of_mass_m) ? std::optional(body.center_of_mass_m) : std::nullopt);
        return false;
    }
    if (!body.shapes || body.shapes->empty() || body.id < 0 || body.id > 65534 ||
        !std::all_of(body.shapes->begin(), body.shapes->end(), is_valid_shape)) {
        conditions.note(StatusBit::shape_refused, std::max(-1, body.id), body.center_of_mass_m);
        return false;
    }
    return true;
}

int Soil::Impl::take_body_index(int id) {
    const auto free = std::find(body_ids.begin(), body_ids.end(), -1);
    if (free != body_ids.end()) {
        *free = id;
        return static_cast<int>(free - body_ids.begin());
    }
    body_ids.push_back(id);
    return static_cast<int>(body_ids.size()) - 1;
}

// Steps that a body's motion needs: no point of it may cross more than a voxel at once.
double Soil::Impl::body_reach_voxels(const StepBody& body) const {
    double reach = 0;
    for (const ConvexShape& shape : body.shapes()) {
        const Aabb a = shape_bounds(shape, body.from, frame.voxel_m);
        const Aabb b = shape_bounds(shape, body.to, frame.voxel_m);
        const double shifts[6] = {a.min.x - b.min.x, a.min.y - b.min.y, a.min.z - b.min.z,
                                  a.max.x - b.max.x, a.max.y - b.max.y, a.max.z - b.max.z};
        for (double shift : shifts) {
            reach = std::max(reach, std::abs(shift));
        }
    }
    return reach;
}

StepReport Soil::Impl::step(std::span<const SoilBody> input) {
    StepReport report;
    device::DeviceSession session(*device);
    ++step_index;
    const int32_t stamp = step_stamp_of(step_index);
    conditions.begin_step(step_index, def.step_s);
    if (stamp < params.step_stamp || params.pass_stamp > (1 << 30)) {
        params.pass_stamp = 0;
        table_dirty = true;
        device->fill_zero(Buffer::block_flags, 0,
                          static_cast<int64_t>(kFlagArrays) * slot_count * blocks_per_tile);
        forget_stamps();
    }
    params.step_stamp = stamp;

    // --- bodies: who is here, who moved, how fast
    std::vector<StepBody>& step_bodies = body_scratch;
    step_bodies.clear();
    double reach = 0;
    const SoilBody* fastest = nullptr;  // the one with this reach
    bool same_bodies = true;
    for (const SoilBody& body : input) {
        if (!accept_body(body)) {
            continue;
        }
        if (static_cast<int>(step_bodies.size()) >= limits::kBodyCapacity) {
            conditions.note(StatusBit::shape_refused, body.id, body.center_of_mass_m);
            break;
        }
        BodyTrack& track = bodies[body.id];
        if (track.last_step == step_index) {
            continue;  // the same id twice in one step: the first counts
        }
        const Pose to = world_to_grid * body.pose;
        StepBody entry{&body, &track, to, to, true, true};
        if (track.index < 0 || track.shape_revision != body.shape_revision ||
            track.walls.growth.size() != body.shapes->size()) {
            track.walls.make(*body.shapes, frame.voxel_m);
            track.surface = {};
        }
        if (def.contact_law.faces_by_shape && !body.is_static && !track.surface.is_made) {
            track.surface.make(*body.shapes, track.walls.growth, frame.voxel_m);
        }
        if (track.index < 0) {
            track.index = take_body_index(body.id);
        } else if (track.shape_revision == body.shape_revision) {
            entry.from = track.pose;
            const double move = body_reach_voxels(entry);
            entry.moved = move > kStillVoxels;
            entry.placed = move > def.substeps_max;
            if (!entry.moved) {
                entry.to = entry.from;
            } else if (move > def.substeps_max) {
                conditions.note(StatusBit::body_teleported, body.id, body.center_of_mass_m);
                entry.from = to;
            } else {
                fastest = move > reach ? &body : fastest;
                reach = std::max(reach, move);
            }
        }
        const GivenBody given{body.pose, body.linear_velocity_m_s, body.angular_velocity_rad_s,
                              body.center_of_mass_m, body.contact_width_m};
        same_bodies = same_bodies && !entry.moved && given == track.given;
        track.given = given;
        entry.turned_static = track.is_static != body.is_static;
        track.pose = entry.to;
        track.shape_revision = body.shape_revision;
        track.is_static = body.is_static;
        track.last_step = step_index;
        if (!body.is_static && !body.may_leave && !frame.is_above(body.center_of_mass_m)) {
            conditions.note(StatusBit::body_outside_grid, body.id, body.center_of_mass_m);
        }
        step_bodies.push_back(entry);
    }
    // Bodies and soil may each cross one voxel at a time. What falls is faster by gravity in this
    // step than in the last, and may get a body's speed.
    const double fall =
        speed_q16 > 0
            ? std::max(reach, static_cast<double>(speed_q16 + params.gravity_q16) / 65536) +
                  kSpeedMargin
            : 0;
    const int body_substeps = std::clamp(static_cast<int>(std::ceil(reach)), 1, def.substeps_max);
    const int fall_substeps = std::clamp(static_cast<int>(std::ceil(fall / body_substeps)), 1,
                                         std::max(1, def.substeps_max / body_substeps));
    if (fall > body_substeps * fall_substeps) {
        const bool by_body = fastest && reach * 65536 > static_cast<double>(speed_q16);
        conditions.note(StatusBit::speed_clamped, by_body ? fastest->id : -1);
    }

    // --- blocks: where coverage changes, what is active, what to dispatch
    for (auto it = bodies.begin(); it != bodies.end();) {
        if (it->second.last_step != step_index) {  // gone: its room is free again
            same_bodies = false;
            mark_rebuild(it->second.blocks, true);
            body_ids[it->second.index] = -1;
            if (it->second.is_ground) {
                mark_ground(it->second);
            }
            it = bodies.erase(it);
        } else {
            ++it;
        }
    }
    update_ground(step_bodies);
    if (any_unchecked) {
        wake_unstable_columns();
    }
    bool any_moved = false;
    std::vector<BlockKey>& blocks = block_scratch;
    for (StepBody& body : step_bodies) {
        const bool is_static = body.input->is_static;
        find_body_blocks(body, body.moved || !is_static, blocks);
        if (body.moved) {
            mark_rebuild(body.track->blocks, true);
            mark_rebuild(blocks, true);
            any_moved = true;
        } else {
            fresh_blocks.clear();
            std::set_difference(blocks.begin(), blocks.end(), body.track->blocks.begin(),
                                body.track->blocks.end(), std::back_inserter(fresh_blocks));
            mark_rebuild(body.turned_static ? blocks : fresh_blocks, false);
        }
        body.track->blocks = blocks;
    }
    list_active_blocks();
    // A tile that woke just now has no coverage yet, and its bodies may not have been looked up
    // with it awake.
    for (StepBody& body : step_bodies) {
        find_body_blocks(body, false, blocks);
        body.track->blocks = blocks;
        for (BlockKey key : blocks) {
            const int block = device_block(key);
            if (woken_step[block / blocks_per_tile] == step_index) {
                rebuild_step[block] = step_index;
            }
            if (!body.input->is_static) {
                contact_step[block] = step_index;
            }
        }
    }
    upload_tile_table();
    build_work_lists();
    list_words_uploaded = 0;
    // No body has moved and no soil may move: all there is to find out is known.
    const bool is_quiet = same_bodies && contacts_known && listed_work.group_count == 0 &&
                          rebuild_work.group_count == 0 && tile_work.group_count == 0;

    // --- the step itself
    device->fill_zero(Buffer::result, 0,
                      kResultHeader + static_cast<int64_t>(limits::kBodyCapacity) * kLoadWords);
    params.body_substep_count = body_substeps;
    for (int s = 0; s < body_substeps; ++s) {
        device->mark_stage(kVoxelize);
        if ((s == 0 && !is_quiet) || any_moved) {
            upload_bodies(step_bodies, static_cast<double>(s + 1) / body_substeps);
            build_pairs();
            dispatch(Kernel::clear_coverage, rebuild_work);
            dispatch(Kernel::voxelize_shapes, pair_work);
        }
        device->mark_stage(kDeform);
        run_deformation();
        device->mark_stage(kAdvect);
        params.substep_count = body_substeps * fall_substeps;
        for (int f = 0; f < fall_substeps; ++f) {
            run_advection();
        }
        device->mark_stage(kSlip);
        params.substep_count = body_substeps;
        if (s == 0 && params.bank_strength > 0) {
            run_failures();
        }
        run_slippage();
    }

    device->mark_stage(kContacts);
    if (is_quiet) {
        speed_q16 = slope_q16 = 0;
    } else {
        params.contact_offset = kResultHeader + limits::kBodyCapacity * kLoadWords;
        params.contact_capacity = limits::kContactCapacity;
        dispatch(Kernel::collect_contacts, contact_work);
        read_back();
        read_results(step_bodies);
        contacts_known = (result_head[kResultStatus] & kStatusContactsFull) == 0;
    }

    device->mark_stage(kActivity);
    if (!is_quiet) {
        read_activity();
    }
    sleep_idle_tiles();
    session.end();
    report.stage_ms = stage_times(device->stage_ms());

    report.substep_count = body_substeps * fall_substeps;
    report.status_bits = conditions.bits();
    report.condition_new_count = conditions.take_new_count();
    report.conditions = conditions.all();
    report.block_active_count = block_active_count;
    report.block_dispatched_count = listed_work.group_count;
    report.tile_awake_count = slot_count - static_cast<int>(free_slots.size());
    report.speed_max_voxels_per_step = static_cast<double>(speed_q16) / 65536;
    report.contacts = contacts;
    report.contacts_unchanged = is_quiet;
    report.loads = loads;
    return report;
}

// All that the host asks about a step, at the cost of one wait.
void Soil::Impl::read_back() {
    const size_t blocks = static_cast<size_t>(slot_count) * blocks_per_tile;
    const int expected =
        contact_work.group_count > 0 ? std::min(contacts_expected, limits::kContactCapacity) : 0;
    result_head.resize(kResultHeader + body_ids.size() * kLoadWords);
    result_words.resize(static_cast<size_t>(expected) * kContactWords);
    static_assert(kFlagWanted == kFlagChanged + 1);
    flag_words.resize(2 * blocks);
    tile_table.resize(static_cast<size_t>(slot_count) * kTileTableWords);
    tile_tops.resize(contact_work.group_count > 0 ? static_cast<size_t>(slot_count) * kTileColumns
                                                  : 0);
    constexpr size_t kTileSpanWords = static_cast<size_t>(kTileColumns) * kColumnWords;
    span_slots.swap(span_asked);
    span_asked.clear();
    std::erase_if(span_slots, [&](int slot) {
        return slot >= slot_count || slot_tile[static_cast<size_t>(slot)] < 0 ||
               contact_work.group_count == 0;
    });
    tile_spans.resize(span_slots.size() * kTileSpanWords);
    span_place.assign(static_cast<size_t>(slot_count), -1);
    read_scratch.clear();
    for (size_t i = 0; i < span_slots.size(); ++i) {
        span_place[static_cast<size_t>(span_slots[i])] = static_cast<int>(i);
        read_scratch.push_back(
            {Buffer::spans,
             static_cast<int64_t>(span_slots[i]) * static_cast<int64_t>(kTileSpanWords),
             std::span(tile_spans).subspan(i * kTileSpanWords, kTileSpanWords)});
    }
    const device::ReadRange ranges[] = {
        {Buffer::result, 0, result_head},
        {Buffer::result, params.contact_offset, result_words},
        {Buffer::block_flags, static_cast<int64_t>(kFlagChanged * blocks), flag_words},
        {Buffer::tile_table, 0, tile_table},
        {Buffer::spans, static_cast<int64_t>(slot_count) * kTileColumns * kColumnWords, tile_tops}};
    read_scratch.insert(read_scratch.end(), std::begin(ranges), std::end(ranges));
    device->read(read_scratch);
    const int count = std::min(result_head[kResultContacts], limits::kContactCapacity);
    if (const size_t words = static_cast<size_t>(count) * kContactWords;
        words > result_words.capacity()) {
        result_words.reserve(2 * words);
    }
    result_words.resize(static_cast<size_t>(count) * kContactWords);
    if (count > expected) {
        const int64_t known = static_cast<int64_t>(expected) * kContactWords;
        device->read(Buffer::result, params.contact_offset + known,
                     std::span(result_words).subspan(static_cast<size_t>(known)));
    }
    contacts_expected = count + count / 4 + kContactsMore;
}

// The kernels keep, of each condition, the place that comes last in the grid's order.
void Soil::Impl::note_kernel_conditions() {
    const auto bits = static_cast<uint32_t>(result_head[kResultStatus]);
    for (const auto& [bit, word] : {std::pair{StatusBit::speed_clamped, kResultSpeedPlace},
                                    std::pair{StatusBit::amount_headroom, kResultHeadroomPlace},
                                    std::pair{StatusBit::span_list_full, kResultSpansPlace}}) {
        if ((bits & static_cast<uint32_t>(bit)) == 0) {
            continue;
        }
        const int levels = ((height - 1) >> params.place_shift) + 1;
        const int code = result_head[word] - 1;
        const int column = code / levels;
        const double half = 0.5 * (1 << params.place_shift);
        conditions.note(
            bit, -1,
            frame.to_world({column / params.place_rows + 0.5, column % params.place_rows + 0.5,
                            (code % levels << params.place_shift) + half}));
    }
    if (bits & kStatusContactsFull) {
        conditions.note(StatusBit::contact_list_full);
    }
}

void Soil::Impl::read_results(std::span<const StepBody> step_bodies) {
    note_kernel_conditions();
    speed_q16 = result_head[kResultSpeed];
    slope_q16 = result_head[kResultSlope];
    loads.clear();
    for (size_t b = 0; b < body_ids.size(); ++b) {
        const int32_t* sums = &result_head[kResultHeader + b * kLoadWords];
        const double units = static_cast<double>(wide_sum(sums + kLoadMass));
        if (units > 0 && body_ids[b] >= 0) {
            const Vec3 center{static_cast<double>(wide_sum(sums + kLoadMoment)) / units / 2,
                              static_cast<double>(wide_sum(sums + kLoadMoment + 2)) / units / 2,
                              static_cast<double>(wide_sum(sums + kLoadMoment + 4)) / units / 2};
            loads.push_back({body_ids[b], units * kLoadPart * kg_per_unit, frame.to_world(center)});
        }
    }
    contact_bodies.resize(body_ids.size());
    for (ContactBody& body : contact_bodies) {
        body.input = nullptr;
    }
    for (const StepBody& body : step_bodies) {
        ContactBody& placed = contact_bodies[static_cast<size_t>(body.track->index)];
        placed.input = body.input;
        placed.faces.place(*body.input, body.track->walls);
        placed.surface = body.track->surface.is_whole ? &body.track->surface : nullptr;
    }
    // Tiles asleep count as they would awake: what wakes them must not change the contacts of a
    // body at rest.
    contact_voxels.make(
        {result_words, contact_bodies, body_ids, body_width_voxels, &frame, &world_to_grid,
         &def.contact_law, wedge_length, work_threads.get()},
        [this](int tx, int ty, int carrier) {
            return carrier == kOnGround ? surface_heights(tile_index(tx, ty))
                                        : carried_surface(tile_index(tx, ty), carrier);
        },
        contacts);
}

// Those that a plane of find_failures runs on into; see kTileTableAsked.
void Soil::Impl::wake_neighbours(int index, int32_t asked) {
    table_dirty = true;  // takes back what was asked
    for (int n = 0; n < 9; ++n) {
        const int tx = index % tiles_x + n % 3 - 1, ty = index / tiles_x + n / 3 - 1;
        if ((asked >> n & 1) != 0 && tx >= 0 && ty >= 0 && tx < tiles_x && ty < tiles_y) {
            activate(static_cast<BlockKey>(tile_index(tx, ty)) * blocks_per_tile);
        }
    }
}

void Soil::Impl::read_activity() {
    const size_t blocks = static_cast<size_t>(slot_count) * blocks_per_tile;
    for (int slot = 0; slot < slot_count; ++slot) {
        const int index = slot_tile[slot];
        if (index < 0) {
            continue;
        }
        Tile& tile = *tiles[index];
        bool changed = false;
        int changed_top = 0;
        for (int zb = 0; zb < blocks_per_tile; ++zb) {
            const size_t block = static_cast<size_t>(slot) * blocks_per_tile + zb;
            if (flag_words[block] == params.step_stamp) {
                changed = true;
                changed_top = (zb + 1) * kTileSide;
                activate(static_cast<BlockKey>(index) * blocks_per_tile + zb);
            }
            if (flag_words[blocks + block] == params.step_stamp) {
                activate(static_cast<BlockKey>(index) * blocks_per_tile + zb);
            }
        }
        tile.revision += changed;
        if (const int32_t asked =
                tile_table[static_cast<size_t>(slot) * kTileTableWords + kTileTableAsked];
            asked > 0) {
            wake_neighbours(index, asked);
        }
        const int32_t top = tile_table[static_cast<size_t>(slot) * kTileTableWords + kTileTableTop];
        if (top / kTileTopStep == params.step_stamp) {
            // find_support looks no higher than soil was expected to reach; where soil moved it may
            // have come higher.
            tile.top = std::max(top % kTileTopStep, changed_top);
        }
    }
}

}  // namespace bsoil
