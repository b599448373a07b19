// Banks of soil that keeps cohesion when it is moved: the height at which they fail, and the face
// at which what has failed comes to rest.
#include "bank_case.h"
#include "temporary_file.h"

namespace bsoil::loose_bank_test {
namespace {

using namespace bank_test;

/// Steepest face on which soil of this cohesion stands so high: Culmann's height, solved for it.
double steepest_face_deg(const BankCase& bank, double cohesion_pa, double high_m) {
    double stands = bank.friction_deg, falls = 90;
    const auto critical_m = [&](double face_deg) {
        return BankCase{cohesion_pa, bank.gamma_n_m3, face_deg, 0, 0, bank.friction_deg}
            .critical_m();
    };
    if (critical_m(falls) >= high_m) return falls;
    for (int i = 0; i < 60; ++i) {
        const double middle = (stands + falls) / 2;
        (critical_m(middle) >= high_m ? stands : falls) = middle;
    }
    return stands;
}

/// Where along the line through the grid's middle, across the bank, the ground first reaches a
/// height.
double first_at_m(const Soil& soil, double yaw_deg, double high_m) {
    const GridFrame& frame = soil.frame();
    const double c = std::cos(yaw_deg * kDegree), s = std::sin(yaw_deg * kDegree);
    double first = 1e9;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            const double dx = x + 0.5 - frame.size[0] / 2.0, dy = y + 0.5 - frame.size[1] / 2.0;
            if (std::abs(dy * c - dx * s) > 1.5) continue;
            if (soil.surface_height_m(x, y) >= high_m) first = std::min(first, dx * c + dy * s);
        }
    }
    return first * frame.voxel_m;
}

class LooseBank : public testing::TestWithParam<BankCase> {};

