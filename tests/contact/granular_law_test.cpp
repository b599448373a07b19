#include "bsoil/contact/granular_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "bsoil/contact/resistive_force_theory.h"
#include "bsoil/contact/soil_flow.h"

namespace bsoil::granular_law_test {
namespace {

constexpr Vec3 kUp{0, 1, 0};
constexpr Vec3 kDown{0, -1, 0};
constexpr double kGravity_m_s2 = 9.81;

MaterialDef sand() { return {}; }
MaterialDef cohesive() {
    MaterialDef m;
    m.cohesion_pa = 1000;
    return m;
}

ContactVoxel element(Vec3 normal, double depth_m) {
    ContactVoxel v;
    v.normal = normal;
    v.depth_m = v.bearing_depth_m = depth_m;
    v.area_m2 = 1;
    return v;
}

/// What the law finds for one strength, all shear developed.
ElementYield yield_of_element(const ContactVoxel& voxel, Vec3 share, double approach_m_s, Vec3 up,
                              const SoilStrength& strength, const FaceExtent& face = {},
                              double retreat_m = 0) {
    const auto soil = std::make_shared<ContactSoil>();
    soil->up = up;
    return GranularLaw(soil, std::vector{strength})
        .yield({voxel, face}, {share, approach_m_s},
               {std::numeric_limits<double>::infinity(), retreat_m});
}

TEST(TouchingShare, is_all_within_the_rebound_and_none_a_quarter_of_a_voxel_beyond) {
    ContactVoxel v;
    v.depth_m = v.bearing_depth_m = 0.04;  // rebounds by 4 mm
    const auto at = [&](double gap_m) {
        v.gap_m = gap_m;
        return touching_share(v, 0.02);
    };
    EXPECT_EQ(at(0), 1);
    EXPECT_EQ(at(0.004), 1);
    EXPECT_NEAR(at(0.0065), 0.5, 1e-12);
    EXPECT_NEAR(at(0.009), 0, 1e-12);
    EXPECT_EQ(at(0.03), 0);
    v.depth_m = v.bearing_depth_m = 0;
    EXPECT_NEAR(at(0.0025), 0.5, 1e-12);
}

TEST(GranularLaw, bearing_capacity_factor_is_prandtls) {
    EXPECT_NEAR(bearing_capacity_factor_nc(0), 5.142, 1e-3);
    EXPECT_NEAR(bearing_capacity_factor_nc(30 * std::numbers::pi / 180), 30.14, 1e-2);
    EXPECT_NEAR(bearing_capacity_factor_nc(2e-4), bearing_capacity_factor_nc(0), 5e-3);
}

TEST(GranularLaw, resting_surface_yields_as_if_pressed_along_its_normal) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const ElementYield y = yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil);
    EXPECT_NEAR(y.normal_limit_pa, 0.875 * soil.stiffness_pa_m * 0.1, 1e-3 * y.normal_limit_pa);
    EXPECT_NEAR(y.friction, 0.4, 1e-12);
    EXPECT_EQ(length(y.mobilized_pa), 0);
}

TEST(GranularLaw, unloads_ten_times_as_stiffly_as_it_loads) {
    EXPECT_EQ(unloaded_share(0.1, 0), 1);
    EXPECT_NEAR(unloaded_share(0.1, 0.005), 0.5, 1e-12);
    EXPECT_EQ(unloaded_share(0.1, 0.02), 0);
    EXPECT_EQ(unloaded_share(0, 0), 1);
    EXPECT_EQ(unloaded_share(0, 1e-6), 0);
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const FaceExtent no_size;
    const ElementYield loaded = yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil, no_size);
    const ElementYield half =
        yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil, no_size, 0.005);
    EXPECT_NEAR(half.normal_limit_pa, 0.5 * loaded.normal_limit_pa, 1e-9);
    EXPECT_EQ(half.friction, loaded.friction);
}

