/// Reads from GL buffers, many parts at the cost of one wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "device/gl_objects.h"

namespace bsoil::device {

/// Waits until the GPU is past a fence; false where it was reset or cannot be waited for.
bool wait_for(const GlFence& fence);

/// Memory that the GPU writes and the host sees: the GPU copies parts of its buffers there, then
/// one fence says that all of them have arrived. A context must be current in every call.
class GlReadBack {
  public:
    /// Forgets the parts of the read before.
    void begin();
    /// Fills what it reads with zeros, where the GPU is lost.
    void fill_zero();
    /// Adds words of a buffer from `offset_bytes` on to the read at hand; `words` is where they go.
    void add(GLuint buffer, int64_t offset_bytes, std::span<int32_t> words);
    /// Lets the GPU copy all of them. The error of one that has no memory for it; empty when all is
    /// well.
    std::string start();
    /// Whether they have arrived.
    bool is_done();
    /// Waits until they have. The error of a GPU that does not answer; empty when all is well.
    std::string finish();
    /// Copies that were asked of the GPU so far.
    int64_t copy_count() const { return copy_count_; }

  private:
    struct Part {
        GLuint buffer = 0;
        int64_t offset_bytes = 0;
        std::span<int32_t> words;
        int64_t at_bytes = 0;  ///< where the GPU copies them to
    };
    std::string reserve(int64_t bytes);
    std::string wait();
    void copy_parts();

    std::vector<Part> parts_;
    int64_t part_bytes_ = 0, copy_count_ = 0;
    GlFence fence_;  ///< behind the copies
    GlBuffer buffer_;
    int64_t capacity_bytes_ = 0;
    const std::byte* memory_ = nullptr;  ///< of the buffer, as the host sees it
};

}  // namespace bsoil::device
