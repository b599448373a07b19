#include "bsoil/contact/contact_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "bsoil/contact/granular_law.h"

namespace bsoil::contact_patches_test {
namespace {

constexpr Vec3 kUp{0, 1, 0};

/// Cohesion only, the same for soles and walls: the same limit stress at every voxel of a body at
/// rest.
SoilStrength uniform_strength(double stress_pa) {
    SoilStrength s;
    s.friction = 0.5;
    s.cohesion_pa = s.cohesion_sole_pa = s.cohesion_wall_pa = stress_pa;
    return s;
}

/// The law of soils with these strengths, in voxels of 0.1 m.
GranularLaw law_of(std::vector<SoilStrength> strengths) {
    auto soil = std::make_shared<ContactSoil>();
    soil->up = kUp;
    soil->voxel_m = 0.1;
    return GranularLaw(std::move(soil), std::move(strengths));
}

ContactVoxel voxel(Vec3 position, Vec3 normal, double area) {
    ContactVoxel v;
    v.center_m = v.position_m = position;
    v.normal = normal;
    v.area_m2 = area;
    v.depth_m = v.bearing_depth_m = 10;  // so that all bearing is developed
    return v;
}

/// A sphere of radius 1 cut into strips of equal angle.
std::vector<ContactVoxel> sphere_voxels() {
    std::vector<ContactVoxel> out;
    const int rings = 40, sectors = 80;
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < sectors; ++j) {
            const double theta = std::numbers::pi * (i + 0.5) / rings;
            const double phi = 2 * std::numbers::pi * (j + 0.5) / sectors;
            const Vec3 n{std::sin(theta) * std::cos(phi), std::cos(theta),
                         std::sin(theta) * std::sin(phi)};
            out.push_back(voxel(n, n, std::sin(theta)));
        }
    }
    return out;
}

Vec3 limit_force(const std::vector<ContactPatch>& patches) {
    Vec3 sum;
    for (const ContactPatch& p : patches) sum += p.normal_limit_n * p.normal;
    return sum;
}

TEST(ContactPatches, uniform_pressure_on_a_closed_body_gives_no_force) {
    std::vector<ContactPatch> patches;
    const GranularLaw law = law_of({uniform_strength(1000)});
    for (const double turn : {0.0, 0.3}) {
        BodyMotion motion;
        motion.pose.rotation = {0, std::sin(turn), 0, std::cos(turn)};
        group_contacts(sphere_voxels(), motion, motion, law, {}, patches);
        EXPECT_EQ(patches.size(), 24u);
        double sum = 0;
        for (const ContactPatch& p : patches) sum += p.normal_limit_n;
        EXPECT_LT(length(limit_force(patches)), 1e-9 * sum);
    }
}

TEST(ContactPatches, patch_sums_equal_voxel_sums) {
    std::vector<ContactVoxel> voxels = sphere_voxels();
    voxels.resize(voxels.size() / 3);
    std::vector<ContactPatch> patches;
    const GranularLaw law = law_of({uniform_strength(1000)});
    group_contacts(voxels, {}, {}, law, {}, patches);
    Vec3 expected;
    for (const ContactVoxel& v : voxels) expected += 1000 * v.area_m2 * v.normal;
    EXPECT_LT(length(limit_force(patches) - expected), 1e-9 * length(expected));
}

TEST(ContactPatches, four_quadrants_carry_a_torque) {
    std::vector<ContactVoxel> voxels;
    for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 10; ++j) {
            voxels.push_back(voxel({-0.45 + 0.1 * i, 0, -0.45 + 0.1 * j}, {0, -1, 0}, 0.01));
        }
    }
    std::vector<ContactPatch> patches;
    const GranularLaw law = law_of({uniform_strength(1000)});
    group_contacts(voxels, {}, {}, law, {}, patches);
    ASSERT_EQ(patches.size(), 4u);
    std::set<std::pair<bool, bool>> corners;
    for (const ContactPatch& p : patches) {
        EXPECT_EQ(p.bin, 3);
        EXPECT_NEAR(std::abs(p.point_m.x), 0.25, 1e-12);
        EXPECT_NEAR(std::abs(p.point_m.z), 0.25, 1e-12);
        EXPECT_NEAR(p.normal_limit_n, 250, 1e-9);
        corners.insert({p.point_m.x > 0, p.point_m.z > 0});
    }
    EXPECT_EQ(corners.size(), 4u);
}

