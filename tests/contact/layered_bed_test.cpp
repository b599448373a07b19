// A sole on soil in layers: how dense each layer is goes by its own materials, so that the bed
// bears between what the layers bear alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "bsoil/host/driven_body.h"
#include "bsoil/host/soil_below.h"

namespace bsoil::layered_bed_test {
namespace {

constexpr double kBedM = 0.3, kTopM = 0.1;  ///< height of the bed, and of its upper layer
constexpr double kSideM = 0.3;              ///< of the plate

/// Sand of 29 deg that differs from others of these tests by its densities alone.
MaterialDef sand(const std::string& name, double density_kg_m3, double loose_kg_m3,
                 double compacted_kg_m3) {
    MaterialDef out = materials::dry_sand();
    out.name = name;
    out.friction_angle_rad = 29 * std::numbers::pi / 180;
    out.density_kg_m3 = density_kg_m3;
    out.loose_density_kg_m3 = loose_kg_m3;
    out.compacted_density_kg_m3 = compacted_kg_m3;
    return out;
}

const MaterialDef kLoose = sand("loose", 1350, 1330, 1700);
const MaterialDef kHeavyLoose = sand("heavy loose", 2030, 2000, 2556);
const MaterialDef kDense = sand("dense", 1690, 1330, 1700);
const MaterialDef kLightDense = sand("light dense", 1000, 780, 1005);

/// An empty soil of all these materials.
std::unique_ptr<Soil> empty_soil(double voxel_m) {
    SoilDef def;
    def.size_m = {1.2, 1.2, 0.6};
    def.up = UpAxis::z;
    def.voxel_m = voxel_m;
    def.backend = Backend::cpu;
    def.thread_count = 1;
    def.materials = {kLoose,      kHeavyLoose,           kDense,
                     kLightDense, materials::dry_sand(), materials::loam()};
    return std::move(*Soil::create(def));
}

void fill_between(Soil& soil, double from_m, double to_m, const MaterialDef& material) {
    EXPECT_TRUE(soil.fill(BoxFill{{{-1, -1, from_m}, {1, 1, to_m}}, material.name}));
}

/// A plate that is driven down into a bed.
class Plate {
  public:
    explicit Plate(Soil& soil) : soil_(soil), forces_(soil) {
        ConvexShape box;
        box.kind = ConvexShape::Kind::box;
        box.half_extents_m = {kSideM / 2, kSideM / 2, kHalfM};
        shapes_ = {box};
        body_.shapes = &shapes_;
        body_.linear_velocity_m_s = {0, 0, -0.05};
        body_.pose.position = {0, 0, kBedM + kHalfM};
    }
    /// Borne with [N], once its sole is as deep as this.
    double borne_n(double depth_m) {
        double force_n = 0;
        while (body_.pose.position.z > kBedM + kHalfM - depth_m) {
            body_.pose.position.z += body_.linear_velocity_m_s.z * soil_.def().step_s;
            body_.center_of_mass_m = body_.pose.position;
            report_ = soil_.step({&body_, 1});
            force_n = forces_.advance(body_, report_.contacts).mobilized_force_n.z;
        }
        return force_n;
    }
    /// Of its last step.
    std::span<const ContactVoxel> contacts() const { return report_.contacts; }

  private:
    static constexpr double kHalfM = 0.1;  ///< of its height
    Soil& soil_;
    DrivenBody forces_;
    std::vector<ConvexShape> shapes_;
    SoilBody body_;
    StepReport report_;
};

/// What a plate is borne with [N] that is driven 11 mm into one soil upon another.
double borne_n(double voxel_m, const MaterialDef& upper, const MaterialDef& lower) {
    const auto soil = empty_soil(voxel_m);
    fill_between(*soil, 0, kBedM - kTopM, lower);
    fill_between(*soil, kBedM - kTopM, kBedM, upper);
    return Plate(*soil).borne_n(0.011);
}

/// A sole compacts more of a layer of two voxels than of a bed: one of them bears up to 16 % more.
constexpr double kGridShare = 1.2;

class LayeredBed : public testing::TestWithParam<double> {
  protected:
    /// Whether either of two soils over the other bears between the two.
    void expect_between(const MaterialDef& one, const MaterialDef& other) {
        const double one_n = measured_n(one, one), other_n = measured_n(other, other);
        const auto [least_n, most_n] = std::minmax(one_n, other_n);
        for (const double got_n : {measured_n(one, other), measured_n(other, one)}) {
            EXPECT_GE(got_n, least_n / kGridShare);
            EXPECT_LE(got_n, kGridShare * most_n);
        }
    }

  private:
    /// borne_n(), which is written down as well.
    double measured_n(const MaterialDef& upper, const MaterialDef& lower) {
        const double out_n = borne_n(GetParam(), upper, lower);
        RecordProperty(upper.name + " over " + lower.name, std::to_string(out_n));
        return out_n;
    }
};

// By the densities of the upper one a bed of two loose sands bore as the densest one does.
TEST_P(LayeredBed, of_two_loose_sands_bears_between_them) { expect_between(kLoose, kHeavyLoose); }

// And one of two dense sands as a loose one.
TEST_P(LayeredBed, of_two_dense_sands_bears_between_them) { expect_between(kDense, kLightDense); }

TEST_P(LayeredBed, of_sand_and_loam_bears_between_them) {
    expect_between(materials::dry_sand(), materials::loam());
}

// Voxels that hold both loose sands. Against the densities of the lighter one alone they would be
// two thirds compacted.
TEST_P(LayeredBed, of_mixed_voxels_is_as_dense_as_their_materials) {
    const double voxel_m = GetParam();
    const auto soil = empty_soil(voxel_m);
    for (double z_m = 0; z_m < kBedM - voxel_m / 2; z_m += voxel_m) {
        fill_between(*soil, z_m, z_m + 0.3 * voxel_m, kHeavyLoose);
        fill_between(*soil, z_m + 0.3 * voxel_m, z_m + voxel_m, kLoose);
    }
    const double density = kLoose.relative_density(kLoose.density_kg_m3);  // of both
    const GroundSurface surface(*soil);
    const auto below = SoilBelow(*soil, surface, {0, 0, 1}).at({0, 0, kBedM + voxel_m});
    ASSERT_TRUE(below);
    EXPECT_NEAR(below->relative_density, density, 0.01);
    Plate plate(*soil);
    plate.borne_n(0.001);
    ASSERT_FALSE(plate.contacts().empty());
    for (const ContactVoxel& contact : plate.contacts()) {
        EXPECT_NEAR(contact.relative_density, density, 0.01);
    }
}

INSTANTIATE_TEST_SUITE_P(Voxels, LayeredBed, testing::Values(0.05, 0.025));

}  // namespace
}  // namespace bsoil::layered_bed_test
