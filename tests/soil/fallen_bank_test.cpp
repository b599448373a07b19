// What becomes of banks that have failed, of undercut ones, overhangs and cavities: heaps whose
// angle, height and foot follow from the area that came down.
#include <string>
#include <tuple>
#include <vector>

#include "bank_case.h"

namespace bsoil::fallen_bank_test {
namespace {

using namespace bank_test;

struct Point {
    double along_m, height_m;
};

/// Heights along a line through the grid's middle, turned by yaw about it: the columns beside it.
std::vector<Point> profile(const Soil& soil, double yaw_deg) {
    const GridFrame& frame = soil.frame();
    const double c = std::cos(yaw_deg * kDegree), s = std::sin(yaw_deg * kDegree);
    std::vector<Point> out;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            const double dx = x + 0.5 - frame.size[0] / 2.0, dy = y + 0.5 - frame.size[1] / 2.0;
            if (std::abs(dy * c - dx * s) > 1.5) continue;
            out.push_back({(dx * c + dy * s) * frame.voxel_m, soil.surface_height_m(x, y)});
        }
    }
    return out;
}

/// A straight line through the points between a quarter and three quarters of a heap's height.
struct Flank {
    double slope_deg = 0, foot_m = 0;  ///< where it meets the floor
};
Flank flank_of(const std::vector<Point>& points, double heap_m, double behind_m) {
    double n = 0, sx = 0, sh = 0, sxx = 0, sxh = 0;
    for (const Point& p : points) {
        if (p.along_m > behind_m || p.height_m < 0.25 * heap_m || p.height_m > 0.75 * heap_m) {
            continue;
        }
        n += 1;
        sx += p.along_m;
        sh += p.height_m;
        sxx += p.along_m * p.along_m;
        sxh += p.along_m * p.height_m;
    }
    const double rise = (n * sxh - sx * sh) / (n * sxx - sx * sx);
    return {std::atan(rise) / kDegree, sx / n - sh / n / rise};
}

/// Steps until nothing is active, and then not a grain moves.
void come_to_rest(Soil& soil, double at_most_s) {
    const int steps_max = static_cast<int>(at_most_s / soil.def().step_s);
    const auto settled = soil.settle(steps_max);
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest) << "after " << steps_max << " steps";
    testing::Test::RecordProperty("steps", settled->step_count);
    const uint64_t checksum = soil.checksum();
    for (int i = 0; i < 60; ++i) soil.step({});
    EXPECT_EQ(soil.checksum(), checksum);
}

class FallenBank : public testing::TestWithParam<BankCase> {};