TEST(ContactPatches, bins_turn_with_the_body) {
    const GranularLaw law = law_of({uniform_strength(1000)});
    std::vector<ContactPatch> patches;
    const double h = std::numbers::sqrt2 / 2;
    BodyMotion quarter_turn_about_z;  // body x is world y
    quarter_turn_about_z.pose.rotation = {0, 0, h, h};
    const ContactVoxel down[] = {voxel({}, {0, -1, 0}, 1)};
    group_contacts(down, quarter_turn_about_z, quarter_turn_about_z, law, {}, patches);
    ASSERT_EQ(patches.size(), 1u);
    EXPECT_EQ(patches[0].bin, 1);
}

TEST(ContactPatches, gap_and_material_enter) {
    const GranularLaw law = law_of({uniform_strength(1000), uniform_strength(3000)});
    ContactVoxel v = voxel({}, {0, -1, 0}, 2);
    // A tenth of 0.5 m rebounds; three quarters of the 25 mm beyond that are open.
    v.gap_m = 0.05 + 0.75 * 0.025;
    v.material = 1;
    v.depth_m = v.bearing_depth_m = 0.5;
    v.compression_m = 0.01;
    v.touching = touching_share(v, law.voxel_m(), law.def());
    std::vector<ContactPatch> patches;
    const BodyContact total = group_contacts({&v, 1}, {}, {}, law, {}, patches);
    ASSERT_EQ(patches.size(), 1u);
    EXPECT_NEAR(patches[0].normal_limit_n, 1500, 1e-9);
    EXPECT_NEAR(total.area_m2, 0.5, 1e-12);
    EXPECT_EQ(total.depth_m, 0.5);
    EXPECT_EQ(total.compression_m, 0.01);
}

TEST(ContactPatches, moving_body_mobilizes_force_and_torque) {
    const GranularLaw law = law_of({uniform_strength(1000)});
    const ContactVoxel v = voxel({0.5, 0, 0}, {0, -1, 0}, 1);
    BodyMotion sinking;
    sinking.linear_velocity_m_s = {0, -1, 0};
    std::vector<ContactPatch> patches;
    const BodyContact total = group_contacts({&v, 1}, sinking, sinking, law, {}, patches);
    EXPECT_NEAR(total.mobilized_force_n.y, 1000, 1e-9);
    EXPECT_NEAR(total.mobilized_torque_n_m.z, 500, 1e-9);
}

TEST(ContactPatches, of_a_body_that_is_solved_for_only_the_mobilized_parts_are_left_out) {
    ContactMotion moving;
    moving.motion.linear_velocity_m_s = moving.direction.linear_velocity_m_s = {0.3, -0.8, 0};
    for (const auto kind :
         {ContactLawDef::Kind::granular, ContactLawDef::Kind::plain, ContactLawDef::Kind::work}) {
        auto soil = std::make_shared<ContactSoil>();
        soil->materials = {materials::dry_sand()};
        soil->up = kUp;
        soil->voxel_m = 0.1;
        soil->law.kind = kind;
        const auto law = ContactLaw::make(std::move(soil));
        const std::vector<ContactVoxel> voxels = sphere_voxels();
        ContactPatches whole, solved;
        const BodyContact all = whole.find(voxels, {&moving, 1}, *law, {});
        const BodyContact asked =
            solved.find(voxels, {&moving, 1}, *law, {}, nullptr, {.mobilized = false});
        EXPECT_GT(length(all.mobilized_force_n), 0);
        EXPECT_EQ(length(asked.mobilized_force_n), 0);
        EXPECT_EQ(length(asked.mobilized_torque_n_m), 0);
        EXPECT_EQ(asked.mobilized_pressure_pa, 0);
        EXPECT_EQ(asked.width_m, all.width_m);
        ASSERT_EQ(solved.patches().size(), whole.patches().size());
        ASSERT_FALSE(whole.patches().empty());
        for (size_t i = 0; i < whole.patches().size(); ++i) {
            const ContactPatch &a = whole.patches()[i], &b = solved.patches()[i];
            EXPECT_EQ(a.normal_limit_n, b.normal_limit_n);
            EXPECT_EQ(a.friction, b.friction);
            EXPECT_EQ(length(a.point_m - b.point_m), 0);
        }
    }
}

