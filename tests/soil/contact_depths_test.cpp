// Depths of contacts in metres: what the soil reports of each face against the free surface that
// the oracle finds over the same columns, and against what can be reckoned by hand.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "oracle/free_surface.h"
#include "soil_fixture.h"

namespace bsoil::contact_depths_test {
namespace {

using namespace layout;
using Top = oracle::SurfaceColumn::Top;

constexpr double kVoxel = 0.05;
constexpr int kSide = 48, kHigh = 32;  // voxels

/// A bed with a body in it that the soil has met for some steps.
class ContactDepths : public testing::Test {
  protected:
    void make_bed(double voxels_deep) {
        SoilDef def = grid_def(kSide, kSide, kHigh, kVoxel);
        soil_ = make_soil(def);
        if (voxels_deep > 0) add_soil({0, 0, 0}, {kSide, kSide, voxels_deep});
    }
    void add_soil(Vec3 low, Vec3 high) { ASSERT_TRUE(soil_->fill(voxel_box(*soil_, low, high))); }
    /// A body that is lowered to its place by `drop` voxels, and what it meets there.
    void press(std::vector<ConvexShape> shapes, Vec3 at_voxels, double drop, double width_voxels,
               std::vector<SoilBody> others = {}) {
        shapes_ = std::move(shapes);
        SoilBody body;
        body.id = 1;
        body.shapes = &shapes_;
        body.contact_width_m = width_voxels * kVoxel;
        width_ = width_voxels;
        const int steps = 40;
        for (int i = 1; i <= steps; ++i) {
            body.pose.position =
                (at_voxels + Vec3{0, 0, drop * (1 - static_cast<double>(i) / steps)}) * kVoxel;
            body.linear_velocity_m_s = {0, 0, -drop * kVoxel / steps * 60};
            body.center_of_mass_m = body.pose.position;
            std::vector<SoilBody> bodies{body};
            bodies.insert(bodies.end(), others.begin(), others.end());
            const auto contacts = soil_->step(bodies).contacts;
            contacts_.assign(contacts.begin(), contacts.end());
        }
        ASSERT_GT(contacts_.size(), 20u);
    }

    /// The columns as the soil has them after the last step.
    oracle::SurfaceMap columns() {
        Soil::Impl& impl = SoilProbe::impl(*soil_);
        oracle::SurfaceMap map;
        map.nx = map.ny = kSide;
        map.columns.resize(kSide * kSide);
        for (int ty = 0; ty < kSide / kTileSide; ++ty) {
            for (int tx = 0; tx < kSide / kTileSide; ++tx) {
                const auto words = impl.contacts.surface().of_ground(impl.tile_index(tx, ty));
                for (int c = 0; c < kTileColumns; ++c) {
                    auto& column = map.columns[(ty * kTileSide + c / kTileSide) * kSide +
                                               tx * kTileSide + c % kTileSide];
                    const int32_t word = words[c];
                    column.top = word >= 0             ? Top::soil
                                 : word <= kTerrainTop ? Top::terrain
                                                       : Top::body;
                    column.height = (word >= 0             ? word
                                     : word <= kTerrainTop ? kTerrainTop - word
                                                           : kCovered - word) /
                                    65536.0;
                }
            }
        }
        return map;
    }

    /// Each contact has the depth that the oracle finds under the free surface at its place.
    void expect_depths_of_oracle() {
        const oracle::SurfaceMap map = columns();
        const SoilDef& def = soil_->def();
        int lowest = kHigh, highest = 0;
        for (const ContactVoxel& c : contacts_) {
            const int z = static_cast<int>(std::floor(c.center_m.z / kVoxel));
            lowest = std::min(lowest, z);
            highest = std::max(highest, z);
        }
        oracle::SurfacePiece piece;
        piece.body_width = width_;
        piece.wedge_length =
            def.contact_law.wedge_length_of(soil_->materials()[0].friction_angle_rad);
        piece.sole_widths = def.contact_law.sole_surroundings_widths;
        piece.reach_most =
            std::clamp(std::ceil(std::max(piece.wedge_length * (highest - lowest + 1),
                                          piece.sole_widths * width_)),
                       16.0, 256.0);
        int deep = 0;
        for (const ContactVoxel& c : contacts_) {
            piece.x = static_cast<int>(c.center_m.x / kVoxel);
            piece.y = static_cast<int>(c.center_m.y / kVoxel);
            piece.at = c.position_m * (1 / kVoxel);
            piece.outward = c.normal;
            const std::optional<double> height = oracle::free_surface(map, piece);
            ASSERT_TRUE(height);
            // Both compute in double precision.
            EXPECT_NEAR(c.depth_m, std::max(0.0, *height - piece.at.z) * kVoxel, 1e-9)
                << "at " << piece.at.x << " " << piece.at.y << " " << piece.at.z << ", normal "
                << c.normal.x << " " << c.normal.y << " " << c.normal.z;
            deep += c.depth_m > 0 ? 1 : 0;
        }
        EXPECT_GT(deep, 10);
    }