TEST(GranularLaw, sole_that_slides_shears_the_soil_or_its_own_surface) {
    MaterialDef rough = sand();
    rough.tool_friction = 2;
    const SoilStrength soil = strength_of(rough, kGravity_m_s2);
    const ElementYield y = yield_of_element(element(kDown, 0.1), {1, 0, 0}, 0, kUp, soil);
    EXPECT_NEAR(y.friction, std::tan(rough.friction_angle_rad), 0.01);
    const SoilStrength smooth = strength_of(rough, kGravity_m_s2, {.friction = 0.2});
    EXPECT_NEAR(yield_of_element(element(kDown, 0.1), {1, 0, 0}, 0, kUp, smooth).friction, 0.2,
                1e-12);
}

// A face that goes into the soil makes it flow; along a slip band Coulomb's friction acts.
TEST(GranularLaw, friction_is_coulombs_along_a_slip_band_and_that_of_flow_beyond) {
    MaterialDef rough = sand();
    rough.tool_friction = 2;
    const SoilStrength soil = strength_of(rough, kGravity_m_s2);
    const double tan_phi = std::tan(rough.friction_angle_rad);
    const auto friction = [&](double into) {
        const Vec3 motion = Vec3{1, 0, 0} + into * kDown;
        return yield_of_element(element(kDown, 0.1), motion, 0, kUp, soil).friction;
    };
    const auto flow = [&](double into) {
        const Vec3 motion = Vec3{1, 0, 0} + (into + ContactLawDef{}.creep) * kDown;
        const Vec3 stress = resistive_stress(kDown, motion * (1 / length(motion)), kUp, tan_phi);
        const double normal = dot(stress, kUp);
        return length(stress - normal * kUp) / normal;
    };
    EXPECT_NEAR(friction(0), tan_phi, 0.01);
    EXPECT_NEAR(slip_band_share(0.1, 1), 0.5, 1e-12);
    EXPECT_NEAR(friction(0.1), flow(0.1) * (1 + soil.sliding_share) / 2, 0.01);
    // A hundredth of Coulomb's share is left.
    EXPECT_NEAR(friction(1), flow(1), 0.03 * flow(1));
    EXPECT_LT(flow(1), 0.8 * tan_phi);
    EXPECT_EQ(slip_band_share(-0.5, 1), 1) << "drawn back";
    EXPECT_EQ(slip_band_share(0, 0), 1) << "at rest";
}

// A face that is dragged level, with the soil before it that it drags up: all its friction, and the
// fan's share of what it bears pushed in. One that goes down along itself has what resistive force
// theory finds; one that goes along with its soil rubs against nothing.
TEST(GranularLaw, face_that_drags_soil_up_bears_by_its_fan) {
    MaterialDef rough = sand();
    rough.tool_friction = 2;
    rough.cohesion_pa = 0;
    const SoilStrength soil = strength_of(rough, kGravity_m_s2);
    const double phi = rough.friction_angle_rad, tan_phi = std::tan(phi);
    for (const double lean_deg : {15.0, 25.0, 40.0}) {
        const double lean = lean_deg * std::numbers::pi / 180;
        const Vec3 normal{std::sin(lean), -std::cos(lean), 0},
            along{std::cos(lean), std::sin(lean), 0};
        const auto yield = [&](Vec3 motion) {
            return yield_of_element(element(normal, 0.1), motion, 0, kUp, soil);
        };
        const double pushed_pa = yield(normal).normal_limit_pa;
        const ElementYield dragged = yield({1, 0, 0});
        // Friction and fan come in over a sliding of the creep, a hundredth.
        EXPECT_NEAR(dragged.friction, tan_phi, 0.05 * tan_phi) << lean_deg;
        EXPECT_NEAR(dragged.normal_limit_pa, fan_share(phi, dragged.friction) * pushed_pa,
                    0.15 * dragged.normal_limit_pa)
            << lean_deg;
        EXPECT_GT(dot(dragged.slide, along), 0.9) << lean_deg;
        const Vec3 down_along = -0.9 * along + 0.3 * normal;
        const ElementYield driven = yield(down_along);
        const Vec3 push = down_along + ContactLawDef{}.creep * normal;
        const Vec3 stress = resistive_stress(normal, push * (1 / length(push)), kUp, soil.friction);
        EXPECT_NEAR(driven.normal_limit_pa, -dot(stress, normal) * soil.stiffness_pa_m * 0.1,
                    1e-9 * driven.normal_limit_pa)
            << lean_deg;
        const ElementYield taken_along = yield(0.9 * normal + 0.3 * along);
        EXPECT_LT(taken_along.friction, 0.05 * tan_phi) << lean_deg;
        EXPECT_NEAR(length(taken_along.slide), 0, 1e-12) << lean_deg;
        EXPECT_GT(taken_along.normal_limit_pa, 0.7 * pushed_pa) << lean_deg;
    }
}

