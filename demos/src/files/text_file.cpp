#include "text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

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

Status replace_file(const std::string& path, const std::string& bytes) {
    std::error_code failed;
    // Of a link, what it leads to.
    const std::string target = std::filesystem::weakly_canonical(path, failed).string();
    const std::string part = (failed ? path : target) + ".part";
    const Status written = write_file(part, bytes);
    if (written) std::filesystem::rename(part, failed ? path : target, failed);
    if (written && !failed) return Done{};
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    if (!written) return written;
    return Error{path + ": cannot be replaced (" + failed.message() + "); check its folder"};
}

}  // namespace bsoil::scene
