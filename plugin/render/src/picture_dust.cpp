/// Dust over what else a picture shows.
#include <cmath>

#include "picture.h"
#include "uniforms.h"

namespace bsoil::render {
namespace {

/// Pixels of the picture to one of dust, along a side: dust is soft.
constexpr int kDustPixel = 2;

/// Leaves out what is not in the bounds, -1..1.
void set_scissor(const Target& target, const glm::vec4& bounds) {
    const auto pixel = [](float at, int size) {
        return static_cast<int>(std::floor((0.5 + 0.5 * static_cast<double>(at)) * size));
    };
    const int x = pixel(bounds.x, target.width) - 1, y = pixel(bounds.y, target.height) - 1;
    glScissor(x, y, pixel(bounds.z, target.width) + 3 - x, pixel(bounds.w, target.height) + 3 - y);
}

}  // namespace

void Picture::draw_dust(const View& view, const Frame& f) {
    dust_layer_.fill(view, f);
    if (dust_layer_.is_empty()) return;
    const int width = (width_ + kDustPixel - 1) / kDustPixel,
              height = (height_ + kDustPixel - 1) / kDustPixel;
    if (dusty_.width != width || dusty_.height != height) {
        dusty_ = create_color_target("dust", width, height, GL_RGBA16F);
    }
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    dusty_.bind();
    set_scissor(dusty_, dust_layer_.bounds());
    const GLfloat nothing[4] = {0, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, nothing);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const Uniforms uniforms(dust_);
    uniforms.set("clip", f.clip);
    const glm::mat3 to_world = glm::transpose(glm::mat3(f.look));
    uniforms.set("aside", to_world[0]);
    uniforms.set("above", to_world[1]);
    uniforms.set("sight", -to_world[2]);
    uniforms.set_unit("depth", kDepthUnit);
    uniforms.set_unit("grains", kGrainUnit);
    bind_texture(kDepthUnit, GL_TEXTURE_2D, seen_.depth);
    bind_texture(kGrainUnit, GL_TEXTURE_3D, grains_);
    uniforms.set("depth_texels", kDustPixel * samples_aside_);
    uniforms.set("depth_to_distance", f.depth_to_distance());
    dust_layer_.draw();

    lit_.bind();
    set_scissor(lit_, dust_layer_.bounds());
    const Uniforms veil_uniforms(veil_);
    veil_uniforms.set_unit("veil", kColorUnit);
    bind_texture(kColorUnit, GL_TEXTURE_2D, dusty_.color);
    // The picture's alpha is a number of its faces.
    glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    draw_screen();
    glBlendFunc(GL_ONE, GL_ZERO);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
}

}  // namespace bsoil::render
