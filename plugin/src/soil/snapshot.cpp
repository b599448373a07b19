// Snapshots: all that a soil carries from one step to the next, as bytes and back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bsoil/snapshot_file.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr char kSection[] = "soil";
// Passes are numbered by 32 bits; step() starts again long before.
constexpr int32_t kPassStampMost = (1 << 30) + (1 << 20);
// More voxels a step than anything can have, Q16.
constexpr int64_t kSpeedLimit = int64_t{1} << 31;

// Planes that are made from the bodies, but not in every step: an awake tile keeps them.
constexpr int kBodyPlanes[] = {kPlaneCoverage, kPlaneOwner, kPlaneSupport};
constexpr int kBodyPlaneCount = 3;

struct NamedValue {
    std::string name;
    double value = 0;
};

/// All of a definition that a state means something by, or that decides how it goes on.
std::vector<NamedValue> meaning_of(const SoilDef& def, const std::vector<MaterialDef>& materials) {
    std::vector<NamedValue> values{
        {"size_m.x", def.size_m.x},
        {"size_m.y", def.size_m.y},
        {"size_m.z", def.size_m.z},
        {"voxel_m", def.voxel_m},
        {"floor_center_m.x", def.floor_center_m.x},
        {"floor_center_m.y", def.floor_center_m.y},
        {"floor_center_m.z", def.floor_center_m.z},
        {"yaw_rad", def.yaw_rad},
        {"up", static_cast<double>(def.up)},
        {"gravity_m_s2", def.gravity_m_s2},
        {"step_s", def.step_s},
        {"propagation_iterations", static_cast<double>(def.propagation_iterations)},
        {"overflow_passes", static_cast<double>(def.overflow_passes)},
        {"overflow", static_cast<double>(def.overflow)},
        {"substeps_max", static_cast<double>(def.substeps_max)},
    };
    for (const MaterialDef& material : materials) {
        // All members by name: one more does not compile until it stands in the list, or is left
        // out on purpose as the name (compared apart) and the colour are.
        const auto& [name, density, loose, compacted, friction_angle, cohesion, loose_cohesion,
                     tool_friction, tool_adhesion, shear_displacement, color] = material;
        static_cast<void>(color);
        const std::pair<const char*, double> fields[] = {
            {"density_kg_m3", density},
            {"loose_density_kg_m3", loose},
            {"compacted_density_kg_m3", compacted},
            {"friction_angle_rad", friction_angle},
            {"cohesion_pa", cohesion},
            {"loose_cohesion_fraction", loose_cohesion},
            {"tool_friction", tool_friction},
            {"tool_adhesion_pa", tool_adhesion},
            {"shear_displacement_m", shear_displacement},
        };
        for (const auto& [field, value] : fields)
            values.push_back({fmt::format("{} of material '{}'", field, name), value});
    }
    return values;
}

struct SavedTile {
    int64_t index = 0;
    int32_t top = 0;
    bool unchecked = false, awake = false;
    std::vector<uint8_t> kept;  ///< packed
    // Of an awake tile:
    int64_t last_used_step = 0;
    std::vector<uint8_t> bodies;            ///< packed; see kBodyPlanes
    std::vector<int32_t> columns, surface;  ///< see Buffer::spans

    void list(StateStream& stream) {
        stream(index, top, unchecked, awake, kept);
        if (awake) stream(last_used_step, bodies, columns, surface);
    }
};

struct SavedTrack {
    int32_t id = 0, index = 0;
    BodyTrack track;

    void list(StateStream& stream) {
        stream(id, index, track.pose, track.shape_revision, track.is_static, track.last_step,
               track.blocks);
    }
};

struct SavedActive {
    BlockKey block = 0;
    int64_t changed = 0;
};

}  // namespace

/// The state of a soil as a snapshot holds it.
struct SavedSoil {
    std::vector<std::string> materials;
    std::vector<NamedValue> meaning;
    int64_t step_index = 0, speed_q16 = 0;
    int32_t slope_q16 = 0, slip_turn = 0, pass_stamp = 0, step_stamp = 0;
    uint32_t status = 0;
    bool any_unchecked = false;
    std::vector<SavedActive> active;
    std::vector<int32_t> body_ids;
    std::vector<SavedTrack> tracks;
    std::vector<SavedTile> tiles;

    void list(StateStream& stream) {
        stream.list(materials, 8, [&](std::string& name) { stream(name); });
        stream.list(meaning, 16, [&](NamedValue& v) { stream(v.name, v.value); });
        stream(step_index, speed_q16, slope_q16, slip_turn, pass_stamp, step_stamp, status,
               any_unchecked);
        stream.list(active, 16, [&](SavedActive& a) { stream(a.block, a.changed); });
        stream(body_ids);
        stream.list(tracks, 80, [&](SavedTrack& t) { t.list(stream); });
        stream.list(tiles, 22, [&](SavedTile& t) { t.list(stream); });
    }
};

