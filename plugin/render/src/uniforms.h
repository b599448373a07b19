/// Uniforms by name, and which texture unit holds what.
#pragma once

#include <epoxy/gl.h>

#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "frame.h"
#include "gl_objects.h"

namespace bsoil::render {

/// Texture units, the same in all shaders.
enum Unit {
    kShadowUnit,
    kOcclusionUnit,
    kGrainUnit,
    kDepthUnit,
    kColorUnit,
    kNormalUnit,
    kMaterialUnit,
    kBlendUnit,
    kVolumeUnit,
    kBlockUnit,
    kSkinUnit,
    kUnitCount
};

/// Uniforms of the program in use, by name.
struct Uniforms {
    GLuint program;
    explicit Uniforms(const GlProgram& used) : program(used.name()) { glUseProgram(program); }
    GLint at(const char* name) const { return glGetUniformLocation(program, name); }
    void set(const char* name, const glm::mat4& value) const {
        glUniformMatrix4fv(at(name), 1, GL_FALSE, glm::value_ptr(value));
    }
    void set(const char* name, const glm::vec3& value) const {
        glUniform3fv(at(name), 1, glm::value_ptr(value));
    }
    void set(const char* name, const glm::vec2& value) const {
        glUniform2fv(at(name), 1, glm::value_ptr(value));
    }
    void set(const char* name, const glm::vec4& value) const {
        glUniform4fv(at(name), 1, glm::value_ptr(value));
    }
    void set(const char* name, std::span<const glm::vec3> values) const {
        glUniform3fv(at(name), static_cast<GLsizei>(values.size()), &values[0].x);
    }
    void set(const char* name, std::span<const glm::mat4> values) const {
        glUniformMatrix4fv(at(name), static_cast<GLsizei>(values.size()), GL_FALSE,
                           glm::value_ptr(values[0]));
    }
    void set(const char* name, std::span<const float> values) const {
        glUniform1fv(at(name), static_cast<GLsizei>(values.size()), values.data());
    }
    void set(const char* name, float value) const { glUniform1f(at(name), value); }
    void set(const char* name, int value) const { glUniform1i(at(name), value); }
    void set(const char* name, bool value) const { glUniform1i(at(name), value ? 1 : 0); }
    void set_unit(const char* name, Unit unit) const { glUniform1i(at(name), unit); }
    /// Draws what the eye sees of an item, with its `model` and its `cut`.
    void draw_seen(const Placed& placed, const glm::vec4& cut) const {
        draw_seen(placed, cut, [&placed] { placed.mesh->draw(); });
    }
    /// The same; `draw_mesh` draws the triangles.
    template <typename DrawMesh>
    void draw_seen(const Placed& placed, const glm::vec4& cut, const DrawMesh& draw_mesh) const {
        const bool is_cut = placed.item && placed.item->is_cut;
        set("cut", is_cut ? cut : glm::vec4(0));
        if (is_cut) glEnable(GL_CLIP_DISTANCE0);
        set("model", placed.model);
        placed.set_culling();
        draw_mesh();
        if (is_cut) glDisable(GL_CLIP_DISTANCE0);
    }
    /// Draws meshes, each with its `model`.
    void draw(std::span<const Placed> list) const {
        const GLint model = at("model");
        for (const Placed& placed : list) {
            glUniformMatrix4fv(model, 1, GL_FALSE, glm::value_ptr(placed.model));
            placed.draw();
        }
    }
};

/// The line of sight through each place of the screen.
inline void set_rays(const Uniforms& uniforms, const Frame& f) {
    const glm::vec4 to_view = f.to_view();
    const glm::mat3 to_world = glm::transpose(glm::mat3(f.look));
    uniforms.set("ray", to_world * glm::vec3(to_view.z, to_view.w, -1));
    uniforms.set("ray_x", to_view.x * to_world[0]);
    uniforms.set("ray_y", to_view.y * to_world[1]);
}

template <typename Texture>
void bind_texture(Unit unit, GLenum target, const Texture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture.name());
}

}  // namespace bsoil::render
