/// Several materials in one surface, blended by their shares.
#include <array>
#include <cmath>
#include <limits>

#include "render_fixture.h"

namespace bsoil::render::mixed_surface_test {
namespace {

using Color = std::array<float, 3>;

const std::vector<Color> kPalette{
    {0.6f, 0.1f, 0.1f}, {0.1f, 0.5f, 0.1f}, {0.1f, 0.1f, 0.6f}, {0.8f, 0.8f, 0.8f}};
constexpr MaterialWeights kWeights{102, 76, 51, 26};  // 40, 30, 20 and 10 %

/// A square before the eye that shows the colours of its own.
Mesh square(const MaterialWeights& weights) {
    Mesh mesh = triangle_mesh(
        {{{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}}, {{0, 1, 2}, {0, 2, 3}}}, {1, 1, 1});
    float sum = 0;
    Color mean{};
    for (size_t m = 0; m < kPalette.size(); ++m) {
        sum += weights[m];
        for (size_t c = 0; c < 3; ++c) mean[c] += weights[m] * kPalette[m][c];
    }
    mesh.palette = kPalette;
    mesh.weights.assign(mesh.vertex_count(), weights);
    for (size_t i = 0; i < mesh.colors.size(); ++i) mesh.colors[i] = mean[i % 3] / sum;
    return mesh;
}

View view_of(MeshId mesh, float grain_m) {
    View view = front_view();
    view.items = {item_of(mesh, {})};
    view.items[0].grain_m = grain_m;
    view.items[0].emission = 1;
    return view;
}

/// Share of the picture that is nearest to each colour of the palette.
std::vector<double> areas(const Image& image) {
    std::vector<double> counts(kPalette.size());
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            size_t nearest = 0;
            double least = std::numeric_limits<double>::infinity();
            for (size_t m = 0; m < kPalette.size(); ++m) {
                double away = 0;
                for (size_t c = 0; c < 3; ++c) {
                    const double seen = std::pow(image.pixel(x, y)[c] / 255.0, 2.2);
                    away += std::pow(seen - static_cast<double>(kPalette[m][c]), 2);
                }
                if (away < least) nearest = m;
                least = std::min(least, away);
            }
            counts[nearest] += 1.0 / (image.width * image.height);
        }
    }
    return counts;
}

TEST_F(Render, four_materials_take_their_shares_of_a_surface) {
    // 5 cm grains: about a thousand lumps are seen. The share of one in ten then has a standard
    // deviation of 0.01, that of two in five 0.016.
    const Image image = draw(view_of(renderer_->add_mesh(square(kWeights)), 0.05f));
    const std::vector<double> seen = areas(image);
    const double shares[] = {0.4, 0.3, 0.2, 0.1};
    for (size_t m = 0; m < 4; ++m) EXPECT_NEAR(seen[m], shares[m], 0.05) << "material " << m;
}

TEST_F(Render, from_afar_a_mixture_has_the_mean_of_its_colours) {
    // 1 mm grains, where a pixel is a centimetre wide.
    const Mesh mixed = square(kWeights);
    const Image image = draw(view_of(renderer_->add_mesh(mixed), 0.001f));
    for (size_t c = 0; c < 3; ++c) {
        const int mean = static_cast<int>(
            std::lround(255 * std::pow(static_cast<double>(mixed.colors[c]), 1 / 2.2)));
        for (const int x : {10, 160, 310}) EXPECT_NEAR(image.pixel(x, 100)[c], mean, 2);
    }
}

TEST_F(Render, a_material_alone_looks_as_if_there_were_no_others) {
    const Mesh alone = square({0, 0, 255});
    Mesh plain = alone;
    plain.weights.clear();
    plain.palette.clear();
    EXPECT_EQ(draw(view_of(renderer_->add_mesh(alone), 0.05f)).rgba,
              draw(view_of(renderer_->add_mesh(plain), 0.05f)).rgba);
}

TEST_F(Render, materials_beyond_the_fourth_take_their_shares_too) {
    Mesh mesh = square(kWeights);
    mesh.palette.insert(mesh.palette.begin(), 4, Color{0, 0, 0});
    mesh.weights.assign(mesh.vertex_count(), {0, 0, 0, 0, 102, 76, 51, 26});
    const std::vector<double> seen = areas(draw(view_of(renderer_->add_mesh(mesh), 0.05f)));
    EXPECT_NEAR(seen[0], 0.4, 0.05);
    EXPECT_NEAR(seen[3], 0.1, 0.05);
}

}  // namespace
}  // namespace bsoil::render::mixed_surface_test
