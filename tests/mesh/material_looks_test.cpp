/// Soils are told apart by their looks.
#include <array>
#include <cmath>
#include <vector>

#include "bsoil/material.h"
#include "mesh_checks.h"
#include "render_fixture.h"

namespace bsoil::render::material_looks_test {
namespace {

/// CIELAB of a linear RGB colour, by daylight. A distance of 2.3 is just noticed.
std::array<double, 3> lab_of(double r, double g, double b) {
    const auto root = [](double t) {
        return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    };
    const double x = root((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505),
                 y = root(0.2126 * r + 0.7152 * g + 0.0722 * b),
                 z = root((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
double apart(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
double linear(double srgb) {
    const double s = srgb / 255;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// By hand from the table's colours: sand and sandy loam 34, sandy loam and loam 17; the nearest are
// clay and sandy loam, 12.
TEST(MaterialLooks, built_in_materials_differ_in_colour) {
    const auto all = materials::all();
    const auto lab = [](const MaterialDef& m) {
        return lab_of(m.color[0], m.color[1], m.color[2]);
    };
    for (size_t i = 0; i < all.size(); ++i) {
        for (size_t k = 0; k < i; ++k) {
            EXPECT_GT(apart(lab(all[i]), lab(all[k])), 10) << all[i].name << ", " << all[k].name;
        }
    }
}

// With light, grains and tone of a picture.
TEST_F(Render, sand_sandy_loam_and_loam_are_told_apart_on_a_picture) {
    std::vector<std::array<double, 3>> seen;
    for (const MaterialDef& material :
         {materials::dry_sand(), materials::sandy_loam(), materials::loam()}) {
        View view = front_view();
        view.items = {
            item_of(renderer_->add_mesh(triangle_mesh(
                        {{{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}}, {{0, 1, 2}, {0, 2, 3}}},
                        {material.color[0], material.color[1], material.color[2]})),
                    {})};
        view.items[0].grain_m = 0.02f;
        const Image image = draw(view);
        double rgb[3] = {};
        for (int y = 50; y < 150; ++y) {
            for (int x = 100; x < 220; ++x) {
                for (int c = 0; c < 3; ++c) rgb[c] += linear(image.pixel(x, y)[c]) / (100 * 120);
            }
        }
        seen.push_back(lab_of(rgb[0], rgb[1], rgb[2]));
    }
    ASSERT_EQ(seen.size(), 3u);
    EXPECT_GT(apart(seen[0], seen[1]), 20);
    EXPECT_GT(apart(seen[1], seen[2]), 10);
    EXPECT_GT(apart(seen[0], seen[2]), 20);
}

}  // namespace
}  // namespace bsoil::render::material_looks_test
