/// A volume on the device.
#pragma once

#include <epoxy/gl.h>

#include "bsoil/render/renderer.h"
#include "gl_objects.h"

namespace bsoil::render {

struct GpuVolume {
    GlTexture3D voxels;
    GlTexture3D blocks;  ///< of 8 x 8 x 8 voxels: whether a ray has to look into them
    int size[3] = {0, 0, 0};
    bool used = false;

    /// Copies the voxels to the device. The error says what it has no room for.
    Status fill(const VolumeData& source);
};

}  // namespace bsoil::render
