// The faces on which contacts lie: those of the shape, whatever the coverage field's gradient says.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "soil_fixture.h"

namespace bsoil::faces_in_the_grid_test {
namespace {

constexpr double kVoxel = 0.05;

/// A body at rest in a bed whose top is at 14 voxels, after the soil has come to rest about it.
class ContactFaces : public testing::Test {
  protected:
    void place(const ConvexShape& shape, Vec3 at_voxels, Quat rotation = {}) {
        soil_ = make_soil(grid_def(32, 32, 32, kVoxel));
        ASSERT_TRUE(soil_->fill(voxel_box(*soil_, {0, 0, 0}, {32, 32, 14})));
        Mover body(1, shape, at_voxels * kVoxel);
        body.body.pose.rotation = rotation;
        for (int i = 0; i < 60; ++i) {
            const auto contacts = soil_->step({&body.body, 1}).contacts;
            contacts_.assign(contacts.begin(), contacts.end());
        }
        ASSERT_GT(contacts_.size(), 50u);
    }
    /// Sum of the areas of faces that look this way.
    double area_towards(Vec3 normal) const {
        double sum = 0;
        for (const ContactVoxel& c : contacts_) sum += dot(c.normal, normal) > 0.99 ? c.area_m2 : 0;
        return sum;
    }

    std::unique_ptr<Soil> soil_;
    std::vector<ContactVoxel> contacts_;
};

TEST_F(ContactFaces, a_curved_face_has_no_edges) {
    // The staircase of a cylinder's coverage turns the gradient by up to 30 deg from voxel to
    // voxel.
    const Vec3 middle = Vec3{16.3, 16.1, 14.4};
    place(round_shape(ConvexShape::Kind::cylinder, 9 * kVoxel, 6 * kVoxel), middle,
          turn({1, 0, 0}, -std::numbers::pi / 2));
    int rim_count = 0;
    for (const ContactVoxel& c : contacts_) {
        if (std::abs(dot(c.normal, Vec3{0, 1, 0})) > 0.99) {
            continue;  // the two ends
        }
        Vec3 radial = c.position_m - middle * kVoxel;
        radial.y = 0;
        EXPECT_GT(dot(c.normal, radial * (1 / length(radial))), 0.97)
            << c.normal.x << " " << c.normal.y << " " << c.normal.z << " at " << radial.x << " "
            << radial.z;
        ++rim_count;
    }
    EXPECT_GT(rim_count, 200);
}

TEST_F(ContactFaces, a_box_has_its_faces_up_to_their_edges) {
    const Vec3 half{6.3, 5.2, 5};
    place(box_shape(half * kVoxel), {16.2, 15.9, 15.1});
    const double sole_m2 = 4 * half.x * half.y * kVoxel * kVoxel;
    // Of a corner's three faces two are told apart.
    EXPECT_NEAR(area_towards({0, 0, -1}), sole_m2, 0.05 * sole_m2);
    const auto oblique = std::ranges::count_if(contacts_, [](const ContactVoxel& c) {
        return std::max({std::abs(c.normal.x), std::abs(c.normal.y), std::abs(c.normal.z)}) < 0.99;
    });
    EXPECT_LE(oblique, 4);
    // Edges belong to two faces: their voxels are listed twice.
    int twice = 0;
    for (size_t i = 1; i < contacts_.size(); ++i) {
        twice += length(contacts_[i].center_m - contacts_[i - 1].center_m) == 0 ? 1 : 0;
    }
    EXPECT_GT(twice, 20);
}

TEST_F(ContactFaces, a_sole_above_the_soil_knows_the_gap) {
    place(box_shape(Vec3{8, 8, 4} * kVoxel), {16, 16, 18.3});
    double widest_m = 0;
    for (const ContactVoxel& c : contacts_) {
        EXPECT_EQ(c.depth_m, 0);
        widest_m = std::max(widest_m, c.normal.z < -0.99 ? c.gap_m : 0);
    }
    EXPECT_NEAR(widest_m, 0.3 * kVoxel, 0.01 * kVoxel);
}

TEST_F(ContactFaces, a_soles_edge_touches_though_its_flank_does_not) {
    place(box_shape(Vec3{8, 8, 4} * kVoxel), {16, 16, 17.5});  // half a voxel deep
    for (const ContactVoxel& c : contacts_) {
        if (c.normal.z < -0.99) {
            EXPECT_EQ(c.gap_m, 0) << c.center_m.x << " " << c.center_m.y << " " << c.center_m.z;
        }
    }
    // The block's flanks stand half a voxel deep in soil, and above it in the air.
    EXPECT_TRUE(std::any_of(contacts_.begin(), contacts_.end(), [](const ContactVoxel& c) {
        return std::abs(c.normal.z) < 0.01 && c.gap_m > 0.3 * kVoxel;
    }));
}

}  // namespace
}  // namespace bsoil::faces_in_the_grid_test
