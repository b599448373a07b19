#include "device/gl_kernels.h"

#include <algorithm>
#include <utility>

namespace bsoil::device {

Status GlKernels::compile(const StorageBlocks& blocks) {
    allow_compiler_threads();
    std::vector<PendingProgram> pending;
    for (int kernel = 0; kernel < std::ssize(kernel_set_.kernels); ++kernel) {
        if (by_lists_) {
            pending.push_back(begin_program(kernel_set_, kernel, ProgramKind::lists_lanes, blocks));
        }
        pending.push_back(
            begin_program(kernel_set_, kernel,
                          by_lists_ ? ProgramKind::listed_lanes : ProgramKind::all_lanes, blocks));
    }
    std::vector<GlProgram> programs, listing_programs;
    for (size_t i = 0; i < pending.size(); ++i) {
        const bool lists = by_lists_ && i % 2 == 0;
        auto program = finish_program(std::move(pending[i]));
        if (!program) return Error{program.error()};
        (lists ? listing_programs : programs).push_back(std::move(*program));
    }
    programs_ = std::move(programs);
    listing_programs_ = std::move(listing_programs);
    return Done{};
}

/// Runs a program in so many work groups for a kernel's groups of lanes.
void GlKernels::run_groups(const GlProgram& program, int group_count, int work_group_count) {
    glUseProgram(program.name());
    glUniform1i(kGroupCountLocation, group_count);
    const int columns = std::min(work_group_count, kGroupsPerRow);
    const int rows = (work_group_count + kGroupsPerRow - 1) / kGroupsPerRow;
    glDispatchCompute(static_cast<GLuint>(columns), static_cast<GLuint>(rows), 1);
}

GLenum GlKernels::run(int kernel, int group_count) {
    const GlProgram& program = programs_[static_cast<size_t>(kernel)];
    if (!by_lists_) {
        run_groups(program, group_count, group_count);
        return GL_NO_ERROR;
    }
    const auto binding = static_cast<GLuint>(kernel_set_.buffers.size());
    const GLenum error = lane_list_.begin(binding, group_count);
    if (error != GL_NO_ERROR) return error;
    run_groups(listing_programs_[static_cast<size_t>(kernel)], group_count,
               lane_list_.listing_groups());
    glUseProgram(program.name());
    lane_list_.dispatch();
    return GL_NO_ERROR;
}

}  // namespace bsoil::device
