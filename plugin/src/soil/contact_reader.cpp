#include "soil/contact_reader.h"

#include <algorithm>

#include "soil/column_surface.h"

namespace bsoil {

using namespace layout;

namespace {

// Contact records that are read with everything else, beyond a quarter more than the last step had.
// A step in which a body lands has more and takes a second read.
constexpr int kContactsMore = 64;
// Contact records that there is room for in a soil without bodies. Ours: 4 MB. Larger: more memory
// for each soil; smaller: it grows in the first steps of a vehicle.
constexpr int kContactsAtStart = 65536;
// And for each block in which bodies are looked at. Ours: a quarter of its voxels, two level soles.
// Larger: more memory; smaller: contact_list_full where many walls stand close together.
constexpr int kContactsABlock = kBlockVoxels / 4;
constexpr size_t kTileSpanWords = static_cast<size_t>(kTileColumns) * kColumnWords;

}  // namespace

void SurfaceReader::want(bool has_contacts, std::vector<device::ReadRange>& ranges) {
    const auto slot_count = static_cast<size_t>(tiles_.slot_count());
    slots_.swap(asked_);
    asked_.clear();
    std::erase_if(slots_, [&](int slot) {
        return !has_contacts || slot >= tiles_.slot_count() ||
               tiles_.slot_tiles()[static_cast<size_t>(slot)] < 0;
    });
    tops_.resize(has_contacts ? slot_count * kTileColumns : 0);
    spans_.resize(slots_.size() * kTileSpanWords);
    place_.assign(slot_count, -1);
    for (size_t i = 0; i < slots_.size(); ++i) {
        place_[static_cast<size_t>(slots_[i])] = static_cast<int>(i);
        ranges.push_back({Buffer::spans, tiles_.spans_offset(slots_[i]),
                          std::span(spans_).subspan(i * kTileSpanWords, kTileSpanWords)});
    }
    ranges.push_back({Buffer::spans, tiles_.column_array_offset(kColumnSurface, 0), tops_});
}

std::span<const int32_t> SurfaceReader::of_ground(int index) {
    static constexpr int32_t kBareFloor[kTileColumns] = {};
    if (!tiles_[index] && !ground_.is_over(index)) return kBareFloor;
    const Tile& tile = tiles_.make(index);
    if (tile.is_awake()) {
        return std::span(tops_).subspan(static_cast<size_t>(tile.slot) * kTileColumns,
                                        kTileColumns);
    }
    if (!tile.packed) return kBareFloor;
    if (tile.packed->surface.empty()) {
        tiles_.read_runs(index, runs_);
        tile.packed->surface = surface_heights_q16(runs_, core_.params.bank_strength > 0);
    }
    return tile.packed->surface;
}

// The records of a tile's columns as they are after this step.
const int32_t* SurfaceReader::spans_of(int slot) {
    if (std::ranges::find(asked_, slot) == asked_.end()) asked_.push_back(slot);
    int& place = place_[static_cast<size_t>(slot)];
    if (place < 0) {
        place = static_cast<int>(slots_.size());
        slots_.push_back(slot);
        spans_.resize(slots_.size() * kTileSpanWords);
        core_.device->read(Buffer::spans, tiles_.spans_offset(slot),
                           std::span(spans_).last(kTileSpanWords));
    }
    return &spans_[static_cast<size_t>(place) * kTileSpanWords];
}

std::span<const int32_t> SurfaceReader::of_carried(int index, int carrier) {
    carried_.assign(kTileColumns, kBare);
    // Bodies that may move keep the tiles with their soil awake.
    if (!tiles_[index] || !tiles_[index]->is_awake()) return carried_;
    const int32_t* spans = spans_of(tiles_[index]->slot);
    for (size_t c = 0; c < kTileColumns; ++c) {
        const int32_t* column = spans + c * kColumnWords;
        for (int i = 0; i < column[kColumnCount]; ++i) {
            const auto pair = static_cast<uint32_t>(column[kColumnBase + i / 2]);
            const int base = static_cast<int>(pair >> (i % 2 * 16) & 0xffff);
            if ((base & kBaseBody) != carrier + 1) continue;
            const int32_t* span = column + kColumnSpans + i * kSpanWords;
            const int32_t bottom = span[kSpanBottom], top = span[kSpanTop];
            if (top > bottom) {
                carried_[c] = (base & kBaseFree) != 0 ? top : kCovered - top;
            } else if (carried_[c] == kBare && (base & kBaseFree) != 0) {
                carried_[c] = kBareTop - top;
            }
        }
    }
    return carried_;
}

void ContactReader::start() {
    wedge_length_.clear();
    wedges_.clear();
    for (const MaterialDef& material : core_.materials) {
        wedge_length_.push_back(core_.def.contact_law.wedge_length_of(material.friction_angle_rad));
        wedges_.emplace_back(std::tan(material.friction_angle_rad), material.tool_friction);
    }
}

// From the step's own work alone: a soil that goes on from a snapshot has as much as the one that
// was saved. Memory stays.
void ContactReader::make_room(int block_count) {
    const int64_t wanted = int64_t{block_count} * kContactsABlock;
    const auto capacity =
        static_cast<int>(std::clamp<int64_t>(wanted, kContactsAtStart, limits::kContactCapacity));
    core_.params.contact_capacity = std::min(capacity, capacity_most);
    if (capacity <= room_) return;
    for (room_ = std::max(room_, kContactsAtStart); room_ < capacity;) room_ *= 2;
    if (const Status allocated =
            core_.device->allocate(Buffer::result, kContactsFirst + int64_t{room_} * kContactWords);
        !allocated) {
        core_.device->give_up(allocated.error());
    }
}

void ContactReader::want(bool has_contacts, std::vector<device::ReadRange>& ranges) {
    const int records = has_contacts ? std::min(expected_, core_.params.contact_capacity) : 0;
    record_words_.resize(static_cast<size_t>(records) * kContactWords);
    ranges.push_back({Buffer::result, core_.params.contact_offset, record_words_});
    surface_.want(has_contacts, ranges);
    silo_walls_.want(has_contacts, ranges);
}

void ContactReader::read(std::span<const int32_t> header) {
    // Of more than there is room for those are there that came first, in no order that would be the
    // same on another device: then none count.
    const int found = header[kResultContacts];
    const int count = found <= core_.params.contact_capacity ? found : 0;
    const size_t words = static_cast<size_t>(count) * kContactWords;
    const size_t known = record_words_.size();
    if (words > record_words_.capacity()) record_words_.reserve(2 * words);
    record_words_.resize(words);
    if (words > known) {
        core_.device->read(Buffer::result,
                           core_.params.contact_offset + static_cast<int64_t>(known),
                           std::span(record_words_).subspan(known));
    }
    expected_ = count + count / 4 + kContactsMore;
    read_loads(header);
    make_contacts();
    silo_walls_.share(
        header, contacts_, [this](int slot) { return surface_.spans_of(slot); }, loads_);
    are_whole_ = (header[kResultStatus] & kStatusContactsFull) == 0;
    known_edit_ = tiles_.edit_count();
}

// Three 64-bit sums in units of the momentum planes [N s], with the world's axes.
Vec3 ContactReader::impulse_of(const int32_t* sums) const {
    const double unit_n_s =
        core_.kg_per_unit * core_.frame.voxel_m / (kVelocityOne * core_.def.step_s);
    return rotate(core_.frame.grid_to_world.rotation,
                  Vec3{static_cast<double>(wide_sum(sums)), static_cast<double>(wide_sum(sums + 2)),
                       static_cast<double>(wide_sum(sums + 4))} *
                      unit_n_s);
}

void ContactReader::read_loads(std::span<const int32_t> header) {
    const std::span<const int> ids = bodies_.ids();
    momentum_ = {impulse_of(&header[kResultFallen]), impulse_of(&header[kResultGround])};
    loads_.clear();
    for (const StepBody& body : bodies_.in_step()) {
        const auto index = static_cast<size_t>(body.track->index);
        const int32_t* sums = &header[kResultHeader + index * kLoadWords];
        const double units = static_cast<double>(wide_sum(sums + kLoadMass));
        const Vec3 impulse_n_s = impulse_of(sums + kLoadImpulse);
        if (ids[index] < 0 || (units <= 0 && dot(impulse_n_s, impulse_n_s) == 0)) continue;
        BodyLoad& load = loads_.emplace_back();
        load.body = ids[index];
        load.impulse_n_s = impulse_n_s;
        load.center_m = body.input->center_of_mass_m;
        if (units <= 0) continue;
        load.mass_kg = units * kLoadPart * core_.kg_per_unit;
        load.center_m = core_.frame.to_world(
            {static_cast<double>(wide_sum(sums + kLoadMoment)) / units / 2,
             static_cast<double>(wide_sum(sums + kLoadMoment + 2)) / units / 2,
             static_cast<double>(wide_sum(sums + kLoadMoment + 4)) / units / 2});
    }
}

void ContactReader::note_quiet() {
    momentum_ = {};
    std::erase_if(loads_,
                  [](const BodyLoad& load) { return load.mass_kg <= 0 && load.held_kg == 0; });
    for (BodyLoad& load : loads_) load.impulse_n_s = {};
}

void ContactReader::make_contacts() {
    const std::span<const int> ids = bodies_.ids();
    placed_.resize(ids.size());
    width_voxels_.assign(ids.size(), 0);
    for (ContactBody& body : placed_) body.input = nullptr;
    // A caller may say any: of infinitely many voxels the law makes no number.
    const double widest_m = length(core_.def.size_m);
    for (const StepBody& body : bodies_.in_step()) {
        const auto at = static_cast<size_t>(body.track->index);
        ContactBody& placed = placed_[at];
        placed.input = body.input;
        placed.faces.place(*body.input, body.track->walls);
        placed.surface = body.track->surface.is_whole ? &body.track->surface : nullptr;
        placed.is_small = body.track->is_small;
        width_voxels_[at] = std::min(body.contact.width_m, widest_m) / core_.frame.voxel_m;
    }
    voxels_.make(
        {record_words_, placed_, ids, width_voxels_, &core_.frame, &core_.world_to_grid,
         &core_.def.contact_law, wedge_length_, wedges_, core_.work_threads.get()},
        [this](int tx, int ty, int carrier) {
            const int tile = core_.tile_index(tx, ty);
            return carrier == kOnGround ? surface_.of_ground(tile)
                                        : surface_.of_carried(tile, carrier);
        },
        contacts_);
}

void ContactReader::clear() {
    contacts_.clear();
    loads_.clear();
    momentum_ = {};
    are_whole_ = false;
}

}  // namespace bsoil
