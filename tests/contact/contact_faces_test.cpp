// What finds a contact's faces: soles and walls of known size, voxel by voxel.
#include "bsoil/contact/contact_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "bsoil/contact/granular_law.h"

namespace bsoil::contact_faces_test {
namespace {

constexpr double kVoxel = 0.05, kPi = std::numbers::pi;

GranularLaw law_in_small_voxels() {
    auto soil = std::make_shared<ContactSoil>();
    soil->voxel_m = kVoxel;
    soil->materials = {materials::dry_sand()};
    return GranularLaw(std::move(soil), SurfaceFriction{});
}

Quat about_up(double angle_rad) { return {0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)}; }

/// A contact put together voxel by voxel.
struct Contact {
    std::vector<ContactVoxel> voxels;
    Quat body_to_world;
    ContactFaces found;

    ContactVoxel& add(Vec3 at, Vec3 normal, double depth_m = 0.1) {
        ContactVoxel v;
        v.center_m = v.position_m = at;
        v.normal = normal;
        v.area_m2 = kVoxel * kVoxel;
        v.depth_m = v.bearing_depth_m = depth_m;
        return voxels.emplace_back(v);
    }
    /// A level sole: all voxels of the grid whose middle is in the shape.
    void add_sole(const std::function<bool(double x, double y)>& shape, double depth_m = 0.1) {
        const int reach = static_cast<int>(4 / kVoxel);
        for (int i = -reach; i < reach; ++i) {
            for (int j = -reach; j < reach; ++j) {
                const double x = (i + 0.5) * kVoxel, y = (j + 0.5) * kVoxel;
                if (shape(x, y)) add({x, y, 0}, {0, 0, -1}, depth_m);
            }
        }
    }
    /// Body and grid turned together, as a host may lay them.
    void turn(double angle_rad) {
        const Quat q = about_up(angle_rad);
        for (ContactVoxel& v : voxels) {
            v.center_m = rotate(q, v.center_m);
            v.position_m = rotate(q, v.position_m);
            v.normal = rotate(q, v.normal);
        }
        body_to_world = q;
    }
    /// The soles, by what ContactFaces finds.
    std::vector<FaceExtent> soles() {
        found.find(voxels, body_to_world, law_in_small_voxels(), kVoxel);
        return {found.faces().begin() + 6, found.faces().end()};
    }
};

/// Corners of voxels stick out of a round edge and stay behind it: half a voxel on either side.
constexpr double kRound = kVoxel;

TEST(FindContactFaces, a_plate_has_its_sides) {
    for (const double angle : {0.0, 0.5, kPi / 4, 2.0}) {
        Contact plate;
        plate.add_sole([](double x, double y) { return std::abs(x) < 0.4 && std::abs(y) < 0.9; });
        plate.turn(angle);
        const auto soles = plate.soles();
        ASSERT_EQ(soles.size(), 1u) << angle;
        EXPECT_NEAR(soles[0].width_m, 0.8, 1e-9);
        EXPECT_NEAR(soles[0].length_m, 1.8, 1e-9);
        EXPECT_EQ(soles[0].depth_m, 0.1);
    }
}

// Elements end at the borders of voxels: a plate that moves by next to nothing gets slivers.
TEST(FindContactFaces, slivers_make_no_sole_narrower) {
    for (const double sliver : {1e-5, 0.01, 0.3}) {
        Contact plate;
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 3; ++j) {
                plate.add({i * kVoxel, j * kVoxel, 0}, {0, 0, -1});
                for (const double share : {sliver, 1 - sliver}) {
                    ContactVoxel& part = share == sliver
                                             ? plate.add({i * kVoxel, j * kVoxel, 0}, {0, 0, -1})
                                             : plate.voxels[plate.voxels.size() - 2];
                    const double off = (share == sliver ? 1 : -1) * (1 - share) / 2 * kVoxel;
                    part.position_m = part.center_m + Vec3{off, 0, 0};
                    part.area_m2 = share * kVoxel * kVoxel;
                }
            }
        }
        const auto soles = plate.soles();
        ASSERT_EQ(soles.size(), 1u) << sliver;
        EXPECT_NEAR(soles[0].width_m, 2 * kVoxel, 0.07 * 2 * kVoxel) << sliver;
        EXPECT_NEAR(soles[0].length_m, 3 * kVoxel, 0.07 * 3 * kVoxel) << sliver;
    }
}

