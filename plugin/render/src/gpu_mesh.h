/// A mesh on the device.
#pragma once

#include <epoxy/gl.h>

#include <glm/glm.hpp>
#include <vector>

#include "bsoil/render/renderer.h"
#include "gl_objects.h"

namespace bsoil::render {

struct GpuMesh {
    GlVertexArray layout;
    GlBuffer positions, normals, colors, indices, weights, wetness;
    GlBuffer places;                 ///< in textures
    std::vector<Skin::Part> parts;   ///< all indices in runs; empty: no textures
    std::vector<glm::vec3> palette;  ///< of the materials weighed; empty: one material
    GLsizei index_count = 0;
    bool is_wet = false;         ///< somewhere
    glm::dvec3 low{0}, high{0};  ///< bounds in the mesh's frame
    bool used = false;

    /// Copies the triangles to the device.
    void fill(const Mesh& source, const Skin& skin, const char* label);
    void draw() const { draw(0, static_cast<uint32_t>(index_count)); }
    void draw(uint32_t index_begin, uint32_t count) const;

  private:
    void fill_weights(const Mesh& source, const char* label);
    void fill_wetness(const Mesh& source, const char* label);
    void fill_skin(const Mesh& source, const Skin& skin, const char* label);
};

}  // namespace bsoil::render
