#include "device/gl_lane_list.h"

#include <algorithm>
#include <cstdint>

#include "device/gl_program.h"

namespace bsoil::device {

namespace {

// The buffer, as main() in gl_program.cpp has it:
//
//   word 0       work groups along x        glDispatchComputeIndirect() reads
//        1                   along y        these three
//        2                   along z
//        3       lanes in the list
//        4 ...   the lanes: group * kGroupLanes + lane
constexpr GLint kEmpty[] = {0, 1, 1, 0};
constexpr GLsizeiptr kLaneBytes = sizeof(int32_t);

}  // namespace

GLenum GlLaneList::begin(GLuint binding, int group_count) {
    group_count_ = group_count;
    if (capacity_ < group_count) {
        const int wanted = std::max(group_count, 2 * capacity_);
        GLuint name = 0;
        glCreateBuffers(1, &name);
        buffer_ = GlBuffer(name);
        buffer_.set_label("lane list");
        glNamedBufferStorage(name, sizeof(kEmpty) + kLaneBytes * kGroupLanes * wanted, nullptr,
                             GL_DYNAMIC_STORAGE_BIT);
        if (const GLenum error = glGetError(); error != GL_NO_ERROR) return error;
        capacity_ = wanted;
    }
    glNamedBufferSubData(buffer_.name(), 0, sizeof(kEmpty), kEmpty);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_.name());
    return GL_NO_ERROR;
}

void GlLaneList::dispatch() const {
    // The list was written by a program; this one and the driver read it.
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffer_.name());
    glDispatchComputeIndirect(0);
}

}  // namespace bsoil::device
