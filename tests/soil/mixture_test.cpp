// Soil of several materials: each of its strengths lies between theirs, by their shares.
#include <numbers>

#include "soil_fixture.h"

namespace bsoil::mixture_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGravity = 9.81;

MaterialDef named(MaterialDef material, const std::string& name) {
    material.name = name;
    return material;
}

/// A box of soil in which every voxel holds each material of the soil by its share.
void fill_mixed(Soil& soil, Vec3 size_m, const std::vector<double>& shares) {
    const double voxel_m = soil.frame().voxel_m;
    const int layers = static_cast<int>(std::lround(size_m.z / voxel_m));
    for (int z = 0; z < layers; ++z) {
        double from = z * voxel_m;
        for (size_t m = 0; m < shares.size(); ++m) {
            const double to = from + shares[m] * voxel_m;
            if (shares[m] > 0) {
                ASSERT_TRUE(soil.fill(
                    BoxFill{{{0, 0, from}, {size_m.x, size_m.y, to}}, soil.materials()[m].name}));
            }
            from = to;
        }
    }
}

/// A bank against a wall, as high as it is wide, of materials in these shares.
std::unique_ptr<Soil> mixed_bank(const std::vector<MaterialDef>& materials,
                                 const std::vector<double>& shares, double height_m,
                                 double voxel_m) {
    const int high = static_cast<int>(std::lround(height_m / voxel_m));
    SoilDef def = grid_def(5 * high, 8, high + 2, voxel_m);
    def.materials = materials;
    auto soil = make_soil(def);
    fill_mixed(*soil, {height_m, 8 * voxel_m, height_m}, shares);
    return soil;
}

int settle(Soil& soil) {
    int steps = 0;
    while (steps < 3000 && soil.step({}).block_active_count > 0) ++steps;
    EXPECT_LT(steps, 3000);
    return steps;
}

/// Slope of the line through the surface between 1/4 and 3/4 of its height [deg].
double slope_deg(const Soil& soil) {
    const double peak = soil.surface_height_m(0, 4);
    double n = 0, sx = 0, sh = 0, sxx = 0, sxh = 0;
    for (int i = 0; i < soil.frame().size[0]; ++i) {
        const double h = soil.surface_height_m(i, 4), x = i * soil.frame().voxel_m;
        if (h < 0.25 * peak || h > 0.75 * peak) continue;
        n += 1;
        sx += x;
        sh += h;
        sxx += x * x;
        sxh += x * h;
    }
    return std::atan(-(n * sxh - sx * sh) / (n * sxx - sx * sx)) / kDegree;
}

class Mixture : public testing::TestWithParam<double> {};

// By the majority's vote the slope jumped from 20 to 40 deg at half and half.
TEST_P(Mixture, of_two_sands_stands_between_them_by_its_shares) {
    double before_deg = 0;
    for (double share : {0.0, 0.25, 0.45, 0.55, 0.75, 1.0}) {
        auto soil = mixed_bank({named(sand(20), "fine"), named(sand(40), "coarse")},
                               {1 - share, share}, 16 * GetParam(), GetParam());
        settle(*soil);
        const double mean = (1 - share) * std::tan(20 * kDegree) + share * std::tan(40 * kDegree);
        const double got_deg = slope_deg(*soil);
        // The gate of Repose. Voxels at the surface hold fine soil above coarse when they are laid.
        EXPECT_NEAR(got_deg, std::atan(mean) / kDegree, 1.5) << "share " << share;
        EXPECT_GT(got_deg, before_deg + (share > 0 ? 0.5 : 0)) << "share " << share;
        before_deg = got_deg;
    }
}

// Half a sand without cohesion and half one of 2 kPa: a vertical cut stands as in soil of 1 kPa.
TEST_P(Mixture, of_sand_and_cohesive_soil_stands_as_high_as_its_mean_cohesion_lets_it) {
    const double critical_m = 4 * 1000 / (1600 * kGravity) * std::tan(60 * kDegree);
    for (const auto& [share, stands] : {std::pair(0.9, true), std::pair(1.15, false)}) {
        const double voxels = share * critical_m / GetParam();
        if (voxels < 4) continue;  // such low walls are not told apart
        const double height_m = (stands ? std::floor(voxels) : std::ceil(voxels)) * GetParam();
        auto soil = mixed_bank({named(sand(30), "sand"), named(sand(30, 2000), "silt")}, {0.5, 0.5},
                               height_m, GetParam());
        const uint64_t checksum = soil->checksum();
        for (int i = 0; i < 300; ++i) soil->step({});
        EXPECT_EQ(soil->checksum() == checksum, stands) << height_m << " m";
    }
}

INSTANTIATE_TEST_SUITE_P(Voxels, Mixture, testing::Values(0.1, 0.05, 0.025));