TEST(ContactPatches, ring_that_turns_has_the_torque_of_its_radius) {
    SoilStrength sticky = uniform_strength(1000);
    sticky.adhesion_pa = 200;
    std::vector<ContactVoxel> voxels;
    const int count = 360;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * (i + 0.5) / count;
        voxels.push_back(voxel({std::cos(angle), 0, std::sin(angle)}, {0, -1, 0}, 0.01));
    }
    BodyMotion turning;
    turning.angular_velocity_rad_s = {0, 1, 0};
    std::vector<ContactPatch> patches;
    group_contacts(voxels, turning, turning, law_of({sticky}), {}, patches);
    ASSERT_EQ(patches.size(), 4u);
    double torque = 0;
    for (const ContactPatch& p : patches) {
        EXPECT_NEAR(length(p.point_m), 0.900, 1e-3) << "the mean of a quarter";
        torque += p.shear_share * p.adhesion_n * length(p.shear_point_m);
    }
    EXPECT_NEAR(torque, 200 * 0.01 * count * 1.0, 0.01 * 200 * 0.01 * count);
}

TEST(ContactPatches, wheel_that_rolls_turns_about_its_rim) {
    SoilStrength sticky = uniform_strength(1000);
    sticky.adhesion_pa = 200;
    std::vector<ContactVoxel> voxels;
    for (double angle = -0.1; angle < 0.5; angle += 0.01) {
        for (double side = -0.2; side < 0.21; side += 0.1) {
            const Vec3 n{std::sin(angle), -std::cos(angle), 0};
            voxels.push_back(voxel(n + side * Vec3{0, 0, 1}, n, 0.001));
        }
    }
    BodyMotion rolling;  // forward, its lowest point at rest
    rolling.linear_velocity_m_s = {0.5, 0, 0};
    rolling.angular_velocity_rad_s = {0, 0, -0.5};
    std::vector<ContactPatch> patches;
    group_contacts(voxels, rolling, rolling, law_of({sticky}), {}, patches);
    ASSERT_EQ(patches.size(), 4u);
    for (const ContactPatch& p : patches) {
        // Every voxel's surface slides backwards along the soil, if it slides at all; so does the
        // patch, whose mean point, inside of the rim, slides forwards near the bottom.
        const Vec3 along{-p.normal.y, p.normal.x, 0};
        EXPECT_LE(dot(rolling.velocity_at(p.shear_point_m), along), 1e-6) << p.point_m.x;
        const Vec3 arm{p.shear_point_m.x, p.shear_point_m.y, 0};
        EXPECT_NEAR(length(arm), 1, 0.02) << p.point_m.x;
    }
}

// By the yield stress and the rebound that the elements' stress is lost over, both the law's.
TEST(ContactPatches, rebound_is_the_mean_of_its_elements_by_their_limits) {
    SoilStrength soft = uniform_strength(1000), hard = uniform_strength(3000);
    std::vector<ContactVoxel> voxels{voxel({-1, 0, -1}, {0, -1, 0}, 1),
                                     voxel({-1, 0, -1}, {0, -1, 0}, 1)};
    voxels[1].material = 1;
    voxels[1].bearing_depth_m = 14;
    std::vector<ContactPatch> patches;
    group_contacts(voxels, {}, {}, law_of({soft, hard}), {}, patches);
    ASSERT_EQ(patches.size(), 1u);
    const double unloading = ContactLawDef{}.unloading_stiffness;
    EXPECT_NEAR(patches[0].rebound_m, (0.25 * 10 + 0.75 * 14) / unloading, 1e-9);
    EXPECT_EQ(unloaded_share(10, rebound_m(10)), 0);
}

TEST(ContactPatches, nothing_gives_no_patches) {
    std::vector<ContactPatch> patches(3);
    const BodyContact total = group_contacts({}, {}, {}, law_of({}), {}, patches);
    EXPECT_TRUE(patches.empty());
    EXPECT_EQ(total.area_m2, 0);
}

}  // namespace
}  // namespace bsoil::contact_patches_test