// Soil that was moved all over and has kept half of its cohesion stands to half the height. Not a
// grain moves below it, and above it the bank goes back to the face at which it stands.
TEST_P(LooseBank, stands_below_its_critical_height_and_fails_above) {
    BankCase bank = GetParam();
    bank.cohesion_pa *= 2;
    bank.loose_fraction = 0.5;
    const bool is_wall = bank.face_deg == 90;
    for (const bool stands : {true, false}) {
        const double share = stands ? (is_wall ? 0.9 : 0.85) : (is_wall ? 1.1 : 1.15);
        auto soil = make_bank(bank, share * bank.loose_fraction, 1.2);
        ASSERT_TRUE(soil);
        soil->step({});
        loosen(*soil);
        const uint64_t checksum = soil->checksum();
        for (int i = 0; i < 300; ++i) soil->step({});  // 5 s
        EXPECT_EQ(soil->checksum() == checksum, stands);
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

// By hand: it stands as steep as a face of its height and of loose soil's cohesion does, which is
// Culmann's. What has come down before the old foot has a foot of its own, and the face between is
// no plane: from a wall it is found up to 8 deg flatter, from a face of 60 deg within 2 deg. A
// voxel more or less at the crest counts too.
TEST_P(LooseBank, rests_at_the_face_that_its_height_gives) {
    for (const double kept : {1.0, 0.5}) {
        BankCase bank = GetParam();
        bank.loose_fraction = kept;
        const bool is_wall = bank.face_deg == 90;
        const double share = is_wall ? 2 : 1.5, high = share * bank.critical_m();
        auto soil = make_bank(bank, share, 1.2);
        ASSERT_TRUE(soil);
        const int64_t units = soil->totals().units[0];
        const auto settled = soil->settle(1200);
        ASSERT_TRUE(settled);
        EXPECT_TRUE(settled->is_at_rest);
        EXPECT_EQ(soil->totals().units[0], units);
        EXPECT_EQ(soil->status_bits(), 0u);
        const double run = first_at_m(*soil, bank.yaw_deg, 0.98 * high) -
                           first_at_m(*soil, bank.yaw_deg, 0.02 * high);
        const double face = std::atan2(high, run) / kDegree;
        const double theory = steepest_face_deg(bank, kept * bank.cohesion_pa, high);
        const double voxel_deg = std::atan2(high, run - bank.voxel_m) / kDegree - face;
        const std::string name = "kept_" + std::to_string(std::lround(100 * kept));
        RecordProperty(name, std::to_string(face) + " of " + std::to_string(theory));
        EXPECT_LT(face, theory + 2 + voxel_deg) << name;
        EXPECT_GT(face, theory - (is_wall ? 8 : 2) - voxel_deg) << name;
    }
}

// Its face is higher than the blocks around what moves at its foot. What slid off the top after 3 s
// was put down below and never taken away above, where no block was dispatched.
TEST(SlowLooseBanks, keep_their_soil_however_high_they_fail) {
    const auto soil = make_bank({1000, 16000, 60, 0.05, 45, 30, 0.3}, 1.5, 1.2);
    ASSERT_TRUE(soil);
    const int64_t units = soil->totals().units[0];
    for (int i = 0; i < 200; ++i) soil->step({});
    EXPECT_EQ(soil->totals().units[0], units);
}

// A plane that fails is asked for anew by each pass: nothing of it outlives a step.
TEST(LooseBanks, go_on_from_a_snapshot_bit_for_bit) {
    const BankCase bank{1000, 16000, 90, 0.05, 22.5, 30, 0.7};
    const TemporaryFile file("loose_bank.snapshot");
    for (int stop : {0, 1, 3, 6, 12}) {
        auto soil = make_bank(bank, 2, 1.2);
        ASSERT_TRUE(soil);
        for (int i = 0; i < stop; ++i) soil->step({});
        ASSERT_TRUE(soil->save(file.path()));
        SoilDef def = soil->def();
        def.thread_count = 3;
        auto twin = make_soil(def);
        ASSERT_TRUE(twin->load(file.path()));
        for (int i = 0; i < 20; ++i) {
            soil->step({});
            twin->step({});
            ASSERT_EQ(soil->checksum(), twin->checksum())
                << "stopped at " << stop << ", step " << i;
        }
    }
}

/// Thin soil on the floor, that was moved all over: it rises by `side` voxels a row and by 1/20 a
/// column, with humps of 0.6 voxels.
std::unique_ptr<Soil> humps(int columns, double side) {
    constexpr double kVoxelM = 0.025, kDensity = 2000, kLoose = 0.3;
    SoilDef def = grid_def(columns, 8, 16, kVoxelM);
    // Loose it has a cohesion over its weight of 1/200 voxel.
    def.material = sand(1, 0.005 * kVoxelM * kDensity * kGravity / kLoose);
    def.material.density_kg_m3 = kDensity;
    def.material.loose_cohesion_fraction = kLoose;
    auto soil = make_soil(def);
    fill_columns(*soil, [side](double x_m, double y_m) {
        const double x = x_m / kVoxelM, y = y_m / kVoxelM;
        return kVoxelM * (0.05 * x + side * y + 0.6 * (1 + std::sin(7 * x) * std::cos(3 * y)));
    });
    soil->step({});
    loosen(*soil);
    return soil;
}

int steps_until_asleep(Soil& soil, int most) {
    for (int i = 0; i < most; ++i) {
        if (soil.step({}).block_active_count == 0) return i;
    }
    return most;
}

// Planes fail over which nothing slides, as less than half of what lies in each voxel is above
// them. A toe looked up to a tile that had just gone to sleep, and had it woken. There another one
// looked back, in turn for good. By hand: each round asks for at least one more of the 8 blocks, or
// is the last, and keeps them awake for 4 steps. That is 36 at most.
TEST(LooseBanks, wake_each_other_no_more_than_once) {
    const auto soil = humps(32, 0.2);
    ASSERT_LT(steps_until_asleep(*soil, 200), 200);
    const uint64_t checksum = soil->checksum();
    Soil::Impl& s = SoilProbe::impl(*soil);
    s.lists.activate(s.block_key(1, 0));
    EXPECT_LE(steps_until_asleep(*soil, 200), 36);
    EXPECT_EQ(soil->checksum(), checksum);
}

// What had been granted was not in snapshots: a restored soil granted it once more, and was awake
// in steps that the saved one slept through.
TEST(LooseBanks, know_from_a_snapshot_who_was_woken) {
    const auto soil = humps(32, 0.2);
    ASSERT_LT(steps_until_asleep(*soil, 200), 200);
    Soil::Impl& s = SoilProbe::impl(*soil);
    s.lists.activate(s.block_key(1, 0));
    std::vector<std::vector<uint8_t>> states;
    std::vector<int> active_counts;
    while (active_counts.empty() || active_counts.back() > 0) {
        ASSERT_LT(active_counts.size(), 36u);
        active_counts.push_back(soil->step({}).block_active_count);
        states.push_back(soil->state());
    }
    ASSERT_FALSE(s.lists.granted().empty());
    for (size_t stop = 0; stop < states.size(); ++stop) {
        const auto twin = make_soil(soil->def());
        const auto put = twin->prepare(states[stop]);
        ASSERT_TRUE(put) << put.error();
        (*put)();
        for (size_t i = stop + 1; i < states.size(); ++i) {
            EXPECT_EQ(twin->step({}).block_active_count, active_counts[i]) << stop << " " << i;
            EXPECT_TRUE(twin->state() == states[i]) << stop << " " << i;
        }
    }
}

// This one never fell asleep.
TEST(LooseBanks, over_which_nothing_slides_fall_asleep) {
    const auto soil = humps(48, 0.1);
    EXPECT_LT(steps_until_asleep(*soil, 400), 400);
}

// Who has woken whom was not in a snapshot. The restored soil looked once more: nothing came of it
// there, but its blocks were active for longer.
TEST(LooseBanks, that_wake_each_other_go_on_from_a_snapshot_bit_for_bit) {
    const TemporaryFile file("humps.snapshot");
    for (const int stop : {2, 12, 17}) {
        const auto soil = humps(48, 0.1);
        for (int i = 0; i < stop; ++i) soil->step({});
        ASSERT_TRUE(soil->save(file.path()));
        SoilDef def = soil->def();
        def.thread_count = 2;
        const auto twin = make_soil(def);
        ASSERT_TRUE(twin->load(file.path()));
        for (int i = 0; i < 40; ++i) {
            soil->step({});
            twin->step({});
            ASSERT_EQ(soil->checksum(), twin->checksum()) << stop << " and " << i;
            ASSERT_TRUE(soil->state() == twin->state()) << stop << " and " << i;
        }
    }
}

// Planes fail in soil that does not flow: nothing moves, and it falls asleep all the same.
TEST(LooseBanks, that_do_not_flow_fall_asleep) {
    const BankCase bank{1000, 16000, 90, 0.05, 0, 30, 1};
    SoilDef def = grid_def(40, 16, 32, bank.voxel_m);
    def.material = bank.material();
    def.material.viscosity = 1;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    // 1.2 m are 2.8 times theory's height.
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 0, 0}, {40, 16, 24})));
    int awake = 1;
    for (int i = 0; i < 60; ++i) awake = soil->step({}).block_active_count;
    EXPECT_EQ(awake, 0);
    EXPECT_EQ(soil->surface_height_m(8, 8), 24 * bank.voxel_m);
}

std::vector<BankCase> bank_cases() {
    std::vector<BankCase> cases;
    for (double yaw : {0.0, 22.5, 45.0}) {
        for (double face : {90.0, 60.0}) cases.push_back({1000, 16000, face, 0.1, yaw});
        cases.push_back({1000, 16000, 90, 0.05, yaw});
    }
    for (double voxel : {0.05, 0.025}) cases.push_back({1000, 16000, 60, voxel, 0});
    cases.push_back({1000, 16000, 90, 0.025, 0});
    return cases;
}
INSTANTIATE_TEST_SUITE_P(Banks, LooseBank, testing::ValuesIn(bank_cases()),
                         testing::PrintToStringParamName());

/// Of thousands of columns: minutes.
INSTANTIATE_TEST_SUITE_P(SlowBanks, LooseBank,
                         testing::Values(BankCase{1000, 16000, 60, 0.05, 22.5},
                                         BankCase{1000, 16000, 60, 0.05, 45},
                                         BankCase{1000, 16000, 90, 0.025, 22.5},
                                         BankCase{1000, 16000, 90, 0.025, 45}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::loose_bank_test
