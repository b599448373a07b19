#include "gl_objects.h"

namespace bsoil::render {
namespace {

/// Compiles a shader and attaches it; an empty text means success.
std::string attach_shader(GLuint program, GLenum stage, const char* text) {
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    std::string log;
    if (compiled) {
        glAttachShader(program, shader);
    } else {
        char buffer[2048] = "no text";
        glGetShaderInfoLog(shader, sizeof(buffer), nullptr, buffer);
        log = buffer;
    }
    glDeleteShader(shader);  // lives on in the program
    return log;
}

}  // namespace

Result<GlProgram> link_program(const char* label, const char* vertex_text,
                               const char* fragment_text) {
    GlProgram program(label);
    std::string log = attach_shader(program.name(), GL_VERTEX_SHADER, vertex_text);
    if (log.empty()) log = attach_shader(program.name(), GL_FRAGMENT_SHADER, fragment_text);
    if (!log.empty()) return Error{std::string("shader ") + label + ": " + log};
    glLinkProgram(program.name());
    GLint linked = GL_FALSE;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    if (!linked) {
        char buffer[2048] = "no text";
        glGetProgramInfoLog(program.name(), sizeof(buffer), nullptr, buffer);
        return Error{std::string("program ") + label + ": " + buffer};
    }
    return program;
}

}  // namespace bsoil::render