// From one to the other, as a face turns its motion, without a jump.
TEST(GranularLaw, drag_comes_in_smoothly) {
    MaterialDef rough = sand();
    rough.tool_friction = 2;
    const SoilStrength soil = strength_of(rough, kGravity_m_s2);
    constexpr int kDirections = 36000;
    for (const double lean : {0.01, 0.1, 0.5, 0.9, 1.05, 1.25, 1.5}) {
        const Vec3 normal{std::sin(lean), -std::cos(lean), 0};
        const auto yield = [&](Vec3 motion) {
            return yield_of_element(element(normal, 0.1), motion, 0, kUp, soil);
        };
        const double pushed_pa = yield(normal).normal_limit_pa;
        ElementYield last = yield({1, 0, 0});
        for (int i = 1; i <= kDirections; ++i) {
            const double at = 2 * std::numbers::pi * i / kDirections;
            const Vec3 motion{std::cos(at), std::sin(at), 0};
            const ElementYield now = yield(motion);
            const bool pushes = dot(motion, normal) > 0.01;
            // Friction comes in over a sliding of the creep, a hundredth. What only just pushes has
            // a limit that changes fast: it has drawn back a little later.
            const double jump_pa = std::abs(now.normal_limit_pa - last.normal_limit_pa);
            EXPECT_LT(pushes ? jump_pa : 0, 0.01 * pushed_pa) << lean << ' ' << at;
            EXPECT_LT(std::abs(now.friction - last.friction), 0.02) << lean << ' ' << at;
            last = now;
        }
    }
}

// Soil lies on a face that leans back: its wedge asks for less than that of an upright one.
TEST(GranularLaw, face_that_leans_back_meets_the_wedge_on_it) {
    MaterialDef m = sand();
    m.cohesion_pa = 0;
    const SoilStrength soil = strength_of(m, kGravity_m_s2);
    const FaceExtent wide{.width_m = 100, .length_m = 100, .depth_m = 0.2};
    const auto limit_pa = [&](double lean_deg, Vec3 motion) {
        const double lean = lean_deg * std::numbers::pi / 180;
        const Vec3 n{std::sin(lean), std::cos(lean), 0};
        return yield_of_element(element(n, 0.1), motion, 0, kUp, soil, wide).normal_limit_pa;
    };
    const double upright_pa = limit_pa(90, {1, 0, 0});
    EXPECT_NEAR(upright_pa, 0.1 * soil.weight_n_m3 * soil.passive_factor, 0.03 * upright_pa);
    double before_pa = upright_pa;
    for (double lean_deg = 89; lean_deg > 20; lean_deg -= 1) {
        const double share = leaning_wedge_share(soil.tan_phi, soil.friction,
                                                 std::cos(lean_deg * std::numbers::pi / 180));
        const double found_pa = limit_pa(lean_deg, {1, 0, 0});
        EXPECT_NEAR(found_pa, share * upright_pa, 0.05 * share * upright_pa) << lean_deg;
        EXPECT_NEAR(found_pa, before_pa, 0.1 * before_pa) << lean_deg << " has no jump";
        before_pa = found_pa;
    }
    // Lifted, a level plate lifts what lies on it: about its weight, not ten times as much.
    const double lifted_pa = limit_pa(0, kUp);
    EXPECT_GT(lifted_pa, 0.7 * 0.1 * soil.weight_n_m3);
    EXPECT_LT(lifted_pa, 1.5 * 0.1 * soil.weight_n_m3);
}

TEST(GranularLaw, body_that_draws_back_meets_nothing) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const ElementYield y = yield_of_element(element(kDown, 0.1), {0, 0.02, 0}, 0, kUp, soil);
    EXPECT_EQ(length(y.mobilized_pa), 0);
}

