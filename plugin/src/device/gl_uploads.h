/// Writes to GL buffers, many at the cost of a few calls.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "device/gl_objects.h"
#include "device/gl_staging.h"

namespace bsoil::device {

/// Words and zeros on their way to buffers. A tile that wakes is written plane by plane; those of
/// tiles that wake together lie side by side, and go with one call. The GPU copies them from memory
/// that the host writes: no driver has to keep what it is given, or to guess where a buffer
/// belongs. A context must be current in every call.
class GlUploads {
  public:
    void write(GLuint buffer, int64_t offset_bytes, std::span<const int32_t> words);
    void clear(GLuint buffer, int64_t offset_bytes, int64_t bytes);
    /// Hands all of them to OpenGL, as if each had been handed over when it came: before anything
    /// else that reads or writes the buffers.
    void flush();
    /// Copies and fills that were asked of the GPU so far.
    int64_t call_count() const { return call_count_; }
    /// The GPU has no memory to copy from, or does not answer: words are lost.
    bool has_failed() const { return has_failed_; }
    /// What note_done() is told when all commands given by now are done.
    int64_t sent_bytes() const { return staging_.taken_bytes(); }
    void note_done(int64_t sent_bytes) { staging_.note_done(sent_bytes); }

  private:
    struct Part {
        GLuint buffer = 0;
        int64_t offset_bytes = 0, bytes = 0;
        int64_t at = kZeros;  ///< of its first word in words_
        size_t order = 0;     ///< in which it came
        int64_t end_bytes() const { return offset_bytes + bytes; }
        bool is_zero() const { return at == kZeros; }
    };
    static constexpr int64_t kZeros = -1;

    void add(const Part& part);
    void forget();
    void drop_overwritten();
    size_t end_of_overlap(size_t first) const;
    size_t hand_over_run(size_t first);
    void hand_over(size_t first, size_t end);
    void send(size_t first, size_t end);

    std::vector<Part> parts_;
    std::vector<int32_t> words_;
    GlStaging staging_;
    bool has_failed_ = false;
    int64_t call_count_ = 0;
};

}  // namespace bsoil::device
