/// Reads on in bytes, never beyond them.
#pragma once

#include <cstring>
#include <string_view>

namespace bsoil::scene {

/// What is asked for beyond the end is zero or empty, and good() is false from then on.
class ByteCursor {
  public:
    explicit ByteCursor(std::string_view bytes) : bytes_(bytes) {}
    bool good() const { return good_; }
    bool at_end() const { return at_ == bytes_.size(); }
    size_t at() const { return at_; }
    template <typename T>
    T get() {
        T value{};
        const std::string_view raw = get(sizeof(T));
        if (good_) std::memcpy(&value, raw.data(), sizeof(T));
        return value;
    }
    std::string_view get(size_t size) {
        if (!good_ || size > bytes_.size() - at_) {
            good_ = false;
            return {};
        }
        at_ += size;
        return bytes_.substr(at_ - size, size);
    }
    void expect(std::string_view tag) { good_ = get(tag.size()) == tag && good_; }
    /// Up to a zero, which is skipped.
    std::string_view get_text() {
        const size_t end = bytes_.find('\0', at_);
        if (end == std::string_view::npos) good_ = false;
        if (!good_) return {};
        const size_t begin = at_;
        at_ = end + 1;
        return bytes_.substr(begin, end - begin);
    }
    /// To the next multiple of four.
    void align() { get((4 - at_ % 4) % 4); }

  private:
    std::string_view bytes_;
    size_t at_ = 0;
    bool good_ = true;
};

}  // namespace bsoil::scene