// By the friction of the first material all of them went with the body alike.
TEST(Mixtures, on_a_body_are_taken_along_by_the_mean_of_their_own_friction) {
    MaterialDef rough = named(materials::dry_sand(), "rough"), slick = named(rough, "slick");
    rough.tool_friction = 0.8;
    slick.tool_friction = 0;
    for (const double share : {1.0, 0.5, 0.0}) {
        SoilDef def = grid_def(48, 24, 16);
        def.materials = {rough, slick};
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil);
        // A plate in the air, with a layer of one voxel on it.
        Mover plate(1, box_shape(Vec3{10, 8, 1} * def.voxel_m), Vec3{14, 12, 7} * def.voxel_m);
        soil->step({&plate.body, 1});
        const double low = 8 * def.voxel_m, middle = (8 + share) * def.voxel_m;
        const auto layer = [&](double from, double to) {
            return Aabb{Vec3{8, 8, 0} * def.voxel_m + Vec3{0, 0, from},
                        Vec3{20, 16, 0} * def.voxel_m + Vec3{0, 0, to}};
        };
        const bool is_filled =
            (share == 0 || soil->fill(BoxFill{layer(low, middle), "rough"})) &&
            (share == 1 || soil->fill(BoxFill{layer(middle, 9 * def.voxel_m), "slick"}));
        ASSERT_TRUE(is_filled);
        plate.set_velocity({3, 0, 0});  // no speed that the soil gets to
        const auto step = [&] {
            plate.advance(def.step_s);
            soil->step({&plate.body, 1});
            return soil->sample(13, 12, 8).velocity_m_s.x;
        };
        double before = 0, after = 0;
        for (int i = 0; i < 2; ++i) before = step();
        after = step();
        // Within the rounding of Q10 velocities, 1/1024 voxel a step, twice.
        EXPECT_NEAR(after - before, share * rough.tool_friction * kGravity * def.step_s,
                    2 * def.voxel_m / def.step_s / 1024)
            << share;
    }
}

TEST(Mixtures, of_four_materials_keep_each_to_the_unit) {
    auto soil = mixed_bank(
        {named(sand(20), "a"), materials::clay(), materials::gravel(), materials::moist_sand()},
        {0.5, 0.02, 0.38, 0.1}, 0.8, 0.05);
    const SoilTotals before = soil->totals();
    const auto expect_masses_by_region = [&](const char* when) {
        const Vec3 half = soil->def().size_m * 0.5;
        const Vec3 middle = soil->def().floor_center_m + Vec3{0, 0, half.z};
        const ConvexShape all = box_shape(half * 1.1), left = box_shape({half.x, half.y, half.z});
        const std::vector<double> masses = soil->masses_inside_kg(all, {middle, {}});
        const std::vector<double> part =
            soil->masses_inside_kg(left, {middle - Vec3{half.x, 0, 0}, {}});
        ASSERT_EQ(masses.size(), 4u);
        double sum = 0, part_sum = 0;
        for (size_t m = 0; m < 4; ++m) {
            EXPECT_NEAR(masses[m], before.mass_kg[m], 1e-9 * before.mass_kg[m]) << when << m;
            EXPECT_LE(part[m], masses[m]);
            sum += masses[m];
            part_sum += part[m];
        }
        EXPECT_NEAR(soil->mass_inside_kg(all, {middle, {}}), sum, 1e-9 * sum) << when;
        EXPECT_NEAR(soil->mass_inside_kg(left, {middle - Vec3{half.x, 0, 0}, {}}), part_sum,
                    1e-9 * sum)
            << when;
    };
    expect_masses_by_region("asleep ");
    for (int i = 0; i < 5; ++i) soil->step({});
    expect_masses_by_region("awake ");
    settle(*soil);
    const SoilTotals after = soil->totals();
    EXPECT_EQ(after.units, before.units);
    for (int64_t units : before.units) EXPECT_GT(units, 0);
    EXPECT_LT(slope_deg(*soil), 45);
    EXPECT_EQ(soil->status_bits(), 0u);
}

// Loose densities of 1430 and 1600 kg/m3: a kilogram of each takes up what both take up apart.
TEST(Mixtures, swell_by_the_volumes_of_their_materials) {
    auto soil = mixed_bank({materials::dry_sand(), materials::gravel()}, {0.5, 0.5}, 0.8, 0.05);
    const SoilTotals totals = soil->totals();
    settle(*soil);
    double volume_m3 = 0, loose_m3 = 0;
    const GridFrame& frame = soil->frame();
    double loose_kg = 0;
    for (int x = 0; x < frame.size[0]; ++x) {
        for (int z = 0; z < frame.size[2]; ++z) {
            const VoxelSample voxel = soil->sample(x, 4, z);
            if (voxel.volume > 0.01 && voxel.undisturbed == 0 && voxel.volume < 1) {
                loose_m3 += voxel.volume;
                loose_kg += voxel.volume * voxel.density_kg_m3;
            }
            volume_m3 += voxel.volume;
        }
    }
    const double placed_share = 1600.0 / (1600 + 1800);  // of the mass, of dry sand
    const double loose_density = 1 / (placed_share / 1430 + (1 - placed_share) / 1600);
    ASSERT_GT(loose_m3, 0.05 * volume_m3);
    // 1 %: voxels at the surface hold a little more of the one or the other.
    EXPECT_NEAR(loose_kg / loose_m3, loose_density, 0.01 * loose_density);
    EXPECT_EQ(soil->totals().units, totals.units);
}

}  // namespace
}  // namespace bsoil::mixture_test
