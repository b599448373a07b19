/// Textures and framebuffers that passes draw into or read.
#pragma once

#include <epoxy/gl.h>

#include <span>

#include "gl_objects.h"

namespace bsoil::render {

/// A framebuffer with the textures that are drawn into.
struct Target {
    GlFramebuffer framebuffer;
    GlTexture2D color, more, depth;
    int width = 0, height = 0;

    /// Binds it, with a viewport of its size.
    void bind() const;
};

/// A depth texture without colour.
Target create_depth_target(const char* label, int width, int height);
Target create_color_target(const char* label, int width, int height, GLint format);
/// What is seen in each pixel: colour RGBA8, more RG16, depth.
Target create_surface_target(const char* label, int width, int height);
/// Colour RGBA8 and depth, as a surface target has it.
Target create_lit_target(const char* label, int width, int height);
/// Copies the depth of one target into another of its size. Leaves the second bound.
void copy_depth(const Target& from, const Target& to);

/// A volume of grains: smooth random values that repeat; mip levels let far grains fade to their
/// mean.
GlTexture3D create_grains();

/// Texels of the blend map along each axis, which is a period.
inline constexpr int kBlendTexels = 64;
/// Exponentially distributed values of mean 1/6, as far as they go in 0..1, for four materials:
/// smooth over about five texels, and repeating.
GlTexture3D create_blend_map();

/// Filter and wrap of the bound texture.
void set_filter(GLenum target, GLint filter, GLint wrap);

/// Replaces the texels of the bound table, `width` wide, four floats a texel.
void fill_table(GLsizei width, std::span<const float> values);

}  // namespace bsoil::render