TEST(FindContactFaces, a_plate_across_the_grid_has_its_sides) {
    Contact plate;
    const double turn = 0.4;
    plate.add_sole([&](double x, double y) {
        const double along = x * std::cos(turn) + y * std::sin(turn);
        const double across = y * std::cos(turn) - x * std::sin(turn);
        return std::abs(across) < 0.4 && std::abs(along) < 0.9;
    });
    const auto soles = plate.soles();
    ASSERT_EQ(soles.size(), 1u);
    EXPECT_NEAR(soles[0].width_m, 0.8, kRound);
    EXPECT_NEAR(soles[0].length_m, 1.8, kRound);
}

TEST(FindContactFaces, a_disc_is_the_square_with_its_second_moments) {
    Contact disc;
    disc.add_sole([](double x, double y) { return std::hypot(x, y) < 1; });
    const auto soles = disc.soles();
    ASSERT_EQ(soles.size(), 1u);
    // R^2 / 4 of a disc is side^2 / 12 of the square; and the disc has room for pi R^2 / side.
    EXPECT_NEAR(soles[0].length_m, std::sqrt(3.0), kRound);
    EXPECT_NEAR(soles[0].width_m, std::min(std::sqrt(3.0), kPi / std::sqrt(3.0)), kRound);
}

TEST(FindContactFaces, a_ring_is_as_wide_as_it_has_area) {
    const double outer = 1, inner = 0.6;
    for (const double angle : {0.0, 0.5}) {
        Contact ring;
        ring.add_sole([&](double x, double y) {
            const double r = std::hypot(x, y);
            return r < outer && r > inner;
        });
        ring.turn(angle);
        const auto soles = ring.soles();
        ASSERT_EQ(soles.size(), 1u);
        // (R^2 + r^2) / 4 is side^2 / 12.
        const double side = std::sqrt(3 * (outer * outer + inner * inner));
        EXPECT_NEAR(soles[0].length_m, side, kRound);
        EXPECT_NEAR(soles[0].width_m, kPi * (outer * outer - inner * inner) / side, kRound);
    }
}

TEST(FindContactFaces, a_frame_is_as_wide_as_it_has_area) {
    Contact frame;
    frame.add_sole([](double x, double y) {
        const double r = std::max(std::abs(x), std::abs(y));
        return r < 1 && r > 0.8;
    });
    const auto soles = frame.soles();
    ASSERT_EQ(soles.size(), 1u);
    // (a^2 + b^2) / 12 of a square frame is side^2 / 12. Its sides are whole voxels.
    const double side = std::sqrt(2 * 2 + 1.6 * 1.6);
    EXPECT_NEAR(soles[0].length_m, side, 0.01 * kVoxel);
    EXPECT_NEAR(soles[0].width_m, (2 * 2 - 1.6 * 1.6) / side, 0.01 * kVoxel);
}

TEST(FindContactFaces, two_tracks_are_two_soles) {
    for (const double angle : {0.0, 0.5, 1.3}) {
        Contact tracks;
        for (const double side : {-1.0, 1.0}) {
            const double depth_m = side < 0 ? 0.05 : 0.15;
            tracks.add_sole(
                [&](double x, double y) {
                    return std::abs(x) < 1.5 && std::abs(y - 1.2 * side) < 0.2;
                },
                depth_m);
        }
        tracks.turn(angle);
        const auto soles = tracks.soles();
        ASSERT_EQ(soles.size(), 2u) << angle;
        for (const FaceExtent& sole : soles) {
            EXPECT_NEAR(sole.width_m, 0.4, 1e-9);
            EXPECT_NEAR(sole.length_m, 3, 1e-9);
        }
        // Each has its own depth.
        EXPECT_NEAR(std::abs(soles[0].depth_m - soles[1].depth_m), 0.1, 1e-12);
        // And each voxel its own track.
        for (size_t i = 0; i < tracks.voxels.size(); ++i) {
            EXPECT_EQ(tracks.found.of_voxel(i).depth_m, tracks.voxels[i].depth_m);
        }
    }
}

TEST(FindContactFaces, a_gap_of_a_lug_does_not_part_a_sole_and_a_wider_one_does) {
    for (const int gap_voxels : {1, 2}) {
        Contact lugs;
        lugs.add_sole([&](double x, double y) {
            return std::abs(y) < 0.2 && std::abs(x) < 0.5 && (x < 0 || x > gap_voxels * kVoxel);
        });
        // Parts no further apart than sole_gap_voxels, 2, from middle to middle.
        EXPECT_EQ(lugs.soles().size(), gap_voxels == 1 ? 1u : 2u) << gap_voxels;
    }
}