// By hand. The plane that fails rises from the toe by (face + phi) / 2. What lay above it, 1/2 H^2
// (cot plane - cot face), lies on it and on the floor as a wedge of phi: with its foot at the
// distance a it meets the plane at a height of a / (cot phi - cot plane), so that 1/2 a of that is
// the area. Just above the critical height there is no other plane that fails.
TEST_P(FallenBank, rests_as_a_heap_at_phi_with_the_foot_that_its_area_gives) {
    const BankCase& bank = GetParam();
    const double share = bank.face_deg == 90 ? 1.1 : 1.15;
    const auto soil = make_bank(bank, share, 1.2);
    ASSERT_TRUE(soil);
    const auto cot = [](double angle_deg) { return 1 / std::tan(angle_deg * kDegree); };
    const double high = share * bank.critical_m();
    const double plane_deg = (bank.face_deg + bank.friction_deg) / 2;
    const double area = 0.5 * high * high * (cot(plane_deg) - cot(bank.face_deg));
    const double spread = cot(bank.friction_deg) - cot(plane_deg);
    const double foot = std::sqrt(2 * area * spread), heap = foot / spread;

    // The old foot: where the ground rises first.
    double old_foot = 1e9;
    for (const Point& p : profile(*soil, bank.yaw_deg)) {
        if (p.height_m > 0) old_foot = std::min(old_foot, p.along_m - bank.voxel_m / 2);
    }
    const int64_t units = soil->totals().units[0];
    come_to_rest(*soil, 300);
    EXPECT_EQ(soil->totals().units[0], units);
    EXPECT_EQ(soil->status_bits(), 0u);

    const std::vector<Point> points = profile(*soil, bank.yaw_deg);
    const Flank flank = flank_of(points, heap, old_foot + heap * cot(plane_deg));
    RecordProperty("slope_deg", std::to_string(flank.slope_deg));
    RecordProperty("foot", std::to_string((old_foot - flank.foot_m) / foot));
    EXPECT_NEAR(flank.slope_deg, bank.friction_deg, 1.5);  // the bar of slopes at rest
    // A voxel, and a tenth for planes that fail further back.
    EXPECT_NEAR(old_foot - flank.foot_m, foot, 0.1 * foot + bank.voxel_m);
    // Behind it the ground is as it was: no further than a second wedge is wide.
    double crest = 1e9;
    for (const Point& p : points) {
        if (p.height_m > high - 1.5 * bank.voxel_m) crest = std::min(crest, p.along_m);
    }
    RecordProperty("crest", std::to_string((crest - old_foot) / (high * cot(plane_deg))));
    EXPECT_GT(crest - old_foot, high * cot(plane_deg) - 1.5 * bank.voxel_m);
    EXPECT_LT(crest - old_foot, 1.5 * high * cot(plane_deg));
}

INSTANTIATE_TEST_SUITE_P(
    Banks, FallenBank,
    testing::Values(BankCase{5000, 18000, 90, 0.1, 0}, BankCase{1000, 16000, 90, 0.025, 0},
                    BankCase{1000, 16000, 60, 0.1, 0}, BankCase{1000, 16000, 60, 0.05, 0},
                    BankCase{1000, 16000, 60, 0.1, 22.5}, BankCase{1000, 16000, 60, 0.1, 45}),
    testing::PrintToStringParamName());
/// The last grains of a flank of so many voxels take two minutes to come to rest.
INSTANTIATE_TEST_SUITE_P(SlowBanks, FallenBank,
                         testing::Values(BankCase{5000, 18000, 90, 0.05, 0},
                                         BankCase{5000, 18000, 90, 0.025, 0},
                                         BankCase{1000, 16000, 60, 0.025, 0}),
                         testing::PrintToStringParamName());

/// Soil of 5 kPa and 18 kN/m3, of which a vertical face stands to 1.92 m.
constexpr double kCohesionPa = 5000, kUnitWeight = 18000, kFrictionDeg = 30;

/// A bank with a notch at its foot, in metres.
struct Notch {
    const char* name;
    double high, notch_high, notch_deep;
};

class Overhang : public testing::TestWithParam<std::tuple<Notch, double>> {};

