// Soles of several bodies beside each other are one, whatever bodies there are.
#include "bsoil/contact/shared_soles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bsoil/contact/granular_law.h"

namespace bsoil::shared_soles_test {
namespace {

constexpr double kVoxel = 0.05;

/// Level soles of several bodies, voxel by voxel.
struct Bodies {
    std::vector<std::vector<ContactVoxel>> voxels;
    std::vector<ContactFaces> faces;
    double turned_rad = 0;

    /// A rectangle of whole voxels, as another body's or a further sole of the last one.
    void add(Vec3 low, int x_count, int y_count, int carrier = -1, bool is_new = true) {
        if (is_new) voxels.emplace_back();
        const double s = std::sin(turned_rad / 2), c = std::cos(turned_rad / 2);
        for (int i = 0; i < x_count * y_count; ++i) {
            ContactVoxel v;
            const Vec3 at = low + Vec3{(i % x_count + 0.5) * kVoxel, (i / x_count + 0.5) * kVoxel,
                                       0.5 * kVoxel};
            v.center_m = v.position_m = rotate(Quat{0, 0, s, c}, at);
            v.normal = {0, 0, -1};
            v.area_m2 = kVoxel * kVoxel;
            v.depth_m = v.bearing_depth_m = 0.1;
            v.carrier = carrier;
            voxels.back().push_back(v);
        }
    }
    void join() {
        auto soil = std::make_shared<ContactSoil>();
        soil->voxel_m = kVoxel;
        soil->materials = {materials::dry_sand()};
        const GranularLaw law(std::move(soil), SurfaceFriction{});
        faces.resize(voxels.size());
        std::vector<BodySoles> soles;
        for (size_t b = 0; b < voxels.size(); ++b) {
            faces[b].find(voxels[b], {}, law, kVoxel);
            soles.push_back({voxels[b], &faces[b]});
        }
        join_soles(soles, law.up());
    }
    /// Of a body's first voxel; at its last, with `last`.
    const FaceExtent& sole(size_t body, bool last = false) const {
        return faces[body].of_voxel(last ? voxels[body].size() - 1 : 0);
    }
};

void expect_size(const FaceExtent& face, double width_m, double length_m) {
    EXPECT_NEAR(face.width_m, width_m, 1e-9);
    EXPECT_NEAR(face.length_m, length_m, 1e-9);
}

TEST(SharedSoles, of_plates_in_a_row_are_one_plate) {
    for (const double turned : {0.0, 0.4, std::numbers::pi / 2}) {
        Bodies row;
        row.turned_rad = turned;
        for (int i = 0; i < 6; ++i) row.add({4 * i * kVoxel, 0, 0}, 4, 6);
        row.join();
        for (size_t i = 0; i < 6; ++i) expect_size(row.sole(i), 6 * kVoxel, 24 * kVoxel);
    }
}

TEST(SharedSoles, apart_above_or_on_other_soil_are_two) {
    Bodies pair;
    pair.add({}, 4, 6);
    const auto second = [&](Vec3 low, int carrier = -1) {
        pair.voxels.resize(1);
        pair.add(low, 4, 6, carrier);
        pair.join();
        return pair.sole(0).length_m > 6.5 * kVoxel;
    };
    EXPECT_TRUE(second({4.4 * kVoxel, 0, 0})) << "a part of a voxel between them";
    EXPECT_FALSE(second({4.6 * kVoxel, 0, 0})) << "more between them";
    EXPECT_TRUE(second({4 * kVoxel, 0, kVoxel})) << "a voxel higher";
    EXPECT_FALSE(second({4 * kVoxel, 0, 2 * kVoxel})) << "two voxels higher";
    EXPECT_FALSE(second({4 * kVoxel, 0, 0}, 7)) << "on soil that a body carries";
    EXPECT_TRUE(second({4.4 * kVoxel, 6.4 * kVoxel, 0})) << "corner to corner";
}

// A frame: one body has two soles, of which each has a neighbour.
TEST(SharedSoles, of_one_body_join_for_themselves) {
    Bodies bodies;
    bodies.add({}, 4, 8);
    bodies.add({20 * kVoxel, 0, 0}, 4, 8, -1, false);
    bodies.add({4 * kVoxel, 0, 0}, 4, 8);
    bodies.join();
    expect_size(bodies.sole(0), 8 * kVoxel, 8 * kVoxel);
    expect_size(bodies.sole(1), 8 * kVoxel, 8 * kVoxel);
    expect_size(bodies.sole(0, true), 4 * kVoxel, 8 * kVoxel);
}

// One body between two others that do not touch.
TEST(SharedSoles, are_one_through_a_third_in_any_order) {
    for (const bool third_first : {false, true}) {
        Bodies bodies;
        if (third_first) bodies.add({4 * kVoxel, 0, 0}, 12, 4);
        bodies.add({}, 4, 4);
        bodies.add({16 * kVoxel, 0, 0}, 4, 4);
        if (!third_first) bodies.add({4 * kVoxel, 0, 0}, 12, 4);
        bodies.join();
        for (size_t i = 0; i < 3; ++i) expect_size(bodies.sole(i), 4 * kVoxel, 20 * kVoxel);
    }
}

TEST(SharedSoles, of_nothing_are_nothing) {
    join_soles({}, {0, 0, 1});
    Bodies bodies;
    bodies.add({}, 4, 4);
    bodies.voxels.emplace_back();
    bodies.join();
    expect_size(bodies.sole(0), 4 * kVoxel, 4 * kVoxel);
}

}  // namespace
}  // namespace bsoil::shared_soles_test