    /// Mean over the area of the faces that look this way [m].
    double mean_depth_m(Vec3 normal) const {
        double area = 0, sum = 0;
        for (const ContactVoxel& c : contacts_) {
            if (dot(c.normal, normal) < 0.99) continue;
            area += c.area_m2;
            sum += c.area_m2 * c.depth_m;
        }
        EXPECT_GT(area, 0);
        return sum / area;
    }

    std::unique_ptr<Soil> soil_;
    std::vector<ConvexShape> shapes_;
    std::vector<ContactVoxel> contacts_;
    double width_ = 0;
};

TEST_F(ContactDepths, flat_bed) {
    make_bed(14);
    press({box_shape(Vec3{6, 6, 4} * kVoxel)}, {24, 24, 16}, 2, 12);
    expect_depths_of_oracle();
    // 2 voxels deep: rim and hollow together are as high as the bed was, but for what the push has
    // sent beyond the 1.5 widths around the sole.
    EXPECT_NEAR(mean_depth_m({0, 0, -1}), 2 * kVoxel, 0.25 * kVoxel);
}

TEST_F(ContactDepths, slope) {
    make_bed(8);
    // Steps of one voxel every two columns: 26.6 deg, which dry sand holds.
    for (int i = 0; i < 12; ++i) add_soil({14.0 + 2 * i, 0, 8.0 + i}, {kSide, kSide, 9.0 + i});
    press({box_shape(Vec3{4, 4, 5} * kVoxel)}, {26, 24, 17}, 3, 8);
    expect_depths_of_oracle();
    // The wall that looks up the slope is deeper than the one that looks down it.
    EXPECT_GT(mean_depth_m({1, 0, 0}), mean_depth_m({-1, 0, 0}) + 2 * kVoxel);
    EXPECT_NEAR(mean_depth_m({0, 1, 0}), mean_depth_m({0, -1, 0}), 0.2 * kVoxel);
}

TEST_F(ContactDepths, heap) {
    make_bed(12);
    add_soil({30, 12, 12}, {40, 36, 15});
    press({box_shape(Vec3{4, 6, 4} * kVoxel)}, {25, 24, 14}, 2, 8);
    expect_depths_of_oracle();
    EXPECT_GT(mean_depth_m({1, 0, 0}), mean_depth_m({-1, 0, 0}) + 0.25 * kVoxel);
}

TEST_F(ContactDepths, rut) {
    make_bed(14);
    press({box_shape(Vec3{5, 16, 4} * kVoxel)}, {24, 24, 16}, 2, 10);
    // A second body in the rut that the first one leaves.
    press({box_shape(Vec3{4, 5, 4} * kVoxel)}, {24, 24, 15.5}, 3, 8);
    expect_depths_of_oracle();
}

TEST_F(ContactDepths, slabs_edge) {
    make_bed(0);
    const std::vector<ConvexShape> slab{box_shape(Vec3{8, 24, 9} * kVoxel)};
    SoilBody ground;
    ground.id = 2;
    ground.shapes = &slab;
    ground.is_static = true;
    ground.pose.position = Vec3{40, 24, 9} * kVoxel;  // 18 high from x = 32 on
    ground.center_of_mass_m = ground.pose.position;
    add_soil({0, 0, 0}, {32, kSide, 14});
    press({box_shape(Vec3{4, 6, 4} * kVoxel)}, {26, 24, 16}, 2, 8, {ground});
    expect_depths_of_oracle();
    // The slab stands 4 voxels above the bed and is no soil.
    EXPECT_LT(mean_depth_m({1, 0, 0}), mean_depth_m({-1, 0, 0}) + 0.5 * kVoxel);
}

TEST_F(ContactDepths, lug) {
    make_bed(14);
    // A wheel's rim stands on the bed, a lug 1 voxel thick and 3 long goes down into it.
    ConvexShape rim = round_shape(ConvexShape::Kind::cylinder, 7 * kVoxel, 4 * kVoxel);
    rim.local.rotation = turn({1, 0, 0}, -std::numbers::pi / 2);
    ConvexShape lug = box_shape(Vec3{1.0, 4, 1.5} * kVoxel);
    lug.local.position = Vec3{0, 0, -8.5} * kVoxel;
    press({rim, lug}, {24, 24, 20.5}, 3, 6);
    expect_depths_of_oracle();
    // Half of the lug's height and the half voxel that the rim is deep, under the surface beside
    // it.
    const double foot = 20.5 - 10, middle = (foot + 14) / 2;
    EXPECT_NEAR(mean_depth_m({0, 0, -1}), (14 - foot) * kVoxel, 0.8 * kVoxel);
    EXPECT_NEAR(mean_depth_m({1, 0, 0}), (14 - middle) * kVoxel, 0.8 * kVoxel);
}

}  // namespace
}  // namespace bsoil::contact_depths_test
