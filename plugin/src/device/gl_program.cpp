#include "device/gl_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>

namespace bsoil::device {

namespace {

/// The rest of `text` after its first line, which goes to `line`.
std::string_view take_line(std::string_view text, std::string_view& line) {
    const size_t end = std::min(text.find('\n'), text.size());
    line = text.substr(0, end);
    return text.substr(std::min(end + 1, text.size()));
}

void append_text(std::string_view name, std::string_view text, const KernelSet& kernel_set,
                 KernelSource& source);

/// Appends a file of the set.
void append_file(std::string_view name, const KernelSet& kernel_set, KernelSource& source) {
    const auto file = std::ranges::find(kernel_set.files, name, &ShaderFile::name);
    assert(file != kernel_set.files.end());
    append_text(file->name, file->text, kernel_set, source);
}

/// Appends a text line by line; a line `#include "name"` is replaced by that file of the set. GLSL
/// has no #include.
void append_text(std::string_view name, std::string_view text, const KernelSet& kernel_set,
                 KernelSource& source) {
    std::string_view line;
    for (int number = 1; !text.empty(); ++number) {
        text = take_line(text, line);
        constexpr std::string_view kInclude = "#include \"";
        if (line.starts_with(kInclude)) {
            const size_t length = line.rfind('"') - kInclude.size();
            append_file(line.substr(kInclude.size(), length), kernel_set, source);
        } else {
            source.text.append(line).append("\n");
            source.lines.push_back({name, number});
        }
    }
}

/// What reaches the words of a long buffer: in its first block, which has the buffer's name, or in
/// one of the others. C++: LONG_BUFFER in cpu_kernels.cpp.
void add_long_buffer(std::string_view name, int block_count, int64_t words_most,
                     std::string& text) {
    struct Access {
        std::string_view head, word;
        bool gives;  ///< a value
    };
    constexpr Access kAccesses[] = {
        {"int {name}_word(int at)", "{word}", true},
        {"void set_{name}_word(int at, int value)", "{word} = value", false},
        {"int add_to_{name}(int at, int value)", "atomicAdd({word}, value)", true},
        {"int raise_{name}(int at, int value)", "atomicMax({word}, value)", true}};
    for (const Access& access : kAccesses) {
        text += fmt::format(fmt::runtime(access.head), fmt::arg("name", name)) + " {\n";
        for (int block = 0; block < block_count; ++block) {
            const std::string word =
                block == 0 ? fmt::format("{}[at]", name)
                           : fmt::format("{}_{}[at - {}]", name, block, block * words_most);
            const std::string what = fmt::format(fmt::runtime(access.word), fmt::arg("word", word));
            if (block + 1 < block_count) {
                text += fmt::format("    if (at < {}) ", (block + 1) * words_most);
                text += access.gives ? fmt::format("return {};\n", what)
                                     : fmt::format("{{ {}; return; }}\n", what);
            } else {
                text += fmt::format("    {}{};\n", access.gives ? "return " : "", what);
            }
        }
        text += "}\n";
    }
}

/// The storage blocks of all buffers.
std::string buffer_blocks(const KernelSet& kernel_set, const StorageBlocks& blocks) {
    std::string text;
    for (size_t i = 0; i < kernel_set.buffers.size(); ++i) {
        const std::string_view name = kernel_set.buffers[i];
        for (int block = 0; block < blocks.count(i); ++block) {
            const std::string in_block =
                block == 0 ? std::string(name) : fmt::format("{}_{}", name, block);
            text += fmt::format("layout(std430, binding = {}) buffer {}_block {{ int {}[]; }};\n",
                                blocks.binding(kernel_set, i, block), in_block, in_block);
        }
        if (kernel_set.are_long[i]) {
            add_long_buffer(name, blocks.count(i), blocks.long_words_most, text);
        }
    }
    return text;
}

/// For NVIDIA's compiler, others do not know it: no copies of loops' bodies. They are long, with
/// all functions in them: with copies all kernels take 31 s to compile, without 13 s
/// (docs/decisions/gpu_programs.md).
constexpr std::string_view kNotUnrolled = "#pragma optionNV(unroll none)\n";

/// Each lane asks whether it has work.
constexpr std::string_view kAllLanesMain = R"(
layout(location = {groups}) uniform int group_count;
void main() {{
    int group = int(gl_WorkGroupID.y) * {row} + int(gl_WorkGroupID.x);
    int lane = int(gl_LocalInvocationIndex);
    if (group < group_count && (({kernel}_lanes(group, lane >> 5) >> (lane & 31)) & 1) != 0) {{
        {kernel}(group, lane);
    }}
}}
)";

/// An invocation lists half a group. The work groups that the list asks for grow with it.
constexpr std::string_view kListsLanesMain = R"(
layout(location = {groups}) uniform int group_count;
void main() {{
    int row = int(gl_WorkGroupID.y) * {row} + int(gl_WorkGroupID.x);
    int half_group = row * {lanes} + int(gl_LocalInvocationIndex);
    int group = half_group >> 1;
    int rest = group < group_count ? {kernel}_lanes(group, half_group & 1) : 0;
    if (rest == 0) return;
    int count = bit_count(rest);
    int next = atomicAdd(lane_count, count);
    int groups = (next + count + {lanes} - 1) / {lanes};
    atomicMax(groups_x, min(groups, {row}));
    atomicMax(groups_y, (groups + {row} - 1) / {row});
    for (; rest != 0; rest = rest & (rest - 1)) {{
        lane_list[next] = half_group * 32 + lowest_bit(rest);
        next += 1;
    }}
}}
)";