TEST(GranularLaw, limit_changes_smoothly_as_a_body_comes_to_rest) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const Vec3 way{0.6, -0.8, 0};
    double last = yield_of_element(element(kDown, 0.1), way, 0, kUp, soil).normal_limit_pa;
    for (double share = 1; share > 1e-4; share *= 0.9) {
        const double now =
            yield_of_element(element(kDown, 0.1), share * way, 0, kUp, soil).normal_limit_pa;
        EXPECT_LT(std::abs(now - last) / last, 0.2) << share;
        last = now;
    }
}

TEST(GranularLaw, sliding_sole_loses_bearing) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const double at_rest = yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil).normal_limit_pa;
    const double sliding =
        yield_of_element(element(kDown, 0.1), {1, 0, 0}, 0, kUp, soil).normal_limit_pa;
    // 0.1103 / 0.875 of the check values, and the creep that is put in.
    EXPECT_NEAR(sliding / at_rest, 0.126, 0.02);
}

TEST(GranularLaw, strength_is_reckoned_from_the_bearing_depth) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    ContactVoxel v = element(kDown, 0);
    v.bearing_depth_m = 0.1;  // pressed in, and no depth below the surface
    EXPECT_NEAR(yield_of_element(v, {}, 0, kUp, soil).normal_limit_pa,
                yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil).normal_limit_pa, 1e-9);
}

TEST(GranularLaw, cohesion_bears_soles_by_prandtl_and_walls_by_rankine) {
    const MaterialDef m = cohesive();
    const SoilStrength soil = strength_of(m, kGravity_m_s2);
    const double sole = yield_of_element(element(kDown, 1e-12), {}, 0, kUp, soil).normal_limit_pa;
    const double wall =
        yield_of_element(element({1, 0, 0}, 1e-12), {}, 0, kUp, soil).normal_limit_pa;
    EXPECT_NEAR(sole, 1000 * bearing_capacity_factor_nc(m.friction_angle_rad), 1e-4);
    EXPECT_NEAR(wall, 2000 * std::tan(std::numbers::pi / 4 + m.friction_angle_rad / 2), 1e-4);
    // Nothing in the air.
    EXPECT_EQ(yield_of_element(element(kDown, 0), {}, 0, kUp, soil).normal_limit_pa, 0);
}

TEST(GranularLaw, fast_intrusion_adds_momentum_flux) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const double slow =
        yield_of_element(element(kDown, 0.1), {0, -1, 0}, 0.01, kUp, soil).normal_limit_pa;
    const double fast =
        yield_of_element(element(kDown, 0.1), {0, -1, 0}, 5, kUp, soil).normal_limit_pa;
    EXPECT_NEAR(fast - slow, 1600 * 25, 1e-3 * 1600 * 25);
}

TEST(GranularLaw, soil_without_friction_bears_by_its_cohesion) {
    MaterialDef clay = cohesive();
    clay.friction_angle_rad = 0;
    const SoilStrength soil = strength_of(clay, kGravity_m_s2);
    const FaceExtent plate{0.1, 0.1, 0.1, 0};
    EXPECT_NEAR(yield_of_element(element(kDown, 0.1), {}, 0, kUp, soil, plate).normal_limit_pa,
                5142, 1);
}

