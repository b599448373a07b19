// Contact records come in any order from a device, and go on in one.
#include "contact/contact_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <tuple>

#include "base/layout.h"

namespace bsoil::contact_record_test {
namespace {

using namespace layout;
using Words = std::array<int32_t, kContactWords>;

/// More than one thread sorts, in three parts and some. No two are in one voxel.
std::vector<Words> some_contacts() {
    std::mt19937 random(3);
    std::vector<Words> contacts;
    for (int i = 0; i < 14000; ++i) {
        Words words{};
        words[kContactAt] = i % 300;
        words[kContactAt + 1] = 16000 + i / 300;
        words[kContactAt + 2] = static_cast<int32_t>(random() % 500);
        words[kContactBody] = static_cast<int32_t>(random() % 7);
        words[kContactCarrier] = random() % 4 == 0 ? static_cast<int32_t>(random() % 3) : kOnGround;
        words[kContactExcess] = i;
        contacts.push_back(words);
    }
    return contacts;
}

TEST(ContactRecord, is_in_one_order_whatever_the_device_and_the_threads) {
    std::vector<Words> contacts = some_contacts();
    const auto place = [](const Words& words) {
        return std::tuple(words[kContactCarrier], words[kContactAt], words[kContactAt + 1],
                          words[kContactAt + 2]);
    };
    std::vector<Words> wanted = contacts;
    std::ranges::sort(wanted, {}, place);
    std::mt19937 random(4);
    ContactOrder order;
    std::vector<ContactRecord> records;
    for (const int thread_count : {1, 2, 5}) {
        const WorkThreads threads(thread_count);
        std::ranges::shuffle(contacts, random);
        std::vector<int32_t> words;
        for (const Words& contact : contacts) {
            words.insert(words.end(), contact.begin(), contact.end());
        }
        decode_contacts(words, order, records, &threads);
        ASSERT_EQ(records.size(), wanted.size());
        for (size_t i = 0; i < wanted.size(); ++i) {
            ASSERT_EQ(records[i].excess, wanted[i][kContactExcess]) << i;
            ASSERT_EQ(records[i].body, wanted[i][kContactBody]) << i;
        }
    }
}

}  // namespace
}  // namespace bsoil::contact_record_test
