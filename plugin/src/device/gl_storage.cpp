#include "device/gl_storage.h"

#include <fmt/format.h>

namespace bsoil::device {

namespace {

constexpr GLsizeiptr kStoredWordBytes = sizeof(int32_t);

}  // namespace

std::string gl_error_name(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE:
            return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION:
            return "GL_INVALID_OPERATION";
        case GL_OUT_OF_MEMORY:
            return "GL_OUT_OF_MEMORY";
        case GL_CONTEXT_LOST:
            return "GL_CONTEXT_LOST";
        default:
            return fmt::format("GL error {:#x}", error);
    }
}

StorageBlocks StorageBlocks::grown(const KernelSet& kernel_set,
                                   std::span<const int64_t> words) const {
    StorageBlocks grown = *this;
    for (size_t i = 0; i < counts.size(); ++i) {
        if (!kernel_set.are_long[i]) continue;
        const int64_t needed = (words[i] + long_words_most - 1) / long_words_most;
        grown.counts[i] = std::max(counts[i], static_cast<int>(needed));
    }
    return grown;
}

GLenum GlStorage::allocate(std::string_view label, int64_t words, int64_t words_most,
                           int block_count) {
    blocks_.clear();
    words_most_ = words_most;
    for (int block = 0; block < block_count; ++block) {
        const int64_t rest = std::clamp<int64_t>(words - block * words_most, 0, words_most);
        if (const GLenum error = add_block(label, rest); error != GL_NO_ERROR) return error;
    }
    return GL_NO_ERROR;
}

GLenum GlStorage::add_blocks(std::string_view label, int block_count) {
    while (std::ssize(blocks_) < block_count) {
        if (const GLenum error = add_block(label, 0); error != GL_NO_ERROR) return error;
    }
    return GL_NO_ERROR;
}

// A block without a buffer behind it is undefined behaviour even in a kernel that does not read it,
// so that each has a word. The host writes by copies alone (GlUploads): a buffer that may be
// written from the host is moved into the host's memory by some drivers, and kernels then read it
// over the bus.
GLenum GlStorage::add_block(std::string_view label, int64_t words) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    GlBuffer made(name);
    made.set_label(label);
    glNamedBufferStorage(name, std::max<int64_t>(words, 1) * kStoredWordBytes, nullptr, 0);
    glClearNamedBufferData(name, GL_R32I, GL_RED_INTEGER, GL_INT, nullptr);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) return error;
    blocks_.push_back(std::move(made));
    return GL_NO_ERROR;
}

void GlStorage::copy_from(const GlStorage& other, int64_t from, int64_t to, int64_t count) const {
    other.for_parts(from, count, [&](GLuint source, int64_t at, int64_t first, int64_t words) {
        for_parts(to + first, words, [&](GLuint target, int64_t to_at, int64_t done, int64_t part) {
            glCopyNamedBufferSubData(source, target, (at + done) * kStoredWordBytes,
                                     to_at * kStoredWordBytes, part * kStoredWordBytes);
        });
    });
}

}  // namespace bsoil::device
