// The law of the propagation's work beside values by hand: 30 deg, 1600 kg/m3, so that Kp is 3.
#include "bsoil/contact/work_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bsoil::work_law_test {
namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr double kWeight = 1600 * 9.81;
constexpr double kEndless = 1e6;
constexpr Vec3 kDown{0, 0, -1};

std::unique_ptr<const ContactLaw> work_law(double tool_friction, double phi_deg = 30) {
    auto soil = std::make_shared<ContactSoil>();
    MaterialDef material;
    material.density_kg_m3 = 1600;
    material.loose_density_kg_m3 = material.compacted_density_kg_m3 = 0;
    material.friction_angle_rad = phi_deg * kDeg;
    material.cohesion_pa = 0;
    material.tool_friction = tool_friction;
    soil->materials = {material};
    soil->law.kind = ContactLawDef::Kind::work;
    return ContactLaw::make(std::move(soil));
}

ContactVoxel element(Vec3 normal, double depth_m) {
    ContactVoxel out;
    out.depth_m = out.bearing_depth_m = depth_m;
    out.normal = normal;
    out.area_m2 = 0.01;
    return out;
}

ElementYield yield_of(const ContactLaw& law, Vec3 normal, double depth_m, const FaceExtent& face,
                      Vec3 motion = {}) {
    return law.yield({element(normal, depth_m), face}, {motion, 0.1}, {});
}

TEST(WorkLaw, path_has_the_factors_of_rankine_and_prandtl) {
    const WorkPath rough(30 * kDeg, 1);
    EXPECT_NEAR(rough.work_share(0), 3, 1e-12);
    EXPECT_NEAR(rough.work_share(90 * kDeg), 18.40, 0.005);
    EXPECT_EQ(rough.work_share(-90 * kDeg), 1) << "lifting alone";
    EXPECT_EQ(rough.rubbed_share(0), 1);
    EXPECT_NEAR(rough.rubbed_share(-rough.rise()), 1.5, 1e-12) << "1 + sin phi";
    EXPECT_NEAR(rough.rubbed_share(rough.rise()), 0.75, 1e-12);
    EXPECT_EQ(WorkPath(30 * kDeg, 0).rubbed_share(-0.5), 1) << "a smooth face";
    const WorkPath water(0, 0.3);
    EXPECT_NEAR(water.work_share(90 * kDeg), 1, 1e-12);
    EXPECT_EQ(water.friction(), 0);
}

// The shear on the plane of Rankine's wedge, and its rise, are the Kp of its normal stress.
TEST(WorkLaw, work_on_the_rising_path_is_lifting_and_shear) {
    for (const double phi_deg : {20, 30, 40}) {
        const WorkPath path(phi_deg * kDeg, 0);
        const double kp = path.rankine(), sine = std::sin(std::atan(path.rise())),
                     cosine = std::cos(std::atan(path.rise()));
        const double shear =
            path.tangent() * (cosine * cosine + kp * sine * sine) / (sine * cosine);
        EXPECT_NEAR(1 + shear, path.work_share(0), 1e-12);
    }
}

TEST(WorkLaw, sole_bears_its_depth_and_the_zone_of_its_width) {
    const auto law = work_law(0.3);
    // h 0.1 sqrt(3) = 0.1732 m, z 0.0866: 0.03 + 17.40 (0.03 + 0.0866) m of soil.
    EXPECT_NEAR(yield_of(*law, kDown, 0.03, {0.2, kEndless, 0.03, 0, 0}).normal_limit_pa,
                kWeight * 2.059, 0.001 * kWeight);
    // A third of the sinkage over which the zone opens.
    EXPECT_NEAR(yield_of(*law, kDown, 0.01, {0.2, kEndless, 0.01, 0, 0}).normal_limit_pa,
                kWeight * (0.01 + 17.40 * (0.01 + 0.02887)), 0.001 * kWeight);
    // Sides: 0.5774 (0.0009 + 0.0052 + 0.01) / (3 0.2) F = 0.2848 m.
    EXPECT_NEAR(yield_of(*law, kDown, 0.03, {0.2, 0.2, 0.03, 0, 0}).normal_limit_pa,
                kWeight * 2.344, 0.002 * kWeight);
}

// At relative density 1 the zone opens over 0.01 m. Its mean overburden is 0.1166 m or 1830 Pa, so
// that ln p is of 1830 / 0.5 e^(0.907) = 9.07 kPa: 1 (10 - 2.205) - 1 is over 4, and a long strip
// has 30 + 4 5 = 50 deg. Kp 7.549, F 319.1, h 0.2748 m: 0.03 + 318.1 (0.03 + 0.1374) m of soil.
TEST(WorkLaw, dense_soil_under_a_sole_has_boltons_angle) {
    const auto law = work_law(0.3);
    EXPECT_NEAR(yield_of(*law, kDown, 0.03, {0.2, kEndless, 0.03, 1, 0}).normal_limit_pa,
                kWeight * 53.28, 0.1 * kWeight);
    EXPECT_EQ(yield_of(*law, {1, 0, 0}, 0.1, {1, 1, 0.1, 1, 0.1}).normal_limit_pa,
              yield_of(*law, {1, 0, 0}, 0.1, {1, 1, 0.1, 0, 0.1}).normal_limit_pa);
}

