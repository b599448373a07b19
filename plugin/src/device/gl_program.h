/// Kernels as OpenGL compute programs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "device/gl_objects.h"
#include "device/gl_storage.h"
#include "device/kernel_set.h"

namespace bsoil::device {

/// Lanes of a group of a kernel, and invocations of a work group (prelude.glsl).
inline constexpr int kGroupLanes = 64;
/// Work groups along x of one dispatch; further ones go along y. Every GL allows this many.
inline constexpr int kGroupsPerRow = 65535;
/// Where a program takes how many groups there are: the last row may have more.
inline constexpr int kGroupCountLocation = 0;

/// For which lanes a program runs a kernel.
enum class ProgramKind {
    all_lanes,     ///< for those that have work; each asks for itself
    lists_lanes,   ///< for none: puts those that have work into a GlLaneList
    listed_lanes,  ///< for those in a GlLaneList
};

/// The whole GLSL text of a kernel, and where each of its lines comes from. (#line would say so,
/// but Mesa drops the source number.)
struct KernelSource {
    struct Line {
        std::string_view file;
        int number = 0;
    };
    std::string text;
    std::vector<Line> lines;
};
KernelSource kernel_source(const KernelSet& kernel_set, int kernel, ProgramKind kind,
                           const StorageBlocks& blocks);

/// The driver's log with the lines of the whole text replaced by file and line.
std::string name_files(const std::string& log, const std::vector<KernelSource::Line>& lines);

/// A program that the driver may still be making, in threads of its own where it has such.
struct PendingProgram {
    GlProgram program;
    GlShader shader;
    std::string_view name;
    KernelSource source;
};

/// Lets the driver compile and link a kernel in the current context. Asking how far it is would
/// wait for it: begin all programs, then finish them.
PendingProgram begin_program(const KernelSet& kernel_set, int kernel,
                             ProgramKind kind = ProgramKind::all_lanes,
                             const StorageBlocks& blocks = {});
/// Waits for the driver. The error is the kernel's name and the driver's log.
Result<GlProgram> finish_program(PendingProgram pending);

/// Lets a driver that can (KHR_parallel_shader_compile) make programs in as many threads as it
/// likes.
void allow_compiler_threads();

}  // namespace bsoil::device
