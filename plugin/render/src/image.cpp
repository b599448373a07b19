#include "bsoil/render/image.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace bsoil::render {

namespace {

constexpr int kJpegQuality = 90;
constexpr int kJpegSideMost = 65535;  ///< of the format: 16 bits

void append(void* to, void* data, int size) {
    auto& all = *static_cast<std::vector<char>*>(to);
    const char* first = static_cast<const char*>(data);
    all.insert(all.end(), first, first + size);
}

// Written by us and not by stb, which does not look whether the disk took it all.
Status write_bytes(std::span<const char> bytes, const std::string& path) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) return Error{path + ": cannot be written whole; look whether the disk is full"};
    return Done{};
}

/// stb counts bytes in ints, of rows with one byte more.
bool is_too_large(int width, int height, size_t pixel_bytes) {
    const size_t bytes =
        (pixel_bytes * static_cast<size_t>(width) + 1) * static_cast<size_t>(height);
    return bytes > static_cast<size_t>(std::numeric_limits<int>::max());
}

Status check(const Image& image, const std::string& path) {
    if (image.width <= 0 || image.height <= 0) {
        return Error{path + ": the picture must be at least a pixel wide and high"};
    }
    if (!image.is_whole()) return Error{path + ": the picture must have four bytes a pixel"};
    if (is_too_large(image.width, image.height, 4)) {
        return Error{path + ": more than 2 GiB; take fewer pixels"};
    }
    return Done{};
}

}  // namespace

Status write_png(const Image& image, const std::string& path) {
    if (Status checked = check(image, path); !checked) return checked;
    std::vector<char> bytes;
    if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.rgba.data(),
                               4 * image.width) == 0) {
        return Error{"no memory for the picture " + path + "; take fewer pixels"};
    }
    return write_bytes(bytes, path);
}

Status write_jpeg(const Image& image, const std::string& path) {
    if (Status checked = check(image, path); !checked) return checked;
    if (std::max(image.width, image.height) > kJpegSideMost) {
        return Error{path + ": a JPEG has at most 65535 pixels a side"};
    }
    std::vector<char> bytes;
    if (stbi_write_jpg_to_func(append, &bytes, image.width, image.height, 4, image.rgba.data(),
                               kJpegQuality) == 0) {
        return Error{"no memory for the picture " + path + "; take fewer pixels"};
    }
    return write_bytes(bytes, path);
}

namespace {

void append_big_endian(std::vector<uint8_t>& bytes, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        bytes.push_back(static_cast<uint8_t>(value >> shift));
    }
}

/// A chunk of a PNG file: length, name, content, checksum of name and content.
void append_chunk(std::vector<uint8_t>& bytes, const char (&name)[5],
                  std::span<const uint8_t> content) {
    append_big_endian(bytes, static_cast<uint32_t>(content.size()));
    const size_t first = bytes.size();
    bytes.insert(bytes.end(), name, name + 4);
    bytes.insert(bytes.end(), content.begin(), content.end());
    append_big_endian(bytes,
                      stbiw__crc32(bytes.data() + first, static_cast<int>(bytes.size() - first)));
}

}  // namespace

Status write_grey_png(int width, int height, std::span<const uint16_t> levels,
                      const std::string& path) {
    if (width <= 0 || height <= 0 ||
        levels.size() != static_cast<size_t>(width) * static_cast<size_t>(height)) {
        return Error{path + ": the levels must be width x height, both above zero"};
    }
    if (is_too_large(width, height, sizeof(uint16_t))) {
        return Error{path + ": more than 2 GiB; take fewer pixels"};
    }
    std::vector<uint8_t> header;
    append_big_endian(header, static_cast<uint32_t>(width));
    append_big_endian(header, static_cast<uint32_t>(height));
    header.insert(header.end(), {16, 0, 0, 0, 0});  // 16 bits of grey
    std::vector<uint8_t> rows;
    rows.reserve(levels.size() * 2 + static_cast<size_t>(height));
    for (int y = 0; y < height; ++y) {
        rows.push_back(0);  // no filter
        for (int x = 0; x < width; ++x) {
            const uint16_t level = levels[static_cast<size_t>(y) * width + x];
            rows.push_back(static_cast<uint8_t>(level >> 8));
            rows.push_back(static_cast<uint8_t>(level));
        }
    }
    int packed_size = 0;
    unsigned char* packed =
        stbi_zlib_compress(rows.data(), static_cast<int>(rows.size()), &packed_size, 8);
    if (!packed) return Error{"no memory for the picture " + path + "; take fewer pixels"};
    std::vector<uint8_t> bytes{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    append_chunk(bytes, "IHDR", header);
    append_chunk(bytes, "IDAT", {packed, static_cast<size_t>(packed_size)});
    append_chunk(bytes, "IEND", {});
    STBIW_FREE(packed);
    return write_bytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path);
}

}  // namespace bsoil::render
