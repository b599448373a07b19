// What the newtons on a blade and on a wheel are made of: docs/records/newtons.md.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/contact_patches.h"
#include "bsoil/contact/passive_wedge.h"
#include "bsoil/soil.h"
#include "oracle/free_surface.h"

namespace bsoil::newton_parts_test {
namespace {

constexpr double kBed = 0.3, kVoxel = 0.025, kLength = 2.4, kWay = 1.2;  // [m]

/// Means over the last tenth of a way [N].
struct Parts {
    Vec3 bed;       ///< friction and weight, of soil below the surface that the bed had
    Vec3 heap;      ///< of what lies higher
    Vec3 cohesion;  ///< and adhesion
    Vec3 inertia;   ///< of soil that is set in motion
    Vec3 whole;
    std::vector<double> ahead_m;  ///< surface over the bed, column by column along the middle
};

/// A body driven along x through a bed, and the forces of the law on it with ever less in it.
Parts drive(const MaterialDef& material, const ConvexShape& shape, double height_m,
            double speed_m_s, double turning_rad_s) {
    SoilDef def;
    def.up = UpAxis::z;
    def.size_m = {kLength, 1.2, 0.9};
    def.voxel_m = kVoxel;
    def.backend = Backend::cpu;
    def.material = material;
    auto soil = std::move(*Soil::create(def));
    EXPECT_TRUE(soil->fill(BoxFill{{{-1.2, -0.6, 0}, {1.2, 0.6, kBed}}, {}}));
    const auto own = std::make_shared<const ContactSoil>(soil->contact_soil());
    auto without = std::make_shared<ContactSoil>(*own);
    for (MaterialDef& m : without->materials) {
        m.cohesion_pa = m.moist_cohesion_pa = m.tool_adhesion_pa = 0;
    }
    const auto law = ContactLaw::make(own), frictional = ContactLaw::make(without);
    ContactMotion motion;
    ContactMemory memory;
    const std::vector<ConvexShape> shapes{shape};
    SoilBody body;
    body.shapes = &shapes;
    Parts sum;
    const int steps = static_cast<int>(std::lround(kWay / speed_m_s / def.step_s));
    const int counted = steps / 10;
    for (int i = 0; i < steps; ++i) {
        const double time_s = (i + 1) * def.step_s;
        body.pose.position = {-0.8 + speed_m_s * time_s, 0, height_m};
        const double angle = turning_rad_s * time_s / 2;
        body.pose.rotation = {0, std::sin(angle), 0, std::cos(angle)};
        body.center_of_mass_m = body.pose.position;
        body.linear_velocity_m_s = {speed_m_s, 0, 0};
        body.angular_velocity_rad_s = {0, turning_rad_s, 0};
        const StepReport report = soil->step({&body, 1});
        std::vector<ContactVoxel> voxels(report.contacts.begin(), report.contacts.end());
        const BodyMotion now{body.pose, body.center_of_mass_m, body.linear_velocity_m_s,
                             body.angular_velocity_rad_s};
        motion.advance(now, nullptr, voxels, def.step_s, {false, false, def.voxel_m});
        const auto history = memory.advance(voxels, now, *law, def.step_s, {}, {}, nullptr);
        const auto force = [&](const ContactMotion& as, const ContactLaw& by) {
            return ContactPatches().find(voxels, {&as, 1}, by, history);
        };
        const BodyContact whole = force(motion, *law);
        soil->known_contacts().set_width(0, whole.width_m);
        soil->known_contacts().set_pressure(0, whole.mobilized_pressure_pa);
        if (i < steps - counted) continue;
        ContactMotion slow = motion;  // the same direction
        slow.motion.linear_velocity_m_s = slow.motion.angular_velocity_rad_s = {};
        const Vec3 still = force(slow, *law).mobilized_force_n;
        const Vec3 friction = force(slow, *frictional).mobilized_force_n;
        for (ContactVoxel& voxel : voxels) {
            const double depth_m = std::max(0.0, kBed - voxel.position_m.z);
            voxel.bearing_depth_m = std::min(voxel.bearing_depth_m, depth_m);
        }
        const Vec3 flat = force(slow, *frictional).mobilized_force_n;
        const double share = 1.0 / counted;
        sum.whole += share * whole.mobilized_force_n;
        sum.inertia += share * (whole.mobilized_force_n - still);
        sum.cohesion += share * (still - friction);
        sum.heap += share * (friction - flat);
        sum.bed += share * flat;
    }
    const int middle = soil->frame().size[1] / 2;
    for (int x = 0; x < soil->frame().size[0]; ++x) {
        sum.ahead_m.push_back(soil->surface_height_m(x, middle) - kBed);
    }
    return sum;
}

void print(const char* what, const Parts& parts) {
    std::printf("| %s |", what);
    for (const Vec3 part : {parts.bed, parts.heap, parts.cohesion, parts.inertia, parts.whole}) {
        std::printf(" %.0f; %.0f |", part.x, part.z);
    }
    std::printf("\n");
}

// A blade 0.5 m wide that cuts 0.1 m deep, after 1.2 m. Forces are against the motion.
TEST(NewtonParts, of_a_blade_are_those_by_hand) {
    constexpr double kCut = 0.1, kWidth = 0.5, kThickness = 0.1;
    ConvexShape blade;
    blade.half_extents_m = {kThickness / 2, kWidth / 2, 0.2};
    const MaterialDef sand = materials::moist_sand();
    const double phi = sand.friction_angle_rad, wall = std::atan(sand.tool_friction);
    const double weight_n_m3 = sand.density_kg_m3 * 9.81;
    // Coulomb's wedge of an endless wall, and what its two sides add under the pressure at rest.
    const double factor = passive_pressure_factor(phi, wall) * std::cos(wall);
    const double sides =
        2.0 / 3 * (1 - std::sin(phi)) * std::sin(phi) / std::sin(std::numbers::pi / 4 + phi / 2);
    const auto wedge_n = [&](double foot_m, double level_m) {
        return weight_n_m3 * foot_m * level_m / 2 * kWidth * factor * (1 + sides * foot_m / kWidth);
    };
    for (const double speed : {0.25, 1.0, 2.0}) {
        const Parts parts = drive(sand, blade, kBed - kCut + 0.2, speed, 0);
        print(speed == 0.25 ? "blade at 0.25 m/s" : speed == 1 ? "at 1 m/s" : "at 2 m/s", parts);
        EXPECT_NEAR(-parts.bed.x, wedge_n(kCut, kCut), 0.2 * wedge_n(kCut, kCut));
        const double face_m = -0.8 + kWay + kThickness / 2;
        const auto above_foot = [&](double x) {
            const double column = (face_m + x + kLength / 2) / kVoxel;
            const size_t at = std::min(static_cast<size_t>(column), parts.ahead_m.size() - 1);
            return std::max(0.0, parts.ahead_m[at]) + kCut;  // beyond its end the bed goes on
        };
        const double deep_m = above_foot(1.5 * kVoxel) + kVoxel;
        const double level_m = oracle::wedge_depth(above_foot, deep_m, phi, wall);
        const double heaped_n = wedge_n(deep_m, level_m);  // along its middle the heap is highest
        std::printf("by hand: wedge %.0f N, new soil %.0f N\n", heaped_n,
                    sand.density_kg_m3 * speed * speed * kCut * kWidth);
        EXPECT_NEAR(-(parts.bed + parts.heap).x, heaped_n, 0.25 * heaped_n) << speed;
        // New soil alone is set in motion: that below the level of the bed.
        const double flux_n = sand.density_kg_m3 * speed * speed * kCut * kWidth;
        EXPECT_NEAR(-parts.inertia.x, flux_n, 0.3 * flux_n) << speed;
        // No more than if all that is cut were undisturbed.
        const double cohesive_n =
            2 * sand.cohesion_pa * std::tan(std::numbers::pi / 4 + phi / 2) * kCut * kWidth;
        EXPECT_GT(-parts.cohesion.x, 0.1 * cohesive_n);
        EXPECT_LT(-parts.cohesion.x, cohesive_n);
    }
}

// A wheel of 0.3 m, 0.2 m wide, held 30 mm deep.
TEST(NewtonParts, of_a_wheel_change_sides_with_its_slip) {
    ConvexShape wheel;
    wheel.kind = ConvexShape::Kind::cylinder;
    wheel.radius_m = 0.3;
    wheel.half_height_m = 0.1;
    const double half = std::sqrt(0.5);
    wheel.local.rotation = {half, 0, 0, half};
    Parts last;
    for (const double slip : {-1.0, 0.0, 0.3}) {
        const double rim_m_s = slip < 0 ? 0 : 0.5 / (1 - slip);
        const Parts parts =
            drive(materials::dry_sand(), wheel, kBed - 0.03 + 0.3, 0.5, rim_m_s / 0.3);
        print(slip < 0 ? "wheel, locked" : slip == 0 ? "without slip" : "at slip 0.3", parts);
        EXPECT_GT(parts.whole.z, 0) << slip;
        if (slip >= 0) {
            EXPECT_GT(parts.whole.x, last.whole.x) << slip;
        }
        // At 0.5 m/s momentum is next to nothing.
        EXPECT_LT(length(parts.inertia), 0.05 * length(parts.whole)) << slip;
        EXPECT_EQ(length(parts.cohesion), 0) << slip;
        last = parts;
    }
}

}  // namespace
}  // namespace bsoil::newton_parts_test
