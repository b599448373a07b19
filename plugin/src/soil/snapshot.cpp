// Snapshots: all that a soil carries from one step to the next, as bytes and back.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "soil/soil_snapshot.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr char kSection[] = "soil";

}  // namespace

void SoilSnapshot::take_awake(int index, SavedTile& saved) const {
    const Tile& tile = *s_.tiles[static_cast<size_t>(index)];
    TileVoxels voxels, bodies;
    bodies.reset(s_.height, kBodyPlaneCount);
    saved.columns.resize(static_cast<size_t>(kTileColumns) * kColumnWords);
    saved.surface.resize(kTileColumns);
    saved.hollows.resize(kTileColumns);
    std::vector<device::ReadRange> ranges;
    s_.tiles.want_voxels(index, kAllPlanes, voxels, ranges);
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    for (size_t p = 0; p < kBodyPlaneCount; ++p) {
        ranges.push_back(s_.tiles.plane_range(kBodyPlanes[p], tile.slot,
                                              std::span(bodies.words).subspan(p * words, words)));
    }
    ranges.push_back({Buffer::spans, s_.tiles.spans_offset(tile.slot), saved.columns});
    ranges.push_back(
        {Buffer::spans, s_.tiles.column_array_offset(kColumnSurface, tile.slot), saved.surface});
    ranges.push_back(
        {Buffer::spans, s_.tiles.column_array_offset(kColumnHollow, tile.slot), saved.hollows});
    s_.device->read(ranges);
    saved.kept = pack_tile(voxels);
    saved.bodies = pack_tile(bodies);
    saved.last_used_step = tile.last_used_step;
    saved.edited = s_.tiles.is_edited(tile.slot);
    saved.looked_blocks = s_.tiles.looked_blocks(tile.slot);
}

SavedSoil SoilSnapshot::take() const {
    SavedSoil out;
    for (const MaterialDef& material : s_.materials) out.materials.push_back(material.name);
    out.meaning = meaning_of(s_.def, s_.materials);
    out.step_index = s_.step_index;
    out.speed_q16 = s_.speed_q16;
    out.slope_q16 = s_.slope_q16;
    out.slide_q16 = s_.slide_q16;
    out.slip_turn = s_.params.slip_turn;
    out.pass_stamp = s_.params.pass_stamp;
    out.step_stamp = s_.params.step_stamp;
    out.conditions.assign(s_.conditions.all().begin(), s_.conditions.all().end());
    out.any_unchecked = s_.tiles.any_unchecked;
    for (const auto& [block, changed] : s_.lists.active()) out.active.push_back({block, changed});
    std::sort(out.active.begin(), out.active.end(),
              [](const SavedActive& a, const SavedActive& b) { return a.block < b.block; });
    out.granted = s_.lists.granted();
    out.body_ids.assign(s_.bodies.ids().begin(), s_.bodies.ids().end());
    for (const auto& [id, track] : s_.bodies.tracks()) {
        out.tracks.push_back({id, track.index, track});
    }
    std::sort(out.tracks.begin(), out.tracks.end(),
              [](const SavedTrack& a, const SavedTrack& b) { return a.id < b.id; });
    for (const Flow& flow : s_.flows.all()) {
        Flow kept = flow;
        kept.region = {};
        out.flows.push_back({std::move(kept)});
    }
    out.next_flow = s_.flows.next_id();
    out.units_in = s_.flows.units_in();
    out.units_out = s_.flows.units_out();
    out.water = s_.water.state();
    s_.bodies.known_contacts.for_each([&](int body, const KnownContact& contact) {
        out.known_contacts.push_back({body, contact});
    });
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
        take_awake(static_cast<int>(index), saved);
    }
    return out;
}

