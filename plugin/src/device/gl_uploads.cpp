#include "device/gl_uploads.h"

#include <algorithm>
#include <tuple>

namespace bsoil::device {

namespace {

// Words that wait at most. Ours: 16 MiB, fifty tiles of 72 voxels. Larger: more memory; smaller:
// more calls where many tiles wake.
constexpr size_t kWordsMost = size_t{4} << 20;

}  // namespace

void GlUploads::write(GLuint buffer, int64_t offset_bytes, std::span<const int32_t> words) {
    if (words.empty()) return;
    if (words.size() > kWordsMost) {
        flush();
        ++call_count_;
        glNamedBufferSubData(buffer, offset_bytes, static_cast<GLsizeiptr>(words.size_bytes()),
                             words.data());
        return;
    }
    Part part{buffer, offset_bytes, static_cast<int64_t>(words.size_bytes())};
    part.at = std::ssize(words_);
    words_.insert(words_.end(), words.begin(), words.end());
    add(part);
}

void GlUploads::clear(GLuint buffer, int64_t offset_bytes, int64_t bytes) {
    if (bytes > 0) add({buffer, offset_bytes, bytes});
}

void GlUploads::add(const Part& part) {
    parts_.push_back(part);
    parts_.back().order = parts_.size();
    if (words_.size() > kWordsMost) flush();
}

void GlUploads::forget() {
    parts_.clear();
    words_.clear();
}

void GlUploads::flush() {
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
    const Part& part = parts_[first];
    const auto bytes = static_cast<GLsizeiptr>(parts_[end - 1].end_bytes() - part.offset_bytes);
    ++call_count_;
    if (part.is_zero()) {
        glClearNamedBufferSubData(part.buffer, GL_R32I, part.offset_bytes, bytes, GL_RED_INTEGER,
                                  GL_INT, nullptr);
        return;
    }
    const int32_t* words = words_.data() + part.at;
    if (end > first + 1) {
        run_.clear();
        for (size_t i = first; i < end; ++i) {
            const auto from = words_.begin() + static_cast<std::ptrdiff_t>(parts_[i].at);
            run_.insert(run_.end(), from,
                        from + parts_[i].bytes / static_cast<int64_t>(sizeof(int32_t)));
        }
        words = run_.data();
    }
    glNamedBufferSubData(part.buffer, part.offset_bytes, bytes, words);
}

}  // namespace bsoil::device
