// Which parts of a body are teeth, and the surface over their tips.
#include "contact/tooth_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact/surface_samples.h"

namespace bsoil::tooth_rows_test {
namespace {

ConvexShape box(Vec3 size_m, Vec3 at_m, Quat rotation = {}) {
    ConvexShape out;
    out.half_extents_m = 0.5 * size_m;
    out.local = {at_m, rotation};
    return out;
}
ConvexShape cylinder_about_y(double radius_m, double width_m) {
    ConvexShape out;
    out.kind = ConvexShape::Kind::cylinder;
    out.radius_m = radius_m;
    out.half_height_m = width_m / 2;
    out.local.rotation = {std::sin(std::numbers::pi / 4), 0, 0, std::cos(std::numbers::pi / 4)};
    return out;
}
Quat about_y(double angle_rad) { return {0, std::sin(angle_rad / 2), 0, std::cos(angle_rad / 2)}; }
std::vector<ConvexShape> wheel(int lug_count, double lug_width_m = 0.2) {
    std::vector<ConvexShape> out{cylinder_about_y(0.25, 0.2)};
    for (int i = 0; i < lug_count; ++i) {
        const Quat turn = about_y(2 * std::numbers::pi * i / lug_count);
        out.push_back(box({0.01, lug_width_m, 0.05}, rotate(turn, {0, 0, 0.245}), turn));
    }
    return out;
}
std::vector<ConvexShape> plate_with(const std::vector<ConvexShape>& parts) {
    std::vector<ConvexShape> out{box({0.6, 0.4, 0.04}, {})};
    out.insert(out.end(), parts.begin(), parts.end());
    return out;
}
size_t row_count(const std::vector<ConvexShape>& shapes) {
    return find_toothed_faces(shapes).size();
}

TEST(ToothRows, lugs_of_a_wheel_are_a_row) {
    const std::vector<ToothedFace> rows = find_toothed_faces(wheel(12));
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_TRUE(rows[0].is_mantle);
    EXPECT_EQ(rows[0].shapes.size(), 12u);
    EXPECT_NEAR(rows[0].height_m, 0.02, 1e-12);
    EXPECT_NEAR(rows[0].thickness_m, 0.01, 1e-12);
    EXPECT_NEAR(rows[0].pitch_m, 2 * std::numbers::pi * 0.25 / 12, 1e-12);
    EXPECT_NEAR(rows[0].to_m - rows[0].from_m, 0.2, 1e-12);
}

TEST(ToothRows, hulls_are_teeth_as_boxes_are) {
    std::vector<ConvexShape> shapes = wheel(12);
    for (size_t i = 1; i < shapes.size(); ++i) {
        const Vec3 h = shapes[i].half_extents_m;
        shapes[i].kind = ConvexShape::Kind::hull;
        shapes[i].bound_m = length(h);
        for (const double s : {-1.0, 1.0}) {
            shapes[i].planes.push_back({{s, 0, 0}, h.x});
            shapes[i].planes.push_back({{0, s, 0}, h.y});
            shapes[i].planes.push_back({{0, 0, s}, h.z});
        }
    }
    const std::vector<ToothedFace> rows = find_toothed_faces(shapes);
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_NEAR(rows[0].height_m, 0.02, 1e-9);
    EXPECT_NEAR(rows[0].thickness_m, 0.01, 1e-9);
}

TEST(ToothRows, grousers_and_ribs_across_a_plate_are_rows) {
    const auto link = plate_with({box({0.03, 0.4, 0.1}, {0.25, 0, -0.06})});
    const std::vector<ToothedFace> one = find_toothed_faces(link);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(one[0].base, 0u);
    EXPECT_NEAR(one[0].pitch_m, 0.6, 1e-12);
    EXPECT_NEAR(one[0].height_m, 0.09, 1e-12);
    EXPECT_NEAR(one[0].thickness_m, 0.03, 1e-12);
    const auto ribbed =
        plate_with({box({0.02, 0.4, 0.1}, {-0.2, 0, 0.03}), box({0.02, 0.4, 0.1}, {0, 0, 0.03}),
                    box({0.02, 0.4, 0.1}, {0.2, 0, 0.03})});
    const std::vector<ToothedFace> three = find_toothed_faces(ribbed);
    ASSERT_EQ(three.size(), 1u);
    EXPECT_NEAR(three[0].pitch_m, 0.2, 1e-12);
}

TEST(ToothRows, what_only_stands_out_is_no_tooth) {
    EXPECT_EQ(row_count(wheel(0)), 0u);
    EXPECT_EQ(row_count(wheel(4)), 0u) << "too few to hold soil all round";
    EXPECT_EQ(row_count(wheel(12, 0.05)), 0u) << "studs: soil goes round them";
    std::vector<ConvexShape> table{box({1, 0.8, 0.04}, {0, 0, 0.7})};
    for (const double x : {-0.45, 0.45}) {
        for (const double y : {-0.35, 0.35}) table.push_back(box({0.05, 0.05, 0.7}, {x, y, 0.35}));
    }
    EXPECT_EQ(row_count(table), 0u);
    EXPECT_EQ(row_count(plate_with({box({0.5, 0.06, 0.06}, {0.5, 0, 0})})), 0u) << "an arm";
    EXPECT_EQ(row_count(plate_with({box({0.6, 0.02, 0.3}, {0, 0.19, 0.13}),
                                    box({0.6, 0.02, 0.3}, {0, -0.19, 0.13}),
                                    box({0.02, 0.4, 0.3}, {-0.29, 0, 0.13})})),
              0u)
        << "a bucket";
}

TEST(ToothRows, surface_over_the_tips_is_a_larger_cylinders) {
    const std::vector<ConvexShape> shapes = wheel(12);
    WallShapes walls;
    walls.make(shapes, 0.02);
    SurfaceSamples surface;
    surface.make(shapes, walls.growth, 0.02);
    EXPECT_TRUE(surface.rows.empty());
    EXPECT_TRUE(surface.over_tips.empty());
    surface.make(shapes, walls.growth, 0.02, true);
    double mantle_m2 = 0, ends_m2 = 0, between_m2 = 0;
    for (const OverTips& sample : surface.over_tips) {
        (std::abs(sample.piece.normal.y) > 0.5 ? ends_m2 : mantle_m2) += sample.piece.area_m2;
        EXPECT_NEAR(std::hypot(sample.root.x, sample.root.z), 0.25, 1e-9);
        EXPECT_NEAR(std::hypot(sample.tip.x, sample.tip.z), 0.27, 1e-9);
        EXPECT_LT(length(sample.tip - sample.root), 0.09) << "no tooth is nearer";
    }
    EXPECT_NEAR(mantle_m2, 2 * std::numbers::pi * 0.27 * 0.2, 1e-6);
    EXPECT_NEAR(ends_m2, 2 * std::numbers::pi * (0.27 * 0.27 - 0.25 * 0.25), 1e-6);
    // Of the wheel itself all but its two discs and the tips and ends of its lugs belongs to the
    // row.
    double faces_m2 = 0, rest_m2 = 0;
    for (const SurfaceSample& sample : surface.samples) {
        double& sum = sample.row < 0                    ? rest_m2
                      : sample.part == ToothPart::tooth ? faces_m2
                                                        : between_m2;
        sum += sample.area_m2;
        EXPECT_NE(sample.part, ToothPart::over_tips);
    }
    constexpr double kTipsM2 = 12 * 0.01 * 0.2, kEndsM2 = 24 * 0.01 * 0.02;
    EXPECT_NEAR(rest_m2, 2 * std::numbers::pi * 0.25 * 0.25 + kTipsM2 + kEndsM2, 0.005);
    EXPECT_NEAR(faces_m2, 24 * 0.02 * 0.2, 0.005);
    EXPECT_NEAR(between_m2, 2 * std::numbers::pi * 0.25 * 0.2 - kTipsM2, 0.005);
}

}  // namespace
}  // namespace bsoil::tooth_rows_test
