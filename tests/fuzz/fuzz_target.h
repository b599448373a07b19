/// What the fuzz targets share. A target is a function of bytes that may fail in no other way than
/// by an error it gets from the library: a crash, an exception, a sanitizer's report or fail() is a
/// finding.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bsoil::fuzz {

using Bytes = std::span<const uint8_t>;

/// One reader, or one interface, under the bytes of somebody else.
struct Target {
    const char* name;
    void (*run)(Bytes);
};

/// All of them.
std::span<const Target> targets();

/// Ends the program: something the library promises does not hold.
[[noreturn]] void fail(const std::string& what);
inline void require(bool holds, const char* what) {
    if (!holds) fail(what);
}

/// Bytes as a sequence of choices; zeros once they are used up.
class Choices {
  public:
    explicit Choices(Bytes bytes) : bytes_(bytes) {}
    bool at_end() const { return at_ >= bytes_.size(); }
    uint64_t word(size_t byte_count);
    /// 0 .. count - 1.
    int below(int count) { return static_cast<int>(word(count > 256 ? 2 : 1) % unsigned(count)); }
    bool flag() { return (word(1) & 1) != 0; }
    /// Mostly a number within the range, now and then one that no reader can want.
    double number(double min, double max);
    Bytes rest() const { return bytes_.subspan(at_); }

  private:
    Bytes bytes_;
    size_t at_ = 0;
};

/// Calls an interface as the bytes choose.
template <typename Caller>
void run_calls(Bytes bytes) {
    Choices choices(bytes);
    Caller(choices).run();
}

/// Makes a few changes to bytes, as the choices say: numbers overwritten, bytes put in, left out,
/// repeated.
void edit(std::vector<uint8_t>& bytes, Choices& choices);

/// A file of this run alone, gone with it, in memory where the system has such a folder.
std::string scratch_path(const std::string& name);
/// Writes it.
std::string scratch_file(const std::string& name, Bytes bytes);
/// Its bytes.
std::vector<uint8_t> read_scratch(const std::string& path);
inline Bytes bytes_of(std::string_view text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}
inline std::string text_of(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace bsoil::fuzz