// By hand. What hangs over the notch falls, b times (H - h) of area. It comes to rest against the
// wall that stands behind, as a wedge of phi: sqrt(2 A cot phi) long and that times tan phi high.
// The face above it is lower than soil of this strength stands, so the crest is the notch's wall.
TEST_P(Overhang, falls_and_rests_as_a_heap_against_what_it_hung_on) {
    const auto& [notch, voxel] = GetParam();
    const double front = 1.6, behind = 1.2, length = front + behind;
    SoilDef def = grid_def(static_cast<int>(std::lround(length / voxel)), 8,
                           static_cast<int>(std::lround(notch.high / voxel)) + 4, voxel);
    def.material = sand(kFrictionDeg, kCohesionPa);
    def.material.density_kg_m3 = kUnitWeight / kGravity;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    const double width = 8 * voxel, wall = front + notch.notch_deep;
    ASSERT_TRUE(soil->fill(BoxFill{{{wall, 0, 0}, {length, width, notch.notch_high}}, {}}));
    ASSERT_TRUE(
        soil->fill(BoxFill{{{front, 0, notch.notch_high}, {length, width, notch.high}}, {}}));
    const int64_t units = soil->totals().units[0];
    come_to_rest(*soil, 30);
    EXPECT_EQ(soil->totals().units[0], units);
    EXPECT_EQ(soil->status_bits(), 0u);

    const double tan_phi = std::tan(kFrictionDeg * kDegree);
    const double area = notch.notch_deep * (notch.high - notch.notch_high);
    const double heap_long = std::sqrt(2 * area / tan_phi), heap_high = heap_long * tan_phi;
    ASSERT_LT(heap_high, notch.high);
    std::vector<Point> points = profile(*soil, 0);
    for (Point& p : points) p.along_m += length / 2;
    const Flank flank = flank_of(points, heap_high, wall);
    RecordProperty("slope_deg", std::to_string(flank.slope_deg));
    RecordProperty("length", std::to_string((wall - flank.foot_m) / heap_long));
    EXPECT_NEAR(flank.slope_deg, kFrictionDeg, 1.5);  // the bar of slopes at rest
    EXPECT_NEAR(wall - flank.foot_m, heap_long, 0.05 * heap_long + voxel);
    for (const Point& p : points) {
        if (p.along_m > wall) {
            EXPECT_NEAR(p.height_m, notch.high, 1e-6) << p.along_m;
        } else if (p.along_m > wall - voxel) {
            EXPECT_NEAR(p.height_m, heap_high, 0.05 * heap_high + voxel);
        }
    }
}

std::string name_of(const testing::TestParamInfo<std::tuple<Notch, double>>& test) {
    return std::string(std::get<Notch>(test.param).name) + "_voxel_mm_" +
           std::to_string(std::lround(std::get<double>(test.param) * 1000));
}
INSTANTIATE_TEST_SUITE_P(Voxels, Overhang,
                         testing::Combine(testing::Values(Notch{"undercut", 1.2, 0.4, 0.2},
                                                          Notch{"ledge", 1.2, 0.8, 0.4}),
                                          testing::Values(0.1, 0.05, 0.025)),
                         name_of);

class Cavity : public testing::TestWithParam<double> {};

// Such soil spans 2 c / gamma, 0.62 m. A wider roof falls, as far as the cavity is high. The walls
// of the trench above it stand.
TEST_P(Cavity, too_wide_for_a_roof_is_filled_by_it) {
    const double voxel = GetParam(), high = 1.2, cavity = 0.4, across = 0.8;
    SoilDef def = grid_def(static_cast<int>(std::lround(2.4 / voxel)), 8,
                           static_cast<int>(std::lround(high / voxel)) + 4, voxel);
    def.material = sand(kFrictionDeg, kCohesionPa);
    def.material.density_kg_m3 = kUnitWeight / kGravity;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil);
    const double width = 8 * voxel;
    for (const auto& [from, to, low] :
         {std::tuple(0.0, 0.8, 0.0), {0.8, 0.8 + across, cavity}, {0.8 + across, 2.4, 0.0}}) {
        ASSERT_TRUE(soil->fill(BoxFill{{{from, 0, low}, {to, width, high}}, {}}));
    }
    come_to_rest(*soil, 10);
    double sum_m = 0, count = 0;
    for (const Point& p : profile(*soil, 0)) {
        if (std::abs(p.along_m) > across / 2) {
            EXPECT_NEAR(p.height_m, high, 1e-6) << p.along_m;
            continue;
        }
        // It breaks up as it falls: what is uneven by less than phi stays so.
        EXPECT_NEAR(p.height_m, high - cavity, 0.1 * cavity) << p.along_m;
        sum_m += p.height_m;
        ++count;
    }
    EXPECT_NEAR(sum_m / count, high - cavity, 0.1 * voxel);  // what voxels may lack and carry
}
INSTANTIATE_TEST_SUITE_P(Voxels, Cavity, testing::Values(0.1, 0.05, 0.025));

}  // namespace
}  // namespace bsoil::fallen_bank_test
