/// The kernels of a set as programs, and what runs them.
#pragma once

#include <vector>

#include "device/gl_lane_list.h"
#include "device/gl_program.h"

namespace bsoil::device {

/// A context must be current in every call.
class GlKernels {
  public:
    /// `by_lists`: lists of the lanes that have work are made and run; else each lane asks.
    GlKernels(const KernelSet& kernel_set, bool by_lists)
        : kernel_set_(kernel_set), by_lists_(by_lists) {}
    /// Compiles all of them, for buffers cut like this. An error leaves those that there were.
    Status compile(const StorageBlocks& blocks);
    /// Lists lie in a storage block, bound behind those of the set's buffers.
    bool has_lists() const { return by_lists_; }
    /// GL_NO_ERROR, or why there is no room for a list.
    GLenum run(int kernel, int group_count);

  private:
    static void run_groups(const GlProgram& program, int group_count, int work_group_count);

    const KernelSet& kernel_set_;
    bool by_lists_;
    std::vector<GlProgram> programs_, listing_programs_;  ///< by kernel; the second: or none
    GlLaneList lane_list_;
};

}  // namespace bsoil::device