TEST(GranularLaw, sole_of_dense_soil_bears_by_boltons_angle) {
    const auto peak_deg = [](double density, double pressure_pa, double slimness) {
        constexpr double kDegree = std::numbers::pi / 180;
        return peak_friction_angle(28.5 * kDegree, density, pressure_pa, slimness) / kDegree;
    };
    // phi 28.5 deg, I_D 0.83, p' 36 kPa: I_R = 0.83 (10 - ln 36) - 1 = 4.33, taken as 4: 20 deg
    // more under a strip, 12 under a square.
    EXPECT_NEAR(peak_deg(0.83, 36e3, 0), 48.5, 1e-9);
    EXPECT_NEAR(peak_deg(0.83, 36e3, 1), 40.5, 1e-9);
    // I_D 0.35, p' 20 kPa: I_R = 0.35 * 7.004 - 1 = 1.451: 5 deg a unit, 4 where it is twice as
    // long as wide, 3.
    EXPECT_NEAR(peak_deg(0.35, 20e3, 0), 35.76, 0.01);
    EXPECT_NEAR(peak_deg(0.35, 20e3, 0.5), 34.31, 0.01);
    EXPECT_NEAR(peak_deg(0.35, 20e3, 1), 32.85, 0.01);
    MaterialDef m = sand();
    m.loose_density_kg_m3 = 1300;
    m.compacted_density_kg_m3 = 1700;
    const SoilStrength soil = strength_of(m, kGravity_m_s2);
    double last = 0;
    for (double density : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const FaceExtent plate{0.15, 0.15, 0.05, density};
        const double limit =
            yield_of_element(element(kDown, 0.05), {}, 0, kUp, soil, plate).normal_limit_pa;
        // Loose soil bears by resistive force theory, 96 kPa: its capacity is 65. Bolton's index
        // ends at 4, here from a density of 0.77 on.
        EXPECT_GT(limit, (density > 0.25 && density < 1 ? 1.3 : 1.0) * last) << density;
        last = limit;
    }
}

// Never less in denser soil, and without a jump. By hand: Ngamma grows by some 20 % a degree of
// Bolton's angle, which rises by 5 deg (strip) or 3 (square) times 10 - ln p from end to end, at
// 10 kPa some 38 and 23 deg. A step of a two-hundredth is at most 0.2 deg, 4 %. Measured: 2.9 %.
TEST(GranularLaw, sole_bears_smoothly_more_in_denser_soil) {
    MaterialDef m = sand();
    m.loose_density_kg_m3 = 1300;
    m.compacted_density_kg_m3 = 1700;
    const SoilStrength soil = strength_of(m, kGravity_m_s2);
    constexpr int kSteps = 200;
    for (const double width_m : {0.05, 0.15, 0.5}) {
        for (const double length_m : {width_m, 20 * width_m}) {
            for (const double depth_m : {0.01, 0.05, 0.2}) {
                double last = 0;
                for (int i = 0; i <= kSteps; ++i) {
                    const FaceExtent plate{width_m, length_m, depth_m, 1.0 * i / kSteps};
                    const double limit =
                        yield_of_element(element(kDown, depth_m), {}, 0, kUp, soil, plate)
                            .normal_limit_pa;
                    if (i > 0) {
                        EXPECT_GE(limit, last) << width_m << " m wide, " << depth_m << " " << i;
                        EXPECT_LT(limit, 1.04 * last)
                            << width_m << " m wide, " << depth_m << " " << i;
                    }
                    last = limit;
                }
            }
        }
    }
}

TEST(GranularLaw, sole_bears_no_less_than_resistive_force_theory_at_any_density) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const auto limit_pa = [&soil](double depth_m, const FaceExtent& face) {
        return yield_of_element(element(kDown, depth_m), {}, 0, kUp, soil, face).normal_limit_pa;
    };
    for (const double depth_m : {0.001, 0.01, 0.05, 0.2}) {
        const double without_size_pa = limit_pa(depth_m, {});
        for (const double density : {0.0, 0.3, 1.0}) {
            EXPECT_GE(limit_pa(depth_m, {0.15, 0.3, depth_m, density}), without_size_pa)
                << depth_m << ' ' << density;
        }
    }
    // Ten widths deep in loose soil it bears just that: Nq sq is 43 at 33 deg, xi over the unit
    // weight 112.
    EXPECT_EQ(limit_pa(0.2, {0.02, 0.02, 0.2, 0}), limit_pa(0.2, {}));
    EXPECT_GT(limit_pa(0.01, {0.15, 0.15, 0.01, 1}), 5 * limit_pa(0.01, {}));
}

TEST(GranularLaw, plate_twice_the_size_at_the_same_geometry_bears_eight_times_the_force) {
    const SoilStrength soil = strength_of(sand(), kGravity_m_s2);
    const auto force = [&](double scale) {
        const FaceExtent plate{0.1 * scale, 0.1 * scale, 0.02 * scale, 0};
        return scale * scale *
               yield_of_element(element(kDown, 0.02 * scale), {}, 0, kUp, soil, plate)
                   .normal_limit_pa;
    };
    EXPECT_NEAR(force(2) / force(1), 8, 1e-9);
}

