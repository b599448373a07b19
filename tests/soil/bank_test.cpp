// Banks of cohesive soil against the heights to which theory lets them stand.
#include <cmath>
#include <numbers>
#include <set>

#include "bank_case.h"
#include "oracle/banks.h"
#include "stage_bench.h"
#include "temporary_file.h"

namespace bsoil::bank_test {
namespace {

/// Cliffs in random directions, with layers, loose soil, rock below and pillars of it.
StatePlanes random_banks(const StageBench& bench, unsigned seed) {
    using namespace layout;
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution(low, high)(random);
    };
    StatePlanes planes = bench.empty_planes();
    const double yaw = uniform(0, 2 * std::numbers::pi), face = uniform(0, 6);
    const double low = uniform(0, 5), high = uniform(12, 22), layer = uniform(0, 24);
    for (int y = 0; y < planes.ny; ++y) {
        for (int x = 0; x < planes.nx; ++x) {
            const double along =
                (x - planes.nx * 0.4) * std::cos(yaw) + (y - planes.ny * 0.5) * std::sin(yaw);
            const double top =
                low + (high - low) * std::clamp(along / (face + 0.01), 0.0, 1.0) + uniform(0, 0.3);
            const double rock = uniform(0, 1) < 0.02 ? top : 2.3 * (x + y) / planes.nx;
            const double loose = uniform(0, 1) < 0.3 ? uniform(0, 4) : 0;
            for (int z = 0; z < planes.nz; ++z) {
                const int terrain = static_cast<int>(std::clamp(rock - z, 0.0, 1.0) * kVoxelFull);
                const int soil =
                    static_cast<int>(std::clamp(top - z, 0.0, 1.0) * kVoxelFull) - terrain;
                planes.at(kPlaneTerrain, x, y, z) = terrain;
                if (soil <= 0) continue;
                planes.at(kPlaneVolume, x, y, z) = soil;
                planes.at(kPlaneBond, x, y, z) = z + loose > top || uniform(0, 1) < 0.01 ? 0 : soil;
                planes.at(
                    kPlaneMaterial + (z < layer ? 0 : 1 + static_cast<int>(random() % 8 == 0)), x,
                    y, z) = soil / 2;
                if (random() % 11 < 2) {
                    planes.at(kPlaneMaterial + 2, x, y, z) += soil / 5;
                }
            }
        }
    }
    return planes;
}

/// Of the materials one keeps some of its cohesion when it is moved, or all three do. Two regain
/// some by their density and have a peak of friction.
SoilDef random_banks_def(unsigned seed) {
    SoilDef def = grid_def(24, 32, 24);
    def.materials = {sand(25, 2500), sand(32, 1500), sand(35, seed % 2 == 0 ? 500 : 0)};
    def.materials[0].loose_cohesion_fraction = 0.1;
    if (seed % 2 == 0) {
        def.materials[0].loose_cohesion_fraction = 0.4;
        def.materials[1].loose_cohesion_fraction = 0.6;
        def.materials[2].loose_cohesion_fraction = 1;
    }
    for (size_t m = 0; m < 3; ++m) {
        def.materials[m].name += std::to_string(m);
        if (seed % 3 != 0 || m == 1) continue;
        // random_banks() makes soil of 1000 kg/m3 and more: a third dense and denser.
        def.materials[m].loose_density_kg_m3 = 870;
        def.materials[m].compacted_density_kg_m3 = 1700;
        def.materials[m].compaction_cohesion_ratio = 0.2;
        def.materials[m].dilatancy_angle_rad = 4 * kDegree;
    }
    return def;
}

class RandomBanks : public testing::TestWithParam<unsigned> {
  protected:
    static void set_up(StageBench& bench) {
        bench.write(random_banks(bench, GetParam()));
        bench.find_support();
        bench.build_spans();
    }
};

/// Whether a way up from a toe is asked about.
using Asks = std::function<bool(const oracle::Way&)>;

/// What fails now, by the oracle.
oracle::FailingPlanes failing_planes(
    const StageBench& bench, const StatePlanes& state, double strength,
    const Asks& asks = [](const oracle::Way&) { return true; }) {
    const oracle::Model model = bench.model();
    const auto soil = [&](const oracle::Voxel& held, bool bonded) -> oracle::BankSoil {
        std::vector<double> heights, frictions;
        for (const MaterialDef& m : bench.soil().materials()) {
            const double strength_m =
                bonded
                    ? m.cohesion_pa / (m.density_kg_m3 * kGravity)
                    : oracle::moved_strength_m(m, oracle::relative_density(model, held), kGravity);
            heights.push_back(strength_m / bench.soil().def().voxel_m);
            frictions.push_back(
                bonded ? oracle::peak_friction(m, oracle::relative_density(model, held))
                       : std::tan(m.friction_angle_rad));
        }
        return {held.mean(heights), held.mean(frictions)};
    };
    return oracle::failing_planes(model, bench.to_field(state), soil, std::tan(25 * kDegree),
                                  strength, 0.04, asks);
}

void expect_between(const std::vector<double>& cuts, const std::vector<double>& weak,
                    const std::vector<double>& strong) {
    for (size_t column = 0; column < cuts.size(); ++column) {
        EXPECT_LE(cuts[column], strong[column] + 0.04) << column;
        EXPECT_GE(cuts[column], weak[column] - 0.04) << column;
    }
}

// What fails with a fiftieth more strength loses its bond and its cohesion, what stands with a
// fiftieth less keeps it: what Q8 heights and Q12 slopes make of a plane's balance is below 1 %.
// Planes start at a 256th of a column and climb by up to 7 voxels a step, so that their heights are
// good to 0.03 voxel.
TEST_P(RandomBanks, fail_as_the_oracle_says) {
    StageBench bench(random_banks_def(GetParam()));
    set_up(bench);
    const StatePlanes before = bench.read();
    bench.find_failures();
    const StatePlanes after = bench.read();
    const std::vector<double> strong = failing_planes(bench, before, 1.02).lowest,
                              weak = failing_planes(bench, before, 0.98).lowest;
    expect_between(bench.read_cuts(), weak, strong);
    int broken = 0;
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            const size_t column = static_cast<size_t>(y) * before.nx + x;
            for (int z = 0; z < before.nz; ++z) {
                if (before.at(layout::kPlaneBond, x, y, z) == 0) continue;
                const bool breaks = after.at(layout::kPlaneBond, x, y, z) == 0;
                // Heights are good to a hundredth of a voxel.
                if (z > strong[column] + 0.01) {
                    EXPECT_TRUE(breaks) << x << " " << y << " " << z;
                }
                if (z + 1 < weak[column] - 0.01) {
                    EXPECT_FALSE(breaks) << x << " " << y << " " << z;
                }
                broken += breaks;
            }
        }
    }
    RecordProperty("broken", broken);
    if (GetParam() == 1) {
        EXPECT_GT(broken, 200) << "too little fails here to test anything";
    }
    // A plane that has failed does not fail again, and its toe has no flatter one that fails.
    // Planes from lower toes may that pass what has broken.
    StatePlanes last = after;
    int rounds = 0;
    for (; rounds < 200; ++rounds) {
        bench.build_spans();
        bench.find_failures();
        StatePlanes next = bench.read();
        if (next == last) break;
        last = std::move(next);
    }
    RecordProperty("rounds", rounds);
    EXPECT_LT(rounds, 200) << "bonds break for ever";
}

