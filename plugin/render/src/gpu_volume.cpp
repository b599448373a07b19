#include "gpu_volume.h"

#include <algorithm>
#include <string>
#include <vector>

#include "targets.h"

namespace bsoil::render {
namespace {

constexpr int kBlockSide = 8;  ///< as in march.frag

void upload(const GlTexture3D& texture, GLint format, const int size[3], GLenum parts,
            const uint8_t* texels, GLint filter) {
    glBindTexture(GL_TEXTURE_3D, texture.name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage3D(GL_TEXTURE_3D, 0, format, size[0], size[1], size[2], 0, parts, GL_UNSIGNED_BYTE,
                 texels);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    set_filter(GL_TEXTURE_3D, filter, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    glBindTexture(GL_TEXTURE_3D, 0);
}

}  // namespace

Status GpuVolume::fill(const VolumeData& source) {
    GLint side_max = 0;
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &side_max);
    const int longest = std::max({source.size[0], source.size[1], source.size[2]});
    if (longest > side_max) {
        return Error{"a volume of " + std::to_string(longest) +
                     " voxels along a side is too large for this device, which takes " +
                     std::to_string(side_max) + "; show a part of it"};
    }
    while (glGetError() != GL_NO_ERROR) {
    }
    if (voxels.name() == 0) {
        voxels = GlTexture3D("voxels");
        blocks = GlTexture3D("blocks of voxels");
    }
    used = true;
    std::copy(std::begin(source.size), std::end(source.size), size);
    int block_size[3];
    for (int axis = 0; axis < 3; ++axis) {
        block_size[axis] = (size[axis] + kBlockSide - 1) / kBlockSide;
    }
    std::vector<uint8_t> texels(source.rgba.size());
    std::vector<uint8_t> is_looked_into(static_cast<size_t>(block_size[0]) *
                                        static_cast<size_t>(block_size[1]) *
                                        static_cast<size_t>(block_size[2]));
    const auto look_into = [&](int x, int y, int z) {
        // Between voxels both are seen: a voxel at its block's border is seen from the next one.
        int first[3], last[3];
        const int at[3] = {x, y, z};
        for (int axis = 0; axis < 3; ++axis) {
            first[axis] = std::max(0, at[axis] - 1) / kBlockSide;
            last[axis] = std::min(size[axis] - 1, at[axis] + 1) / kBlockSide;
        }
        for (int k = first[2]; k <= last[2]; ++k) {
            for (int j = first[1]; j <= last[1]; ++j) {
                for (int i = first[0]; i <= last[0]; ++i) {
                    const int block = (k * block_size[1] + j) * block_size[0] + i;
                    is_looked_into[static_cast<size_t>(block)] = 255;
                }
            }
        }
    };
    size_t v = 0;
    for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x, v += 4) {
                const int alpha = source.rgba[v + 3];
                if (alpha == 0) continue;
                for (size_t c = 0; c < 3; ++c) {
                    texels[v + c] = static_cast<uint8_t>((source.rgba[v + c] * alpha + 127) / 255);
                }
                texels[v + 3] = static_cast<uint8_t>(alpha);
                look_into(x, y, z);
            }
        }
    }
    upload(voxels, GL_RGBA8, size, GL_RGBA, texels.data(), GL_LINEAR);
    upload(blocks, GL_R8, block_size, GL_RED, is_looked_into.data(), GL_NEAREST);
    if (glGetError() == GL_NO_ERROR) return Done{};
    *this = {};
    return Error{"the device has no memory for a volume of " + std::to_string(source.rgba.size()) +
                 " bytes; show a part of it"};
}

}  // namespace bsoil::render