constexpr std::string_view kListedLanesMain = R"(
void main() {{
    int row = int(gl_WorkGroupID.y) * {row} + int(gl_WorkGroupID.x);
    int place = row * {lanes} + int(gl_LocalInvocationIndex);
    if (place < lane_count) {{
        int lane = lane_list[place];
        {kernel}(lane / {lanes}, lane % {lanes});
    }}
}}
)";

/// See gl_lane_list.cpp.
constexpr std::string_view kLaneListBlock = R"(
layout(std430, binding = {binding}) buffer lane_list_block {{
    int groups_x, groups_y, groups_z, lane_count, lane_list[];
}};
)";

std::string main_function(const KernelSet& kernel_set, std::string_view kernel, ProgramKind kind) {
    const auto named = [&](std::string_view text) {
        return fmt::format(fmt::runtime(text), fmt::arg("groups", kGroupCountLocation),
                           fmt::arg("row", kGroupsPerRow), fmt::arg("lanes", kGroupLanes),
                           fmt::arg("binding", kernel_set.buffers.size()),
                           fmt::arg("kernel", kernel));
    };
    if (kind == ProgramKind::all_lanes) return named(kAllLanesMain);
    return named(kLaneListBlock) +
           named(kind == ProgramKind::lists_lanes ? kListsLanesMain : kListedLanesMain);
}

/// Takes an unsigned number off the front of `text`; -1 when there is none.
int take_number(std::string_view& text) {
    int number = -1;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc{}) text.remove_prefix(static_cast<size_t>(stop - text.data()));
    return number;
}

/// The line in "0:31: rest" or "0(31) rest" (source string 0, line 31), and the rest; 0 when it
/// does not start so.
int read_location(std::string_view log_line, std::string_view& rest) {
    rest = log_line;
    if (take_number(rest) != 0 || rest.empty() || (rest[0] != ':' && rest[0] != '(')) return 0;
    const bool has_bracket = rest[0] == '(';
    rest.remove_prefix(1);
    const int number = take_number(rest);
    if (has_bracket && rest.starts_with(')')) rest.remove_prefix(1);
    return std::max(number, 0);
}

template <typename GetParameter, typename GetLog>
std::string info_log(GLuint name, GetParameter get_parameter, GetLog get_log) {
    GLint length = 0;
    get_parameter(name, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
    GLsizei written = 0;
    get_log(name, length, &written, log.data());
    log.resize(static_cast<size_t>(written));
    return log;
}

}  // namespace

