// Where records are: a large body's cells are larger than voxels, a small one's are not.
#include "contact/record_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace bsoil::record_places_test {
namespace {

constexpr int kSide = 200;

/// Three bodies: one small and dense, one with few records far apart, one that lies along x over
/// more voxels than a word has bits. Some voxels have two records of a body, as where two carriers'
/// soil meets.
std::vector<ContactRecord> some_records() {
    std::mt19937 random(5);
    std::vector<ContactRecord> records;
    constexpr unsigned kSides[3][3] = {{12, 12, 12}, {kSide, kSide, kSide}, {110, 3, 3}};
    for (int i = 0; i < 300; ++i) {
        ContactRecord record;
        record.body = i % 3;
        for (int k = 0; k < 3; ++k) {
            record.voxel[k] = static_cast<int>(random() % kSides[record.body][k]);
        }
        record.gradient = {0, 0, -65536};
        records.push_back(record);
        if (i % 10 == 0) records.push_back(record);
    }
    return records;
}

int first_at(const std::vector<ContactRecord>& records, const int voxel[3], int body) {
    for (size_t i = 0; i < records.size(); ++i) {
        if (records[i].body == body && std::equal(voxel, voxel + 3, records[i].voxel)) {
            return static_cast<int>(i);
        }
    }
    return -1;
}

using Voxel = std::array<int, 3>;
Voxel beside(const int voxel[3], int dx, int dy, int dz) {
    return {voxel[0] + dx, voxel[1] + dy, voxel[2] + dz};
}

/// Calls check(voxel, body) for each voxel no more than two off a record of the body.
template <typename Check>
void for_each_near(const std::vector<ContactRecord>& records, const Check& check) {
    for (const ContactRecord& record : records) {
        for (int i = 0; i < 125; ++i) {
            check(beside(record.voxel, i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2), record.body);
        }
    }
}

TEST(RecordPlaces, finds_the_first_record_of_a_voxel_and_those_around) {
    const std::vector<ContactRecord> records = some_records();
    const int size[3] = {kSide, kSide, kSide};
    RecordPlaces places;
    places.fill(records, 4, size);
    EXPECT_TRUE(places.has_any(1));
    EXPECT_FALSE(places.has_any(3));
    int looked_at_count = 0;
    for_each_near(records, [&](const Voxel& voxel, int body) {
        ASSERT_EQ(places.find(voxel.data(), body), first_at(records, voxel.data(), body));
        std::vector<int> around, found;
        for (int i = 0; i < 18; ++i) {
            const Voxel at = beside(voxel.data(), i % 3 - 1, i / 3 % 3 - 1, i / 9);
            if (const int record = first_at(records, at.data(), body); record >= 0) {
                around.push_back(record);
            }
        }
        const bool is_below = first_at(records, beside(voxel.data(), 0, 0, -1).data(), body) >= 0;
        const bool may_be = places.may_be_beside(body, voxel.data(), voxel.data());
        const bool is_answered = !around.empty() || is_below;
        ASSERT_TRUE(may_be || !is_answered);
        // Of bodies whose cells are voxels nothing is looked at in vain.
        ASSERT_TRUE(body == 1 || may_be == is_answered);
        if (!may_be) return;
        ++looked_at_count;
        places.visit_around(voxel.data(), body,
                            [&](int, int, int, int record) { found.push_back(record); });
        ASSERT_EQ(found, around);
    });
    EXPECT_GT(looked_at_count, 0);
}

TEST(RecordPlaces, finds_those_along_an_axis) {
    const std::vector<ContactRecord> records = some_records();
    const int size[3] = {kSide, kSide, kSide};
    RecordPlaces places;
    places.fill(records, 3, size);
    for_each_near(records, [&](const Voxel& voxel, int body) {
        for (int axis = 0; axis < 3; ++axis) {
            for (const int step : {-1, 1}) {
                int found[3] = {-1, -1, -1}, there[3];
                for (int i = 0; i < 3; ++i) {
                    Voxel at = voxel;
                    at[static_cast<size_t>(axis)] += (i - 1) * step;
                    there[i] = first_at(records, at.data(), body);
                }
                const bool is_any = places.find_along(voxel.data(), axis, step, body, found);
                ASSERT_EQ(is_any, places.may_be_beside(body, voxel.data(), voxel.data()));
                for (int i = 0; is_any && i < 3; ++i) {
                    ASSERT_EQ(std::max(found[i], -1), there[i]);
                }
            }
        }
    });
}

TEST(RecordPlaces, are_far_from_what_is_out_of_reach) {
    const std::vector<ContactRecord> records = some_records();
    const int size[3] = {kSide, kSide, kSide};
    RecordPlaces places;
    places.fill(records, 3, size);
    for (const int far : {-1000000, -4, 15, 1000000}) {
        const int voxel[3] = {5, far, 5};
        EXPECT_FALSE(places.may_be_beside(0, voxel, voxel)) << far;
        EXPECT_EQ(places.find(voxel, 0), -1) << far;
    }
    EXPECT_TRUE(places.is_near_box(0, {-1.4, 5, 5}, 1.5));
    EXPECT_FALSE(places.is_near_box(0, {-1.6, 5, 5}, 1.5));
    EXPECT_FALSE(places.is_near_box(0, {1e300, 5, 5}, 1.5));
}

TEST(RecordPlaces, voxel_of_rounds_down) {
    for (const auto& [place, voxel] :
         {std::pair{0.0, 0}, {0.999, 0}, {1.0, 1}, {-0.001, -1}, {-1.0, -1}, {-1.5, -2}}) {
        EXPECT_EQ(voxel_of(place), voxel) << place;
    }
}

}  // namespace
}  // namespace bsoil::record_places_test
