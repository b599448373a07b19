#include "device/gl_staging.h"

#include <cassert>

#include "device/gl_read_back.h"

namespace bsoil::device {

bool GlStaging::make() {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    buffer_ = GlBuffer(name);
    buffer_.set_label("staging");
    constexpr GLbitfield kAccess = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    constexpr GLsizeiptr kBytes = kPieceCount * kPieceBytes;
    glNamedBufferStorage(name, kBytes, nullptr, kAccess | GL_CLIENT_STORAGE_BIT);
    memory_ = static_cast<std::byte*>(glMapNamedBufferRange(name, 0, kBytes, kAccess));
    return memory_ != nullptr;
}

bool GlStaging::enter_piece(int piece) {
    fences_[static_cast<size_t>(piece_)] = GlFence(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0));
    piece_ = piece;
    used_bytes_ = 0;
    const GlFence before = std::exchange(fences_[static_cast<size_t>(piece)], GlFence());
    return before.sync() == nullptr || wait_for(before);
}

GlStaging::Place GlStaging::take(int64_t bytes) {
    assert(bytes > 0 && bytes <= kPieceBytes);
    if (memory_ == nullptr && !make()) return {};
    if (used_bytes_ + bytes > kPieceBytes && !enter_piece((piece_ + 1) % kPieceCount)) return {};
    const int64_t offset_bytes = piece_ * kPieceBytes + used_bytes_;
    used_bytes_ += bytes;
    taken_bytes_ += bytes;
    return {memory_ + offset_bytes, offset_bytes};
}

// Then the ring begins anew, where it lies in the caches.
void GlStaging::note_done(int64_t taken_bytes) {
    if (taken_bytes != taken_bytes_) return;
    for (GlFence& fence : fences_) fence = GlFence();
    piece_ = 0;
    used_bytes_ = 0;
}

}  // namespace bsoil::device
