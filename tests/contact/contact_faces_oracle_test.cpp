// The faces of a contact beside an oracle that asks every pair of elements, for bodies whose form
// is known: a plate, a plate on a slope, the edge of a slab, lugs. What they measure is known too.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "bsoil/contact/contact_faces.h"
#include "oracle/contact_faces.h"

namespace bsoil::contact_faces_oracle_test {
namespace {

constexpr double kElementM = 0.05;
/// What sums in another order leave.
constexpr double kRounding = 1e-9;
/// The oracle looks for the longest direction; a variance is flat there.
constexpr double kSearched = 1e-7;

/// A rectangle of elements on a plane: its elements are squares with a middle each.
struct Rectangle {
    Vec3 corner, along, across;  ///< both unit, at right angles
    int long_count = 1, short_count = 1;
    Vec3 normal;  ///< unit, out of the body
};

class Contact {
  public:
    Contact() {
        auto soil = std::make_shared<ContactSoil>();
        soil->voxel_m = kElementM;
        soil->materials = {materials::dry_sand()};
        law_ = ContactLaw::make(std::move(soil));
    }
    /// Elements touch their soil in part, by chance; is_whole: all of it.
    void add(const Rectangle& r, bool is_whole = false) {
        for (int i = 0; i < r.long_count; ++i) {
            for (int j = 0; j < r.short_count; ++j) {
                ContactVoxel v;
                v.position_m =
                    r.corner + (i + 0.5) * kElementM * r.along + (j + 0.5) * kElementM * r.across;
                v.center_m = v.position_m;
                v.normal = r.normal;
                v.area_m2 = kElementM * kElementM;
                v.depth_m = v.bearing_depth_m = -v.position_m.z;
                v.relative_density = chance_(random_);
                v.touching = is_whole ? 1 : 0.5 + chance_(random_) / 2;
                voxels_.push_back(v);
            }
        }
    }
    void turn(double angle_rad) {
        turn_ = {0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)};
    }
    /// Compares every face with the oracle's; returns the oracle's.
    std::vector<oracle::Face> compare() {
        ContactFaces found;
        found.find(voxels_, turn_, *law_, kElementM);
        oracle::FaceRules rules;
        rules.body_to_world = turn_;
        rules.element_m = kElementM;
        rules.gap = law_->def().sole_gap_voxels;
        const std::vector<oracle::Face> wanted = oracle::contact_faces(voxels_, rules);
        size_t soles = 0;
        for (const oracle::Face& face : wanted) {
            soles += face.is_sole;
            const int index = found.index_of_voxel(static_cast<size_t>(face.elements.front()));
            if (!face.is_sole) {
                EXPECT_EQ(index, face.axis);
            }
            for (const int element : face.elements) {
                EXPECT_EQ(found.index_of_voxel(static_cast<size_t>(element)), index);
            }
            const FaceExtent& extent = found.faces()[static_cast<size_t>(index)];
            EXPECT_NEAR(extent.width_m, face.width_m, kSearched);
            EXPECT_NEAR(extent.length_m, face.length_m, kSearched);
            EXPECT_NEAR(extent.depth_m, face.depth_m, kRounding);
            EXPECT_NEAR(extent.foot_m, face.foot_m, kRounding);
            EXPECT_NEAR(extent.relative_density, face.relative_density, kRounding);
        }
        EXPECT_EQ(found.faces().size(), 6 + soles);
        return wanted;
    }

  private:
    std::unique_ptr<const ContactLaw> law_;
    std::vector<ContactVoxel> voxels_;
    Quat turn_;
    std::mt19937 random_{1};
    std::uniform_real_distribution<double> chance_{0, 1};
};

TEST(ContactFacesBesideOracle, a_flat_plate_is_one_sole_of_its_sides) {
    for (const bool is_whole : {true, false}) {
        Contact contact;
        contact.add({{-0.4, -0.2, -0.1}, {1, 0, 0}, {0, 1, 0}, 16, 8, {0, 0, -1}}, is_whole);
        const auto faces = contact.compare();
        ASSERT_EQ(faces.size(), 1u);
        EXPECT_TRUE(faces[0].is_sole);
        EXPECT_NEAR(faces[0].depth_m, 0.1, kRounding);
        if (!is_whole) continue;
        EXPECT_NEAR(faces[0].length_m, 0.8, kRounding);
        EXPECT_NEAR(faces[0].width_m, 0.4, kRounding);
    }
}

TEST(ContactFacesBesideOracle, a_plate_on_a_slope_is_a_sole_up_to_45_deg_and_a_wall_beyond) {
    for (const double degrees : {10.0, 30.0, 44.0, 46.0, 70.0}) {
        const double slope = degrees * std::numbers::pi / 180;
        Contact contact;
        contact.turn(0.3);
        const Vec3 along{std::cos(0.3) * std::cos(slope), std::sin(0.3) * std::cos(slope),
                         -std::sin(slope)};
        const Vec3 across{-std::sin(0.3), std::cos(0.3), 0};
        contact.add({{0, 0, -0.1}, along, across, 10, 6, -1.0 * cross(along, across)});
        const auto faces = contact.compare();
        ASSERT_EQ(faces.size(), 1u) << degrees;
        EXPECT_EQ(faces[0].is_sole, degrees < 45) << degrees;
        // Across the slope it has its own width, along it what is seen from above.
        if (!faces[0].is_sole) {
            EXPECT_NEAR(faces[0].width_m, 0.3, 0.05) << degrees;
        }
    }
}

TEST(ContactFacesBesideOracle, the_edge_of_a_slab_has_a_sole_and_a_wall) {
    Contact contact;
    contact.add({{-0.5, -0.3, -0.15}, {1, 0, 0}, {0, 1, 0}, 20, 12, {0, 0, -1}});
    contact.add({{0.5, -0.3, -0.15}, {0, 1, 0}, {0, 0, 1}, 12, 3, {1, 0, 0}});
    const auto faces = contact.compare();
    ASSERT_EQ(faces.size(), 2u);
    EXPECT_TRUE(faces[0].is_sole);
    EXPECT_EQ(faces[1].axis, 0);
    EXPECT_NEAR(faces[1].width_m, 0.6, 0.05);
    // Its lower edge is half an element below its lowest middle.
    EXPECT_NEAR(faces[1].foot_m, 0.15, kRounding);
}

TEST(ContactFacesBesideOracle, lugs_are_soles_of_their_own_where_the_gap_between_them_is_wide) {
    for (const int gap : {1, 2, 3, 6}) {
        Contact contact;
        for (int lug = 0; lug < 4; ++lug) {
            const double x = lug * (1 + gap) * kElementM;
            contact.add({{x, 0, -0.2}, {0, 1, 0}, {1, 0, 0}, 8, 1, {0, 0, -1}});
            contact.add({{x + kElementM, 0, -0.2}, {0, 1, 0}, {0, 0, 1}, 8, 2, {1, 0, 0}});
        }
        size_t soles = 0;
        for (const oracle::Face& face : contact.compare()) soles += face.is_sole;
        // Tips that are `gap` elements apart have their middles one more apart.
        EXPECT_EQ(soles, gap + 1 <= ContactLawDef{}.sole_gap_voxels ? 1u : 4u) << gap;
    }
}

}  // namespace
}  // namespace bsoil::contact_faces_oracle_test
