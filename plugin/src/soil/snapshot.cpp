// Snapshots: all that a soil carries from one step to the next, as bytes and back.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>
#include <unordered_map>

#include "bsoil/snapshot_file.h"
#include "contact/law_fields.h"
#include "soil/def_fields.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr char kSection[] = "soil";
// Passes are numbered by 32 bits; step() starts again long before.
constexpr int32_t kPassStampMost = (1 << 30) + (1 << 20);
// Steps of a million years.
constexpr int64_t kStepsMost = int64_t{1} << 53;
// What a voxel may hold: the headroom of the kernels' integers (plugin/README.md). Of a soil that
// has left it (amount_headroom) a snapshot is refused.
constexpr int64_t kMassMost = 2 * kVoxelMost - 1;  // 16 voxels of 4000 kg/m3
constexpr int64_t kMomentumMost = 1 << 30;
constexpr int64_t kForceMost = 1 << 30;
// Bodies in a voxel: 16384 shapes that cover all of it.
constexpr int64_t kCoverageMost = 1 << 30;
// Whole units of mass and momentum do not go into quite equal parts: a unit of mass can come with
// the momentum of this many, at twice the speed (Q10 voxels a step) that any soil gets.
constexpr int64_t kMassSlack = 256;
constexpr int64_t kSpeedSlack = 2 * (kSpeedMost / 64);

template <typename... T>
Status damaged(fmt::format_string<T...> text, T&&... values) {
    return Error{"is damaged: " + fmt::format(text, std::forward<T>(values)...)};
}

// Planes that are made from the bodies, but not in every step: an awake tile keeps them.
constexpr int kBodyPlanes[] = {kPlaneCoverage, kPlaneOwner, kPlaneSupport};
constexpr int kBodyPlaneCount = 3;

