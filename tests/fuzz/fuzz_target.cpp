#include "fuzz_target.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace bsoil::fuzz {
namespace fs = std::filesystem;

namespace {

class ScratchFolder {
  public:
    ScratchFolder() {
        const fs::path memory = "/dev/shm";
        path_ = (fs::is_directory(memory) ? memory : fs::temp_directory_path()) /
                ("bsoil_fuzz_" + std::to_string(getpid()));
        fs::create_directories(path_);
    }
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

}  // namespace

void fail(const std::string& what) {
    std::fprintf(stderr, "FOUND: %s\n", what.c_str());
    std::abort();
}

uint64_t Choices::word(size_t byte_count) {
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count && at_ < bytes_.size(); ++i) {
        value |= uint64_t{bytes_[at_++]} << (8 * i);
    }
    return value;
}

double Choices::number(double min, double max) {
    constexpr double kStrange[] = {std::numeric_limits<double>::quiet_NaN(),
                                   std::numeric_limits<double>::infinity(),
                                   -std::numeric_limits<double>::infinity(),
                                   0,
                                   -0.0,
                                   1e308,
                                   -1e308,
                                   1e-308,
                                   3e9,
                                   -3e9,
                                   1e20,
                                   1e6};
    const uint64_t chosen = word(2);
    if (chosen >= 0xff00) return kStrange[chosen % std::size(kStrange)];
    return min + (max - min) * static_cast<double>(chosen) / 0xfeff;
}

void edit(std::vector<uint8_t>& bytes, Choices& choices) {
    const int count = 1 + choices.below(8);
    for (int i = 0; i < count && !bytes.empty(); ++i) {
        const size_t at = choices.word(4) % bytes.size(), left = bytes.size() - at;
        const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        const auto part = [&](size_t size) { return first + static_cast<std::ptrdiff_t>(size); };
        const int kind = choices.below(8);
        if (kind <= 3) {
            const size_t size = std::min(size_t{1} << kind, left);
            const uint64_t value = choices.word(size);
            std::memcpy(&bytes[at], &value, size);
        } else if (kind == 4) {
            bytes.insert(first, 1 + choices.word(1), static_cast<uint8_t>(choices.word(1)));
        } else if (kind == 5) {
            bytes.erase(first, part(std::min<size_t>(left, 1 + choices.word(1))));
        } else if (kind == 6) {
            const std::vector<uint8_t> copy(first, part(std::min<size_t>(left, choices.word(2))));
            const size_t to = choices.word(4) % bytes.size();
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(to), copy.begin(), copy.end());
        } else {
            bytes[at] ^= static_cast<uint8_t>(1u << choices.below(8));
        }
    }
}

std::string scratch_path(const std::string& name) {
    static const ScratchFolder folder;
    return (folder.path() / name).string();
}

std::string scratch_file(const std::string& name, Bytes bytes) {
    const std::string path = scratch_path(name);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return path;
}

std::vector<uint8_t> read_scratch(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace bsoil::fuzz