// After soil has slid: a toe that was one asks up the ways where planes failed, one to which soil
// has run out wherever failing soil lies one or two columns on, and one on failing soil nowhere.
TEST_P(RandomBanks, are_asked_again_where_they_failed) {
    StageBench bench(random_banks_def(GetParam()));
    set_up(bench);
    const StatePlanes before = bench.read();
    std::set<std::pair<int, int>> toes;
    const auto weak = failing_planes(bench, before, 0.98,
                                     [&](const oracle::Way&way) {
                                         toes.insert({way.x, way.y});
                                         return true;
                                     }),
               strong = failing_planes(bench, before, 1.02);
    bench.find_failures();
    const std::vector<double> failed = bench.read_cuts();
    bench.slip(1);
    bench.build_spans();
    const StatePlanes slid = bench.read();
    bench.find_failures_again();
    const auto has_failed = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < slid.nx && y < slid.ny &&
               !std::isinf(failed[static_cast<size_t>(y) * slid.nx + x]);
    };
    const auto may_ask = [&](const oracle::Way& way) {
        if (has_failed(way.x, way.y)) return false;
        if (toes.contains({way.x, way.y})) return weak.ways.contains(way);
        return has_failed(way.x + way.dx, way.y + way.dy) ||
               has_failed(way.x + 2 * way.dx, way.y + 2 * way.dy);
    };
    const auto has_to_ask = [&](const oracle::Way& way) {
        if (toes.contains({way.x, way.y}) && !strong.ways.contains(way)) return false;
        return may_ask(way);
    };
    const auto most = failing_planes(bench, slid, 0.98, may_ask),
               least = failing_planes(bench, slid, 1.02, has_to_ask);
    expect_between(bench.read_cuts(), most.lowest, least.lowest);
    RecordProperty("again", std::to_string(least.ways.size()) + " to " +
                                std::to_string(most.ways.size()) + " of " +
                                std::to_string(failing_planes(bench, slid, 0.98).ways.size()));
    if (GetParam() == 1) {
        EXPECT_GT(least.ways.size(), 10u) << "too little fails here to test anything";
    }
}

