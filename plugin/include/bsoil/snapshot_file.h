/// Snapshot files: named sections of bytes, each compressed and checksummed, and the stream that
/// states are written to and read from. Used by Soil, by the bridge and by hosts that keep a state
/// of their own in the same file.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What helps where a snapshot is damaged; stands behind what is wrong with it.
inline constexpr char kTakeAnotherCopy[] = "; take another copy of it, or an earlier one";

/// Writes or reads values one after the other, so that one function lists the fields of a state for
/// both ways. Whatever is wrong with the bytes (too few, a number that is not finite, a count they
/// cannot hold) makes good() false and stays; what was read is then to be thrown away. Nothing is
/// allocated beyond a small multiple of the bytes there are.
class StateStream {
  public:
    StateStream() = default;  ///< writes
    /// Reads; the bytes must outlive the stream.
    explicit StateStream(std::span<const uint8_t> bytes) : reads_(true), in_(bytes) {}

    bool reads() const { return reads_; }  ///< else it writes
    bool good() const { return good_; }    ///< whether all was well so far
    /// Whether every byte has been read and all was well.
    bool at_end() const { return good_ && at_ == in_.size(); }
    /// From now on NaN and infinity are numbers like others.
    void accept_non_finite() { accepts_non_finite_ = true; }
    /// For a value that is out of its range.
    void refuse() { good_ = false; }
    /// What was written.
    const std::vector<uint8_t>& bytes() const { return out_; }
    /// Writes or reads each value: numbers, texts, vectors of integers, geometry.
    template <typename... T>
    void operator()(T&... values) {
        (value(values), ...);
    }
    /// An enumeration whose values are 0 .. last.
    template <typename Enum>
    void choice(Enum& value, Enum last) {
        int32_t number = static_cast<int32_t>(value);
        (*this)(number);
        if (number < 0 || number > static_cast<int32_t>(last)) return refuse();
        value = static_cast<Enum>(number);
    }
    /// Number of items that follow, each of which takes at least `item_bytes` (1 or more).
    size_t count(size_t wanted, size_t item_bytes) {
        uint64_t number = wanted;
        (*this)(number);
        if (reads_ && number > (in_.size() - at_) / item_bytes) refuse();
        return good_ ? static_cast<size_t>(number) : 0;
    }
    /// A vector of anything that `each` lists; an item takes at least `item_bytes`.
    template <typename T, typename Each>
    void list(std::vector<T>& items, size_t item_bytes, const Each& each) {
        const size_t size = count(items.size(), item_bytes);
        if (reads_) items.clear();
        for (size_t i = 0; i < size && good_; ++i) {
            if (reads_) items.emplace_back();
            each(items[i]);
        }
    }

  private:
    void raw(void* data, size_t size) {
        if (reads_) {
            if (!good_ || size > in_.size() - at_) return refuse();
            if (size > 0) std::memcpy(data, in_.data() + at_, size);
            at_ += size;
        } else {
            const auto* bytes = static_cast<const uint8_t*>(data);
            out_.insert(out_.end(), bytes, bytes + size);
        }
    }
    template <typename T>
    requires std::is_arithmetic_v<T>
    void value(T& number) {
        if constexpr (std::is_same_v<T, bool>) {
            uint8_t byte = number ? 1 : 0;
            raw(&byte, 1);
            if (byte > 1) refuse();
            number = byte == 1;
        } else {
            raw(&number, sizeof(T));
            if constexpr (std::is_floating_point_v<T>) {
                if (!accepts_non_finite_ && !std::isfinite(number)) refuse();
            }
        }
    }
    void value(Vec3& v) { (*this)(v.x, v.y, v.z); }
    void value(Quat& q) { (*this)(q.x, q.y, q.z, q.w); }
    void value(Pose& p) { (*this)(p.position, p.rotation); }
    void value(std::string& text) {
        text.resize(count(text.size(), 1));
        raw(text.data(), text.size());
    }
    template <typename T>
    requires(std::is_integral_v<T> &&
             !std::is_same_v<T, bool>) void value(std::vector<T>& numbers) {
        numbers.resize(count(numbers.size(), sizeof(T)));
        raw(numbers.data(), numbers.size() * sizeof(T));
    }

    bool reads_ = false, good_ = true, accepts_non_finite_ = false;
    std::span<const uint8_t> in_;
    size_t at_ = 0;
    std::vector<uint8_t> out_;
};

/// One part of a snapshot.
struct SnapshotSection {
    std::string name;  ///< 1..16 characters other than zero, unique in a file
    std::vector<uint8_t> bytes;
};

/// Writes a file beside `path` and renames it: what stood there stays if anything fails. Error: the
/// file cannot be written, there are no sections or more than 64, or a name is not as it must be.
/// Cost: compresses everything.
Status write_snapshot_file(const std::string& path, std::span<const SnapshotSection> sections);

/// Reads a file and checks it: magic, version, every checksum. Error: it cannot be read, is not a
/// snapshot, has another version, is damaged or cut short.
Result<std::vector<SnapshotSection>> read_snapshot_file(const std::string& path);

/// The bytes of a section; null where the file has none of that name.
const std::vector<uint8_t>* find_section(std::span<const SnapshotSection> sections,
                                         std::string_view name);

}  // namespace bsoil
#pragma GCC visibility pop
