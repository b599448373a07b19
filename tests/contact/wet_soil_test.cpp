// What laws make of the water in the soil beside an element.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bsoil/contact/contact_law.h"

namespace bsoil::wet_soil_test {
namespace {

constexpr double kSaturation = 0.4;

std::unique_ptr<const ContactLaw> law_of(const MaterialDef& material, ContactLawDef::Kind kind) {
    auto soil = std::make_shared<ContactSoil>();
    soil->law.kind = kind;
    soil->materials = {material};
    return ContactLaw::make(std::move(soil));
}

MaterialDef wet_material() {
    MaterialDef out;
    out.density_kg_m3 = 1500;
    out.cohesion_pa = 300;
    out.pore_water_fraction = 0.25;
    out.moist_cohesion_pa = 2000;
    return out;
}

/// Dry soil that weighs as much and holds together as well.
MaterialDef same_but_dry(MaterialDef material) {
    material.density_kg_m3 *= 1.1;        // 1 + 0.4 * 0.25
    material.cohesion_pa += 0.96 * 2000;  // 4 * 0.4 * (1 - 0.4)
    material.pore_water_fraction = 0;
    return material;
}

ContactVoxel element(Vec3 normal, double saturation) {
    ContactVoxel out;
    out.normal = normal;
    out.depth_m = out.bearing_depth_m = 0.07;
    out.area_m2 = 0.01;
    out.saturation = saturation;
    return out;
}

// Cohesion is none of the laws but the granular one; in all of them the friction of wet soil goes
// by its weight.
TEST(WetSoil, pushes_as_dry_soil_of_its_weight_and_cohesion_does) {
    const ContactHistory sheared{std::numeric_limits<double>::infinity(), 0};
    for (const auto kind :
         {ContactLawDef::Kind::granular, ContactLawDef::Kind::plain, ContactLawDef::Kind::work}) {
        const auto wet = law_of(wet_material(), kind);
        const auto dry = law_of(same_but_dry(wet_material()), kind);
        for (const Vec3 normal :
             {Vec3{0, 0, -1}, {1, 0, 0}, {std::sqrt(0.5), 0, -std::sqrt(0.5)}}) {
            for (const Vec3 motion : {Vec3{0, 0, -1}, {0.8, 0, -0.6}, {}}) {
                const FaceExtent face{0.1, 0.2, 0.07, 0};
                const ElementYield got =
                    wet->yield({element(normal, kSaturation), face}, {motion, 0.2}, sheared);
                const ElementYield want =
                    dry->yield({element(normal, 0), face}, {motion, 0.2}, sheared);
                const double all = want.normal_limit_pa + length(want.mobilized_pa);
                EXPECT_NEAR(got.normal_limit_pa, want.normal_limit_pa, 1e-12 * all);
                EXPECT_LT(length(got.mobilized_pa - want.mobilized_pa), 1e-12 * all + 1e-300);
                EXPECT_LT(length(got.drag_pa - want.drag_pa), 1e-12 * all + 1e-300);
                EXPECT_DOUBLE_EQ(got.friction, want.friction);
            }
        }
    }
}

TEST(WetSoil, full_of_water_has_no_cohesion_but_its_own) {
    const MaterialDef material = wet_material();
    EXPECT_EQ(material.moisture_cohesion_pa(0), 0);
    EXPECT_EQ(material.moisture_cohesion_pa(1), 0);
    EXPECT_EQ(material.moisture_cohesion_pa(0.5), material.moist_cohesion_pa);
    EXPECT_EQ(material.wet_mass_share(0), 1);
    EXPECT_EQ(material.wet_mass_share(1), 1.25);
}

}  // namespace
}  // namespace bsoil::wet_soil_test