TEST_P(RandomBanks, have_the_same_bits_on_gl) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    const auto result = [&](Backend backend) {
        SoilDef def = random_banks_def(GetParam());
        def.backend = backend;
        StageBench bench(def);
        set_up(bench);
        bench.find_failures();
        const std::vector<double> failed = bench.read_cuts();
        bench.slip(1);
        bench.build_spans();
        bench.find_failures_again();
        return std::tuple(bench.read(), failed, bench.read_cuts());
    };
    EXPECT_TRUE(result(Backend::cpu) == result(Backend::gl));
}

INSTANTIATE_TEST_SUITE_P(Banks, RandomBanks,
                         testing::Values(1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 23u,
                                         29u, 50u, 97u));

class CohesiveBank : public testing::TestWithParam<BankCase> {};

// Above a factor of safety of 1 nothing moves, not a grain in 10,000 steps.
TEST_P(CohesiveBank, stands_below_its_critical_height) {
    const double share = GetParam().face_deg == 90 ? 0.9 : 0.85;
    auto soil = make_bank(GetParam(), share);
    ASSERT_TRUE(soil);
    const uint64_t checksum = soil->checksum();
    for (int i = 0; i < 10000; ++i) soil->step({});
    EXPECT_EQ(soil->checksum(), checksum);
    EXPECT_EQ(soil->status_bits(), 0u);
}

TEST_P(CohesiveBank, fails_above_its_critical_height) {
    const double share = GetParam().face_deg == 90 ? 1.1 : 1.15;
    auto soil = make_bank(GetParam(), share);
    ASSERT_TRUE(soil);
    const auto highest = [&] {
        double high = 0;
        for (int x = 0; x < soil->frame().size[0]; ++x) {
            high = std::max(high, soil->surface_height_m(x, soil->frame().size[1] / 2));
        }
        return high;
    };
    const int middle_y = soil->frame().size[1] / 2;
    const double crest = highest();
    const auto above_half = [&] {
        double area = 0;
        for (int x = 0; x < soil->frame().size[0]; ++x) {
            area += std::max(0.0, soil->surface_height_m(x, middle_y) - crest / 2) *
                    soil->frame().voxel_m;
        }
        return area;
    };
    // By hand: of the wedge of a vertical cut, 0.29 H^2 at phi 30, three quarters lie above half of
    // its height, and half of that at least has come down; of a face of 60 deg it is 0.21 H^2.
    const double wedge = (GetParam().face_deg == 90 ? 0.29 : 0.21) * crest * crest;
    const double failed_m2 = above_half() - 0.75 / 2 * wedge;
    int steps = 0;
    while (above_half() >= failed_m2 && steps < 300) {
        soil->step({});
        ++steps;
    }
    EXPECT_LT(steps, 300) << "5 s";
    EXPECT_EQ(soil->status_bits(), 0u);
}

