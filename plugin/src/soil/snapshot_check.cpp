// What a snapshot may hold: of this soil, whole, and within what the kernels' integers bear.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "contact/law_fields.h"
#include "soil/def_fields.h"
#include "soil/soil_snapshot.h"

namespace bsoil {

using namespace layout;

namespace {

// Passes are numbered by 32 bits; step() starts again long before.
constexpr int32_t kPassStampMost = (1 << 30) + (1 << 20);
// Steps of a million years.
constexpr int64_t kStepsMost = int64_t{1} << 53;
// What a voxel may hold is the headroom of the kernels' integers (kMassMost, kMomentumMost;
// plugin/README.md). Of a soil that has left it (amount_headroom) a snapshot is refused.
constexpr int64_t kForceMost = 1 << 30;
// Bodies in a voxel: 16384 shapes that cover all of it.
constexpr int64_t kCoverageMost = 1 << 30;
// Of what sources and sinks have moved: a full grid for a thousand years.
constexpr int64_t kFlowUnitsMost = int64_t{1} << 62;
// Whole units of mass and momentum do not go into quite equal parts: a unit of mass can come with
// the momentum of this many, at twice the speed (Q10 voxels a step) that any soil gets.
constexpr int64_t kMassSlack = 256;
constexpr int64_t kSpeedSlack = 2 * (kSpeedMost / 64);

template <typename... T>
Status damaged(fmt::format_string<T...> text, T&&... values) {
    return Error{"is damaged: " + fmt::format(text, std::forward<T>(values)...)};
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
        if (value != here[i].value) {
            return Error{
                fmt::format("is of a soil with {} {:.9g}, this one has {} {:.9g}; "
                            "create it as that was",
                            here[i].name, value, here[i].name, here[i].value)};
        }
    }
    if (found == saved.size()) return Done{};
    const auto unknown = std::find_if(saved.begin(), saved.end(), [&](const NamedValue& v) {
        return std::none_of(here.begin(), here.end(),
                            [&](const NamedValue& known) { return known.name == v.name; });
    });
    if (unknown == saved.end()) return Error{std::string("is damaged") + kTakeAnotherCopy};
    return Error{
        fmt::format("is of a soil with {} {:.9g}, which this version does not know; "
                    "load it with the one that wrote it",
                    unknown->name, unknown->value)};
}

}  // namespace

