#include "contact/contact_record.h"

#include <algorithm>

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

}  // namespace

void decode_contacts(std::span<const int32_t> words, std::vector<ContactOrder>& order,
                     std::vector<ContactRecord>& out, const WorkThreads* threads) {
    constexpr int kBits = 21;  // of a place or a body's index
    static_assert(limits::kGridSideMax < 1 << kBits && limits::kBodyCapacity < 1 << kBits);
    static_assert(kOnGround == -1);
    order.resize(words.size() / kContactWords);
    for_ranges(threads, order.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const int32_t* c = &words[i * kContactWords];
            const auto word = [c](int at) { return static_cast<uint64_t>(c[at]); };
            const uint64_t x = word(kContactAt), y = word(kContactAt + 1), z = word(kContactAt + 2);
            order[i] = {(word(kContactCarrier) + 1) << 32 | x,
                        (y << kBits | z) << kBits | word(kContactBody), i};
        }
    });
    std::sort(order.begin(), order.end(), [](const ContactOrder& a, const ContactOrder& b) {
        return a.carrier_x != b.carrier_x ? a.carrier_x < b.carrier_x : a.y_z_body < b.y_z_body;
    });
    out.resize(order.size());
    for_ranges(threads, order.size(), kRangeContacts, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const int32_t* c = &words[order[i].contact * kContactWords];
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
            contact.undisturbed = c[kContactUndisturbed];
        }
    });
}

}  // namespace bsoil
