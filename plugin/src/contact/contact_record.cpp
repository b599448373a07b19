#include "contact/contact_record.h"

#include <algorithm>
#include <numeric>

#include "soil/layout.h"

namespace bsoil {

using namespace layout;

namespace {

Vec3 vector_at(const int32_t* words) {
    return {static_cast<double>(words[0]), static_cast<double>(words[1]),
            static_cast<double>(words[2])};
}

}  // namespace

void decode_contacts(std::span<const int32_t> words, std::vector<int>& order,
                     std::vector<ContactRecord>& out) {
    const auto record = [&](int i) { return &words[static_cast<size_t>(i) * kContactWords]; };
    order.resize(words.size() / kContactWords);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const int32_t *first = record(a), *second = record(b);
        if (first[kContactCarrier] != second[kContactCarrier]) {
            return first[kContactCarrier] < second[kContactCarrier];
        }
        return std::lexicographical_compare(first, first + kContactKey, second,
                                            second + kContactKey);
    });
    out.clear();
    for (int i : order) {
        const int32_t* c = record(i);
        ContactRecord contact;
        std::copy_n(c + kContactAt, 3, contact.voxel);
        contact.body = c[kContactBody];
        contact.carrier = c[kContactCarrier];
        contact.gradient = vector_at(c + kContactGradient);
        contact.gap = vector_at(c + kContactGap);
        contact.excess = c[kContactExcess];
        contact.material = c[kContactMaterial];
        contact.density = c[kContactDensity];
        out.push_back(contact);
    }
}

}  // namespace bsoil
