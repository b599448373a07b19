#include "contact/contact_record.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "base/layout.h"
#include "bsoil/limits.h"

namespace bsoil {

using namespace layout;

namespace {

/// Contacts that one thread takes at least.
constexpr size_t kRangeContacts = 256;

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

/// Digit by digit from the lowest, where keys differ: no comparison to guess wrong.
void sort_by_key(ContactOrder& order) {
    constexpr int kDigitBits = 11;  // their counts fit into a processor's first cache
    constexpr uint64_t kDigits = uint64_t{1} << kDigitBits;
    auto& [entries, room] = order;
    room.resize(entries.size());
    uint64_t differing = 0;
    for (const ContactOrder::Entry& entry : entries) differing |= entry.key ^ entries[0].key;
    while (differing != 0) {
        const int shift = std::countr_zero(differing);
        const auto digit_of = [shift](uint64_t key) { return key >> shift & (kDigits - 1); };
        std::array<uint32_t, kDigits> places{};
        for (const ContactOrder::Entry& entry : entries) ++places[digit_of(entry.key)];
        std::exclusive_scan(places.begin(), places.end(), places.begin(), uint32_t{0});
        for (const ContactOrder::Entry& entry : entries) {
            room[places[digit_of(entry.key)]++] = entry;
        }
        entries.swap(room);
        differing &= ~((kDigits - 1) << shift);
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
    sort_by_key(order);
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
            contact.is_between_walls = c[kContactUndisturbed] >= kContactBetweenWalls;
        }
    });
}

}  // namespace bsoil
