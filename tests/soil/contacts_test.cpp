// Contacts from the coverage field's gradient: against the oracle, and against what a closed
// surface has to add up to.
#include "oracle/contacts.h"

#include <numbers>

#include "stage_scenario.h"

namespace bsoil::contacts_test {
namespace {

using namespace layout;

class Contacts : public Stage {};

TEST_P(Contacts, follow_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    const auto got = bench.collect_contacts();
    const std::vector<oracle::Contact> expected =
        oracle::find_contacts(bench.model(), bench.to_field(bench.read()), bench.oracle_bodies());
    ASSERT_EQ(got.size(), expected.size());
    EXPECT_GT(got.size(), 20u);
    int state_count = 0, disturbed_count = 0;
    const bool coheres = GetParam().material_count > 1;  // its moist sand does
    for (size_t i = 0; i < got.size(); ++i) {
        const oracle::Contact& contact = expected[i];
        SCOPED_TRACE(testing::Message()
                     << "voxel " << contact.x << " " << contact.y << " " << contact.z);
        EXPECT_EQ(got[i][0], contact.x);
        EXPECT_EQ(got[i][1], contact.y);
        EXPECT_EQ(got[i][2], contact.z);
        EXPECT_EQ(got[i][3], contact.body);
        // Differences of the same integers, exact in doubles too.
        EXPECT_EQ(got[i][4], contact.gradient.x * kVoxelFull);
        EXPECT_EQ(got[i][5], contact.gradient.y * kVoxelFull);
        EXPECT_EQ(got[i][6], contact.gradient.z * kVoxelFull);
        EXPECT_EQ(got[i][7], contact.gap.x * kVoxelFull);
        EXPECT_EQ(got[i][8], contact.gap.y * kVoxelFull);
        EXPECT_EQ(got[i][9], contact.gap.z * kVoxelFull);
        EXPECT_EQ(got[i][10], contact.excess * kVoxelFull);
        EXPECT_EQ(got[i][11], contact.material);
        EXPECT_EQ(got[i][kContactCarrier], contact.carrier);
        // A quotient, rounded down. Where nothing has cohesion nobody asks.
        const double undisturbed = coheres ? contact.undisturbed : 1;
        const int flag = contact.is_between_walls ? kContactBetweenWalls : 0;
        EXPECT_NEAR((got[i][kContactUndisturbed] - flag) * 1.0 / kVoxelFull, undisturbed, 4e-5);
        int load = contact.load_above + 1;
        for (int k = 0; k < 4; ++k) load += contact.load_ends[k] ? 1 << (kLoadSides + k) : 0;
        EXPECT_EQ(got[i][kContactLoad], load);
        disturbed_count += undisturbed < 0.99;
        if (contact.relative_density < 0) {
            EXPECT_EQ(got[i][12], kDensityFixed);
        } else {
            // Q16 tables of volume per mass and products rounded down, against the range between
            // loose and compacted. Of a mixture only a third of the mass has a range here: thin
            // soil then has some 200 units between the two, and each product is off by up to one.
            const double tolerance = GetParam().material_count > 1 ? 4e-3 : 1e-3;
            EXPECT_NEAR(got[i][12] * 1.0 / kVoxelFull, contact.relative_density, tolerance);
            ++state_count;
        }
    }
    if (GetParam().material_count > 1) {
        EXPECT_GT(state_count, 0);
    }
    EXPECT_EQ(disturbed_count > 0, coheres);
}

TEST_P(Contacts, have_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) { return bench.collect_contacts(); });
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Contacts, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

// Sums over the contacts of a ball all around which resting soil lies.
TEST(ContactGradient,
     feels_nothing_from_uniform_pressure_and_its_displaced_weight_from_hydrostatic) {
    constexpr double kRadius = 4.3;
    StageBench& bench = bench_of({1, 16, 16, 16, 1}, Backend::cpu);
    for (Vec3 middle : {Vec3{8, 8, 8}, Vec3{8.37, 7.81, 8.13}, Vec3{7.55, 8.42, 7.9}}) {
        StatePlanes planes = bench.empty_planes();
        for (int z = 0; z < 16; ++z) {
            for (int y = 0; y < 16; ++y) {
                for (int x = 0; x < 16; ++x) {
                    planes.at(kPlaneVolume, x, y, z) = kVoxelFull;
                    planes.at(kPlaneMaterial, x, y, z) = kVoxelFull;
                }
            }
        }
        bench.write(planes);
        std::vector<Mover> movers;
        movers.emplace_back(0, sphere_shape(kRadius * 0.05), middle * 0.05, true);
        bench.place(movers);
        bench.find_support();
        Vec3 uniform, hydrostatic;
        double covered = 0;
        for (const auto& contact : bench.collect_contacts()) {
            const Vec3 area = Vec3{static_cast<double>(contact[4]), static_cast<double>(contact[5]),
                                   static_cast<double>(contact[6])} *
                              (0.5 / kVoxelFull);
            uniform += area;
            hydrostatic += area * (16 - (contact[2] + 0.5));  // pressure = depth
        }
        const StatePlanes after = bench.read();
        for (int z = 0; z < 16; ++z) {
            for (int y = 0; y < 16; ++y) {
                for (int x = 0; x < 16; ++x) {
                    covered += after.at(kPlaneCoverage, x, y, z) / static_cast<double>(kVoxelFull);
                }
            }
        }
        // Central differences telescope: these sums are exact but for the doubles.
        EXPECT_LT(length(uniform), 1e-9);
        EXPECT_NEAR(hydrostatic.x, 0, 1e-9);
        EXPECT_NEAR(hydrostatic.y, 0, 1e-9);
        EXPECT_NEAR(hydrostatic.z, covered, 1e-3 * covered);
        EXPECT_NEAR(covered, 4 * std::numbers::pi / 3 * std::pow(kRadius, 3), 0.01 * covered);
    }
}

}  // namespace
}  // namespace bsoil::contacts_test
