#include "device/gl_uploads.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <tuple>

namespace bsoil::device {

namespace {

// Words that wait at most. Ours: 16 MiB, fifty tiles of 72 voxels. Larger: more memory; smaller:
// more calls where many tiles wake.
constexpr size_t kWordsMost = size_t{4} << 20;

}  // namespace

void GlUploads::write(GLuint buffer, int64_t offset_bytes, std::span<const int32_t> words) {
    while (!words.empty()) {
        const std::span<const int32_t> taken = words.first(std::min(words.size(), kWordsMost));
        Part part{buffer, offset_bytes, static_cast<int64_t>(taken.size_bytes())};
        part.at = std::ssize(words_);
        words_.insert(words_.end(), taken.begin(), taken.end());
        add(part);
        offset_bytes += part.bytes;
        words = words.subspan(taken.size());
    }
}

void GlUploads::clear(GLuint buffer, int64_t offset_bytes, int64_t bytes) {
    if (bytes > 0) add({buffer, offset_bytes, bytes});
}

void GlUploads::add(const Part& part) {
    parts_.push_back(part);
    parts_.back().order = parts_.size();
    if (words_.size() >= kWordsMost) flush();
}

void GlUploads::forget() {
    parts_.clear();
    words_.clear();
}

void GlUploads::flush() {
    if (has_failed_) forget();
    if (parts_.empty()) return;
    std::ranges::sort(parts_, {}, [](const Part& part) {
        return std::tuple(part.buffer, part.offset_bytes, part.bytes, part.order);
    });
    drop_overwritten();
    for (size_t first = 0; first < parts_.size();) {
        const size_t end = end_of_overlap(first);
        if (end == first + 1) {
            first = hand_over_run(first);
            continue;
        }
        std::sort(parts_.begin() + static_cast<std::ptrdiff_t>(first),
                  parts_.begin() + static_cast<std::ptrdiff_t>(end),
                  [](const Part& a, const Part& b) { return a.order < b.order; });
        for (; first < end; ++first) hand_over(first, first + 1);
    }
    forget();
}

// Of parts with the same place and size the last one counts.
void GlUploads::drop_overwritten() {
    const auto is_same_place = [](const Part& a, const Part& b) {
        return a.buffer == b.buffer && a.offset_bytes == b.offset_bytes && a.bytes == b.bytes;
    };
    size_t count = 0;
    for (size_t i = 0; i < parts_.size(); ++i) {
        if (i + 1 < parts_.size() && is_same_place(parts_[i], parts_[i + 1])) continue;
        parts_[count++] = parts_[i];
    }
    parts_.resize(count);
}

// The end of those that lie over one another, from `first` on; their order counts.
size_t GlUploads::end_of_overlap(size_t first) const {
    int64_t end_bytes = parts_[first].end_bytes();
    size_t next = first + 1;
    for (; next < parts_.size() && parts_[next].buffer == parts_[first].buffer &&
           parts_[next].offset_bytes < end_bytes;
         ++next) {
        end_bytes = std::max(end_bytes, parts_[next].end_bytes());
    }
    return next;
}

// One part, with those of its kind that follow it without a gap. Returns the next one.
size_t GlUploads::hand_over_run(size_t first) {
    size_t end = first + 1;
    while (end < parts_.size() && parts_[end].buffer == parts_[first].buffer &&
           parts_[end].offset_bytes == parts_[end - 1].end_bytes() &&
           parts_[end].is_zero() == parts_[first].is_zero() && end_of_overlap(end) == end + 1) {
        ++end;
    }
    hand_over(first, end);
    return end;
}

void GlUploads::hand_over(size_t first, size_t end) {
    if (has_failed_) return;
    const Part& part = parts_[first];
    if (part.is_zero()) {
        const auto bytes = static_cast<GLsizeiptr>(parts_[end - 1].end_bytes() - part.offset_bytes);
        ++call_count_;
        glClearNamedBufferSubData(part.buffer, GL_R32I, part.offset_bytes, bytes, GL_RED_INTEGER,
                                  GL_INT, nullptr);
        return;
    }
    send(first, end);
}

// Parts of words that lie one behind the other, in as few copies as the staging memory allows.
void GlUploads::send(size_t first, size_t end) {
    const GLuint buffer = parts_[first].buffer;
    int64_t to = parts_[first].offset_bytes;
    const int64_t end_bytes = parts_[end - 1].end_bytes();
    size_t i = first;
    int64_t taken = 0;  // of part i
    while (to < end_bytes) {
        const int64_t bytes = std::min(end_bytes - to, GlStaging::kPieceBytes);
        const GlStaging::Place place = staging_.take(bytes);
        if (place.memory == nullptr) {
            has_failed_ = true;
            return;
        }
        for (int64_t done = 0; done < bytes;) {
            const Part& part = parts_[i];
            const auto* from = reinterpret_cast<const std::byte*>(words_.data() + part.at);
            const int64_t now = std::min(bytes - done, part.bytes - taken);
            std::memcpy(place.memory + done, from + taken, static_cast<size_t>(now));
            done += now;
            taken += now;
            if (taken == part.bytes) {
                ++i;
                taken = 0;
            }
        }
        glCopyNamedBufferSubData(staging_.buffer(), buffer, place.offset_bytes, to, bytes);
        ++call_count_;
        to += bytes;
    }
}

}  // namespace bsoil::device
