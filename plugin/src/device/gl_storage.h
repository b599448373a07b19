/// A kernel's buffer in OpenGL: one storage block, or several where it outgrows one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "device/gl_objects.h"
#include "device/kernel_set.h"

namespace bsoil::device {

/// What glGetError says, in words.
std::string gl_error_name(GLenum error);

/// How the buffers of a set are cut into storage blocks, and where those are bound.
struct StorageBlocks {
    int64_t plain_words_most = 0, long_words_most = 0;  ///< of a block, by the buffer's kind
    std::vector<int> counts;                            ///< by buffer; none: one block each
    int list_count = 0;                                 ///< blocks of GlLaneList

    int64_t words_most(const KernelSet& kernel_set, size_t buffer) const {
        return kernel_set.are_long[buffer] ? long_words_most : plain_words_most;
    }
    /// With blocks for so many words, by buffer, of long ones, and no less than now.
    StorageBlocks grown(const KernelSet& kernel_set, std::span<const int64_t> words) const;
    int count(size_t buffer) const { return counts.empty() ? 1 : counts[buffer]; }
    /// A buffer's first block is bound at the buffer's number, as if it were all. Behind those
    /// comes GlLaneList's, if there is one, then the others.
    GLuint binding(const KernelSet& kernel_set, size_t buffer, int block) const {
        if (block == 0) return static_cast<GLuint>(buffer);
        int place = static_cast<int>(kernel_set.buffers.size()) + list_count + block - 1;
        for (size_t i = 0; i < buffer; ++i) place += count(i) - 1;
        return static_cast<GLuint>(place);
    }
    /// Of all buffers together.
    int total(const KernelSet& kernel_set) const {
        int sum = 0;
        for (size_t i = 0; i < kernel_set.buffers.size(); ++i) sum += count(i);
        return sum;
    }
};

/// A context must be current in every call.
class GlStorage {
  public:
    /// So many words, zero-filled, in so many blocks; blocks behind them hold one word.
    /// GL_NO_ERROR, or why not.
    GLenum allocate(std::string_view label, int64_t words, int64_t words_most, int block_count);
    /// Has `block_count` blocks from now on, those that come with one word each.
    GLenum add_blocks(std::string_view label, int block_count);
    const std::vector<GlBuffer>& blocks() const { return blocks_; }

    /// Calls visit(name, offset in the block, number of the first word, count) [words] for each
    /// part of these words that lies in one block.
    template <typename Visit>
    void for_parts(int64_t offset, int64_t count, Visit&& visit) const {
        for (int64_t done = 0; done < count;) {
            const int64_t at = offset + done, in_block = at % words_most_;
            const int64_t part = std::min(count - done, words_most_ - in_block);
            visit(blocks_[static_cast<size_t>(at / words_most_)].name(), in_block, done, part);
            done += part;
        }
    }
    /// Copies words of another storage on the device.
    void copy_from(const GlStorage& other, int64_t from, int64_t to, int64_t count) const;

  private:
    GLenum add_block(std::string_view label, int64_t words);

    int64_t words_most_ = 1;
    std::vector<GlBuffer> blocks_;
};

}  // namespace bsoil::device
