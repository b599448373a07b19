#include "bsoil/render/image.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace bsoil::render {

Status write_png(const Image& image, const std::string& path) {
    if (image.width <= 0 || image.height <= 0) return Error{"no picture to write to " + path};
    if (stbi_write_png(path.c_str(), image.width, image.height, 4, image.rgba.data(),
                       4 * image.width) == 0) {
        return Error{"cannot write " + path};
    }
    return Done{};
}

}  // namespace bsoil::render