/// Takes states out of a soil, checks them and puts them in.
class SoilSnapshot {
  public:
    explicit SoilSnapshot(Soil::Impl& soil) : s_(soil) {}

    SavedSoil take() const;
    Status check(const SavedSoil& saved) const;
    void put(const SavedSoil& saved);

  private:
    Status check_meaning(const SavedSoil& saved) const;
    bool is_sound(const SavedSoil& saved) const;
    bool are_bodies_sound(const SavedSoil& saved) const;
    bool is_sound(const SavedTile& tile, const SavedSoil& saved, TileVoxels& kept,
                  TileVoxels& bodies) const;
    bool are_blocks_sound(const std::vector<BlockKey>& blocks) const;
    void put_awake(const SavedTile& tile);
    TileVoxels body_planes(int slot) const;

    Soil::Impl& s_;
};

TileVoxels SoilSnapshot::body_planes(int slot) const {
    TileVoxels out;
    out.reset(s_.height, kBodyPlaneCount);
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    for (size_t p = 0; p < kBodyPlaneCount; ++p) {
        s_.device->read(Buffer::state,
                        static_cast<int64_t>(kBodyPlanes[p]) * s_.params.plane_stride +
                            static_cast<int64_t>(slot) * s_.params.tile_voxels,
                        std::span(out.words).subspan(p * words, words));
    }
    return out;
}

SavedSoil SoilSnapshot::take() const {
    SavedSoil out;
    for (const MaterialDef& material : s_.materials) out.materials.push_back(material.name);
    out.meaning = meaning_of(s_.def, s_.materials);
    out.step_index = s_.step_index;
    out.speed_q16 = s_.speed_q16;
    out.slope_q16 = s_.slope_q16;
    out.slip_turn = s_.params.slip_turn;
    out.pass_stamp = s_.params.pass_stamp;
    out.step_stamp = s_.params.step_stamp;
    out.status = s_.status;
    out.any_unchecked = s_.any_unchecked;
    for (const auto& [block, changed] : s_.active) out.active.push_back({block, changed});
    std::sort(out.active.begin(), out.active.end(),
              [](const SavedActive& a, const SavedActive& b) { return a.block < b.block; });
    out.body_ids.assign(s_.body_ids.begin(), s_.body_ids.end());
    for (const auto& [id, track] : s_.bodies) out.tracks.push_back({id, track.index, track});
    std::sort(out.tracks.begin(), out.tracks.end(),
              [](const SavedTrack& a, const SavedTrack& b) { return a.id < b.id; });
    TileVoxels voxels;
    for (size_t index = 0; index < s_.tiles.size(); ++index) {
        const Tile* tile = s_.tiles[index].get();
        if (!tile) continue;
        SavedTile& saved = out.tiles.emplace_back();
        saved.index = static_cast<int64_t>(index);
        saved.top = tile->top;
        saved.unchecked = tile->unchecked;
        saved.awake = tile->slot >= 0;
        if (!saved.awake) {
            saved.kept = tile->packed;
            continue;
        }
        s_.read_voxels(static_cast<int>(index), voxels);
        saved.kept = pack_tile(voxels);
        saved.last_used_step = tile->last_used_step;
        saved.bodies = pack_tile(body_planes(tile->slot));
        saved.columns.resize(static_cast<size_t>(kTileColumns) * kColumnWords);
        saved.surface.resize(kTileColumns);
        const int64_t slot = tile->slot;
        s_.device->read(Buffer::spans, slot * kTileColumns * kColumnWords, saved.columns);
        s_.device->read(Buffer::spans,
                        (static_cast<int64_t>(s_.slot_count) * kColumnWords + slot) * kTileColumns,
                        saved.surface);
    }
    return out;
}

Status SoilSnapshot::check(const SavedSoil& saved) const {
    if (Status same = check_meaning(saved); !same) return same;
    if (!is_sound(saved)) return Error{"is damaged"};
    const auto awake = std::count_if(saved.tiles.begin(), saved.tiles.end(),
                                     [](const SavedTile& tile) { return tile.awake; });
    if (awake > s_.slot_count && !s_.grow_slots(static_cast<int>(awake)))
        return Error{
            fmt::format("has {} awake tiles, tile_capacity or memory allows fewer ({} now)", awake,
                        s_.slot_count)};
    return Done{};
}