TEST(FindContactFaces, what_only_brushes_the_soil_makes_no_face_wider) {
    Contact wheel;
    wheel.add_sole([](double x, double y) { return std::abs(x) < 0.2 && std::abs(y) < 0.2; });
    wheel.add_sole(
        [](double x, double y) {
            return std::abs(x) > 0.2 && std::abs(x) < 1 && std::abs(y) < 0.2;
        },
        0);
    const auto soles = wheel.soles();
    ASSERT_EQ(soles.size(), 1u);
    EXPECT_NEAR(soles[0].width_m, 0.4, 1e-9);
    EXPECT_NEAR(soles[0].length_m, 0.4, 1e-9);
    // Nothing pressed: no size.
    Contact brushing;
    brushing.add_sole([](double x, double y) { return std::hypot(x, y) < 0.3; }, 0);
    ASSERT_EQ(brushing.soles().size(), 1u);
    EXPECT_EQ(brushing.soles()[0].width_m, 0);
}

TEST(FindContactFaces, soil_that_has_drawn_back_makes_no_face_wider) {
    Contact plate;
    plate.add_sole([](double x, double y) { return std::abs(x) < 0.5 && std::abs(y) < 0.3; });
    // Across half of it the soil stands half a voxel off: further than rebound (a tenth of the
    // depth) and open_gap_voxels, a quarter, reach.
    for (ContactVoxel& v : plate.voxels) {
        v.gap_m = v.center_m.x > 0 ? 0.5 * kVoxel : 0;
        v.touching = touching_share(v, kVoxel);
    }
    const auto soles = plate.soles();
    ASSERT_EQ(soles.size(), 1u);
    EXPECT_NEAR(soles[0].width_m, 0.5, 1e-9);
    EXPECT_NEAR(soles[0].length_m, 0.6, 1e-9);
}

TEST(FindContactFaces, density_is_the_mean_over_what_is_pressed) {
    Contact plate;
    plate.add_sole([](double x, double y) { return std::abs(x) < 0.5 && std::abs(y) < 0.5; });
    for (ContactVoxel& v : plate.voxels) v.relative_density = v.center_m.x > 0 ? 0.6 : 0.2;
    EXPECT_NEAR(plate.soles()[0].relative_density, 0.4, 1e-9);
    // Soil of a fixed density is loose.
    for (ContactVoxel& v : plate.voxels) v.relative_density = -1;
    EXPECT_EQ(plate.soles()[0].relative_density, 0);
}

TEST(FindContactFaces, walls_are_as_wide_as_they_are_level) {
    for (const double angle : {0.0, 0.6}) {
        Contact blade;
        // Two walls of a blade 2 m wide and 0.5 m high, and its ends, 0.1 m.
        for (int k = 0; k < 10; ++k) {
            for (int j = -20; j < 20; ++j) {
                for (const double side : {-1.0, 1.0}) {
                    blade.add({0.05 * side, (j + 0.5) * kVoxel, -k * kVoxel}, {side, 0, 0},
                              k * kVoxel + 0.02);
                }
            }
            for (int i = -1; i < 1; ++i) {
                for (const double side : {-1.0, 1.0}) {
                    blade.add({(i + 0.5) * kVoxel, side, -k * kVoxel}, {0, side, 0},
                              k * kVoxel + 0.02);
                }
            }
        }
        blade.turn(angle);
        EXPECT_TRUE(blade.soles().empty());
        const std::span<const FaceExtent> walls = blade.found.faces();
        for (const int front : {0, 1}) EXPECT_NEAR(walls[front].width_m, 2, 1e-9) << angle;
        for (const int end : {2, 3}) EXPECT_NEAR(walls[end].width_m, 0.1, 1e-9) << angle;
        for (const int face : {0, 1, 2, 3}) EXPECT_NEAR(walls[face].depth_m, 0.47, 1e-9);
        EXPECT_EQ(walls[4].width_m, 0);  // nothing looks up
    }
}

TEST(FindContactFaces, a_sole_looks_down_by_more_than_45_degrees) {
    Contact inclined;
    for (const double degrees : {44.0, 46.0}) {
        const double angle = degrees * kPi / 180;  // off straight down
        inclined.add({degrees, 0, 0}, {std::sin(angle), 0, -std::cos(angle)});
    }
    EXPECT_EQ(inclined.soles().size(), 1u);
    EXPECT_EQ(inclined.found.index_of_voxel(0), 6);
    EXPECT_EQ(inclined.found.index_of_voxel(1), 0);  // along +x
}

}  // namespace
}  // namespace bsoil::contact_faces_test