void SoilSnapshot::put(const SavedSoil& saved) {
    s_.drop_step();
    s_.tiles.clear();
    s_.sampler.forget();
    s_.contacts.clear();
    ++s_.state_revision;

    s_.step_index = saved.step_index;
    s_.speed_q16 = saved.speed_q16;
    s_.slope_q16 = saved.slope_q16;
    s_.slide_q16 = saved.slide_q16;
    s_.conditions.begin_step(saved.step_index, s_.def.step_s);
    s_.conditions.replace(saved.conditions);
    s_.tiles.any_unchecked = saved.any_unchecked;
    s_.params.slip_turn = saved.slip_turn;
    s_.params.pass_stamp = saved.pass_stamp;
    s_.params.step_stamp = saved.step_stamp;
    std::unordered_map<BlockKey, int64_t> active;
    for (const SavedActive& a : saved.active) active[a.block] = a.changed;
    s_.lists.restart(std::move(active), saved.granted);
    std::unordered_map<int, BodyTrack> tracks;
    for (const SavedTrack& t : saved.tracks) {
        tracks[t.id] = t.track;
        tracks[t.id].index = t.index;
    }
    s_.bodies.restart(std::move(tracks), saved.body_ids);
    s_.bodies.known_contacts.clear();
    for (const SavedContact& c : saved.known_contacts) {
        s_.bodies.known_contacts.set_width(c.body, c.contact.width_m);
        s_.bodies.known_contacts.set_pressure(c.body, c.contact.pressure_pa);
    }
    s_.ground.restart();
    std::vector<Flow> flows;
    for (const SavedFlow& f : saved.flows) flows.push_back(f.flow);
    s_.flows.restart(std::move(flows), saved.next_flow, saved.units_in, saved.units_out);
    s_.water.restart(saved.water);
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
        made->revision = s_.tiles.revision_base() + 1;
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
    const int slot = s_.tiles.wake(static_cast<int>(tile.index));
    s_.tiles[static_cast<size_t>(tile.index)]->last_used_step = tile.last_used_step;
    TileVoxels bodies;
    bodies.reset(s_.height, kBodyPlaneCount);
    unpack_tile(tile.bodies, bodies);
    const auto words = static_cast<size_t>(s_.params.tile_voxels);
    for (size_t p = 0; p < kBodyPlaneCount; ++p) {
        s_.device->write(Buffer::state, s_.tiles.plane_offset(kBodyPlanes[p], slot),
                         std::span<const int32_t>(bodies.words).subspan(p * words, words));
    }
    s_.device->write(Buffer::spans, s_.tiles.spans_offset(slot), tile.columns);
    s_.device->write(Buffer::spans, s_.tiles.column_array_offset(kColumnSurface, slot),
                     tile.surface);
    s_.tiles.note_stale(slot, true);
    s_.device->write(Buffer::spans, s_.tiles.column_array_offset(kColumnHollow, slot),
                     tile.hollows);
    if (tile.edited) s_.tiles.look_anew(slot);
    s_.tiles.note_restored(slot, tile.looked_blocks);
}

std::vector<uint8_t> Soil::state() const {
    impl_->finish();
    StateStream stream;
    SoilSnapshot(*impl_).take().list(stream);
    if (!impl_->device->failure().empty()) return {};
    return stream.bytes();
}

Result<std::function<void()>> Soil::prepare(std::span<const uint8_t> state) {
    if (const std::string failure = impl_->device->failure(); !failure.empty()) {
        return Error{"cannot be put into a soil that is lost, create another: " + failure};
    }
    auto saved = std::make_shared<SavedSoil>();
    StateStream stream(state);
    saved->list(stream);
    if (!stream.at_end()) return Error{std::string("is damaged") + kTakeAnotherCopy};
    if (const Status sound = SoilSnapshot(*impl_).check(*saved); !sound) {
        return Error{sound.error()};
    }
    return std::function<void()>([this, saved] { SoilSnapshot(*impl_).put(*saved); });
}

Result<std::vector<uint8_t>> Soil::checked_state() const {
    impl_->finish();
    SoilSnapshot snapshot(*impl_);
    SavedSoil saved = snapshot.take();
    if (const std::string failure = impl_->device->failure(); !failure.empty()) {
        return Error{"the soil cannot be saved, it is lost; go on from an earlier snapshot: " +
                     failure};
    }
    if (impl_->conditions.was_met(StatusBit::amount_headroom)) {
        if (const Status sound = snapshot.check_state(saved); !sound) {
            return Error{"the soil cannot be saved: it " + sound.error() +
                         " (amount_headroom); let what is pressed come out first"};
        }
    }
    StateStream stream;
    saved.list(stream);
    return stream.bytes();
}

Status Soil::save(const std::string& path) const {
    const auto bytes = checked_state();
    if (!bytes) return Error{fmt::format("snapshot '{}': {}", path, bytes.error())};
    const SnapshotSection section{kSection, *bytes};
    return write_snapshot_file(path, {&section, 1});
}

Status Soil::load(const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const std::vector<uint8_t>* bytes = find_section(*sections, kSection);
    if (!bytes) {
        return Error{
            fmt::format("snapshot '{}': holds no soil; load a file that Soil::save() wrote", path)};
    }
    const auto put = prepare(*bytes);
    if (!put) return Error{fmt::format("snapshot '{}': {}", path, put.error())};
    (*put)();
    return Done{};
}

}  // namespace bsoil
