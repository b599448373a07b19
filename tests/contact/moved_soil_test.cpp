// What laws make of soil that has lost its cohesion by being moved.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bsoil/contact/granular_law.h"
#include "bsoil/host/driven_body.h"

namespace bsoil::moved_soil_test {
namespace {

std::unique_ptr<const ContactLaw> law_of(const MaterialDef& material) {
    auto soil = std::make_shared<ContactSoil>();
    soil->materials = {material};
    return ContactLaw::make(std::move(soil));
}

// By hand: u c + (1 - u) of what moved soil has.
TEST(MovedSoil, pushes_as_soil_of_the_cohesion_that_is_left) {
    struct Case {
        double undisturbed, kept, ratio, relative_density, saturation, cohesion_pa;
    };
    const double regained_pa = 0.05 * pressure_of_relative_density(0.6);  // 3.15 kPa
    constexpr double kWater = 4 * 0.25 * 0.75 * 2000;
    for (const Case& c :
         {Case{1, 0, 0, 0.5, 0, 8000}, Case{0, 0, 0, 0.5, 0, 0}, Case{0.25, 0, 0, 0.5, 0, 2000},
          Case{0.25, 0.1, 0, 0.5, 0, 2600}, Case{0, 0.1, 0.05, 0.6, 0, regained_pa},
          Case{0.5, 0, 0.05, 0.6, 0, 4000 + 0.5 * regained_pa}, Case{0, 0, 0.5, 1, 0, 8000},
          Case{0.5, 0.2, 0, 0.5, 0.25, 0.6 * (8000 + kWater)}}) {
        MaterialDef moved = materials::clay();
        moved.cohesion_pa = 8000;
        // As much as the dry soil holds; water is no bound of it.
        moved.tool_adhesion_pa = c.saturation > 0 ? 0 : 1e5;
        moved.loose_cohesion_fraction = c.kept;
        moved.compaction_cohesion_ratio = c.ratio;
        moved.moist_cohesion_pa = 2000;
        MaterialDef same = moved;
        same.cohesion_pa = c.cohesion_pa;
        same.moist_cohesion_pa = 0;
        const auto law = law_of(moved), other = law_of(same);
        for (const Vec3 normal : {Vec3{0, 0, -1}, {1, 0, 0}, {0.6, 0, -0.8}}) {
            for (const Vec3 motion : {Vec3{0, 0, -1}, {0.8, 0, -0.6}, {}}) {
                ContactVoxel element;
                element.normal = normal;
                element.depth_m = element.bearing_depth_m = 0.07;
                element.area_m2 = 0.01;
                element.relative_density = c.relative_density;
                element.saturation = c.saturation;
                const FaceExtent face{0.1, 0.2, 0.07, c.relative_density};
                const ContactHistory sheared{std::numeric_limits<double>::infinity(), 0};
                const ElementYield want = other->yield({element, face}, {motion, 0.2}, sheared);
                element.undisturbed = c.undisturbed;
                const ElementYield got = law->yield({element, face}, {motion, 0.2}, sheared);
                const double all = want.normal_limit_pa + length(want.mobilized_pa) + 1;
                EXPECT_NEAR(got.normal_limit_pa, want.normal_limit_pa, 1e-9 * all);
                EXPECT_LT(length(got.mobilized_pa - want.mobilized_pa), 1e-9 * all);
                EXPECT_NEAR(got.adhesion_pa, want.adhesion_pa, 1e-9 * all);
            }
        }
    }
}

/// Force up on a plate of 0.4 x 0.4 m pressed 0.05 m deep into clay [N].
double bears_n(double cohesion_pa, bool has_fallen) {
    SoilDef def;
    def.up = UpAxis::z;
    def.size_m = {1.6, 1.6, 1.2};
    def.voxel_m = 0.05;
    def.backend = Backend::cpu;
    def.material = materials::clay();
    def.material.cohesion_pa = cohesion_pa;
    def.material.loose_density_kg_m3 = def.material.compacted_density_kg_m3 = 0;
    auto soil = std::move(*Soil::create(def));
    constexpr double kBed = 0.5;
    const double lift_m = has_fallen ? 0.3 : 0;
    EXPECT_TRUE(soil->fill(BoxFill{{{-0.8, -0.8, lift_m}, {0.8, 0.8, lift_m + kBed}}, {}}));
    for (int i = 0; i < 60; ++i) soil->step({});
    EXPECT_EQ(soil->sample(16, 16, 5).undisturbed, has_fallen ? 0 : 1);
    ConvexShape plate;
    plate.half_extents_m = {0.2, 0.2, 0.1};
    const std::vector<ConvexShape> shapes{plate};
    DrivenBody forces(*soil);
    SoilBody body;
    body.shapes = &shapes;
    double force_n = 0;
    constexpr int kSteps = 60;
    constexpr double kSpeed = 0.05;  // m/s
    for (int i = 1; i <= kSteps; ++i) {
        body.pose.position = {0, 0, kBed + 0.1 - kSpeed * i * def.step_s};
        body.center_of_mass_m = body.pose.position;
        body.linear_velocity_m_s = {0, 0, -kSpeed};
        const StepReport report = soil->step({&body, 1});
        force_n = forces.advance(body, report.contacts).mobilized_force_n.z;
    }
    return force_n;
}

// Clay of 20 kPa that has fallen is crumbs: it bears as the same soil without cohesion does.
TEST(MovedSoil, bears_by_its_friction_alone) {
    const double whole_n = bears_n(20e3, false), fallen_n = bears_n(20e3, true),
                 crumbs_n = bears_n(0, true);
    EXPECT_NEAR(fallen_n, crumbs_n, 0.02 * crumbs_n);
    // c Nc of phi 20 deg, developed over 0.15 widths: the plate is pressed in by 0.125 of one. What
    // it pushes aside has lost its cohesion, down to half a width.
    const double cohesive_n = 0.16 * 20e3 * bearing_capacity_factor_nc(0.349) * 0.125 / 0.15;
    EXPECT_GT(whole_n - fallen_n, 0.6 * cohesive_n);
    EXPECT_LT(whole_n - fallen_n, 1.05 * cohesive_n);
}

}  // namespace
}  // namespace bsoil::moved_soil_test
