#include "bsoil/render/image.h"

#include <fstream>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace bsoil::render {

Status write_png(const Image& image, const std::string& path) {
    if (image.width <= 0 || image.height <= 0) return Error{"no picture to write to " + path};
    std::vector<char> bytes;
    const auto append = [](void* to, void* data, int size) {
        auto& all = *static_cast<std::vector<char>*>(to);
        const char* first = static_cast<const char*>(data);
        all.insert(all.end(), first, first + size);
    };
    // Written by us and not by stb, which does not look whether the disk took it all.
    std::ofstream file(path, std::ios::binary);
    if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.rgba.data(),
                               4 * image.width) == 0) {
        return Error{"no memory for the picture " + path};
    }
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) return Error{path + ": cannot be written whole; is the disk full?"};
    return Done{};
}

}  // namespace bsoil::render
