// What it takes to pull a level plate up out of its bed, beside the textbook's wedge.
#include <gtest/gtest.h>

#include <cmath>

#include "bsoil/host/driven_body.h"
#include "plain_sand.h"

namespace bsoil::pull_out_test {
namespace {

constexpr double kPlateM = 0.4, kThickM = 0.05, kGravity_m_s2 = 9.81;

/// Over the weight of the soil straight above the plate.
struct PullOut {
    double load = 0, contact = 0;
    double all() const { return load + contact; }
};

/// A square plate, 16 voxels wide, whose top is `depth_m` below the surface, begins to rise.
PullOut pull_out(double depth_m) {
    SoilDef def;
    def.size_m = {1.2, 1.2, 0.8};
    def.up = UpAxis::z;
    def.voxel_m = kPlateM / 16;
    def.backend = Backend::cpu;
    def.material = sand();
    auto soil = std::move(*Soil::create(def));
    constexpr double kTopM = 0.2;
    ConvexShape box;
    box.half_extents_m = {kPlateM / 2, kPlateM / 2, kThickM / 2};
    const std::vector<ConvexShape> shapes{box};
    SoilBody plate;
    plate.shapes = &shapes;
    plate.pose.position = {0, 0, kTopM - kThickM / 2};
    const Vec3 half = box.half_extents_m, middle = plate.pose.position;
    EXPECT_TRUE(soil->fill(FunctionFill{[=](Vec3 p) {
                                            const Vec3 at = p - middle;
                                            const bool is_plate = std::abs(at.x) < half.x &&
                                                                  std::abs(at.y) < half.y &&
                                                                  std::abs(at.z) < half.z;
                                            return p.z < kTopM + depth_m && !is_plate ? 1.0 : -1.0;
                                        },
                                        ""}));
    DrivenBody forces(*soil);
    double load_kg = 0, contact_n = 0;
    for (int i = 0; i < 24; ++i) {
        const double speed_m_s = i < 12 ? 0 : 0.002;
        plate.pose.position.z += speed_m_s * def.step_s;
        plate.center_of_mass_m = plate.pose.position;
        plate.linear_velocity_m_s = {0, 0, speed_m_s};
        const StepReport report = soil->step({&plate, 1});
        contact_n = -forces.advance(plate, report.contacts).mobilized_force_n.z;
        load_kg = 0;
        for (const BodyLoad& load : report.loads) load_kg += load.mass_kg - load.held_kg;
    }
    const double above_kg = def.material.density_kg_m3 * kPlateM * kPlateM * depth_m;
    return {load_kg / above_kg, contact_n / (above_kg * kGravity_m_s2)};
}

/// The plate's column of soil and friction at rest on its four sides, as White, Cheuk and Bolton
/// (2008) have two of a strip: 1 + K0 tan phi H / B.
double wedge(double depth_m) {
    const double at_rest = 1 - std::sin(kPhi);
    return 1 + 2 * at_rest * std::tan(kPhi) * depth_m / kPlateM;
}

// The column is the plate's load, and no friction holds it: docs/decisions/leaning_faces.md. A ring
// of a voxel along the plate's edge counts as load and as wall: of 16 voxels it is 0.23 of the
// plate, at most. Measured: 1.17 and 1.18 of the column, by hand 1.30 and 1.59.
TEST(PullOut, level_plate_lifts_its_column_without_the_friction_of_its_sides) {
    for (const double depth_m : {0.2, 0.4}) {
        const PullOut found = pull_out(depth_m);
        EXPECT_NEAR(found.load, 1, 0.01) << depth_m;
        EXPECT_GT(found.contact, 0.1) << depth_m;
        EXPECT_LT(found.contact, 0.23) << depth_m;
        EXPECT_LT(found.all(), wedge(depth_m)) << depth_m;
    }
    // As deep as wide it lacks a quarter of the wedge, where the ring counts. What has that
    // friction has to come nearer, and changes this bound.
    EXPECT_NEAR(pull_out(kPlateM).all() / wedge(kPlateM), 0.74, 0.04);
}

}  // namespace
}  // namespace bsoil::pull_out_test