/// To find the bytes of a tile among others.
std::string_view key_of(const std::vector<uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct NamedValue {
    std::string name;
    double value = 0;
};

/// All of a definition that a state means something by, or that decides how it goes on.
std::vector<NamedValue> meaning_of(const SoilDef& def, const std::vector<MaterialDef>& materials) {
    std::vector<NamedValue> values;
    for_each_number(def, [&](const FieldNumber& field) {
        if (field.use == FieldUse::state) values.push_back({field.name, field.value});
    });
    values.push_back({"contact_law.kind", static_cast<double>(def.contact_law.kind)});
    for_each_constant(def.contact_law, [&](const char* name, double value, double, double) {
        values.push_back({std::string("contact_law.") + name, value});
    });
    for (const MaterialDef& material : materials) {
        for_each_number(material, [&](const FieldNumber& field) {
            values.push_back(
                {fmt::format("{} of material '{}'", field.name, material.name), field.value});
        });
    }
    return values;
}

/// Whether a snapshot's values are those of a soil. What a snapshot does not name was a default
/// when it was written: there was no such field.
Status compare_meaning(const std::vector<NamedValue>& saved, const SoilDef& def,
                       const std::vector<MaterialDef>& materials) {
    SoilDef default_def;
    default_def.contact_law.kind = def.contact_law.kind;
    std::vector<MaterialDef> default_materials(materials.size());
    for (size_t i = 0; i < materials.size(); ++i) default_materials[i].name = materials[i].name;
    const std::vector<NamedValue> here = meaning_of(def, materials),
                                  fallbacks = meaning_of(default_def, default_materials);
    size_t found = 0;
    for (size_t i = 0; i < here.size(); ++i) {
        const auto same = std::find_if(saved.begin(), saved.end(),
                                       [&](const NamedValue& v) { return v.name == here[i].name; });
        found += same != saved.end();
        const double value = same == saved.end() ? fallbacks[i].value : same->value;
        if (value != here[i].value)
            return Error{fmt::format("is of a soil with {} {:.9g}, this one has {} {:.9g}",
                                     here[i].name, value, here[i].name, here[i].value)};
    }
    if (found == saved.size()) return Done{};
    const auto unknown = std::find_if(saved.begin(), saved.end(), [&](const NamedValue& v) {
        return std::none_of(here.begin(), here.end(),
                            [&](const NamedValue& known) { return known.name == v.name; });
    });
    if (unknown == saved.end()) return Error{"is damaged"};
    return Error{fmt::format("is of a soil with {} {:.9g}, which this version does not know",
                             unknown->name, unknown->value)};
}

struct SavedTile {
    int64_t index = 0;
    int32_t top = 0;
    bool unchecked = false, awake = false;
    std::vector<uint8_t> kept;            ///< packed
    std::vector<uint8_t> ground, buried;  ///< packed; see Tile
    // Of an awake tile:
    int64_t last_used_step = 0;
    std::vector<uint8_t> bodies;            ///< packed; see kBodyPlanes
    std::vector<int32_t> columns, surface;  ///< see Buffer::spans

    void list(StateStream& stream) {
        stream(index, top, unchecked, awake, kept, ground, buried);
        if (awake) stream(last_used_step, bodies, columns, surface);
    }
};

struct SavedTrack {
    int32_t id = 0, index = 0;
    BodyTrack track;

    void list(StateStream& stream) {
        stream(id, index, track.pose, track.shape_revision, track.is_static, track.last_step,
               track.blocks, track.last_moved_step, track.is_ground, track.ground_pose);
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
    bool any_unchecked = false;
    std::vector<Condition> conditions;
    std::vector<SavedActive> active;
    std::vector<int32_t> body_ids;
    std::vector<SavedTrack> tracks;
    std::vector<SavedTile> tiles;

    void list(StateStream& stream) {
        stream.list(materials, 8, [&](std::string& name) { stream(name); });
        stream.list(meaning, 16, [&](NamedValue& v) { stream(v.name, v.value); });
        stream(step_index, speed_q16, slope_q16, slip_turn, pass_stamp, step_stamp, any_unchecked);
        stream.list(conditions, 61, [&](Condition& c) { bsoil::list(stream, c); });
        stream.list(active, 16, [&](SavedActive& a) { stream(a.block, a.changed); });
        stream(body_ids);
        stream.list(tracks, 140, [&](SavedTrack& t) { t.list(stream); });
        stream.list(tiles, 38, [&](SavedTile& t) { t.list(stream); });
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
    Status check_state(const SavedSoil& saved) const;
    Status check_bodies(const SavedSoil& saved) const;
    Status check_soil(const SavedTile& tile, const TileVoxels& kept) const;
    Status check_fill_up(const SavedTile& tile, const TileVoxels& kept,
                         const TileVoxels* bodies) const;
    Status check_ground(const SavedTile& tile, const TileVoxels& kept) const;
    Status check_awake(const SavedTile& tile, const SavedSoil& saved, TileVoxels& bodies) const;
    Status check_columns(const SavedTile& tile) const;
    Status check_words(const SavedTile& tile, const char* plane, std::span<const int32_t> words,
                       int64_t low, int64_t high) const;
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
    out.conditions.assign(s_.conditions.all().begin(), s_.conditions.all().end());
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
        if (tile->ground) saved.ground = *tile->ground;
        if (tile->buried) saved.buried = *tile->buried;
        saved.awake = tile->slot >= 0;
        if (!saved.awake) {
            saved.kept.assign(tile->bytes().begin(), tile->bytes().end());
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
    if (Status sound = check_state(saved); !sound) return sound;
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
    return compare_meaning(saved.meaning, s_.def, s_.materials);
}

bool SoilSnapshot::are_blocks_sound(const std::vector<BlockKey>& blocks) const {
    const auto most = static_cast<BlockKey>(s_.tiles.size()) * s_.blocks_per_tile;
    return std::is_sorted(blocks.begin(), blocks.end()) &&
           (blocks.empty() || (blocks.front() >= 0 && blocks.back() < most));
}

Status SoilSnapshot::check_bodies(const SavedSoil& saved) const {
    if (saved.body_ids.size() > limits::kBodyCapacity)
        return damaged("{} bodies, at most {} are possible", saved.body_ids.size(),
                       limits::kBodyCapacity);
    size_t taken = 0;
    for (const int32_t id : saved.body_ids) {
        if (id < -1 || id > 65534) return damaged("a body has the id {}", id);
        taken += id >= 0;
    }
    if (taken != saved.tracks.size())
        return damaged("{} bodies have {} records", taken, saved.tracks.size());
    int32_t before = -1;
    for (const SavedTrack& t : saved.tracks) {
        if (t.id <= before || t.index < 0 ||
            static_cast<size_t>(t.index) >= saved.body_ids.size() ||
            saved.body_ids[static_cast<size_t>(t.index)] != t.id)
            return damaged("body {} is not where it should be in the list", t.id);
        if (t.track.last_step < -1 || t.track.last_step > saved.step_index)
            return damaged("body {} was last seen in step {} of {}", t.id, t.track.last_step,
                           saved.step_index);
        if (!are_blocks_sound(t.track.blocks))
            return damaged("body {} stands in blocks outside of the grid", t.id);
        before = t.id;
    }
    return Done{};
}

// Every word in its range: the kernels' integers hold what these can come to, and nothing else.
Status SoilSnapshot::check_words(const SavedTile& tile, const char* plane,
                                 std::span<const int32_t> words, int64_t low, int64_t high) const {
    for (const int32_t word : words)
        if (word < low || word > high)
            return damaged("{} of a voxel in tile {} is {}, must be {} to {}", plane, tile.index,
                           word, low, high);
    return Done{};
}

Status SoilSnapshot::check_soil(const SavedTile& tile, const TileVoxels& kept) const {
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    const auto plane = [&](int p) {
        return std::span(kept.words).subspan(static_cast<size_t>(p) * words, words);
    };
    const auto check = [&](const char* name, int p, int64_t low, int64_t high) {
        return check_words(tile, name, plane(p), low, high);
    };
    for (const Status& status :
         {check("terrain", kKeptTerrain, 0, kVoxelFull),
          check("volume", kKeptVolume, 0, kVoxelMost),
          check("momentum", kKeptMomentum, -kMomentumMost, kMomentumMost),
          check("momentum", kKeptMomentum + 1, -kMomentumMost, kMomentumMost),
          check("momentum", kKeptMomentum + 2, -kMomentumMost, kMomentumMost),
          check("force", kKeptForce, -kForceMost, kForceMost),
          check("force", kKeptForce + 1, -kForceMost, kForceMost),
          check("force", kKeptForce + 2, -kForceMost, kForceMost),
          check("bond", kKeptBond, -kVoxelMost, kVoxelMost)})
        if (!status) return status;
    std::vector<int64_t> mass(words, 0);
    for (int m = 0; m < s_.params.material_count; ++m) {
        if (Status status = check("mass", kKeptMaterial + m, 0, kMassMost); !status) return status;
        const std::span<const int32_t> of_material = plane(kKeptMaterial + m);
        for (size_t v = 0; v < words; ++v) mass[v] += of_material[v];
    }
    for (size_t v = 0; v < words; ++v) {
        if (mass[v] > kMassMost)
            return damaged("mass of a voxel in tile {} is {}, must be 0 to {}", tile.index, mass[v],
                           kMassMost);
        for (int axis = 0; axis < 3; ++axis) {
            const int64_t momentum = plane(kKeptMomentum + axis)[v];
            if (std::abs(momentum) > (mass[v] + kMassSlack) * kSpeedSlack)
                return damaged("momentum of a voxel in tile {} is {}, too much for its mass of {}",
                               tile.index, momentum, mass[v]);
        }
    }
    return Done{};
}

// What ground bodies add to the terrain, and the soil that lies buried in them.
Status SoilSnapshot::check_ground(const SavedTile& tile, const TileVoxels& kept) const {
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    TileVoxels voxels;
    if (!tile.ground.empty()) {
        voxels.reset(s_.height, 1);
        if (!unpack_tile(tile.ground, voxels))
            return damaged("bytes of the ground in tile {} are no voxels", tile.index);
        for (size_t v = 0; v < words; ++v)
            if (voxels.words[v] < 0 || voxels.words[v] > kept.words[v])
                return damaged("ground of a voxel in tile {} is {}, its terrain is {}", tile.index,
                               voxels.words[v], kept.words[v]);
    }
    if (!tile.buried.empty()) {
        voxels.reset(s_.height, s_.kept_planes);
        if (!unpack_tile(tile.buried, voxels))
            return damaged("bytes of the buried soil in tile {} are no voxels", tile.index);
        if (Status status = check_soil(tile, voxels); !status) return status;
        for (const int p : {kKeptTerrain, kKeptMomentum, kKeptMomentum + 1, kKeptMomentum + 2,
                            kKeptForce, kKeptForce + 1, kKeptForce + 2}) {
            const auto plane =
                std::span(voxels.words).subspan(static_cast<size_t>(p) * words, words);
            if (Status status = check_words(tile, "motion of buried soil", plane, 0, 0); !status)
                return status;
        }
    }
    return Done{};
}

// Columns that only fill up a last tile are a wall, without soil or bodies.
Status SoilSnapshot::check_fill_up(const SavedTile& tile, const TileVoxels& kept,
                                   const TileVoxels* bodies) const {
    const int x0 = static_cast<int>(tile.index % s_.tiles_x) * kTileSide;
    const int y0 = static_cast<int>(tile.index / s_.tiles_x) * kTileSide;
    for (int c = 0; c < kTileColumns; ++c) {
        if (x0 + c % kTileSide < s_.frame.size[0] && y0 + c / kTileSide < s_.frame.size[1])
            continue;
        for (int z = 0; z < s_.height; ++z) {
            bool is_wall = kept.at(kKeptTerrain, z, c) == kVoxelFull;
            for (int p = 1; p < kept.plane_count; ++p) is_wall &= kept.at(p, z, c) == 0;
            for (int p = 0; bodies && p < kBodyPlaneCount; ++p) is_wall &= bodies->at(p, z, c) == 0;
            if (!is_wall)
                return damaged("tile {} has something beyond the sides of the grid", tile.index);
        }
    }
    return Done{};
}

Status SoilSnapshot::check_columns(const SavedTile& tile) const {
    const int64_t top = int64_t{s_.height} * kVoxelFull;
    if (tile.surface.size() != kTileColumns ||
        tile.columns.size() != static_cast<size_t>(kTileColumns) * kColumnWords)
        return damaged("tile {} has no height spans", tile.index);
    const auto check = [&](const char* name, int64_t value, int64_t low, int64_t high) {
        if (value >= low && value <= high) return Status{Done{}};
        return damaged("{} of a height span in tile {} is {}, must be {} to {}", name, tile.index,
                       value, low, high);
    };
    for (size_t c = 0; c < kTileColumns; ++c) {
        const int32_t* column = &tile.columns[c * kColumnWords];
        Status status = check("count", column[0], 0, kSpanCapacity);
        const int32_t surface = tile.surface[c];
        if (status)
            status = surface <= kTerrainTop
                         ? check("bare surface", surface, kTerrainTop - top, kTerrainTop)
                         : check("surface", surface, kCovered - top, top);
        for (int i = 0; i < kSpanCapacity && status; ++i) {
            const int32_t* span = column + 1 + i * kSpanWords;
            status = check("bottom", span[0], 0, top);
            if (status) status = check("top", span[1], span[0], top);
            if (status) status = check("kind", span[2], 0, kSpanFalling);
            for (int turn = 0; turn < 2 && status; ++turn)
                status =
                    check("speed", column[kColumnSpeed + turn * kSpanCapacity + i], 0, kVoxelFull);
        }
        if (!status) return status;
    }
    return Done{};
}

Status SoilSnapshot::check_awake(const SavedTile& tile, const SavedSoil& saved,
                                 TileVoxels& bodies) const {
    if (tile.last_used_step < 0 || tile.last_used_step > saved.step_index)
        return damaged("tile {} was last used in step {} of {}", tile.index, tile.last_used_step,
                       saved.step_index);
    if (!unpack_tile(tile.bodies, bodies))
        return damaged("bytes of the bodies in tile {} are no voxels", tile.index);
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    const auto plane = [&](size_t p) { return std::span(bodies.words).subspan(p * words, words); };
    const auto body_count = static_cast<int64_t>(saved.body_ids.size());
    if (Status status = check_words(tile, "coverage", plane(0), 0, kCoverageMost); !status)
        return status;
    for (const int32_t owner : plane(1))
        if (owner < 0 || (owner & 0xffff) > body_count)
            return damaged("owner of a voxel in tile {} is {}, there are {} bodies", tile.index,
                           owner, body_count);
    if (Status status = check_words(tile, "support", plane(2), 0, kSupportBody + body_count - 1);
        !status)
        return status;
    return check_columns(tile);
}

Status SoilSnapshot::check_state(const SavedSoil& saved) const {
    const auto check = [](const char* name, int64_t value, int64_t low, int64_t high) {
        if (value >= low && value <= high) return Status{Done{}};
        return damaged("{} is {}, must be {} to {}", name, value, low, high);
    };
    const int64_t stamp = saved.step_index > 0 ? step_stamp_of(saved.step_index) : 0;
    for (const Status& status :
         {check("step_index", saved.step_index, 0, kStepsMost),
          check("step_stamp", saved.step_stamp, stamp, stamp),
          check("speed", saved.speed_q16, 0, INT32_MAX),
          check("slope", saved.slope_q16, 0, int64_t{s_.height} * kVoxelFull),
          check("slip_turn", saved.slip_turn, 0, 1),
          check("pass_stamp", saved.pass_stamp, 0, kPassStampMost)})
        if (!status) return status;
    if (Status sound = ConditionLog::check(saved.conditions, saved.step_index); !sound)
        return damaged("{}", sound.error());
    std::vector<BlockKey> blocks;
    for (const SavedActive& a : saved.active) {
        if (Status status = check("step of an active block", a.changed, 0, saved.step_index);
            !status)
            return status;
        blocks.push_back(a.block);
    }
    if (!are_blocks_sound(blocks)) return damaged("an active block is outside of the grid");
    if (Status status = check_bodies(saved); !status) return status;
    TileVoxels kept, bodies;
    kept.reset(s_.height, s_.kept_planes);
    bodies.reset(s_.height, kBodyPlaneCount);
    std::set<std::array<std::string_view, 3>> sound;  // contents that have been looked at
    int64_t before = -1;
    for (const SavedTile& tile : saved.tiles) {
        if (tile.index <= before || tile.index >= static_cast<int64_t>(s_.tiles.size()))
            return damaged("tile {} follows tile {} of {}", tile.index, before, s_.tiles.size());
        before = tile.index;
        if (Status status = check("top of a tile", tile.top, 0, s_.height); !status) return status;
        const bool is_last = (tile.index % s_.tiles_x + 1) * kTileSide > s_.frame.size[0] ||
                             (tile.index / s_.tiles_x + 1) * kTileSide > s_.frame.size[1];
        const std::array<std::string_view, 3> content{key_of(tile.kept), key_of(tile.ground),
                                                      key_of(tile.buried)};
        if (sound.contains(content) && !tile.awake && !is_last) continue;
        if (!unpack_tile(tile.kept, kept))
            return damaged("bytes of tile {} are no voxels", tile.index);
        if (Status status = check_soil(tile, kept); !status) return status;
        if (Status status = check_ground(tile, kept); !status) return status;
        if (tile.awake) {
            if (Status status = check_awake(tile, saved, bodies); !status) return status;
        }
        if (is_last) {
            if (Status status = check_fill_up(tile, kept, tile.awake ? &bodies : nullptr); !status)
                return status;
        }
        if (!tile.awake) sound.insert(content);
    }
    return Done{};
}

void SoilSnapshot::put(const SavedSoil& saved) {
    // Whoever remembers a tile's revision must see that it is another tile now.
    for (const auto& tile : s_.tiles)
        if (tile) s_.revision_base = std::max(s_.revision_base, tile->revision);
    ++s_.revision_base;
    s_.contacts_known = false;
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
    s_.forget_stamps();

    s_.step_index = saved.step_index;
    s_.speed_q16 = saved.speed_q16;
    s_.slope_q16 = saved.slope_q16;
    s_.conditions.begin_step(saved.step_index, s_.def.step_s);
    s_.conditions.replace(saved.conditions);
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
    s_.ground_shapes.clear();
    s_.ground_listed = false;
    for (const SavedTrack& t : saved.tracks) {
        s_.bodies[t.id] = t.track;
        s_.bodies[t.id].index = t.index;
    }
    // Tiles that held the same share it again.
    std::unordered_map<std::string_view, std::shared_ptr<const PackedTile>> known;
    std::unordered_map<std::string_view, TileBytes> known_bytes;
    const auto shared = [&](const std::vector<uint8_t>& bytes) {
        if (bytes.empty()) return TileBytes{};
        TileBytes& entry = known_bytes[key_of(bytes)];
        if (!entry) entry = std::make_shared<const std::vector<uint8_t>>(bytes);
        return entry;
    };
    for (const SavedTile& tile : saved.tiles) {
        auto made = std::make_unique<Tile>();
        made->revision = s_.revision_base + 1;
        auto& packed = known[key_of(tile.kept)];
        if (!packed && !tile.kept.empty()) {
            packed = std::make_shared<PackedTile>(PackedTile{tile.kept, tile.top, {}});
        }
        made->packed = packed;
        made->unchecked = tile.unchecked;
        made->ground = shared(tile.ground);
        made->buried = shared(tile.buried);
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
    s_.note_stale(static_cast<int>(slot), true);
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
