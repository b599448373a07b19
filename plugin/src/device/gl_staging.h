/// Memory that the host writes and the GPU copies from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "device/gl_objects.h"

namespace bsoil::device {

/// A ring, mapped for good. A piece of it is written again when the GPU is through with it: waits
/// only where the host is a whole ring ahead. A context must be current in every call.
class GlStaging {
  public:
    /// What take() gives at most [bytes]. Ours: 4 MiB, four of which are the ring. Larger: more
    /// memory, and more of the caches; smaller: more copies where many tiles wake.
    static constexpr int64_t kPieceBytes = int64_t{4} << 20;

    struct Place {
        std::byte* memory = nullptr;  ///< null: the GPU has none, or does not answer
        int64_t offset_bytes = 0;     ///< in buffer()
    };
    /// Room for so many bytes, to be written at once and copied from by commands that follow at
    /// once.
    Place take(int64_t bytes);
    GLuint buffer() const { return buffer_.name(); }

    /// Grows with each take().
    int64_t taken_bytes() const { return taken_bytes_; }
    /// All commands are done that were given when taken_bytes() was this.
    void note_done(int64_t taken_bytes);

  private:
    /// Ours: 4. Larger: more memory; smaller: the host waits where much is written at once.
    static constexpr int kPieceCount = 4;
    bool make();
    bool enter_piece(int piece);

    GlBuffer buffer_;
    std::byte* memory_ = nullptr;
    std::array<GlFence, kPieceCount> fences_;  ///< behind the last commands that copy from a piece
    int piece_ = 0;
    int64_t used_bytes_ = 0;  ///< of the piece at hand
    int64_t taken_bytes_ = 0;
};

}  // namespace bsoil::device
