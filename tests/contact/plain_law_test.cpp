// The plain law by the element, beside the oracle's resistive force theory and figures by hand.
#include "bsoil/contact/plain_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bsoil/contact/contact_patches.h"
#include "oracle/resistive_force.h"
#include "plain_sand.h"

namespace bsoil::plain_law_test {
namespace {

std::unique_ptr<const ContactLaw> plain_law(MaterialDef material, Rules rules = {}) {
    auto soil = std::make_shared<ContactSoil>();
    soil->law.passive_wedge = rules.wedge;
    soil->law.trapped_soil = rules.trapped;
    soil->materials = {std::move(material)};
    soil->law.kind = ContactLawDef::Kind::plain;
    return ContactLaw::make(std::move(soil));
}

/// The k-th of 200 directions spread over the sphere, by the golden angle.
Vec3 spread(int k) {
    const double z = 1 - (k + 0.5) / 100, around = std::sqrt(1 - z * z), t = 2.39996 * k;
    return {around * std::cos(t), around * std::sin(t), z};
}

TEST(PlainLaw, moving_element_meets_the_oracles_stress) {
    const double m = std::tan(kPhi);
    const double xi = 1600 * 9.81 * (894 * m * m * m - 386 * m * m + 89 * m);
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.07;
    int pushed = 0;
    for (int i = 0; i < 200; ++i) {
        voxel.normal = spread(i);
        const Vec3 direction = spread((i * 73 + 11) % 200);
        const ElementYield yield =
            plain_law(sand())->yield({voxel, {}}, {0.6 * direction, 0.3}, {});
        const Vec3 want = xi * 0.07 * oracle::resistive_stress(voxel.normal, direction, 0.5);
        EXPECT_LT(length(yield.mobilized_pa - want), 1e-9 * xi) << i;
        EXPECT_GE(0, dot(yield.mobilized_pa, voxel.normal)) << i << ": soil does not pull";
        if (!(length(want) > 0)) continue;
        ++pushed;
        // Where it is pushed in, its limit is what it meets; the creep of 0.01 turns the
        // push of 0.6 by up to 0.017.
        if (dot(voxel.normal, direction) > 0.3) {
            EXPECT_NEAR(yield.normal_limit_pa, -dot(want, voxel.normal), 0.02 * xi * 0.07) << i;
        }
    }
    EXPECT_GT(pushed, 40);
}

// A row along the normal, one along the sliding: both at their limits give the stress of the
// theory, also where that drags the surface along or aside. The creep of 0.01 turns a push of 0.6.
TEST(PlainLaw, rows_at_yield_give_the_oracles_stress) {
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.07;
    const double m = std::tan(kPhi);
    const double xi_depth = 1600 * 9.81 * (894 * m * m * m - 386 * m * m + 89 * m) * 0.07;
    int dragged = 0;
    for (int i = 0; i < 200; ++i) {
        voxel.normal = spread(i);
        const Vec3 direction = spread((i * 73 + 11) % 200);
        const double approach = dot(voxel.normal, direction);
        if (approach < 0.1) continue;
        const ElementYield yield =
            plain_law(sand())->yield({voxel, {}}, {0.6 * direction, 0.3}, {});
        const Vec3 want = xi_depth * oracle::resistive_stress(voxel.normal, direction, 0.5);
        const Vec3 slide = direction - approach * voxel.normal;
        const Vec3 rows = yield.drag_pa - yield.normal_limit_pa * voxel.normal -
                          (yield.friction * yield.normal_limit_pa / length(slide)) * slide;
        EXPECT_LT(length(rows - want), 0.03 * xi_depth) << i;
        dragged += length(yield.drag_pa) > 0.05 * length(want);
    }
    EXPECT_GT(dragged, 10) << "there is something to drag";
}

TEST(PlainLaw, shear_that_comes_with_the_normal_force_leans_a_patch) {
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.07;
    voxel.area_m2 = 0.01;
    voxel.normal = {std::sin(0.3), 0, -std::cos(0.3)};
    voxel.relative_density = -1;
    // Soil that is pushed aside by an inclined face bears on it across the sliding too.
    BodyMotion motion;
    motion.linear_velocity_m_s = {0.25, 0.6, -0.5};
    const auto law = plain_law(sand());
    const ElementYield yield = law->yield({voxel, {}}, {motion.linear_velocity_m_s, 1}, {});
    ASSERT_GT(length(yield.drag_pa), 0.02 * yield.normal_limit_pa);
    std::vector<ContactPatch> patches;
    group_contacts({&voxel, 1}, motion, motion, *law, {}, patches);
    ASSERT_EQ(patches.size(), 1u);
    const Vec3 push = -patches[0].normal_limit_n * patches[0].normal;
    EXPECT_LT(length(push - 0.01 * (yield.drag_pa - yield.normal_limit_pa * voxel.normal)),
              1e-9 * length(push));
    // At rest it leans on nothing.
    group_contacts({&voxel, 1}, {}, {}, *law, {}, patches);
    EXPECT_LT(length(patches[0].normal - voxel.normal), 1e-12);
}

TEST(PlainLaw, size_density_speed_and_shear_do_not_enter) {
    MaterialDef other = sand();
    other.loose_density_kg_m3 = 1400;
    other.compacted_density_kg_m3 = 1800;
    other.shear_displacement_m = 0.02;
    other.cohesion_pa = 5e3;
    other.tool_adhesion_pa = 2e3;
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.1;
    voxel.normal = {0.6, 0, -0.8};
    const ElementMotion slow{{0.5, 0.2, -0.5}, 0.01}, fast{{0.5, 0.2, -0.5}, 5};
    const ElementYield small = plain_law(sand())->yield({voxel, {}}, slow, {});
    const ElementYield large =
        plain_law(other)->yield({voxel, {1.0, 2.0, 0.1, 0.9, 0.1}}, fast, {0.001, 0});
    EXPECT_EQ(small.normal_limit_pa, large.normal_limit_pa);
    EXPECT_EQ(small.friction, large.friction);
    EXPECT_EQ(large.adhesion_pa, 0);
    EXPECT_EQ(length(small.mobilized_pa - large.mobilized_pa), 0);
}

// By hand: Kp 7.70 of 33 deg and a wall of 26.57 deg, its normal part 6.89; Ka 0.295; twice as wide
// as deep: 1 + 3.80 1.6 / 11 = 1.553. At 0.1 m: 1600 9.81 0.1 6.89 1.553 = 16.8 kPa.
TEST(PlainLaw, wide_wall_meets_its_wedge_and_a_sole_all_it_met) {
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.1;
    voxel.normal = {1, 0, 0};
    const FaceExtent face{0.4, 0.4, 0.19, 0, 0.2};
    const auto yield_of = [&](Rules rules) {
        return plain_law(sand(), rules)->yield({voxel, face}, {{0.9, 0, 0}, 0.1}, {});
    };
    EXPECT_NEAR(yield_of({.wedge = true}).normal_limit_pa, 16.8e3, 0.005 * 16.8e3);
    EXPECT_NEAR(-yield_of({.wedge = true}).mobilized_pa.x, 16.8e3, 0.005 * 16.8e3);
    EXPECT_GT(yield_of({}).normal_limit_pa, 18e3);
    voxel.normal = {0, 0, -1};
    EXPECT_EQ(yield_of({.wedge = true}).normal_limit_pa, yield_of({}).normal_limit_pa);
}

// By hand, 33 deg: h tan(61.5 deg) = 1.842 h. Lugs 10 mm high, 5 mm thick, 30 of them round
// 157.35 mm: pitch 32.95 mm. Of the 27.95 mm
// between two the wedge before one takes 18.42: 0.659. Over the tips it goes all the way round:
// 0.559 of that.
TEST(PlainLaw, soil_between_teeth_shares_an_element_with_the_surface_over_the_tips) {
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.05;
    voxel.normal = {0, 0, -1};
    voxel.teeth = {0.010, 0.005, 0.03295, 0, {0, 0, -1}, ToothPart::base};
    const ElementMotion slides{{0.9, 0, -0.3}, 0.1};
    const auto law = plain_law(sand(), {.trapped = true});
    const ElementYield bare = plain_law(sand())->yield({voxel, {}}, slides, {});
    const ElementYield rim = law->yield({voxel, {}}, slides, {});
    EXPECT_NEAR(rim.area_share, 1 - 0.659, 0.001);
    EXPECT_EQ(rim.normal_limit_pa, bare.normal_limit_pa);
    EXPECT_EQ(rim.friction, bare.friction);
    voxel.teeth.part = ToothPart::over_tips;
    voxel.teeth.above_m = 0.010;
    const ElementYield tips = law->yield({voxel, {}}, slides, {});
    EXPECT_NEAR(tips.area_share, 0.559, 0.001);
    EXPECT_NEAR(law->yield({voxel, {}}, {}, {}).friction, std::tan(kPhi), 1e-12)
        << "soil on soil, where the rim has 0.5";
    // The tips 4 mm deep: four tenths of the space are filled.
    voxel.depth_m = voxel.bearing_depth_m = 0.004;
    EXPECT_NEAR(law->yield({voxel, {}}, slides, {}).area_share, 0.4 * 0.559, 0.001);
    // Close teeth carry all of it.
    voxel.teeth.pitch_m = 0.02;
    voxel.depth_m = voxel.bearing_depth_m = 0.05;
    EXPECT_NEAR(law->yield({voxel, {}}, slides, {}).area_share, 0.75, 0.001) << "teeth 5 of 20 mm";
    voxel.teeth.part = ToothPart::base;
    EXPECT_NEAR(law->yield({voxel, {}}, slides, {}).area_share, 0, 0.001);
    // A tooth's face towards the next is there as far as nothing is filled.
    voxel.teeth.part = ToothPart::tooth;
    EXPECT_EQ(law->yield({voxel, {}}, slides, {}).area_share, 0);
    voxel.depth_m = voxel.bearing_depth_m = 0.005;
    voxel.teeth.above_m = 0.005;  // its middle: three quarters of it are below
    EXPECT_NEAR(law->yield({voxel, {}}, slides, {}).area_share, 0, 1e-12);
    voxel.depth_m = voxel.bearing_depth_m = 0.001;
    EXPECT_NEAR(law->yield({voxel, {}}, slides, {}).area_share, 0.4, 1e-12);
}

TEST(PlainLaw, soil_between_teeth_bears_as_deep_as_their_roots) {
    const auto law = plain_law(sand(), {.trapped = true});
    const auto bears = [&](double depth_m, Vec3 outward) {
        ContactVoxel tips;
        tips.depth_m = tips.bearing_depth_m = depth_m;
        tips.normal = outward;
        tips.teeth = {0.010, 0.005, 0.03295, 0.010, outward, ToothPart::over_tips};
        return law->yield({tips, {}}, {0.9 * outward, 0.1}, {}).normal_limit_pa;
    };
    const double whole = bears(0.05, {0, 0, -1});
    EXPECT_GT(whole, 0);
    EXPECT_NEAR(bears(0.03, {0, 0, -1}), whole / 2, 1e-9 * whole) << "20 of 40 mm";
    EXPECT_EQ(bears(0.010, {0, 0, -1}), 0) << "the rim is at the surface";
    EXPECT_EQ(bears(0.004, {0, 0, -1}), 0);
    // On an upright side teeth and roots are equally deep.
    EXPECT_NEAR(bears(0.03, {1, 0, 0}), 0.6 * bears(0.05, {1, 0, 0}), 1e-9 * whole);
}

TEST(PlainLaw, element_at_rest_holds_a_push_along_its_normal_and_all_friction) {
    ContactVoxel voxel;
    voxel.depth_m = voxel.bearing_depth_m = 0.1;
    voxel.normal = {0, 0, -1};
    const ElementYield rests = plain_law(sand())->yield({voxel, {}}, {}, {});
    const ElementYield sinks = plain_law(sand())->yield({voxel, {}}, {{0, 0, -0.8}, 0.1}, {});
    EXPECT_NEAR(rests.normal_limit_pa, sinks.normal_limit_pa, 1e-9 * sinks.normal_limit_pa);
    EXPECT_NEAR(rests.friction, 0.5, 1e-12);
    EXPECT_EQ(length(rests.mobilized_pa), 0);
    EXPECT_EQ(plain_law(sand())->yield({voxel, {}}, {}, {0, 0.02}).normal_limit_pa, 0)
        << "it has drawn back by a fifth of its depth";
}

}  // namespace
}  // namespace bsoil::plain_law_test
