/// Textures on meshes, looked for in the picture.
#include <algorithm>
#include <array>
#include <cmath>

#include "render_fixture.h"

namespace bsoil::render::texture_test {
namespace {

using Rgb = std::array<int, 3>;
constexpr Rgb kRed{200, 60, 40}, kGreen{60, 200, 40}, kBlue{40, 60, 200}, kYellow{220, 200, 40};
/// Of 255: the picture keeps square roots of colours in 8 bits on its way.
constexpr int kTolerance = 4;

/// Four fields: blue and yellow above, red and green below.
TextureData four_fields(int side) {
    TextureData data{side, side, {}};
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const bool is_right = 2 * x >= side, is_lower = 2 * y >= side;
            const Rgb& c = is_lower ? (is_right ? kGreen : kRed) : (is_right ? kYellow : kBlue);
            for (const int v : c) data.rgba.push_back(static_cast<uint8_t>(v));
            data.rgba.push_back(255);
        }
    }
    return data;
}

/// A square of 2 m that faces the camera of front_view(), linear grey 0.2 where it has no texture.
Mesh square() {
    return triangle_mesh({{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}},
                         {0.2f, 0.2f, 0.2f});
}
constexpr Rgb kGrey{124, 124, 124};  // 0.2 as sRGB

/// The texture `count` times along each side.
Skin skin_of(TextureId texture, float count = 1) {
    return {{0, 0, count, 0, count, count, 0, 0, count, count, 0, count}, {{texture, 0, 6}}};
}

class Texture : public Render {
  protected:
    /// Shown in its own colours, whatever the light.
    Image shown(MeshId mesh) {
        View view = front_view();
        view.items = {item_of(mesh, {})};
        view.items[0].emission = 1;
        return draw(view);
    }
    TextureId add(const TextureData& data) {
        const auto added = renderer_->add_texture(data);
        EXPECT_TRUE(added) << added.error();
        return added ? *added : TextureId{};
    }
    static void expect_color(const Image& image, int x, int y, const Rgb& expected) {
        const uint8_t* found = image.pixel(x, y);
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(found[c], expected[c], kTolerance)
                << "channel " << c << " at " << x << ", " << y;
        }
    }
};

// 1 m is 80 pixels; the square's middle is at 160, 100.
TEST_F(Texture, lies_upright_and_in_its_own_colours) {
    const Image image = shown(renderer_->add_mesh(square(), skin_of(add(four_fields(64)))));
    expect_color(image, 120, 140, kRed);
    expect_color(image, 200, 140, kGreen);
    expect_color(image, 120, 60, kBlue);
    expect_color(image, 200, 60, kYellow);
}

TEST_F(Texture, goes_on_and_is_smooth_where_it_is_far_finer_than_a_pixel) {
    const TextureId id = add(four_fields(64));
    const Image twice = shown(renderer_->add_mesh(square(), skin_of(id, 2)));
    for (const int x : {100, 180}) {
        for (const int y : {40, 120}) {
            expect_color(twice, x, y + 40, kRed);
            expect_color(twice, x + 40, y + 40, kGreen);
            expect_color(twice, x, y, kBlue);
            expect_color(twice, x + 40, y, kYellow);
        }
    }
    // 500 times: the mean of the four, by their linear light.
    const auto linear = [](int v) {
        const double s = v / 255.0;
        return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    };
    Rgb mean{};
    for (size_t c = 0; c < 3; ++c) {
        const double light =
            (linear(kRed[c]) + linear(kGreen[c]) + linear(kBlue[c]) + linear(kYellow[c])) / 4;
        mean[c] = static_cast<int>(std::lround(255 * (1.055 * std::pow(light, 1 / 2.4) - 0.055)));
    }
    const Image fine = shown(renderer_->add_mesh(square(), skin_of(id, 500)));
    for (const int x : {101, 133, 160, 199}) expect_color(fine, x, x - 40, mean);
}

TEST_F(Texture, beside_it_and_without_it_the_colours_show) {
    const TextureId id = add(four_fields(64));
    Skin half = skin_of(id);
    half.parts = {{id, 3, 3}};  // the upper left triangle
    const MeshId mesh = renderer_->add_mesh(square(), half);
    Image image = shown(mesh);
    expect_color(image, 120, 60, kBlue);
    expect_color(image, 200, 140, kGrey);

    for (const Skin& wrong :
         {Skin{{0, 0}, {{id, 0, 6}}}, Skin{skin_of(id).places, {}}, skin_of({77}), skin_of({})}) {
        image = shown(renderer_->add_mesh(square(), wrong));
        expect_color(image, 120, 60, kGrey);
        expect_color(image, 200, 140, kGrey);
    }
    // Parts beyond the indices, or on each other.
    Skin beyond = skin_of(id);
    beyond.parts = {{id, 0, 4'000'000'000}, {id, 3, 3}, {id, 4'000'000'000, 9}};
    expect_color(shown(renderer_->add_mesh(square(), beyond)), 120, 60, kBlue);

    renderer_->set_mesh(mesh, square());
    expect_color(shown(mesh), 120, 60, kGrey);
    const MeshId whole = renderer_->add_mesh(square(), skin_of(id));
    renderer_->remove_texture(id);
    expect_color(shown(whole), 120, 60, kGrey);
}

TEST_F(Texture, of_a_wrong_size_is_refused) {
    for (const TextureData& wrong :
         {TextureData{0, 4, {}}, TextureData{4, 9000, {}}, TextureData{2, 2, {1, 2, 3}}}) {
        EXPECT_FALSE(renderer_->add_texture(wrong));
    }
}

}  // namespace
}  // namespace bsoil::render::texture_test
