/// Move-only owners of GL objects. A context must be current where one is destroyed or replaced.
#pragma once

#include <epoxy/gl.h>

#include <string_view>
#include <utility>

namespace bsoil::device {

/// While one of these is there, owners in this thread forget their objects and delete none: those
/// went with their context.
class LostGlObjects {
  public:
    LostGlObjects() { are_lost() = true; }
    ~LostGlObjects() { are_lost() = false; }
    LostGlObjects(const LostGlObjects&) = delete;
    LostGlObjects& operator=(const LostGlObjects&) = delete;
    static bool& are_lost() {
        thread_local bool lost = false;
        return lost;
    }
};

/// Owns one GL name; 0 is none. `destroy` deletes it, `kNamespace` is its kind for debug labels.
template <GLenum kNamespace, void (*destroy)(GLuint)>
class GlObject {
  public:
    GlObject() = default;
    explicit GlObject(GLuint name) : name_(name) {}
    GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlObject& operator=(GlObject&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlObject() { reset(); }

    void reset() {
        const GLuint name = std::exchange(name_, 0);
        if (name != 0 && !LostGlObjects::are_lost()) destroy(name);
    }
    /// The name under which debuggers and driver messages show it.
    void set_label(std::string_view label) const {
        glObjectLabel(kNamespace, name_, static_cast<GLsizei>(label.size()), label.data());
    }
    GLuint name() const { return name_; }

  private:
    GLuint name_ = 0;
};

inline void delete_gl_buffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void delete_gl_shader(GLuint name) { glDeleteShader(name); }
inline void delete_gl_program(GLuint name) { glDeleteProgram(name); }
inline void delete_gl_query(GLuint name) { glDeleteQueries(1, &name); }

/// Owns a fence.
class GlFence {
  public:
    GlFence() = default;
    explicit GlFence(GLsync sync) : sync_(sync) {}
    GlFence(GlFence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
    GlFence& operator=(GlFence&& other) noexcept {
        std::swap(sync_, other.sync_);
        return *this;
    }
    ~GlFence() {
        if (sync_ != nullptr && !LostGlObjects::are_lost()) glDeleteSync(sync_);
    }
    GLsync sync() const { return sync_; }

  private:
    GLsync sync_ = nullptr;
};

using GlBuffer = GlObject<GL_BUFFER, delete_gl_buffer>;
using GlShader = GlObject<GL_SHADER, delete_gl_shader>;
using GlProgram = GlObject<GL_PROGRAM, delete_gl_program>;
using GlQuery = GlObject<GL_QUERY, delete_gl_query>;

}  // namespace bsoil::device
