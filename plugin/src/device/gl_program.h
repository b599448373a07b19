/// Kernels as OpenGL compute programs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "device/gl_objects.h"
#include "device/kernel_set.h"

namespace bsoil::device {

/// Work groups along x of one dispatch; further ones go along y. Every GL allows this many.
inline constexpr int kGroupsPerRow = 65535;
/// Where a program takes how many groups there are: the last row may have more.
inline constexpr int kGroupCountLocation = 0;

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
KernelSource kernel_source(const KernelSet& kernel_set, int kernel);

/// The driver's log with the lines of the whole text replaced by file and line.
std::string name_files(const std::string& log, const std::vector<KernelSource::Line>& lines);

/// Compiles and links a kernel in the current context. The error is the kernel's name and the
/// driver's log.
Result<GlProgram> create_program(const KernelSet& kernel_set, int kernel);

}  // namespace bsoil::device
