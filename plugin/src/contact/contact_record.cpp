#include "contact/contact_record.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "base/layout.h"
#include "bsoil/limits.h"

namespace bsoil {

using namespace layout;

namespace {

/// Contacts that one thread takes at least.
constexpr size_t kRangeContacts = 256;
/// And where they are sorted. Ours, as a matter of cost: more than there are digits. Larger:
/// threads wait; smaller: more is counted than sorted.
constexpr size_t kSortedContacts = 4096;

Vec3 vector_at(const int32_t* words) {
    return {static_cast<double>(words[0]), static_cast<double>(words[1]),
            static_cast<double>(words[2])};
}

/// By carrier, place and body.
uint64_t key_of(const int32_t* contact) {
    constexpr int kBodyBits = std::bit_width(limits::kBodyCapacity - 1u),
                  kHeightBits = std::bit_width(limits::kGridHeightMax - 1u),
                  kSideBits = std::bit_width(limits::kGridSideMax - 1u),
                  kCarrierBits = std::bit_width(unsigned{limits::kBodyCapacity});
    static_assert(kCarrierBits + 2 * kSideBits + kHeightBits + kBodyBits <= 64);
    static_assert(kOnGround == -1);
    const auto word = [contact](int at) { return static_cast<uint64_t>(contact[at]); };
    uint64_t key = word(kContactCarrier) + 1;
    key = key << kSideBits | word(kContactAt);
    key = key << kSideBits | word(kContactAt + 1);
    key = key << kHeightBits | word(kContactAt + 2);
    return key << kBodyBits | word(kContactBody);
}

constexpr int kDigitBits = 11;  // their counts fit into a processor's first cache
constexpr size_t kDigits = size_t{1} << kDigitBits;

/// Digit by digit from the lowest, where keys differ: no comparison to guess wrong. In parts, each
/// with counts of its own: where an entry goes hangs on the digits alone.
void sort_by_key(ContactOrder& order, const WorkThreads* threads) {
    std::vector<ContactOrder::Entry>&entries = order.entries, &room = order.room;
    std::vector<uint32_t>& places = order.places;
    room.resize(entries.size());
    const size_t part_count = std::max<size_t>(1, entries.size() / kSortedContacts);
    const auto for_parts = [&](const auto& act) {
        const auto begin_of = [&](size_t part) { return part * entries.size() / part_count; };
        for_ranges(threads, part_count, 1, [&](size_t first, size_t last) {
            for (size_t part = first; part < last; ++part) {
                const size_t begin = begin_of(part);
                act(part, std::span(entries).subspan(begin, begin_of(part + 1) - begin));
            }
        });
    };
    uint64_t differing = 0;
    for (const ContactOrder::Entry& entry : entries) differing |= entry.key ^ entries[0].key;
    while (differing != 0) {
        const int shift = std::countr_zero(differing);
        const auto digit_of = [shift](uint64_t key) { return key >> shift & (kDigits - 1); };
        places.assign(part_count * kDigits, 0);
        for_parts([&](size_t part, std::span<const ContactOrder::Entry> own) {
            uint32_t* counts = &places[part * kDigits];
            for (const ContactOrder::Entry& entry : own) ++counts[digit_of(entry.key)];
        });
        uint32_t before = 0;
        for (size_t digit = 0; digit < kDigits; ++digit) {
            for (size_t part = 0; part < part_count; ++part) {
                before += std::exchange(places[part * kDigits + digit], before);
            }
        }
        for_parts([&](size_t part, std::span<const ContactOrder::Entry> own) {
            uint32_t* next = &places[part * kDigits];
            for (const ContactOrder::Entry& entry : own) room[next[digit_of(entry.key)]++] = entry;
        });
        entries.swap(room);
        differing &= ~(uint64_t{kDigits - 1} << shift);
    }
}

}  // namespace

void decode_contacts(std::span<const int32_t> words, ContactOrder& order,
                     std::vector<ContactRecord>& out, const WorkThreads* threads) {
    std::vector<ContactOrder::Entry>& entries = order.entries;
    entries.resize(words.size() / kContactWords);
    for_ranges(threads, entries.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            entries[i] = {key_of(&words[i * kContactWords]), static_cast<uint32_t>(i)};
        }
    });
    sort_by_key(order, threads);
    out.resize(entries.size());
    for_ranges(threads, entries.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const int32_t* c = &words[entries[i].contact * kContactWords];
            ContactRecord& contact = out[i];
            std::copy_n(c + kContactAt, 3, contact.voxel);
            contact.body = c[kContactBody];
            contact.carrier = c[kContactCarrier];
            contact.gradient = vector_at(c + kContactGradient);
            contact.gap = vector_at(c + kContactGap);
            contact.excess = c[kContactExcess];
            contact.material = c[kContactMaterial] & ((1 << kSaturationShift) - 1);
            contact.saturation = c[kContactMaterial] >> kSaturationShift;
            contact.density = c[kContactDensity];
            contact.undisturbed = c[kContactUndisturbed] % kContactBetweenWalls;
            contact.load_above = c[kContactLoad] % (1 << kLoadSides) - 1;
            contact.load_sides = c[kContactLoad] >> kLoadSides;
            contact.is_between_walls = c[kContactUndisturbed] >= kContactBetweenWalls;
        }
    });
}

}  // namespace bsoil
