#include "targets.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "frame.h"

namespace bsoil::render {
namespace {

constexpr uint32_t kSumsInBin = 16;  ///< of the blend map: finer than its eight bits

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

GlTexture3D create_blend_map() {
    constexpr int kSide = kBlendTexels, kCount = kSide * kSide * kSide, kChannels = 4;
    constexpr double kMost = 6;  // a time in 400 is longer
    std::mt19937 random(86);     // any fixed seed
    std::vector<uint8_t> texels(kChannels * kCount);
    std::vector<uint32_t> values(kCount), sums(kCount);
    for (int channel = 0; channel < kChannels; ++channel) {
        for (uint32_t& value : values) value = static_cast<uint32_t>(random()) >> 23;
        // Twice the sum of three texels along each axis: smooth over five. At most 512 * 3^6.
        for (const int stride : {1, 1, kSide, kSide, kSide * kSide, kSide * kSide}) {
            for (int t = 0; t < kCount; ++t) {
                const int at = t / stride % kSide;
                sums[t] = values[t] + values[at == 0 ? t + (kSide - 1) * stride : t - stride] +
                          values[at == kSide - 1 ? t - (kSide - 1) * stride : t + stride];
            }
            std::swap(values, sums);
        }
        // As evenly spread as ranks are, and from there to times.
        std::vector<uint32_t> ranks(512 * 729 / kSumsInBin + 1, 0);
        for (const uint32_t value : values) ++ranks[value / kSumsInBin];
        uint32_t below = 0;
        for (uint32_t& rank : ranks) rank = (below += rank) - rank / 2;
        for (int t = 0; t < kCount; ++t) {
            const double share = (ranks[values[t] / kSumsInBin] + 0.5) / (kCount + 1);
            const double time = -std::log(share) / kMost;
            texels[kChannels * t + channel] =
                static_cast<uint8_t>(std::lround(255 * std::min(1.0, time)));
        }
    }
    GlTexture3D texture("blend map");
    glBindTexture(GL_TEXTURE_3D, texture.name());
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, kSide, kSide, kSide, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 texels.data());
    glGenerateMipmap(GL_TEXTURE_3D);
    set_filter(GL_TEXTURE_3D, GL_LINEAR, GL_REPEAT);
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
