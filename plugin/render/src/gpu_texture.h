/// A texture on the device.
#pragma once

#include <epoxy/gl.h>

#include "bsoil/render/renderer.h"
#include "gl_objects.h"

namespace bsoil::render {

struct GpuTexture {
    GlTexture2D pixels;
    bool used = false;

    /// Copies the pixels to the device. The error says what it has no room for.
    Status fill(const TextureData& source);
};

}  // namespace bsoil::render
