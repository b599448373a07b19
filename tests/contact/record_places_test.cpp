// Where records are: a large body's cells are larger than voxels, a small one's are not.
#include "contact/record_places.h"

#include <gtest/gtest.h>

#include <random>

namespace bsoil::record_places_test {
namespace {

constexpr int kSide = 200;

/// Two bodies: one small and dense, one with few records far apart. Some voxels have two records of
/// a body, as where two carriers' soil meets.
std::vector<ContactRecord> some_records() {
    std::mt19937 random(5);
    std::vector<ContactRecord> records;
    for (int i = 0; i < 400; ++i) {
        ContactRecord record;
        record.body = i % 2;
        for (int& at : record.voxel) {
            at = static_cast<int>(random() % (record.body == 0 ? 12 : kSide));
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

TEST(RecordPlaces, finds_the_first_record_of_a_voxel_and_those_around) {
    const std::vector<ContactRecord> records = some_records();
    const int size[3] = {kSide, kSide, kSide};
    RecordPlaces places;
    places.fill(records, 3, size);
    EXPECT_TRUE(places.has_any(1));
    EXPECT_FALSE(places.has_any(2));
    for (const ContactRecord& record : records) {
        int voxel[3];
        for (int i = 0; i < 125; ++i) {
            const int off[3] = {i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2};
            for (int k = 0; k < 3; ++k) voxel[k] = record.voxel[k] + off[k];
            ASSERT_EQ(places.find(voxel, record.body), first_at(records, voxel, record.body));
            const bool is_beside =
                std::abs(off[0]) < 2 && std::abs(off[1]) < 2 && std::abs(off[2]) < 2;
            if (!is_beside) continue;
            ASSERT_TRUE(places.may_be_beside(record.body, voxel, voxel));
            int found[RecordPlaces::kAround];
            bool is_any = false;
            const bool says_any = places.find_around(voxel, record.body, found);
            for (int j = 0; j < RecordPlaces::kAround; ++j) {
                const int beside[3] = {voxel[0] + j % 3 - 1, voxel[1] + j / 3 % 3 - 1,
                                       voxel[2] + j / 9};
                const int there = first_at(records, beside, record.body);
                is_any = is_any || there >= 0;
                ASSERT_EQ(std::max(found[j], -1), there);
            }
            ASSERT_EQ(says_any, is_any);
        }
    }
}

TEST(RecordPlaces, are_far_from_what_is_out_of_reach) {
    const std::vector<ContactRecord> records = some_records();
    const int size[3] = {kSide, kSide, kSide};
    RecordPlaces places;
    places.fill(records, 2, size);
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
