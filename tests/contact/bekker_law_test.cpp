#include "bsoil/contact/bekker_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace bsoil::bekker_law_test {
namespace {

constexpr Vec3 kDown{0, 0, -1};
constexpr double kDeveloped = std::numeric_limits<double>::infinity();

/// Wong's LETE sand: n 0.7, kc 6.2 kN/m^1.7, kphi 1500 kN/m^2.7, c 1.1 kPa, phi 31 deg, K 12 mm.
BekkerSoil lete_sand() {
    BekkerSoil soil;
    soil.n = 0.7;
    soil.kc_pa_m_n1 = 6.2e3;
    soil.kphi_pa_m_n = 1.5e6;
    soil.cohesion_pa = 1.1e3;
    soil.friction_angle_rad = 0.541;
    soil.shear_displacement_m = 0.012;
    return soil;
}

std::unique_ptr<const ContactLaw> law(const SurfaceFriction& surface = {}) {
    auto soil = std::make_shared<ContactSoil>();
    soil->materials = {MaterialDef{}};
    soil->law.kind = ContactLawDef::Kind::bekker;
    soil->law.bekker = {lete_sand()};
    return ContactLaw::make(std::move(soil), surface);
}

ContactVoxel element(Vec3 normal, double depth_m) {
    ContactVoxel v;
    v.normal = normal;
    v.depth_m = v.bearing_depth_m = depth_m;
    return v;
}

TEST(BekkerLaw, sole_bears_bekkers_pressure_whatever_the_density) {
    for (const double depth_m : {0.01, 0.05, 0.2}) {
        const ContactVoxel v = element(kDown, depth_m);
        for (const double relative_density : {0.0, 0.2, 0.9}) {
            // b of 0.3 x 0.6 m is 0.2 m.
            const FaceExtent face{0.3, 0.6, depth_m, relative_density};
            const double limit_pa = law()->yield({v, face}, {}, {}).normal_limit_pa;
            EXPECT_NEAR(limit_pa, (6.2e3 / 0.2 + 1.5e6) * std::pow(depth_m, 0.7), 1e-6 * limit_pa);
        }
    }
}

TEST(BekkerLaw, shear_is_mohr_coulombs_and_develops_as_janosis) {
    const ContactVoxel v = element(kDown, 0.05);
    const FaceExtent face{0.3, 0.6, 0.05, 0};
    const ElementMotion slides{{0.5, 0, -0.5}, 0};
    const ElementYield all = law()->yield({v, face}, slides, {kDeveloped, 0});
    EXPECT_NEAR(all.friction, std::tan(0.541), 1e-12);
    EXPECT_NEAR(all.adhesion_pa, 1.1e3, 1e-9);
    EXPECT_NEAR(all.mobilized_pa.z, all.normal_limit_pa, 1e-9);
    EXPECT_NEAR(all.mobilized_pa.x, -(1.1e3 + std::tan(0.541) * all.normal_limit_pa), 1e-6);
    const ElementYield some = law()->yield({v, face}, slides, {0.012, 0});
    EXPECT_NEAR(some.friction / all.friction, 1 - std::exp(-1.0), 1e-12);
    EXPECT_NEAR(some.adhesion_pa / all.adhesion_pa, 1 - std::exp(-1.0), 1e-12);
    EXPECT_NEAR(law({.friction = 0.2})->yield({v, face}, slides, {kDeveloped, 0}).friction, 0.2,
                1e-12);
}

TEST(BekkerLaw, knows_no_wall_and_lets_go_what_draws_back) {
    const FaceExtent face{0.3, 0.6, 0.1, 0};
    EXPECT_EQ(law()->yield({element({1, 0, 0}, 0.1), face}, {}, {}).normal_limit_pa, 0);
    EXPECT_EQ(law()->yield({element({0, 0, 1}, 0.1), face}, {}, {}).normal_limit_pa, 0);
    const ContactVoxel v = element(kDown, 0.1);
    EXPECT_EQ(law()->yield({v, face}, {}, {0, 0.02}).normal_limit_pa, 0);
    EXPECT_EQ(length(law()->yield({v, face}, {{0, 0, 1}, 0}, {}).mobilized_pa), 0);
}

TEST(ContactLawDef, refuses_what_is_out_of_range_by_name) {
    ContactLawDef def;
    EXPECT_TRUE(def.validate(1));
    def.creep = 0;
    ASSERT_FALSE(def.validate(1));
    EXPECT_NE(def.validate(1).error().find("contact_law.creep is 0"), std::string::npos);
    def = {};
    def.mobilization_fall_widths = 0.15;
    EXPECT_FALSE(def.validate(1)) << "dense soil would bear with no sinkage at all";
    def = {};
    def.kind = ContactLawDef::Kind::bekker;
    ASSERT_FALSE(def.validate(1));
    EXPECT_NE(def.validate(1).error().find("0 entries for 1 materials"), std::string::npos);
    def.bekker = {lete_sand()};
    EXPECT_TRUE(def.validate(1));
    def.bekker[0].n = std::numeric_limits<double>::quiet_NaN();
    ASSERT_FALSE(def.validate(1));
    EXPECT_NE(def.validate(1).error().find("contact_law.bekker[0].n"), std::string::npos);
}

}  // namespace
}  // namespace bsoil::bekker_law_test
