/// Textures on the device, and the pass that draws what has them.
#include <algorithm>
#include <string>

#include "picture.h"
#include "targets.h"
#include "uniforms.h"

namespace bsoil::render {
namespace {

constexpr int kTextureSideMax = 8192;

}  // namespace

Status TextureData::validate() const {
    for (const int side : {width, height}) {
        if (side < 1 || side > kTextureSideMax) {
            return Error{"TextureData: " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, each side must be in 1..8192"};
        }
    }
    const size_t bytes = size_t{4} * static_cast<size_t>(width) * static_cast<size_t>(height);
    if (rgba.size() != bytes) {
        return Error{"TextureData::rgba has " + std::to_string(rgba.size()) +
                     " bytes; must be four for each pixel, " + std::to_string(bytes)};
    }
    return Done{};
}

Status GpuTexture::fill(const TextureData& source) {
    GLint side_max = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max);
    if (std::max(source.width, source.height) > side_max) {
        return Error{"TextureData: OpenGL takes textures of at most " + std::to_string(side_max) +
                     " pixels a side here"};
    }
    while (glGetError() != GL_NO_ERROR) {
    }
    pixels = GlTexture2D("texture");
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(kSkinUnit));
    glBindTexture(GL_TEXTURE_2D, pixels.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, source.width, source.height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, source.rgba.data());
    glGenerateMipmap(GL_TEXTURE_2D);
    set_filter(GL_TEXTURE_2D, GL_LINEAR, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glBindTexture(GL_TEXTURE_2D, 0);
    glActiveTexture(GL_TEXTURE0);
    used = glGetError() == GL_NO_ERROR;
    if (used) return Done{};
    pixels = {};
    return Error{"TextureData: OpenGL has no room for it; take a smaller one"};
}

/// Meshes with textures, in runs of triangles with one texture each.
void Picture::draw_textured(const Frame& f) {
    const Uniforms uniforms(textured_);
    uniforms.set("clip", f.clip);
    uniforms.set_unit("skin", kSkinUnit);
    const GLint material = uniforms.at("material"), is_skinned = uniforms.at("is_skinned");
    for (const Placed& placed : f.items) {
        if (!placed.is_textured()) continue;
        glUniform1f(material, static_cast<float>(placed.material) / 255);
        uniforms.draw_seen(placed, f.cut, [&] {
            for (const Skin::Part& part : placed.mesh->parts) {
                const size_t id = part.texture.value;
                const bool is_there = id > 0 && id <= textures_.size() && textures_[id - 1].used;
                glUniform1f(is_skinned, is_there ? 1.0f : 0.0f);
                if (is_there) bind_texture(kSkinUnit, GL_TEXTURE_2D, textures_[id - 1].pixels);
                placed.mesh->draw(part.index_begin, part.index_count);
            }
        });
    }
}

}  // namespace bsoil::render
