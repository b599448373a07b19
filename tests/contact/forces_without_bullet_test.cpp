// What a host with another physics engine does: it steps the soil with its bodies and asks for the
// force on each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bsoil/host/driven_body.h"

namespace bsoil::forces_without_bullet_test {
namespace {

/// A box with a level sole that is driven straight down into dry sand.
class DrivenPlate {
  public:
    static constexpr double kSideM = 0.3, kSpeedMS = 0.02, kBedM = 0.5;

    DrivenPlate() {
        SoilDef def;
        def.size_m = {2, 2, 1};
        def.up = UpAxis::z;
        def.voxel_m = 0.025;
        def.backend = Backend::cpu;
        soil_ = std::move(*Soil::create(def));
        EXPECT_TRUE(soil_->fill(BoxFill{{{-1, -1, 0}, {1, 1, kBedM}}, "dry_sand"}));
        forces_ = std::make_unique<DrivenBody>(*soil_);
        ConvexShape box;
        box.kind = ConvexShape::Kind::box;
        box.half_extents_m = {kSideM / 2, kSideM / 2, 0.1};
        shapes_ = {box};
        plate_.shapes = &shapes_;
        plate_.linear_velocity_m_s = {0, 0, -kSpeedMS};
        plate_.pose.position = {0, 0, kBedM + 0.1};
    }
    /// On the plate [N], once its sole is as deep as this.
    Vec3 force_at(double depth_m) {
        const double step_s = soil_->def().step_s;
        Vec3 force_n;
        while (kBedM + 0.1 - plate_.pose.position.z < depth_m) {
            plate_.pose.position.z -= kSpeedMS * step_s;
            plate_.center_of_mass_m = plate_.pose.position;
            const StepReport report = soil_->step({&plate_, 1});
            force_n = forces_->advance(plate_, report.contacts).mobilized_force_n;
            find_sole(report.contacts);
        }
        return force_n;
    }
    Soil& soil() { return *soil_; }
    const ContactLaw& law() const { return forces_->law(); }
    KnownContact known() const { return soil_->known_contacts().of(plate_.id); }
    /// A step without the plate.
    void step_alone() { soil_->step({}); }
    /// Mean of the sole's elements.
    double sole_depth_m() const { return sole_depth_m_; }
    double sole_density() const { return sole_density_; }

  private:
    void find_sole(std::span<const ContactVoxel> contacts) {
        double area_m2 = 0;
        sole_depth_m_ = sole_density_ = 0;
        for (const ContactVoxel& v : contacts) {
            if (v.normal.z > -0.99) continue;
            area_m2 += v.area_m2;
            EXPECT_EQ(v.bearing_depth_m, std::max(v.depth_m, v.compression_m));
            sole_depth_m_ += v.area_m2 * v.depth_m;
            sole_density_ += v.area_m2 * v.relative_density;
        }
        sole_depth_m_ /= area_m2;
        sole_density_ /= area_m2;
    }

    std::unique_ptr<Soil> soil_;
    std::unique_ptr<DrivenBody> forces_;
    std::vector<ConvexShape> shapes_;
    SoilBody plate_;
    double sole_depth_m_ = 0, sole_density_ = 0;
};

TEST(ForcesWithoutBullet, plate_is_borne_by_the_laws_pressure_on_its_sole) {
    DrivenPlate plate;
    for (const double depth_m : {0.03, 0.06}) {
        const Vec3 force_n = plate.force_at(depth_m);
        // As much soil as it displaces stands around it.
        EXPECT_NEAR(plate.sole_depth_m(), depth_m, 0.15 * depth_m);
        ContactVoxel sole;
        sole.normal = {0, 0, -1};
        sole.depth_m = sole.bearing_depth_m = plate.sole_depth_m();
        const double side = DrivenPlate::kSideM;
        const FaceExtent face{side, side, sole.depth_m, plate.sole_density()};
        const double expected_n =
            side * side * length(plate.law().yield({sole, face}, {{0, 0, -1}, 0}, {}).mobilized_pa);
        EXPECT_NEAR(force_n.z / expected_n, 1, 0.05) << depth_m;
        EXPECT_LT(std::hypot(force_n.x, force_n.y), 0.01 * force_n.z);
    }
}

TEST(ForcesWithoutBullet, soil_that_has_changed_is_met_as_it_is_now) {
    DrivenPlate strong, weak;
    const double before_n = strong.force_at(0.03).z;
    EXPECT_EQ(weak.force_at(0.03).z, before_n);
    SoilDef def = weak.soil().def();
    def.material.friction_angle_rad = 0.3;
    ASSERT_TRUE(weak.soil().change(def));
    const double strong_n = strong.force_at(0.035).z, weak_n = weak.force_at(0.035).z;
    EXPECT_LT(weak_n, 0.5 * strong_n);
    EXPECT_EQ(weak.law().soil().materials[0].friction_angle_rad, 0.3);
}

TEST(ForcesWithoutBullet, soil_keeps_width_and_pressure_while_the_body_is_there) {
    DrivenPlate plate;
    EXPECT_EQ(plate.known().width_m, 0);
    const Vec3 force_n = plate.force_at(0.03);
    const double side = DrivenPlate::kSideM;
    EXPECT_NEAR(plate.known().width_m, side, 0.1 * side);
    // Its mean is weighted by force, so it is the sole's pressure, or more at an edge.
    EXPECT_GT(plate.known().pressure_pa, 0.9 * force_n.z / (side * side));
    plate.step_alone();
    EXPECT_EQ(plate.known().width_m, 0);
    EXPECT_EQ(plate.known().pressure_pa, 0);
}

}  // namespace
}  // namespace bsoil::forces_without_bullet_test
