/// SoilSnapshot: the state of a soil as a snapshot holds it, taken, checked and put in.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bsoil/snapshot_file.h"
#include "soil/soil_impl.h"

namespace bsoil {

/// Planes that are made from the bodies, but not in every step: an awake tile keeps them.
inline constexpr int kBodyPlanes[] = {layout::kPlaneCoverage, layout::kPlaneOwner,
                                      layout::kPlaneSupport};
inline constexpr int kBodyPlaneCount = 3;

/// To find the bytes of a tile among others.
inline std::string_view key_of(const std::vector<uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A number of a soil's definition.
struct NamedValue {
    std::string name;
    double value = 0;
};

/// All of a definition that a state means something by, or that decides how it goes on.
std::vector<NamedValue> meaning_of(const SoilDef& def, const std::vector<MaterialDef>& materials);

struct SavedTile {
    int64_t index = 0;
    int32_t top = 0;
    bool unchecked = false, awake = false;
    std::vector<uint8_t> kept;            ///< packed
    std::vector<uint8_t> ground, buried;  ///< packed; see Tile
    // Of an awake tile:
    int64_t last_used_step = 0;
    bool edited = false;  ///< see TileTable::is_edited()
    int32_t looked_blocks = 0;
    std::vector<uint8_t> bodies;                     ///< packed; see kBodyPlanes
    std::vector<int32_t> columns, surface, hollows;  ///< see Buffer::spans

    void list(StateStream& stream) {
        stream(index, top, unchecked, awake, kept, ground, buried);
        if (awake) stream(last_used_step, edited, looked_blocks, bodies, columns, surface, hollows);
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

/// A source, sink or open side. What follows from its definition is made anew.
struct SavedFlow {
    Flow flow;

    void list(StateStream& stream) {
        SourceDef& in = flow.source;
        SinkDef& out = flow.sink;
        stream.choice(flow.kind, FlowKind::well);
        stream(flow.id, flow.units, flow.missed_units, flow.held_units, flow.lump_count,
               flow.is_fresh, flow.since_s);
        if (flow.kind == FlowKind::source) {
            stream.choice(in.shape, SourceDef::Shape::rectangle);
            stream(in.center_m, in.direction, in.radius_m, in.length_m, in.width_m, in.turn_rad,
                   in.speed_m_s, in.spread_rad, in.rate_kg_s, in.rate_m3_s, in.start_s, in.end_s,
                   in.material);
        } else if (flow.kind != FlowKind::open_side) {
            stream.choice(out.region.kind, ConvexShape::Kind::cone);
            stream(out.region.local, out.region.half_extents_m, out.region.radius_m,
                   out.region.half_height_m, out.region.rounding_m, out.pose, out.rate_kg_s,
                   out.start_s, out.end_s);
            if (flow.kind == FlowKind::well) stream(out.water_kg_s);
        }
    }
};

struct SavedContact {
    int32_t body = 0;
    KnownContact contact;
};

struct SavedActive {
    BlockKey block = 0;
    int64_t changed = 0;
};

/// The state of a soil as a snapshot holds it.
struct SavedSoil {
    std::vector<std::string> materials;
    std::vector<NamedValue> meaning;
    int64_t step_index = 0, speed_q16 = 0;
    int32_t slope_q16 = 0, slide_q16 = 0, slip_turn = 0, pass_stamp = 0, step_stamp = 0;
    bool any_unchecked = false;
    std::vector<Condition> conditions;
    std::vector<SavedActive> active;
    std::vector<BlockKey> granted;
    std::vector<int32_t> body_ids;
    std::vector<SavedTrack> tracks;
    std::vector<SavedTile> tiles;
    std::vector<SavedFlow> flows;
    int32_t next_flow = 1;
    std::vector<int64_t> units_in, units_out;
    std::vector<int64_t> water;  ///< see Water::state()
    std::vector<SavedContact> known_contacts;

    void list(StateStream& stream) {
        stream.list(materials, 8, [&](std::string& name) { stream(name); });
        stream.list(meaning, 16, [&](NamedValue& v) { stream(v.name, v.value); });
        stream(step_index, speed_q16, slope_q16, slide_q16, slip_turn, pass_stamp, step_stamp,
               any_unchecked);
        stream.list(conditions, 61, [&](Condition& c) { bsoil::list(stream, c); });
        stream.list(active, 16, [&](SavedActive& a) { stream(a.block, a.changed); });
        stream(granted, body_ids);
        stream.list(tracks, 140, [&](SavedTrack& t) { t.list(stream); });
        stream.list(tiles, 38, [&](SavedTile& t) { t.list(stream); });
        stream.list(flows, 49, [&](SavedFlow& f) { f.list(stream); });
        stream(next_flow, units_in, units_out, water);
        stream.list(known_contacts, 20, [&](SavedContact& c) {
            stream(c.body, c.contact.width_m, c.contact.pressure_pa);
        });
    }
};

/// Takes states out of a soil, checks them and puts them in.
class SoilSnapshot {
  public:
    explicit SoilSnapshot(Soil::Impl& soil) : s_(soil) {}

    SavedSoil take() const;
    Status check(const SavedSoil& saved) const;
    /// Of that, whether it is sound; the text does not say what to do.
    Status check_state(const SavedSoil& saved) const;
    void put(const SavedSoil& saved);

  private:
    Status check_meaning(const SavedSoil& saved) const;
    Status check_bodies(const SavedSoil& saved) const;
    Status check_flows(const SavedSoil& saved) const;
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
    /// Waits for the device once.
    void take_awake(int index, SavedTile& saved) const;

    Soil::Impl& s_;
};

}  // namespace bsoil