TEST(WorkLaw, wall_meets_rankines_wedge_its_sides_and_its_own_friction) {
    const FaceExtent endless{kEndless, kEndless, 0.1, 0, 0.1}, narrow{0.1, 0.1, 0.1, 0, 0.1};
    const Vec3 ahead{1, 0, 0};
    EXPECT_NEAR(yield_of(*work_law(0), ahead, 0.1, endless).normal_limit_pa, 0.3 * kWeight, 1);
    EXPECT_NEAR(yield_of(*work_law(0), ahead, 0.1, narrow).normal_limit_pa, 0.35774 * kWeight, 1);
    // A rough wall, all of whose friction is against the soil that rises before it: 4.5 for 3.
    EXPECT_NEAR(yield_of(*work_law(1), ahead, 0.1, endless).normal_limit_pa, 0.45 * kWeight,
                0.005 * kWeight);
    const ElementYield pushed = yield_of(*work_law(0.3), ahead, 0.1, endless, {0.9, 0, 0});
    EXPECT_NEAR(pushed.drag_pa.z, 0.3 * pushed.normal_limit_pa, 0.02 * pushed.normal_limit_pa)
        << "soil that rises takes the wall along";
    EXPECT_LT(pushed.mobilized_pa.x, 0);
    EXPECT_NEAR(pushed.mobilized_pa.z, -0.3 * pushed.mobilized_pa.x, -0.01 * pushed.mobilized_pa.x);
}

TEST(WorkLaw, friction_lets_a_rising_face_bear_less_and_a_sole_as_much) {
    const auto law = work_law(1);
    const FaceExtent face{0.2, kEndless, 0.05, 0, 0};
    const double pressed = yield_of(*law, kDown, 0.05, face, {0, 0, -0.9}).normal_limit_pa;
    const ElementYield slides = yield_of(*law, kDown, 0.05, face, {0.9, 0, 0});
    EXPECT_NEAR(slides.normal_limit_pa, pressed, 1e-9 * pressed);
    EXPECT_NEAR(slides.friction, std::tan(30 * kDeg), 0.015);
    EXPECT_LT(length(slides.drag_pa), 1e-9 * pressed);
    // Up at the soil's own speed a wall rubs against nothing, faster it lifts the soil.
    const FaceExtent wall{kEndless, kEndless, 0.1, 0, 0.1};
    const auto along_wall = [&](double up) {
        return yield_of(*law, {1, 0, 0}, 0.1, wall, {0.3, 0, up});
    };
    const double flow = 0.31 * std::tan(30 * kDeg);
    EXPECT_NEAR(along_wall(flow).normal_limit_pa, 0.3 * kWeight, 1);
    EXPECT_NEAR(along_wall(flow).friction, 0.02, 0.02);
    EXPECT_NEAR(along_wall(0.9).normal_limit_pa, 0.225 * kWeight, 0.01 * kWeight);
    EXPECT_NEAR(along_wall(-0.9).normal_limit_pa, 0.45 * kWeight, 0.01 * kWeight);
    EXPECT_NEAR(along_wall(-0.9).friction, std::tan(30 * kDeg), 0.015);
}

TEST(WorkLaw, nothing_without_depth_and_less_once_drawn_back) {
    const auto law = work_law(0.5);
    const FaceExtent face{0.2, 0.3, 0.05, 0, 0.1};
    for (const Vec3 normal : {kDown, Vec3{1, 0, 0}, Vec3{0.6, 0, 0.8}}) {
        const ElementYield out = yield_of(*law, normal, 0, face, 0.9 * normal);
        EXPECT_EQ(out.normal_limit_pa, 0);
        EXPECT_EQ(length(out.mobilized_pa), 0);
        EXPECT_LT(yield_of(*law, normal, 1e-6, face).normal_limit_pa, 10);
    }
    EXPECT_EQ(law->yield({element(kDown, 0.05), face}, {}, {0, 0.01}).normal_limit_pa, 0);
    const ElementYield rests = yield_of(*law, kDown, 0.05, face);
    EXPECT_NEAR(rests.friction, 0.5, 1e-12);
    EXPECT_EQ(length(rests.mobilized_pa), 0);
    EXPECT_EQ(length(rests.drag_pa), 0);
}

TEST(WorkLaw, turns_with_the_world_and_grows_with_density) {
    auto soil = std::make_shared<ContactSoil>();
    soil->up = {0, 1, 0};
    soil->materials = {materials::dry_sand()};
    soil->law.kind = ContactLawDef::Kind::work;
    const auto y_up = ContactLaw::make(soil);
    auto same = std::make_shared<ContactSoil>(*soil);
    same->up = {0, 0, 1};
    const auto z_up = ContactLaw::make(same);
    const FaceExtent face{0.2, 0.3, 0.05, 0, 0.1};
    const ElementYield a = yield_of(*z_up, {0.6, 0, -0.8}, 0.05, face, {0.5, 0.2, -0.5});
    const ElementYield b = yield_of(*y_up, {0.6, -0.8, 0}, 0.05, face, {0.5, -0.5, -0.2});
    EXPECT_NEAR(a.normal_limit_pa, b.normal_limit_pa, 1e-9 * a.normal_limit_pa);
    EXPECT_NEAR(a.friction, b.friction, 1e-9);
    EXPECT_NEAR(a.mobilized_pa.z, b.mobilized_pa.y, 1e-9 * a.normal_limit_pa);
    EXPECT_GT(length(a.mobilized_pa), 0);
}

}  // namespace
}  // namespace bsoil::work_law_test
