// The results of a step: what the device wrote is read back and told.
#include <algorithm>
#include <cmath>

#include "soil/soil_impl.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;

namespace {

// Contact records read with everything else are those of the step before and so many more: a
// second read is for the step in which a body lands.
constexpr int kContactsMore = 64;

int64_t wide_sum(const int32_t* words) {
    return static_cast<int64_t>(static_cast<uint64_t>(static_cast<uint32_t>(words[1])) << 32 |
                                static_cast<uint32_t>(words[0]));
}

}  // namespace

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