TEST(GranularLaw, shear_develops_with_displacement_and_faster_in_denser_soil) {
    MaterialDef m = sand();
    m.shear_displacement_m = 0.01;
    const SoilStrength soil = strength_of(m, kGravity_m_s2);
    EXPECT_NEAR(developed_shear(soil, 0.01, 0), 1 - std::exp(-1.0), 1e-12);
    m.loose_density_kg_m3 = 1500;
    m.compacted_density_kg_m3 = 1800;
    const SoilStrength state = strength_of(m, kGravity_m_s2);
    EXPECT_NEAR(developed_shear(state, 0.01, state.placed_relative_density), 1 - std::exp(-1.0),
                1e-12);
    EXPECT_GT(developed_shear(state, 0.01, 1), developed_shear(state, 0.01, 0) + 0.1);
    EXPECT_EQ(developed_shear(strength_of(sand(), kGravity_m_s2), 0, 0), 1);
}

TEST(GranularLaw, friction_is_that_of_the_weaker_of_tool_and_soil) {
    MaterialDef m = sand();
    m.tool_friction = 2;
    EXPECT_NEAR(strength_of(m, kGravity_m_s2).friction, std::tan(m.friction_angle_rad), 1e-12);
    m.tool_friction = 0.1;
    EXPECT_NEAR(strength_of(m, kGravity_m_s2).friction, 0.1, 1e-12);
}

/// What a surface over the tips of a row, 0.1 m high, can shear as it slides along, per area of the
/// whole row.
double sheared_over_tips_pa(const MaterialDef& material, double tip_depth_m, double retreat_m = 0) {
    const auto soil = std::make_shared<ContactSoil>();
    soil->up = kUp;
    soil->materials = {material};
    ContactVoxel tips = element(kDown, tip_depth_m);
    tips.teeth = {0.1, 0.03, 0.5, 0.1, kDown, ToothPart::over_tips};
    const ElementYield y = GranularLaw(soil, SurfaceFriction{})
                               .yield({tips, {}}, {{0.9, -0.1, 0}, 0},
                                      {std::numeric_limits<double>::infinity(), retreat_m});
    return y.area_share * (y.friction * y.normal_limit_pa + y.adhesion_pa);
}

TEST(GranularLaw, soil_between_teeth_shears_from_the_tips_on_without_a_jump) {
    MaterialDef clay = cohesive();
    clay.cohesion_pa = 5000;
    for (const MaterialDef& material : {sand(), clay}) {
        double before = sheared_over_tips_pa(material, 0);
        EXPECT_EQ(before, 0);
        double largest = 0;
        for (int mm = 1; mm <= 150; ++mm) {
            const double now = sheared_over_tips_pa(material, mm * 1e-3);
            EXPECT_GE(now, before) << mm;
            largest = std::max(largest, now - before);
            before = now;
        }
        EXPECT_LT(largest, 0.05 * before) << "in a step of a 150th of the way";
    }
    // By hand, the roots at the surface: the soil's weight, and in clay its cohesion on all of it.
    const MaterialDef m = sand();
    const double tan_phi = std::tan(m.friction_angle_rad);
    const double wedge_m = 0.1 * std::tan(std::numbers::pi / 4 + m.friction_angle_rad / 2);
    const double share = wedge_m / 0.47 * (1 - 0.03 / 0.5);
    const double weight_pa = m.density_kg_m3 * kGravity_m_s2 * 0.1;
    EXPECT_NEAR(sheared_over_tips_pa(m, 0.1), share * tan_phi * weight_pa, 1e-6 * weight_pa);
    EXPECT_NEAR(sheared_over_tips_pa(clay, 0.1), share * (tan_phi * weight_pa + 5000), 1e-3);
    // Nor does it let go at once where the body draws back.
    EXPECT_NEAR(sheared_over_tips_pa(clay, 0.1, 1e-9), sheared_over_tips_pa(clay, 0.1), 1e-2);
    EXPECT_NEAR(sheared_over_tips_pa(clay, 0.1, 0.005), sheared_over_tips_pa(clay, 0.1) / 2, 1e-3);
}

}  // namespace
}  // namespace bsoil::granular_law_test
