/// A picture in memory.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil::render {

/// Rows from top to bottom, four bytes a pixel: red, green, blue (sRGB), alpha (255).
struct Image {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;

    /// Whether it has pixels, and four bytes for each.
    bool is_whole() const {
        return width > 0 && height > 0 &&
               rgba.size() == 4 * static_cast<size_t>(width) * static_cast<size_t>(height);
    }
    /// The four bytes of a pixel within the picture.
    /// @{
    uint8_t* pixel(int x, int y) { return &rgba[4 * (static_cast<size_t>(y) * width + x)]; }
    const uint8_t* pixel(int x, int y) const {
        return &rgba[4 * (static_cast<size_t>(y) * width + x)];
    }
    /// @}
};

/// Writes a PNG file of a whole picture, up to 2 GiB of pixels. The error names the file.
Status write_png(const Image& image, const std::string& path);

/// Writes a JPEG file of good quality (90 of 100): a tenth of a PNG where soil has grains. No side
/// may have more than 65535 pixels; else as write_png().
Status write_jpeg(const Image& image, const std::string& path);

/// Writes a PNG file of 16 bits of grey: heights, depths, labels. Levels row by row from the top,
/// up to 2 GiB of them. The error names the file.
Status write_grey_png(int width, int height, std::span<const uint16_t> levels,
                      const std::string& path);

}  // namespace bsoil::render
#pragma GCC visibility pop
