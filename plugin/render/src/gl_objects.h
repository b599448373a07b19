/// Owners of GL objects. All need the context that made them to be current, at destruction too.
#pragma once

#include <epoxy/gl.h>

#include <string>
#include <utility>

#include "bsoil/result.h"

namespace bsoil::render {

/// While it lives, owners in this thread forget their objects: those go with their context, which
/// is not the one that is current.
class ForgetGlObjects {
  public:
    ForgetGlObjects() { is_on() = true; }
    ~ForgetGlObjects() { is_on() = false; }
    ForgetGlObjects(const ForgetGlObjects&) = delete;
    ForgetGlObjects& operator=(const ForgetGlObjects&) = delete;
    static bool& is_on() {
        thread_local bool on = false;
        return on;
    }
};

/// The name of one GL object; move-only. Traits: create() and destroy(name).
template <typename Traits>
class GlObject {
  public:
    GlObject() = default;
    /// A new object with a label for debuggers.
    explicit GlObject(const char* label) : name_(Traits::create()) {
        if (epoxy_has_gl_extension("GL_KHR_debug") && Traits::kIdentifier != 0) {
            Traits::bind(name_);  // a name has no object, and takes no label, before it is bound
            glObjectLabel(Traits::kIdentifier, name_, -1, label);
        }
    }
    ~GlObject() {
        if (name_ != 0 && !ForgetGlObjects::is_on()) Traits::destroy(name_);
    }
    GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlObject& operator=(GlObject&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    GLuint name() const { return name_; }

  private:
    GLuint name_ = 0;
};

struct BufferTraits {
    static constexpr GLenum kIdentifier = GL_BUFFER;
    static GLuint create() {
        GLuint name = 0;
        glGenBuffers(1, &name);
        return name;
    }
    static void bind(GLuint name) { glBindBuffer(GL_ARRAY_BUFFER, name); }
    static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct VertexArrayTraits {
    static constexpr GLenum kIdentifier = GL_VERTEX_ARRAY;
    static GLuint create() {
        GLuint name = 0;
        glGenVertexArrays(1, &name);
        return name;
    }
    static void bind(GLuint name) { glBindVertexArray(name); }
    static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct FramebufferTraits {
    static constexpr GLenum kIdentifier = GL_FRAMEBUFFER;
    static GLuint create() {
        GLuint name = 0;
        glGenFramebuffers(1, &name);
        return name;
    }
    static void bind(GLuint name) { glBindFramebuffer(GL_FRAMEBUFFER, name); }
    static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct RenderbufferTraits {
    static constexpr GLenum kIdentifier = GL_RENDERBUFFER;
    static GLuint create() {
        GLuint name = 0;
        glGenRenderbuffers(1, &name);
        return name;
    }
    static void bind(GLuint name) { glBindRenderbuffer(GL_RENDERBUFFER, name); }
    static void destroy(GLuint name) { glDeleteRenderbuffers(1, &name); }
};
template <GLenum target>
struct TextureTraits {
    static constexpr GLenum kIdentifier = GL_TEXTURE;
    static GLuint create() {
        GLuint name = 0;
        glGenTextures(1, &name);
        return name;
    }
    static void bind(GLuint name) { glBindTexture(target, name); }
    static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct ProgramTraits {
    static constexpr GLenum kIdentifier = GL_PROGRAM;
    static GLuint create() { return glCreateProgram(); }
    static void bind(GLuint) {}
    static void destroy(GLuint name) { glDeleteProgram(name); }
};

struct QueryTraits {
    static constexpr GLenum kIdentifier = 0;  // a query takes a label only once it has begun
    static GLuint create() {
        GLuint name = 0;
        glGenQueries(1, &name);
        return name;
    }
    static void bind(GLuint) {}
    static void destroy(GLuint name) { glDeleteQueries(1, &name); }
};

using GlBuffer = GlObject<BufferTraits>;
using GlVertexArray = GlObject<VertexArrayTraits>;
using GlFramebuffer = GlObject<FramebufferTraits>;
using GlRenderbuffer = GlObject<RenderbufferTraits>;
using GlTexture2D = GlObject<TextureTraits<GL_TEXTURE_2D>>;
using GlTexture3D = GlObject<TextureTraits<GL_TEXTURE_3D>>;
using GlQuery = GlObject<QueryTraits>;
using GlProgram = GlObject<ProgramTraits>;

/// Compiles and links. The error holds the label and the compiler's text.
Result<GlProgram> link_program(const char* label, const char* vertex_text,
                               const char* fragment_text);

}  // namespace bsoil::render
