#include "targets.h"

#include <cstdint>
#include <random>
#include <vector>

#include "frame.h"

namespace bsoil::render {
namespace {

/// A texture without values, attached to the bound framebuffer.
GlTexture2D attach(const char* label, GLenum attachment, int width, int height, GLint format,
                   GLint filter) {
    GlTexture2D texture(label);
    glBindTexture(GL_TEXTURE_2D, texture.name());
    const bool is_depth = attachment == GL_DEPTH_ATTACHMENT;
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0,
                 is_depth ? GL_DEPTH_COMPONENT : GL_RGBA, is_depth ? GL_FLOAT : GL_UNSIGNED_BYTE,
                 nullptr);
    set_filter(GL_TEXTURE_2D, filter, GL_CLAMP_TO_EDGE);
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture.name(), 0);
    return texture;
}

Target create_target(const char* label, int width, int height) {
    Target target{GlFramebuffer(label), {}, {}, {}, width, height};
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.name());
    return target;
}

}  // namespace

void set_filter(GLenum target, GLint filter, GLint wrap) {
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, wrap);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, wrap);
}

void Target::bind() const {
    glViewport(0, 0, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
}

Target create_depth_target(const char* label, int width, int height) {
    Target target = create_target(label, width, height);
    target.depth =
        attach(label, GL_DEPTH_ATTACHMENT, width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    return target;
}

Target create_color_target(const char* label, int width, int height, GLint format) {
    Target target = create_target(label, width, height);
    target.color = attach(label, GL_COLOR_ATTACHMENT0, width, height, format, GL_LINEAR);
    return target;
}

Target create_surface_target(const char* label, int width, int height) {
    Target target = create_target(label, width, height);
    target.color = attach(label, GL_COLOR_ATTACHMENT0, width, height, GL_RGBA8, GL_NEAREST);
    target.more = attach(label, GL_COLOR_ATTACHMENT1, width, height, GL_RG16, GL_NEAREST);
    target.depth =
        attach(label, GL_DEPTH_ATTACHMENT, width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, attachments);
    return target;
}

Target create_lit_target(const char* label, int width, int height) {
    Target target = create_color_target(label, width, height, GL_RGBA8);
    target.depth =
        attach(label, GL_DEPTH_ATTACHMENT, width, height, GL_DEPTH_COMPONENT32F, GL_NEAREST);
    return target;
}

void copy_depth(const Target& from, const Target& to) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer.name());
    glBlitFramebuffer(0, 0, from.width, from.height, 0, 0, to.width, to.height, GL_DEPTH_BUFFER_BIT,
                      GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, to.framebuffer.name());
}

GlTexture3D create_grains() {
    std::mt19937 random(20);  // any fixed seed: pictures of one scene are equal
    std::vector<uint8_t> texels(4 * kGrainPeriod * kGrainPeriod * kGrainPeriod);
    for (uint8_t& value : texels) value = static_cast<uint8_t>(random() >> 24);
    GlTexture3D texture("grains");
    glBindTexture(GL_TEXTURE_3D, texture.name());
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, kGrainPeriod, kGrainPeriod, kGrainPeriod, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, texels.data());
    glGenerateMipmap(GL_TEXTURE_3D);
    set_filter(GL_TEXTURE_3D, GL_LINEAR, GL_REPEAT);
    // Between levels nothing is mixed: no border is seen in a noise, and half the texels are read.
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_REPEAT);
    return texture;
}

void fill_table(GLsizei width, std::span<const float> values) {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width,
                 static_cast<GLsizei>(values.size() / 4) / width, 0, GL_RGBA, GL_FLOAT,
                 values.data());
    set_filter(GL_TEXTURE_2D, GL_NEAREST, GL_CLAMP_TO_EDGE);
}

}  // namespace bsoil::render