/// All of a definition that a state means something by, or that decides how it goes on.
std::vector<NamedValue> meaning_of(const SoilDef& def, const std::vector<MaterialDef>& materials) {
    std::vector<NamedValue> values;
    for_each_number(def, [&](const FieldNumber& field) {
        if (field.use != FieldUse::run && field.use != FieldUse::pace) {
            values.push_back({field.name, field.value});
        }
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

Status SoilSnapshot::check(const SavedSoil& saved) const {
    if (Status same = check_meaning(saved); !same) return same;
    if (Status sound = check_state(saved); !sound) {
        return Error{sound.error() + kTakeAnotherCopy};
    }
    const auto awake = std::count_if(saved.tiles.begin(), saved.tiles.end(),
                                     [](const SavedTile& tile) { return tile.awake; });
    if (awake > s_.tiles.slot_count() && !s_.tiles.grow_slots(static_cast<int>(awake))) {
        return Error{fmt::format(
            "has {} awake tiles, tile_capacity or memory allows fewer ({} now); raise it", awake,
            s_.tiles.slot_count())};
    }
    return Done{};
}

Status SoilSnapshot::check_meaning(const SavedSoil& saved) const {
    std::vector<std::string> names;
    for (const MaterialDef& material : s_.materials) names.push_back(material.name);
    if (saved.materials != names) {
        return Error{fmt::format("is of a soil of {}, this one is of {}; create it as that was",
                                 fmt::join(saved.materials, ", "), fmt::join(names, ", "))};
    }
    return compare_meaning(saved.meaning, s_.def, s_.materials);
}

bool SoilSnapshot::are_blocks_sound(const std::vector<BlockKey>& blocks) const {
    const auto most = static_cast<BlockKey>(s_.tiles.size()) * s_.blocks_per_tile;
    return std::is_sorted(blocks.begin(), blocks.end()) &&
           (blocks.empty() || (blocks.front() >= 0 && blocks.back() < most));
}

Status SoilSnapshot::check_bodies(const SavedSoil& saved) const {
    if (saved.body_ids.size() > limits::kBodyCapacity) {
        return damaged("{} bodies, at most {} are possible", saved.body_ids.size(),
                       limits::kBodyCapacity);
    }
    size_t taken = 0;
    for (const int32_t id : saved.body_ids) {
        if (id < -1 || id > limits::kBodyIdMost) return damaged("a body has the id {}", id);
        taken += id >= 0;
    }
    if (taken != saved.tracks.size()) {
        return damaged("{} bodies have {} records", taken, saved.tracks.size());
    }
    int32_t before = -1;
    for (const SavedTrack& t : saved.tracks) {
        if (t.id <= before || t.index < 0 ||
            static_cast<size_t>(t.index) >= saved.body_ids.size() ||
            saved.body_ids[static_cast<size_t>(t.index)] != t.id) {
            return damaged("body {} is not where it should be in the list", t.id);
        }
        if (t.track.last_step < -1 || t.track.last_step > saved.step_index) {
            return damaged("body {} was last seen in step {} of {}", t.id, t.track.last_step,
                           saved.step_index);
        }
        if (!are_blocks_sound(t.track.blocks)) {
            return damaged("body {} stands in blocks outside of the grid", t.id);
        }
        before = t.id;
    }
    before = -1;
    for (const SavedContact& c : saved.known_contacts) {
        if (c.body <= before || c.body > limits::kBodyIdMost || !(c.contact.width_m >= 0) ||
            !(c.contact.pressure_pa >= 0)) {
            return damaged("what is known of the contact of body {} is out of its range", c.body);
        }
        before = c.body;
    }
    return Done{};
}

// Definitions as add_source() and add_sink() take them, counts that a run can come to.
Status SoilSnapshot::check_flows(const SavedSoil& saved) const {
    if (saved.flows.size() > kFlowCapacity) {
        return damaged("{} sources and sinks, at most {} are possible", saved.flows.size(),
                       kFlowCapacity);
    }
    const auto materials = s_.materials.size();
    if (saved.units_in.size() != materials || saved.units_out.size() != materials) {
        return damaged("{} and {} sums of what came and went, there are {} materials",
                       saved.units_in.size(), saved.units_out.size(), materials);
    }
    const auto is_count = [](int64_t units) { return units >= 0 && units <= kFlowUnitsMost; };
    if (!std::ranges::all_of(saved.units_in, is_count) ||
        !std::ranges::all_of(saved.units_out, is_count)) {
        return damaged("what came or went is less than nothing");
    }
    if (!Water::is_state(saved.water, s_.water.is_there())) {
        return damaged("the account of its water has {} sums", saved.water.size());
    }
    const auto side_count = std::ranges::count_if(
        s_.flows.all(), [](const Flow& flow) { return flow.kind == FlowKind::open_side; });
    int32_t before = 0;
    for (size_t i = 0; i < saved.flows.size(); ++i) {
        Flow flow = saved.flows[i].flow;
        if (!is_count(flow.units) || !is_count(flow.missed_units) || !is_count(flow.held_units) ||
            !is_count(flow.lump_count) ||
            !(flow.since_s >= 0 && flow.since_s <= static_cast<double>(kStepsMost))) {
            return damaged("source or sink {} has moved {} units, missed {}, left {}", flow.id,
                           flow.units, flow.missed_units, flow.held_units);
        }
        const bool is_side = flow.kind == FlowKind::open_side;
        if (is_side != (static_cast<int64_t>(i) < side_count) ||
            (is_side && flow.id != s_.flows.all()[i].id)) {
            return damaged("its open sides are not those of the soil");
        }
        if (is_side) continue;
        if (flow.id <= before || flow.id >= saved.next_flow) {
            return damaged("source or sink {} follows {}, the next is {}", flow.id, before,
                           saved.next_flow);
        }
        before = flow.id;
        if (Status placed = s_.flows.place(flow); !placed) return damaged("{}", placed.error());
    }
    if (static_cast<int64_t>(saved.flows.size()) < side_count) {
        return damaged("its open sides are not those of the soil");
    }
    return Done{};
}

// Every word in its range: the kernels' integers hold what these can come to, and nothing else.
Status SoilSnapshot::check_words(const SavedTile& tile, const char* plane,
                                 std::span<const int32_t> words, int64_t low, int64_t high) const {
    for (const int32_t word : words) {
        if (word < low || word > high) {
            return damaged("{} of a voxel in tile {} is {}, must be {} to {}", plane, tile.index,
                           word, low, high);
        }
    }
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
          check("bond", kKeptBond, -kVoxelMost, kVoxelMost)}) {
        if (!status) return status;
    }
    if (s_.water.is_there()) {
        if (Status status = check("water", kKeptMaterial + s_.params.material_count, 0,
                                  kMassMost * kWaterParts);
            !status) {
            return status;
        }
    }
    std::vector<int64_t> mass(words, 0);
    for (int m = 0; m < s_.params.material_count; ++m) {
        if (Status status = check("mass", kKeptMaterial + m, 0, kMassMost); !status) return status;
        const std::span<const int32_t> of_material = plane(kKeptMaterial + m);
        for (size_t v = 0; v < words; ++v) mass[v] += of_material[v];
    }
    for (size_t v = 0; v < words; ++v) {
        if (mass[v] > kMassMost) {
            return damaged("mass of a voxel in tile {} is {}, must be 0 to {}", tile.index, mass[v],
                           kMassMost);
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int64_t momentum = plane(kKeptMomentum + axis)[v];
            if (std::abs(momentum) > (mass[v] + kMassSlack) * kSpeedSlack) {
                return damaged("momentum of a voxel in tile {} is {}, too much for its mass of {}",
                               tile.index, momentum, mass[v]);
            }
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
        if (!unpack_tile(tile.ground, voxels)) {
            return damaged("bytes of the ground in tile {} are no voxels", tile.index);
        }
        for (size_t v = 0; v < words; ++v) {
            if (voxels.words[v] < 0 || voxels.words[v] > kept.words[v]) {
                return damaged("ground of a voxel in tile {} is {}, its terrain is {}", tile.index,
                               voxels.words[v], kept.words[v]);
            }
        }
    }
    if (!tile.buried.empty()) {
        voxels.reset(s_.height, s_.kept_planes);
        if (!unpack_tile(tile.buried, voxels)) {
            return damaged("bytes of the buried soil in tile {} are no voxels", tile.index);
        }
        if (Status status = check_soil(tile, voxels); !status) return status;
        for (const int p : {kKeptTerrain, kKeptMomentum, kKeptMomentum + 1, kKeptMomentum + 2,
                            kKeptForce, kKeptForce + 1, kKeptForce + 2}) {
            const auto plane =
                std::span(voxels.words).subspan(static_cast<size_t>(p) * words, words);
            if (Status status = check_words(tile, "motion of buried soil", plane, 0, 0); !status) {
                return status;
            }
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
        if (x0 + c % kTileSide < s_.frame.size[0] && y0 + c / kTileSide < s_.frame.size[1]) {
            continue;
        }
        for (int z = 0; z < s_.height; ++z) {
            bool is_wall = kept.at(kKeptTerrain, z, c) == kVoxelFull;
            for (int p = 1; p < kept.plane_count; ++p) is_wall &= kept.at(p, z, c) == 0;
            for (int p = 0; bodies && p < kBodyPlaneCount; ++p) is_wall &= bodies->at(p, z, c) == 0;
            if (!is_wall) {
                return damaged("tile {} has something beyond the sides of the grid", tile.index);
            }
        }
    }
    return Done{};
}

Status SoilSnapshot::check_columns(const SavedTile& tile) const {
    const int64_t top = int64_t{s_.height} * kVoxelFull;
    if (tile.surface.size() != kTileColumns || tile.hollows.size() != kTileColumns ||
        tile.columns.size() != static_cast<size_t>(kTileColumns) * kColumnWords) {
        return damaged("tile {} has no height spans", tile.index);
    }
    const auto check = [&](const char* name, int64_t value, int64_t low, int64_t high) {
        if (value >= low && value <= high) return Status{Done{}};
        return damaged("{} of a height span in tile {} is {}, must be {} to {}", name, tile.index,
                       value, low, high);
    };
    for (size_t c = 0; c < kTileColumns; ++c) {
        const int32_t* column = &tile.columns[c * kColumnWords];
        Status status = check("count", column[0], 0, kSpanCapacity);
        const int32_t surface = tile.surface[c];
        if (status) {
            status = surface <= kTerrainTop
                         ? check("bare surface", surface, kTerrainTop - top, kTerrainTop)
                         : check("surface", surface, kCovered - top, top);
        }
        if (status) status = check("hollow", tile.hollows[c], kHollowUnknown, s_.height);
        for (int i = 0; i < kSpanCapacity && status; ++i) {
            const int32_t* span = column + 1 + i * kSpanWords;
            status = check("bottom", span[0], 0, top);
            if (status) status = check("top", span[1], span[0], top);
            if (status) status = check("kind", span[2], 0, kSpanFalling);
            for (int turn = 0; turn < 2 && status; ++turn) {
                status =
                    check("speed", column[kColumnSpeed + turn * kSpanCapacity + i], 0, kVoxelFull);
            }
        }
        if (!status) return status;
    }
    return Done{};
}

Status SoilSnapshot::check_awake(const SavedTile& tile, const SavedSoil& saved,
                                 TileVoxels& bodies) const {
    if (tile.last_used_step < 0 || tile.last_used_step > saved.step_index) {
        return damaged("tile {} was last used in step {} of {}", tile.index, tile.last_used_step,
                       saved.step_index);
    }
    if (tile.looked_blocks < 0 || tile.looked_blocks > s_.blocks_per_tile) {
        return damaged("tile {} was looked at up to block {} of {}", tile.index, tile.looked_blocks,
                       s_.blocks_per_tile);
    }
    if (!unpack_tile(tile.bodies, bodies)) {
        return damaged("bytes of the bodies in tile {} are no voxels", tile.index);
    }
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    const auto plane = [&](size_t p) { return std::span(bodies.words).subspan(p * words, words); };
    const auto body_count = static_cast<int64_t>(saved.body_ids.size());
    if (Status status = check_words(tile, "coverage", plane(0), 0, kCoverageMost); !status) {
        return status;
    }
    for (const int32_t owner : plane(1)) {
        if (owner < 0 || (owner & 0xffff) > body_count) {
            return damaged("owner of a voxel in tile {} is {}, there are {} bodies", tile.index,
                           owner, body_count);
        }
    }
    if (Status status = check_words(tile, "support", plane(2), 0, kSupportBody + body_count - 1);
        !status) {
        return status;
    }
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
          check("slide", saved.slide_q16, 0, kSlideSpeedMost),
          check("slip_turn", saved.slip_turn, 0, 1),
          check("pass_stamp", saved.pass_stamp, 0, kPassStampMost)}) {
        if (!status) return status;
    }
    if (Status sound = ConditionLog::check(saved.conditions, saved.step_index); !sound) {
        return damaged("{}", sound.error());
    }
    std::vector<BlockKey> blocks;
    for (const SavedActive& a : saved.active) {
        if (Status status = check("step of an active block", a.changed, 0, saved.step_index);
            !status) {
            return status;
        }
        blocks.push_back(a.block);
    }
    if (!are_blocks_sound(blocks)) return damaged("an active block is outside of the grid");
    if (!are_blocks_sound(saved.granted)) return damaged("a granted block is outside of the grid");
    if (Status status = check_bodies(saved); !status) return status;
    if (Status status = check_flows(saved); !status) return status;
    TileVoxels kept, bodies;
    kept.reset(s_.height, s_.kept_planes);
    bodies.reset(s_.height, kBodyPlaneCount);
    std::set<std::array<std::string_view, 3>> sound;  // contents that have been looked at
    int64_t before = -1;
    for (const SavedTile& tile : saved.tiles) {
        if (tile.index <= before || tile.index >= static_cast<int64_t>(s_.tiles.size())) {
            return damaged("tile {} follows tile {} of {}", tile.index, before, s_.tiles.size());
        }
        before = tile.index;
        if (Status status = check("top of a tile", tile.top, 0, s_.height); !status) return status;
        const bool is_last = (tile.index % s_.tiles_x + 1) * kTileSide > s_.frame.size[0] ||
                             (tile.index / s_.tiles_x + 1) * kTileSide > s_.frame.size[1];
        const std::array<std::string_view, 3> content{key_of(tile.kept), key_of(tile.ground),
                                                      key_of(tile.buried)};
        if (sound.contains(content) && !tile.awake && !is_last) continue;
        if (!unpack_tile(tile.kept, kept)) {
            return damaged("bytes of tile {} are no voxels", tile.index);
        }
        if (Status status = check_soil(tile, kept); !status) return status;
        if (Status status = check_ground(tile, kept); !status) return status;
        if (tile.awake) {
            if (Status status = check_awake(tile, saved, bodies); !status) return status;
        }
        if (is_last) {
            if (Status status = check_fill_up(tile, kept, tile.awake ? &bodies : nullptr);
                !status) {
                return status;
            }
        }
        if (!tile.awake) sound.insert(content);
    }
    return Done{};
}

}  // namespace bsoil
