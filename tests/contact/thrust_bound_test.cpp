// What a wheel can pull: no more than the sand under it can shear. On exact surfaces in a flat bed,
// each element at its limit with its friction against the sliding, as a row of the coupling at
// yield.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/contact/contact_faces.h"
#include "bsoil/contact/plain_law.h"
#include "oracle/resistive_force.h"

namespace bsoil::thrust_bound_test {
namespace {

constexpr double kRadiusM = 0.2, kWidthM = 0.15, kThicknessM = 0.005, kLoadN = 200;

struct Lugs {
    int count;
    double height_m;
};

struct Element {
    oracle::Facet facet;
    ToothRow teeth;
};

ConvexShape cylinder(double radius_m) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::cylinder;
    shape.radius_m = radius_m;
    shape.half_height_m = kWidthM / 2;
    shape.local.rotation = {std::sin(std::numbers::pi / 4), 0, 0, std::cos(std::numbers::pi / 4)};
    return shape;
}

/// Rim and lugs, and the surface over the tips.
std::vector<Element> wheel_with(Lugs lugs) {
    std::vector<ConvexShape> solids{cylinder(kRadiusM)};
    for (int i = 0; i < lugs.count; ++i) {
        const double a = 2 * std::numbers::pi * (i + 0.5) / lugs.count;
        const double root = 0.9 * kRadiusM, top = kRadiusM + lugs.height_m;
        ConvexShape& lug = solids.emplace_back();
        lug.half_extents_m = {kThicknessM / 2, kWidthM / 2, (top - root) / 2};
        lug.local.rotation = {0, std::sin(a / 2), 0, std::cos(a / 2)};
        lug.local.position = rotate(lug.local.rotation, {0, 0, (root + top) / 2});
    }
    constexpr double kEdgeM = kRadiusM / 20;
    std::vector<Element> out;
    const auto add = [&](const oracle::Facet& facet, bool is_over_tips) {
        Element& element = out.emplace_back(Element{facet, {}});
        const double r = std::hypot(facet.at.x, facet.at.z);
        if (lugs.count == 0 || (std::abs(facet.normal.y) > 0.5 && r <= kRadiusM)) return;
        const Vec3 spoke = Vec3{facet.at.x, 0, facet.at.z} * (1 / r);
        const double along = std::abs(dot(facet.normal, cross(spoke, {0, 1, 0})));
        const bool is_on_tooth = r > kRadiusM + 0.02 * lugs.height_m;
        if (is_on_tooth && !is_over_tips && along < 0.7) return;
        element.teeth = {lugs.height_m,
                         kThicknessM,
                         2 * std::numbers::pi * kRadiusM / lugs.count,
                         r - kRadiusM,
                         spoke,
                         is_over_tips  ? ToothPart::over_tips
                         : is_on_tooth ? ToothPart::tooth
                                       : ToothPart::base};
    };
    for (const oracle::Facet& facet : oracle::surface_of(solids, kEdgeM)) add(facet, false);
    if (lugs.count > 0) {
        for (const oracle::Facet& facet :
             oracle::surface_of({cylinder(kRadiusM + lugs.height_m)}, kEdgeM)) {
            if (std::hypot(facet.at.x, facet.at.z) > kRadiusM) add(facet, true);
        }
    }
    return out;
}

/// Along x and up, of a wheel that rolls along x.
Vec3 force_of(const std::vector<Element>& wheel, const ContactLaw& law, double slip,
              double sinkage_m) {
    const double axle_m = kRadiusM - sinkage_m;
    const Vec3 spin{0, 1 / (1 - slip) / kRadiusM, 0};
    std::vector<ContactVoxel> voxels;
    for (const Element& element : wheel) {
        if (axle_m + element.facet.at.z >= 0) continue;
        ContactVoxel& v = voxels.emplace_back();
        v.center_m = v.position_m = element.facet.at;
        v.normal = element.facet.normal;
        v.area_m2 = element.facet.area_m2;
        v.depth_m = v.bearing_depth_m = -(axle_m + element.facet.at.z);
        v.teeth = element.teeth;
    }
    if (voxels.empty()) return {};
    ContactFaces faces;
    faces.find(voxels, {}, law, law.voxel_m());
    Vec3 sum;
    for (size_t i = 0; i < voxels.size(); ++i) {
        const Vec3 velocity = Vec3{1, 0, 0} + cross(spin, voxels[i].position_m);
        const Vec3 share = velocity * (1 / (2 + kRadiusM * spin.y));
        const double approach = dot(share, voxels[i].normal);
        if (approach <= 0) continue;
        const ElementYield yield = law.yield({voxels[i], faces.of_voxel(i)}, {share, 0}, {});
        const Vec3 slide = share - approach * voxels[i].normal;
        Vec3 stress = yield.drag_pa - yield.normal_limit_pa * voxels[i].normal;
        if (length(slide) > 0) {
            stress += slide * (-yield.friction * yield.normal_limit_pa / length(slide));
        }
        sum += voxels[i].area_m2 * yield.area_share * stress;
    }
    return sum;
}

/// Pull over load, the wheel as deep as its load has it.
double pull_share(const std::vector<Element>& wheel, const ContactLaw& law, double slip,
                  double lug_height_m) {
    double low = -lug_height_m, high = 1.2 * kRadiusM;
    for (int i = 0; i < 14; ++i) {
        const double middle = (low + high) / 2;
        (force_of(wheel, law, slip, middle).z < kLoadN ? low : high) = middle;
    }
    const Vec3 force = force_of(wheel, law, slip, high);
    return force.x / kLoadN;
}

/// A law, and which rule it has beside trapped soil.
struct Ruled {
    ContactLawDef::Kind kind;
    bool passive_wedge = true;
};

/// with_rules: else neither. rim_share: of the sand's angle, what the rim has.
std::unique_ptr<const ContactLaw> law_of(Ruled ruled, double friction_angle_rad, bool with_rules,
                                         double rim_share = 1) {
    MaterialDef sand;
    sand.density_kg_m3 = 1500;
    sand.loose_density_kg_m3 = sand.compacted_density_kg_m3 = 0;
    sand.friction_angle_rad = friction_angle_rad;
    sand.cohesion_pa = 0;
    sand.tool_friction = std::tan(rim_share * friction_angle_rad);
    auto soil = std::make_shared<ContactSoil>();
    soil->materials = {sand};
    soil->voxel_m = kRadiusM / 20;
    soil->law.kind = ruled.kind;
    soil->law.passive_wedge = with_rules && ruled.passive_wedge;
    soil->law.trapped_soil = with_rules;
    return ContactLaw::make(soil);
}

// 0.1 is for what the soil before the lugs adds to its own friction.
class ThrustBound : public testing::TestWithParam<Ruled> {};

TEST_P(ThrustBound, no_wheel_pulls_more_than_its_sand_can_shear) {
    double most_without = 0;
    for (const Lugs lugs : {Lugs{0, 0},
                            {8, 0.02},
                            {12, 0.01},
                            {24, 0.01},
                            {12, 0.03},
                            {24, 0.03},
                            {40, 0.03},
                            {16, 0.06}}) {
        const std::vector<Element> wheel = wheel_with(lugs);
        for (const double phi : {25.0, 29.0, 33.0, 38.0, 42.0}) {
            const double tan_phi = std::tan(phi * std::numbers::pi / 180);
            const auto law = law_of(GetParam(), phi * std::numbers::pi / 180, true);
            for (const double slip : {0.02, 0.1, 0.3, 0.6, 0.9}) {
                const double share = pull_share(wheel, *law, slip, lugs.height_m);
                EXPECT_LE(share, tan_phi + 0.1) << phi << " deg, " << lugs.count << " lugs of "
                                                << lugs.height_m << " m, slip " << slip;
            }
            if (lugs.count == 24) {
                most_without = std::max(
                    most_without,
                    pull_share(wheel, *law_of(GetParam(), phi * std::numbers::pi / 180, false), 0.6,
                               lugs.height_m) -
                        tan_phi);
            }
        }
    }
    EXPECT_GT(most_without, 0.25) << "resistive force theory alone has no such bound";
}

// Lugs are there to pull, where the rim is of metal. A rim as rough as the sand shears it as well
// as they do: there they only must not cost pull, but for what they sink.
TEST_P(ThrustBound, lugs_raise_the_pull_of_a_slipping_wheel) {
    for (const double phi : {29.0, 33.0, 38.0}) {
        for (const double rim_share : {2.0 / 3, 1.0}) {
            const auto law = law_of(GetParam(), phi * std::numbers::pi / 180, true, rim_share);
            const double smooth = pull_share(wheel_with({0, 0}), *law, 0.1, 0);
            const double least = rim_share < 1 ? smooth : smooth - 0.01;
            for (const Lugs lugs : {Lugs{12, 0.01}, {24, 0.01}, {24, 0.03}}) {
                EXPECT_GT(pull_share(wheel_with(lugs), *law, 0.1, lugs.height_m), least)
                    << phi << " deg, rim " << rim_share << ", " << lugs.count << " of "
                    << lugs.height_m;
            }
        }
    }
}

// The work of propagation needs no soil between the lugs for its bound: friction along a face is
// all that pulls, and lugs meet no more than their wedge.
TEST(ThrustByWork, has_its_bound_with_and_without_trapped_soil) {
    for (const Lugs lugs : {Lugs{0, 0}, {12, 0.03}, {24, 0.01}, {24, 0.03}, {40, 0.03}}) {
        const std::vector<Element> wheel = wheel_with(lugs);
        for (const double phi : {25.0, 33.0, 42.0}) {
            const double tan_phi = std::tan(phi * std::numbers::pi / 180);
            for (const bool is_trapped : {false, true}) {
                const auto law =
                    law_of({ContactLawDef::Kind::work}, phi * std::numbers::pi / 180, is_trapped);
                for (const double slip : {0.1, 0.3, 0.6, 0.9}) {
                    EXPECT_LE(pull_share(wheel, *law, slip, lugs.height_m), tan_phi + 0.1)
                        << phi << " deg, " << lugs.count << " lugs of " << lugs.height_m
                        << " m, slip " << slip << (is_trapped ? ", trapped" : "");
                }
            }
        }
    }
}

// As a scene has it that names no rule: trapped soil alone.
INSTANTIATE_TEST_SUITE_P(Laws, ThrustBound,
                         testing::Values(Ruled{ContactLawDef::Kind::granular},
                                         Ruled{ContactLawDef::Kind::granular, false},
                                         Ruled{ContactLawDef::Kind::plain}),
                         [](const auto& law) -> std::string {
                             if (law.param.kind == ContactLawDef::Kind::plain) return "plain";
                             return law.param.passive_wedge ? "granular" : "granular_by_default";
                         });

}  // namespace
}  // namespace bsoil::thrust_bound_test