Status SoilSnapshot::check_meaning(const SavedSoil& saved) const {
    std::vector<std::string> names;
    for (const MaterialDef& material : s_.materials) names.push_back(material.name);
    if (saved.materials != names)
        return Error{fmt::format("is of a soil of {}, this one is of {}",
                                 fmt::join(saved.materials, ", "), fmt::join(names, ", "))};
    const std::vector<NamedValue> here = meaning_of(s_.def, s_.materials);
    if (saved.meaning.size() != here.size()) return Error{"is damaged"};
    for (size_t i = 0; i < here.size(); ++i)
        if (saved.meaning[i].name != here[i].name || saved.meaning[i].value != here[i].value)
            return Error{fmt::format("is of a soil with {} {:.9g}, this one has {} {:.9g}",
                                     saved.meaning[i].name, saved.meaning[i].value, here[i].name,
                                     here[i].value)};
    return Done{};
}

bool SoilSnapshot::are_blocks_sound(const std::vector<BlockKey>& blocks) const {
    const auto most = static_cast<BlockKey>(s_.tiles.size()) * s_.blocks_per_tile;
    return std::is_sorted(blocks.begin(), blocks.end()) &&
           (blocks.empty() || (blocks.front() >= 0 && blocks.back() < most));
}

bool SoilSnapshot::are_bodies_sound(const SavedSoil& saved) const {
    if (saved.body_ids.size() > limits::kBodyCapacity) return false;
    size_t taken = 0;
    for (const int32_t id : saved.body_ids) {
        if (id < -1 || id > 65534) return false;
        taken += id >= 0;
    }
    if (taken != saved.tracks.size()) return false;
    int32_t before = -1;
    for (const SavedTrack& t : saved.tracks) {
        if (t.id <= before || t.index < 0 ||
            static_cast<size_t>(t.index) >= saved.body_ids.size() ||
            saved.body_ids[static_cast<size_t>(t.index)] != t.id || t.track.last_step < -1 ||
            t.track.last_step > saved.step_index || !are_blocks_sound(t.track.blocks))
            return false;
        before = t.id;
    }
    return true;
}

// What the kernels use as an index, or take for granted, must be so whatever the file says.
bool SoilSnapshot::is_sound(const SavedTile& tile, const SavedSoil& saved, TileVoxels& kept,
                            TileVoxels& bodies) const {
    if (tile.top < 0 || tile.top > s_.height || !unpack_tile(tile.kept, kept)) return false;
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    const auto all = [words](const TileVoxels& voxels, int plane, auto&& good) {
        const auto first = voxels.words.begin() + static_cast<std::ptrdiff_t>(words) * plane;
        return std::all_of(first, first + static_cast<std::ptrdiff_t>(words), good);
    };
    const auto not_negative = [](int32_t v) { return v >= 0; };
    if (!all(kept, kKeptTerrain, [](int32_t v) { return v >= 0 && v <= kVoxelFull; }) ||
        !all(kept, kKeptVolume, not_negative))
        return false;
    for (int m = 0; m < s_.params.material_count; ++m)
        if (!all(kept, kKeptMaterial + m, not_negative)) return false;
    if (!tile.awake) return true;
    const auto body_count = static_cast<int32_t>(saved.body_ids.size());
    if (tile.last_used_step < 0 || tile.last_used_step > saved.step_index ||
        tile.surface.size() != kTileColumns ||
        tile.columns.size() != static_cast<size_t>(kTileColumns) * kColumnWords ||
        !unpack_tile(tile.bodies, bodies) || !all(bodies, 0, not_negative) ||
        !all(bodies, 1, [&](int32_t v) { return v >= 0 && (v & 0xffff) <= body_count; }) ||
        !all(bodies, 2, [&](int32_t v) { return v >= 0 && v < kSupportBody + body_count; }))
        return false;
    for (size_t c = 0; c < kTileColumns; ++c) {
        const int32_t count = tile.columns[c * kColumnWords];
        if (count < 0 || count > kSpanCapacity) return false;
    }
    return true;
}

bool SoilSnapshot::is_sound(const SavedSoil& saved) const {
    if (saved.step_index < 0 || saved.speed_q16 < 0 || saved.speed_q16 > kSpeedLimit ||
        saved.slope_q16 < 0 || saved.slip_turn < 0 || saved.slip_turn > 1 || saved.pass_stamp < 0 ||
        saved.pass_stamp > kPassStampMost || saved.step_stamp < 0 ||
        saved.step_stamp > saved.step_index + 1)
        return false;
    std::vector<BlockKey> blocks;
    for (const SavedActive& a : saved.active) {
        if (a.changed < 0 || a.changed > saved.step_index) return false;
        blocks.push_back(a.block);
    }
    if (!are_blocks_sound(blocks) || !are_bodies_sound(saved)) return false;
    TileVoxels kept, bodies;
    kept.reset(s_.height, s_.kept_planes);
    bodies.reset(s_.height, kBodyPlaneCount);
    int64_t before = -1;
    for (const SavedTile& tile : saved.tiles) {
        if (tile.index <= before || tile.index >= static_cast<int64_t>(s_.tiles.size()) ||
            !is_sound(tile, saved, kept, bodies))
            return false;
        before = tile.index;
    }
    return true;
}

