#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <utility>

#include "bsoil/surface_mesh.h"

namespace bsoil {
namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

Error cannot_write(const std::string& path) {
    return {"cannot write " + path + "; check its folder and the disk"};
}

/// Buffered output may fail as late as at closing.
Status close_checked(File file, const std::string& path) {
    const bool failed = std::ferror(file.get()) != 0;
    if (std::fclose(file.release()) != 0 || failed) return cannot_write(path);
    return Done{};
}

/// Numbers as they are written everywhere: printf would take the decimal point of the host's
/// locale.
template <typename... Values>
void put(std::FILE* file, fmt::format_string<const Values&...> text, const Values&... values) {
    fmt::memory_buffer line;
    fmt::format_to(std::back_inserter(line), text, values...);
    std::fwrite(line.data(), 1, line.size(), file);
}

uint8_t to_srgb_byte(float linear) {
    const float c = std::clamp(linear, 0.0f, 1.0f);
    const float encoded = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
    return static_cast<uint8_t>(std::lround(255.0f * encoded));
}

}  // namespace

Status Mesh::validate() const {
    const std::pair<const char*, size_t> lists[] = {
        {"positions", positions.size()}, {"normals", normals.size()}, {"colors", colors.size()}};
    for (const auto& [name, size] : lists) {
        if (size == 3 * vertex_count()) continue;
        return Error{
            fmt::format("Mesh::{} has {} numbers, must have three for each of {} vertices: {}",
                        name, size, vertex_count(), 3 * vertex_count())};
    }
    if (indices.size() % 3 != 0) {
        return Error{
            fmt::format("Mesh::indices has {}, must be three for each triangle", indices.size())};
    }
    if (indices.empty()) return Done{};
    const uint32_t most = *std::max_element(indices.begin(), indices.end());
    if (most < vertex_count()) return Done{};
    return Error{
        fmt::format("Mesh::indices has {}, must be below {}, the vertices", most, vertex_count())};
}

void Mesh::clear() {
    positions.clear();
    normals.clear();
    colors.clear();
    indices.clear();
    weights.clear();
    palette.clear();
    wetness.clear();
}

void Mesh::append(const Mesh& other) {
    if (&other == this) return append(Mesh(other));
    const auto base = static_cast<uint32_t>(vertex_count());
    if (base == 0) palette = other.palette;
    if (palette == other.palette) {
        weights.insert(weights.end(), other.weights.begin(), other.weights.end());
    } else if (!other.positions.empty()) {
        weights.clear();
        palette.clear();
    }
    if (!wetness.empty() || !other.wetness.empty()) {
        wetness.resize(base, 0);
        wetness.insert(wetness.end(), other.wetness.begin(), other.wetness.end());
        wetness.resize(base + other.vertex_count(), 0);
    }
    positions.insert(positions.end(), other.positions.begin(), other.positions.end());
    normals.insert(normals.end(), other.normals.begin(), other.normals.end());
    colors.insert(colors.end(), other.colors.begin(), other.colors.end());
    for (const uint32_t index : other.indices) indices.push_back(base + index);
}

Status write_obj(const Mesh& mesh, const std::string& path) {
    if (Status valid = mesh.validate(); !valid) return valid;
    File file(std::fopen(path.c_str(), "wb"));
    if (!file) return cannot_write(path);
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const float* p = &mesh.positions[3 * v];
        const float* c = &mesh.colors[3 * v];
        put(file.get(), "v {} {} {} {:.4g} {:.4g} {:.4g}\n", p[0], p[1], p[2], c[0], c[1], c[2]);
    }
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const float* n = &mesh.normals[3 * v];
        put(file.get(), "vn {:.4g} {:.4g} {:.4g}\n", n[0], n[1], n[2]);
    }
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        const uint32_t* i = &mesh.indices[3 * t];  // OBJ counts from one
        put(file.get(), "f {0}//{0} {1}//{1} {2}//{2}\n", i[0] + 1, i[1] + 1, i[2] + 1);
    }
    return close_checked(std::move(file), path);
}

Status write_ply(const Mesh& mesh, const std::string& path) {
    static_assert(std::endian::native == std::endian::little, "vertices are written as they lie");
    if (Status valid = mesh.validate(); !valid) return valid;
    File file(std::fopen(path.c_str(), "wb"));
    if (!file) return cannot_write(path);
    std::fprintf(file.get(),
                 "ply\nformat binary_little_endian 1.0\nelement vertex %zu\n"
                 "property float x\nproperty float y\nproperty float z\n"
                 "property float nx\nproperty float ny\nproperty float nz\n"
                 "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 "element face %zu\nproperty list uchar uint vertex_indices\nend_header\n",
                 mesh.vertex_count(), mesh.triangle_count());
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        uint8_t record[6 * sizeof(float) + 3];
        std::memcpy(record, &mesh.positions[3 * v], 3 * sizeof(float));
        std::memcpy(record + 3 * sizeof(float), &mesh.normals[3 * v], 3 * sizeof(float));
        for (int i = 0; i < 3; ++i) {
            record[6 * sizeof(float) + i] = to_srgb_byte(mesh.colors[3 * v + i]);
        }
        std::fwrite(record, sizeof(record), 1, file.get());
    }
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        uint8_t record[1 + 3 * sizeof(uint32_t)] = {3};
        std::memcpy(record + 1, &mesh.indices[3 * t], 3 * sizeof(uint32_t));
        std::fwrite(record, sizeof(record), 1, file.get());
    }
    return close_checked(std::move(file), path);
}

}  // namespace bsoil
