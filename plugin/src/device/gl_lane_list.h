/// Which lanes of a dispatch have work, as a list made on the device.
#pragma once

#include <epoxy/gl.h>

#include "device/gl_objects.h"

namespace bsoil::device {

/// A GPU lets the lanes without work return. Mesa's software takes every branch of a kernel, for
/// eight lanes at a time, whether or not any of them goes there: a dispatch in which few lanes have
/// work takes as long as one in which all have. So there a first program lists the lanes that have
/// work, and the kernel runs for these alone. A context must be current in every call.
class GlLaneList {
  public:
    /// Binds the list of a dispatch as storage block `binding`, empty, with room for all lanes of
    /// so many groups. The GL error of a buffer for which there is no memory.
    GLenum begin(GLuint binding, int group_count);
    /// Work groups for the program that fills it.
    int listing_groups() const { return (group_count_ + kGroupsAtOnce - 1) / kGroupsAtOnce; }
    /// Runs the program in use for the lanes of the list.
    void dispatch() const;

  private:
    /// Groups whose lanes one work group lists: each invocation takes half of one.
    static constexpr int kGroupsAtOnce = 32;

    GlBuffer buffer_;
    int group_count_ = 0, capacity_ = 0;
};

}  // namespace bsoil::device