KernelSource kernel_source(const KernelSet& kernel_set, int kernel, ProgramKind kind,
                           const StorageBlocks& blocks) {
    const std::string_view name = kernel_set.kernels[static_cast<size_t>(kernel)].name;
    KernelSource source;
    append_text("version", "#version 450\n", kernel_set, source);
    append_text("version",
                kind == ProgramKind::all_lanes ? kNotUnrolled : "#define RUNS_IN_SOFTWARE\n",
                kernel_set, source);
    append_file("prelude.glsl", kernel_set, source);
    append_text("buffers", buffer_blocks(kernel_set, blocks), kernel_set, source);
    append_text("params", "layout(std140, binding = 0) uniform ParamsBlock {\n", kernel_set,
                source);
    append_file(kernel_set.params_file, kernel_set, source);
    append_text("params", "} params;\n", kernel_set, source);
    append_file("exact_math.glsl", kernel_set, source);
    append_file(kernel_set.layout_file, kernel_set, source);
    append_file(kernel_set.common_file, kernel_set, source);
    append_file(fmt::format("{}.glsl", name), kernel_set, source);
    append_text("main", main_function(kernel_set, name, kind), kernel_set, source);
    return source;
}

std::string name_files(const std::string& log, const std::vector<KernelSource::Line>& lines) {
    // Mesa writes "0:31(5): error: ...", NVIDIA "0(31) : error ...", others "ERROR: 0:31: ...".
    std::string named;
    std::string_view rest = log, line;
    while (!rest.empty()) {
        rest = take_line(rest, line);
        for (const std::string_view prefix : {"ERROR: ", "WARNING: "}) {
            if (line.starts_with(prefix)) {
                line.remove_prefix(prefix.size());
                named += prefix;
            }
        }
        std::string_view message;
        const auto number = static_cast<size_t>(read_location(line, message));
        if (number > 0 && number <= lines.size()) {
            named += fmt::format("{}:{}", lines[number - 1].file, lines[number - 1].number);
            line = message;
        }
        named.append(line).append("\n");
    }
    return named;
}

void allow_compiler_threads() {
    constexpr GLuint kAsManyAsItLikes = ~0u;
    if (epoxy_has_gl_extension("GL_KHR_parallel_shader_compile")) {
        glMaxShaderCompilerThreadsKHR(kAsManyAsItLikes);
    } else if (epoxy_has_gl_extension("GL_ARB_parallel_shader_compile")) {
        glMaxShaderCompilerThreadsARB(kAsManyAsItLikes);
    }
}

PendingProgram begin_program(const KernelSet& kernel_set, int kernel, ProgramKind kind,
                             const StorageBlocks& blocks) {
    PendingProgram pending;
    pending.name = kernel_set.kernels[static_cast<size_t>(kernel)].name;
    pending.source = kernel_source(kernel_set, kernel, kind, blocks);
    pending.shader = GlShader(glCreateShader(GL_COMPUTE_SHADER));
    const char* text = pending.source.text.c_str();
    glShaderSource(pending.shader.name(), 1, &text, nullptr);
    glCompileShader(pending.shader.name());
    pending.program = GlProgram(glCreateProgram());
    pending.program.set_label(pending.name);
    glAttachShader(pending.program.name(), pending.shader.name());
    glLinkProgram(pending.program.name());
    return pending;
}

Result<GlProgram> finish_program(PendingProgram pending) {
    GLint done = GL_FALSE;
    glGetShaderiv(pending.shader.name(), GL_COMPILE_STATUS, &done);
    if (done == GL_FALSE) {
        const std::string log = info_log(pending.shader.name(), glGetShaderiv, glGetShaderInfoLog);
        return Error{fmt::format("kernel {} does not compile:\n{}", pending.name,
                                 name_files(log, pending.source.lines))};
    }
    glGetProgramiv(pending.program.name(), GL_LINK_STATUS, &done);
    if (done == GL_FALSE) {
        const std::string log =
            info_log(pending.program.name(), glGetProgramiv, glGetProgramInfoLog);
        return Error{fmt::format("kernel {} does not link:\n{}", pending.name,
                                 name_files(log, pending.source.lines))};
    }
    glDetachShader(pending.program.name(), pending.shader.name());
    return std::move(pending.program);
}

}  // namespace bsoil::device
