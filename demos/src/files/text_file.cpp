#include "text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>

namespace bsoil::scene {

Result<std::string> read_file(const std::string& path, size_t capacity) {
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
    std::string bytes;
    std::array<char, 65536> part;
    while (file && bytes.size() <= capacity) {
        const size_t count = std::fread(part.data(), 1, part.size(), file.get());
        if (count == 0) break;
        bytes.append(part.data(), count);
    }
    if (!file || std::ferror(file.get())) {
        return Error{path + ": cannot be read; check its name and rights"};
    }
    if (bytes.size() > capacity) {
        return Error{fmt::format("{}: must be at most {} MiB", path, capacity >> 20)};
    }
    return bytes;
}

Status write_file(const std::string& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    if (!file) return Error{path + ": cannot be written; check its folder and the disk"};
    file << bytes;
    file.close();
    if (!file) return Error{path + ": cannot be written whole; look whether the disk is full"};
    return Done{};
}

}  // namespace bsoil::scene