// What a bank does does not depend on threads, nor on a stop while it comes down.
TEST(FailingBank, goes_on_from_a_snapshot_bit_for_bit) {
    const BankCase bank{1000, 16000, 60, 0.1, 22.5};
    const TemporaryFile file("failing_bank.snapshot");
    for (int stop : {0, 1, 2, 3, 5, 8, 40}) {
        auto soil = make_bank(bank, 1.15);
        ASSERT_TRUE(soil);
        for (int i = 0; i < stop; ++i) soil->step({});
        ASSERT_TRUE(soil->save(file.path()));
        SoilDef def = soil->def();
        def.thread_count = 3;
        auto twin = make_soil(def);
        ASSERT_TRUE(twin->load(file.path()));
        for (int i = 0; i < 30; ++i) {
            soil->step({});
            twin->step({});
            ASSERT_EQ(soil->checksum(), twin->checksum())
                << "stopped at " << stop << ", step " << i;
        }
    }
}

// Back in time too: what the soil has gone through since says nothing about the steps that follow.
TEST(FailingBank, goes_on_from_a_snapshot_of_its_own_past) {
    const BankCase bank{1000, 16000, 60, 0.1, 22.5};
    const TemporaryFile file("past_bank.snapshot");
    auto soil = make_bank(bank, 1.15);
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->save(file.path()));
    for (int i = 0; i < 40; ++i) soil->step({});
    ASSERT_TRUE(soil->load(file.path()));
    auto twin = make_soil(soil->def());
    ASSERT_TRUE(twin->load(file.path()));
    for (int i = 0; i < 30; ++i) {
        soil->step({});
        twin->step({});
        ASSERT_EQ(soil->checksum(), twin->checksum()) << "step " << i;
    }
}

// A crest that is loaded fails later than it was dug: the toe is looked at again.
TEST(FailingBank, fails_when_its_crest_is_loaded) {
    const BankCase bank{1000, 16000, 90, 0.05, 0};
    auto soil = make_bank(bank, 0.9);
    ASSERT_TRUE(soil);
    for (int i = 0; i < 60; ++i) soil->step({});
    const GridFrame& frame = soil->frame();
    const double height = 0.9 * bank.critical_m();
    int first = 0;  // column of the bank
    while (soil->surface_height_m(first, 4) == 0) ++first;
    const double top = std::ceil(height / frame.voxel_m);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {first + 1.0, 0, top}, {first + 5.0, 8, top + 2})));
    const double before = soil->surface_height_m(first, 4);
    for (int i = 0; i < 120; ++i) soil->step({});
    EXPECT_LT(soil->surface_height_m(first, 4), 0.8 * before);
}

std::vector<BankCase> bank_cases() {
    std::vector<BankCase> cases;
    for (double voxel : {0.1, 0.05, 0.025}) {
        for (double yaw : {0.0, 22.5, 45.0}) {
            cases.push_back({1000, 16000, 90, voxel, yaw});
            // See high_turned_banks().
            if (voxel > 0.05 || yaw == 0) cases.push_back({5000, 18000, 90, voxel, yaw});
            if (voxel > 0.025 || yaw == 0) cases.push_back({1000, 16000, 60, voxel, yaw});
        }
    }
    // Built-in soils at voxels at which wedges of one voxel never failed.
    for (const auto& [material, voxel] :
         {std::pair{materials::moist_sand(), 0.025}, std::pair{materials::sandy_loam(), 0.025},
          std::pair{materials::loam(), 0.1}, std::pair{materials::clay(), 0.2}}) {
        cases.push_back({material.cohesion_pa, material.density_kg_m3 * kGravity, 90, voxel, 0,
                         material.friction_angle_rad / kDegree});
    }
    return cases;
}

/// 14,000 to 40,000 columns, of which thousands slide: minutes.
std::vector<BankCase> high_turned_banks() {
    std::vector<BankCase> cases;
    for (double yaw : {22.5, 45.0}) {
        for (double voxel : {0.05, 0.025}) cases.push_back({5000, 18000, 90, voxel, yaw});
        cases.push_back({1000, 16000, 60, 0.025, yaw});
    }
    return cases;
}

INSTANTIATE_TEST_SUITE_P(Banks, CohesiveBank, testing::ValuesIn(bank_cases()),
                         testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(SlowBanks, CohesiveBank, testing::ValuesIn(high_turned_banks()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::bank_test
