// Bodies smaller than a voxel meet the soil by their shapes: several in one voxel, on any grid.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/granular_law.h"
#include "soil_fixture.h"

namespace bsoil::small_bodies_test {
namespace {

constexpr double kVoxelM = 0.05, kBedM = 0.4;

std::unique_ptr<Soil> level_bed(Backend backend = Backend::cpu) {
    SoilDef def = grid_def(24, 24, 16, kVoxelM);
    def.backend = backend;
    def.material = materials::dry_sand();  // with its range of densities
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(BoxFill{{{-9, -9, -9}, {9, 9, kBedM}}, "dry_sand"}));
    return soil;
}

Mover cube(int id, double side_m, Vec3 position) {
    return Mover(id, box_shape({side_m / 2, side_m / 2, side_m / 2}), position);
}

/// Sums over one body's elements.
struct Sums {
    int count = 0;
    double sole_m2 = 0;  ///< of what looks down
    double deepest_m = 0;
    Vec3 area_m2;      ///< of normal times area
    Vec3 buoyancy_m3;  ///< of depth times normal times area
    int carrier = -2;
};

Sums sums_of(const StepReport& report, int body) {
    Sums out;
    for (const ContactVoxel& v : report.contacts) {
        if (v.body != body) continue;
        ++out.count;
        if (v.normal.z < -0.9) out.sole_m2 += v.area_m2;
        out.deepest_m = std::max(out.deepest_m, v.depth_m);
        out.area_m2 += v.area_m2 * v.normal;
        out.buoyancy_m3 += v.depth_m * v.area_m2 * v.normal;
        out.carrier = v.carrier;
    }
    return out;
}

// Eight cubes of 1 cm stand 1 mm deep in one voxel, which knows one owner.
TEST(SmallBodies, of_one_voxel_each_meet_the_soil_alike_on_both_backends) {
    std::vector<ContactVoxel> found[2];
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        if (backend == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
        const auto soil = level_bed(backend);
        std::vector<Mover> cubes;
        for (int i = 0; i < 8; ++i) {
            const Vec3 middle{0.5 + 0.007 + 0.011 * (i % 4), 0.5 + 0.01 + 0.02 * (i / 4),
                              kBedM + 0.004};
            cubes.push_back(cube(i, 0.01, middle));
        }
        const std::vector<SoilBody> bodies = bodies_of(cubes);
        const StepReport report = soil->step(bodies);
        for (int i = 0; i < 8; ++i) {
            const Sums sums = sums_of(report, i);
            SCOPED_TRACE(i);
            EXPECT_NEAR(sums.sole_m2, 1e-4, 1e-12);
            EXPECT_NEAR(sums.deepest_m, 0.001, 1e-4);  // the soil they press aside lies beside them
            EXPECT_EQ(sums.count, 4) << "the middles of the sides lie above the soil";
            EXPECT_EQ(sums.carrier, -1);
        }
        found[backend == Backend::gl].assign(report.contacts.begin(), report.contacts.end());
    }
    ASSERT_EQ(found[0].size(), found[1].size());
    for (size_t i = 0; i < found[0].size(); ++i) {
        EXPECT_EQ(found[0][i].body, found[1][i].body);
        EXPECT_EQ(found[0][i].depth_m, found[1][i].depth_m);
        EXPECT_EQ(found[0][i].relative_density, found[1][i].relative_density);
    }
}

// Over a closed surface area vectors add up to nothing, and depths times them to its volume.
TEST(SmallBodies, have_a_closed_surface_whatever_their_shape_and_turn) {
    const auto soil = level_bed();
    std::vector<Mover> movers;
    movers.push_back(cube(0, 0.02, {0.31, 0.32, kBedM - 0.06}));
    movers.emplace_back(1, box_shape({0.02, 0.004, 0.003}), Vec3{0.52, 0.33, kBedM - 0.06});
    movers.emplace_back(2, sphere_shape(0.015), Vec3{0.73, 0.35, kBedM - 0.06});
    movers.emplace_back(3, octahedron_shape(0.02), Vec3{0.33, 0.71, kBedM - 0.06});
    movers.emplace_back(4, round_shape(ConvexShape::Kind::cylinder, 0.01, 0.015),
                        Vec3{0.7, 0.7, kBedM - 0.06});
    const double volumes_m3[] = {8e-6, 8 * 0.02 * 0.004 * 0.003,
                                 4.0 / 3 * std::numbers::pi * std::pow(0.015, 3),
                                 4.0 / 3 * std::pow(0.02, 3), std::numbers::pi * 1e-4 * 0.03};
    for (Mover& mover : movers) mover.body.pose.rotation = turn({0.6, 0, 0.8}, 0.7);
    const std::vector<SoilBody> bodies = bodies_of(movers);
    const StepReport report = soil->step(bodies);
    for (int i = 0; i < 5; ++i) {
        const Sums sums = sums_of(report, i);
        SCOPED_TRACE(i);
        const double size_m2 = std::pow(volumes_m3[i], 2.0 / 3);
        EXPECT_GT(sums.count, 5);
        EXPECT_LT(length(sums.area_m2), 0.02 * size_m2);
        // Pressure grows downwards, and normals look out of the body: the sum looks down.
        EXPECT_NEAR(-sums.buoyancy_m3.z, volumes_m3[i], 0.1 * volumes_m3[i]);
    }
}

TEST(SmallBodies, in_the_air_and_under_the_floor_meet_nothing) {
    const auto soil = level_bed();
    std::vector<Mover> movers;
    movers.push_back(cube(0, 0.02, {0.5, 0.5, kBedM + 0.03}));
    movers.push_back(cube(1, 0.02, {0.6, 0.6, -0.04}));
    movers.push_back(cube(2, 0.02, {-0.3, 0.6, kBedM - 0.01}));
    movers.push_back(cube(3, 0.02, {0.5, 0.7, kBedM + 0.3}));
    for (int i = 0; i < 3; ++i) {
        const std::vector<SoilBody> bodies = bodies_of(movers);
        EXPECT_TRUE(soil->step(bodies).contacts.empty());
    }
}

// A rock on a loaded bed: the soil that it lies on is the bed's.
TEST(SmallBodies, on_carried_soil_press_on_the_body_that_carries_it) {
    const auto soil = level_bed();
    std::vector<Mover> movers;
    movers.emplace_back(0, box_shape({0.3, 0.3, 0.05}), Vec3{0.6, 0.6, kBedM + 0.05});
    std::vector<SoilBody> bodies = bodies_of(movers);
    soil->step(bodies);
    ASSERT_TRUE(
        soil->fill(BoxFill{{{0.4, 0.4, kBedM + 0.1}, {0.8, 0.8, kBedM + 0.2}}, "dry_sand"}));
    for (int i = 0; i < 20; ++i) soil->step(bodies);
    movers.push_back(cube(1, 0.02, {0.61, 0.59, kBedM + 0.2}));
    bodies = bodies_of(movers);
    const Sums sums = sums_of(soil->step(bodies), 1);
    EXPECT_GT(sums.deepest_m, 0);
    EXPECT_EQ(sums.carrier, 0);
}

// What the record says of the soil, against the means of the voxels in doubles.
TEST(SmallBodies, know_the_density_of_the_soil_that_they_are_in) {
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        if (backend == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
        const auto soil = level_bed(backend);
        // Half of the bed is dug and thrown back: loose.
        std::vector<Mover> blade;
        blade.emplace_back(9, box_shape({0.02, 0.4, 0.1}), Vec3{0.3, 0.6, kBedM});
        blade[0].set_velocity({1, 0, 0});
        for (int i = 0; i < 30; ++i) {
            const std::vector<SoilBody> moved = bodies_of(blade);
            soil->step(moved);
            blade[0].advance(soil->def().step_s);
        }
        for (int i = 0; i < 60; ++i) soil->step({});
        int loose_count = 0;
        for (int x = 2; x < 22; x += 2) {
            const double height_m = soil->surface_height_m(x, 12);
            const Vec3 middle{(x + 0.5) * kVoxelM, 12.5 * kVoxelM, height_m - 0.03};
            std::vector<Mover> movers;
            movers.push_back(cube(1, 0.004, middle));
            const std::vector<SoilBody> bodies = bodies_of(movers);
            const StepReport report = soil->step(bodies);
            const auto voxel_at = [&](int down) {
                return soil->sample(x, 12, static_cast<int>(middle.z / kVoxelM) - down);
            };
            const VoxelSample here = voxel_at(0), below = voxel_at(1);
            const VoxelSample& fullest = below.volume > here.volume ? below : here;
            const MaterialDef& sand = soil->materials()[static_cast<size_t>(fullest.material)];
            const double expected =
                std::clamp(sand.relative_density(fullest.density_kg_m3), 0., 1.);
            ASSERT_FALSE(report.contacts.empty()) << x;
            for (const ContactVoxel& v : report.contacts) {
                EXPECT_NEAR(v.relative_density, expected, 2e-3) << x;
            }
            loose_count += expected < 0.3;
            const std::vector<SoilBody> gone;
            soil->step(gone);
        }
        EXPECT_GT(loose_count, 0);
    }
}

/// A cube that is pressed in by its lower side, slowly.
struct Pressed {
    double force_n = 0, sole_m2 = 0;
};
Pressed pressed_in(double side_m, double voxel_m, double depth_m) {
    SoilDef def =
        grid_def(static_cast<int>(std::lround(std::max(0.16, 12 * voxel_m) / voxel_m)),
                 static_cast<int>(std::lround(std::max(0.16, 12 * voxel_m) / voxel_m)),
                 static_cast<int>(std::lround(std::max(0.16, 8 * voxel_m) / voxel_m)), voxel_m);
    def.backend = Backend::cpu;
    def.material = materials::dry_sand();
    const auto soil = make_soil(def);
    const double bed_m = 4 * std::max(0.02, voxel_m), middle_m = def.size_m.x / 2;
    EXPECT_TRUE(soil->fill(BoxFill{{{-9, -9, -9}, {9, 9, bed_m}}, "dry_sand"}));
    const auto contact_soil = std::make_shared<ContactSoil>();
    contact_soil->voxel_m = voxel_m;
    contact_soil->materials = soil->materials();
    const auto law = ContactLaw::make(contact_soil);
    Mover plate = cube(0, side_m, {middle_m + 0.0011, middle_m + 0.0007, bed_m + side_m / 2});
    plate.set_velocity({0, 0, -0.002});
    ContactMemory memory;
    std::vector<ContactPatch> patches;
    Pressed out;
    while (bed_m + side_m / 2 - plate.body.pose.position.z < depth_m) {
        plate.advance(def.step_s);
        plate.body.shapes = &plate.shapes;
        const StepReport report = soil->step({&plate.body, 1});
        BodyMotion motion;
        motion.pose = plate.body.pose;
        motion.center_of_mass_m = plate.body.center_of_mass_m;
        motion.linear_velocity_m_s = plate.body.linear_velocity_m_s;
        BodyMotion direction = motion;
        direction.linear_velocity_m_s = {0, 0, -1};
        const auto history = memory.advance(report.contacts, motion, *law, def.step_s);
        const BodyContact contact =
            group_contacts(report.contacts, motion, direction, *law, history, patches);
        plate.body.contact_pressure_pa = contact.mobilized_pressure_pa;
        plate.body.contact_width_m = contact.width_m;
        out = {contact.mobilized_force_n.z, sums_of(report, 0).sole_m2};
    }
    return out;
}

// By hand: a newton of a sole does not hang on the grid. In fine voxels the coverage field rounds a
// tenth of the sole off; per area that it sees both bear the same.
TEST(SmallBodies, bear_as_the_same_body_does_in_a_grid_that_resolves_it) {
    for (const double depth_m : {0.002, 0.004}) {
        const Pressed fine = pressed_in(0.01, 0.0025, depth_m);
        const Pressed coarse = pressed_in(0.01, 0.02, depth_m);
        const Pressed coarser = pressed_in(0.01, 0.05, depth_m);
        EXPECT_NEAR(coarse.sole_m2, 1e-4, 1e-12);
        EXPECT_NEAR(coarser.force_n, coarse.force_n, 0.01 * coarse.force_n);
        EXPECT_NEAR(coarse.force_n / coarse.sole_m2, fine.force_n / fine.sole_m2,
                    0.1 * fine.force_n / fine.sole_m2);
    }
}

TEST(SmallBodies, go_by_the_grid_where_they_are_wider_than_a_voxel) {
    const auto soil = level_bed();
    std::vector<Mover> movers;
    movers.push_back(cube(0, kVoxelM * 1.001, {0.6, 0.6, kBedM + 0.02}));
    const std::vector<SoilBody> bodies = bodies_of(movers);
    const StepReport report = soil->step(bodies);
    ASSERT_FALSE(report.contacts.empty());
    for (const ContactVoxel& v : report.contacts) {
        // A voxel's centre, on half voxels.
        const double halves = v.center_m.x / kVoxelM - 0.5;
        EXPECT_NEAR(halves, std::round(halves), 1e-9);
    }
}

}  // namespace
}  // namespace bsoil::small_bodies_test