void SoilSnapshot::put(const SavedSoil& saved) {
    // Whoever remembers a tile's revision must see that it is another tile now.
    for (const auto& tile : s_.tiles)
        if (tile) s_.revision_base = std::max(s_.revision_base, tile->revision);
    ++s_.revision_base;
    for (auto& tile : s_.tiles) tile.reset();
    std::fill(s_.slot_tile.begin(), s_.slot_tile.end(), -1);
    s_.free_slots.clear();
    for (int slot = s_.slot_count - 1; slot >= 0; --slot) s_.free_slots.push_back(slot);
    s_.sampled_tile = -1;
    s_.table_dirty = true;
    for (auto* steps : {&s_.listed_step, &s_.rebuild_step, &s_.contact_step, &s_.woken_step})
        std::fill(steps->begin(), steps->end(), 0);
    s_.device->fill_zero(Buffer::block_flags, 0,
                         static_cast<int64_t>(kFlagArrays) * s_.slot_count * s_.blocks_per_tile);

    s_.step_index = saved.step_index;
    s_.speed_q16 = saved.speed_q16;
    s_.slope_q16 = saved.slope_q16;
    s_.status = saved.status;
    s_.any_unchecked = saved.any_unchecked;
    s_.params.slip_turn = saved.slip_turn;
    s_.params.pass_stamp = saved.pass_stamp;
    s_.params.step_stamp = saved.step_stamp;
    s_.contacts.clear();
    s_.loads.clear();
    s_.active.clear();
    for (const SavedActive& a : saved.active) s_.active[a.block] = a.changed;
    s_.body_ids.assign(saved.body_ids.begin(), saved.body_ids.end());
    s_.bodies.clear();
    for (const SavedTrack& t : saved.tracks) {
        s_.bodies[t.id] = t.track;
        s_.bodies[t.id].index = t.index;
    }
    for (const SavedTile& tile : saved.tiles) {
        auto made = std::make_unique<Tile>();
        made->revision = s_.revision_base + 1;
        made->packed = tile.kept;
        made->unchecked = tile.unchecked;
        s_.tiles[static_cast<size_t>(tile.index)] = std::move(made);
        if (tile.awake) put_awake(tile);
        s_.tiles[static_cast<size_t>(tile.index)]->top = tile.top;
    }
}

// check() has made room for all of them.
void SoilSnapshot::put_awake(const SavedTile& tile) {
    const int64_t slot = s_.wake(static_cast<int>(tile.index));
    s_.tiles[static_cast<size_t>(tile.index)]->last_used_step = tile.last_used_step;
    TileVoxels bodies;
    bodies.reset(s_.height, kBodyPlaneCount);
    unpack_tile(tile.bodies, bodies);
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    for (size_t p = 0; p < kBodyPlaneCount; ++p) {
        s_.device->write(Buffer::state,
                         static_cast<int64_t>(kBodyPlanes[p]) * s_.params.plane_stride +
                             slot * s_.params.tile_voxels,
                         std::span<const int32_t>(bodies.words).subspan(p * words, words));
    }
    s_.device->write(Buffer::spans, slot * kTileColumns * kColumnWords, tile.columns);
    s_.device->write(Buffer::spans,
                     (static_cast<int64_t>(s_.slot_count) * kColumnWords + slot) * kTileColumns,
                     tile.surface);
}

std::vector<uint8_t> Soil::state() const {
    StateStream stream;
    SoilSnapshot(*impl_).take().list(stream);
    return stream.bytes();
}

Result<std::function<void()>> Soil::prepare(std::span<const uint8_t> state) {
    auto saved = std::make_shared<SavedSoil>();
    StateStream stream(state);
    saved->list(stream);
    if (!stream.at_end()) return Error{"is damaged"};
    if (const Status sound = SoilSnapshot(*impl_).check(*saved); !sound)
        return Error{sound.error()};
    return std::function<void()>([this, saved] { SoilSnapshot(*impl_).put(*saved); });
}

Status Soil::save(const std::string& path) const {
    const SnapshotSection section{kSection, state()};
    return write_snapshot_file(path, {&section, 1});
}

Status Soil::load(const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const std::vector<uint8_t>* bytes = find_section(*sections, kSection);
    if (!bytes) return Error{fmt::format("snapshot '{}': holds no soil", path)};
    const auto put = prepare(*bytes);
    if (!put) return Error{fmt::format("snapshot '{}': {}", path, put.error())};
    (*put)();
    return Done{};
}

}  // namespace bsoil
