#include "device/gl_read_back.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "device/parallel_ranges.h"

namespace bsoil::device {

namespace {

/// So long a single wait lasts before the GPU is asked whether it is still there.
constexpr GLuint64 kPatienceNs = 1'000'000'000;

/// From so many bytes on several threads take what has arrived. Ours: what one takes in a tenth of
/// a millisecond. Larger: one thread takes the tiles that fall asleep; smaller: sharing the work
/// takes longer than the work.
constexpr int64_t kSharedBytes = int64_t{1} << 20;

bool is_passed(GLenum answer) {
    return answer == GL_ALREADY_SIGNALED || answer == GL_CONDITION_SATISFIED;
}

}  // namespace

bool wait_for(const GlFence& fence) {
    GLenum answer = GL_TIMEOUT_EXPIRED;
    while (answer == GL_TIMEOUT_EXPIRED && glGetGraphicsResetStatus() == GL_NO_ERROR) {
        answer = glClientWaitSync(fence.sync(), GL_SYNC_FLUSH_COMMANDS_BIT, kPatienceNs);
    }
    return is_passed(answer);
}

void GlReadBack::begin() {
    parts_.clear();
    part_bytes_ = 0;
}

void GlReadBack::add(GLuint buffer, int64_t offset_bytes, std::span<int32_t> words) {
    if (words.empty()) return;  // nor need there be a place for them
    parts_.push_back({buffer, offset_bytes, words});
    part_bytes_ += static_cast<int64_t>(words.size_bytes());
}

void GlReadBack::fill_zero() {
    for (const Part& part : parts_) std::ranges::fill(part.words, 0);
}

std::string GlReadBack::start() {
    if (std::string error = reserve(part_bytes_); !error.empty()) return error;
    copy_parts();
    fence_ = GlFence(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0));
    return {};
}

// Parts that lie one behind the other come with one copy, as a plane's words of neighbouring tiles
// do: a driver takes microseconds for each.
void GlReadBack::copy_parts() {
    std::ranges::sort(parts_, {},
                      [](const Part& part) { return std::pair(part.buffer, part.offset_bytes); });
    GLintptr at = 0;
    for (size_t first = 0; first < parts_.size();) {
        Part& part = parts_[first];
        part.at_bytes = at;
        auto bytes = static_cast<GLsizeiptr>(part.words.size_bytes());
        size_t next = first + 1;
        for (; next < parts_.size() && parts_[next].buffer == part.buffer &&
               parts_[next].offset_bytes == part.offset_bytes + bytes;
             ++next) {
            parts_[next].at_bytes = at + bytes;
            bytes += static_cast<GLsizeiptr>(parts_[next].words.size_bytes());
        }
        glCopyNamedBufferSubData(part.buffer, buffer_.name(), part.offset_bytes, at, bytes);
        ++copy_count_;
        at += bytes;
        first = next;
    }
}

bool GlReadBack::is_done() {
    return is_passed(glClientWaitSync(fence_.sync(), GL_SYNC_FLUSH_COMMANDS_BIT, 0));
}

// All commands before the fence are done then.
std::string GlReadBack::wait() {
    const bool passed = wait_for(std::exchange(fence_, GlFence()));
    return passed ? std::string() : "was reset or cannot be waited for; its buffers are lost";
}

std::string GlReadBack::finish() {
    if (std::string error = wait(); !error.empty()) return error;
    const auto take = [this](size_t first, size_t last) {
        for (const Part& part : std::span(parts_).subspan(first, last - first)) {
            std::memcpy(part.words.data(), memory_ + part.at_bytes, part.words.size_bytes());
        }
    };
    if (part_bytes_ < kSharedBytes) {
        take(0, parts_.size());
    } else {
        parallel_ranges(parts_.size(), take);
    }
    return {};
}

std::string GlReadBack::reserve(int64_t bytes) {
    if (bytes <= capacity_bytes_) return {};
    const int64_t capacity = std::max(bytes, 2 * capacity_bytes_);
    capacity_bytes_ = 0;
    memory_ = nullptr;
    GLuint name = 0;
    glCreateBuffers(1, &name);
    buffer_ = GlBuffer(name);
    buffer_.set_label("read back");
    // Coherent: what the GPU has copied is visible once the fence behind it has been passed.
    constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glNamedBufferStorage(name, capacity, nullptr, kAccess | GL_CLIENT_STORAGE_BIT);
    memory_ = static_cast<const std::byte*>(glMapNamedBufferRange(name, 0, capacity, kAccess));
    if (!memory_) return fmt::format("has no {} bytes for what is read back", capacity);
    capacity_bytes_ = capacity;
    return {};
}

}  // namespace bsoil::device
