// What a host with another physics engine does: it steps the soil with its bodies and asks for the
// force on each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/granular_law.h"
#include "bsoil/soil.h"

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
        const auto contact_soil = std::make_shared<ContactSoil>();
        contact_soil->voxel_m = def.voxel_m;
        contact_soil->materials = soil_->materials();
        law_ = ContactLaw::make(contact_soil);
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
            BodyMotion motion;
            motion.pose = plate_.pose;
            motion.center_of_mass_m = plate_.center_of_mass_m;
            motion.linear_velocity_m_s = plate_.linear_velocity_m_s;
            BodyMotion direction = motion;
            direction.linear_velocity_m_s = {0, 0, -1};
            const auto history = memory_.advance(report.contacts, motion, *law_, step_s);
            const BodyContact contact =
                group_contacts(report.contacts, motion, direction, *law_, history, patches_);
            force_n = contact.mobilized_force_n;
            // The soil packs under this pressure, and looks as far around as this width.
            plate_.contact_pressure_pa = contact.mobilized_pressure_pa;
            plate_.contact_width_m = contact.width_m;
            find_sole(report.contacts);
        }
        return force_n;
    }
    const ContactLaw& law() const { return *law_; }
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
    std::unique_ptr<const ContactLaw> law_;
    std::vector<ConvexShape> shapes_;
    SoilBody plate_;
    double sole_depth_m_ = 0, sole_density_ = 0;
    ContactMemory memory_;
    std::vector<ContactPatch> patches_;
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

}  // namespace
}  // namespace bsoil::forces_without_bullet_test
