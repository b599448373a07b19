#include "gpu_mesh.h"

#include <algorithm>

namespace bsoil::render {
namespace {

constexpr GLuint kWetnessPlace = 5;  ///< of the attribute, see surface.vert
constexpr GLuint kSkinPlace = 6;

void upload(GLenum target, const GlBuffer& buffer, size_t bytes, const void* data) {
    glBindBuffer(target, buffer.name());
    glBufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
}

}  // namespace

void GpuMesh::fill(const Mesh& source, const Skin& skin, const char* label) {
    if (!source.validate()) return fill({}, {}, label);
    if (layout.name() == 0) {
        layout = GlVertexArray(label);
        positions = GlBuffer(label);
        normals = GlBuffer(label);
        colors = GlBuffer(label);
        indices = GlBuffer(label);
    }
    used = true;
    index_count = static_cast<GLsizei>(source.indices.size());
    glBindVertexArray(layout.name());
    const struct {
        const GlBuffer& buffer;
        const std::vector<float>& values;
    } attributes[3] = {
        {positions, source.positions}, {normals, source.normals}, {colors, source.colors}};
    for (GLuint a = 0; a < 3; ++a) {
        const auto& values = attributes[a].values;
        upload(GL_ARRAY_BUFFER, attributes[a].buffer, values.size() * sizeof(float), values.data());
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    }
    fill_weights(source, label);
    fill_wetness(source, label);
    fill_skin(source, skin, label);
    upload(GL_ELEMENT_ARRAY_BUFFER, indices, source.indices.size() * sizeof(uint32_t),
           source.indices.data());
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    low = glm::dvec3(1e300);
    high = glm::dvec3(-1e300);
    for (size_t i = 0; i + 2 < source.positions.size(); i += 3) {
        const glm::dvec3 p{source.positions[i], source.positions[i + 1], source.positions[i + 2]};
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
}

void GpuMesh::fill_weights(const Mesh& source, const char* label) {
    constexpr GLuint kFirst = 3;  // two attributes of four materials
    constexpr GLsizei kBytes = sizeof(MaterialWeights);
    static_assert(kBytes == 8);
    palette.clear();
    if (source.weights.empty() || source.weights.size() != source.vertex_count()) {
        for (GLuint a = 0; a < 2; ++a) glDisableVertexAttribArray(kFirst + a);
        return;
    }
    for (const auto& [r, g, b] : source.palette) palette.emplace_back(r, g, b);
    if (weights.name() == 0) weights = GlBuffer(label);
    upload(GL_ARRAY_BUFFER, weights, source.weights.size() * kBytes, source.weights.data());
    for (GLuint a = 0; a < 2; ++a) {
        glEnableVertexAttribArray(kFirst + a);
        glVertexAttribPointer(kFirst + a, 4, GL_UNSIGNED_BYTE, GL_TRUE, kBytes,
                              reinterpret_cast<const void*>(static_cast<uintptr_t>(4 * a)));
    }
}

void GpuMesh::fill_wetness(const Mesh& source, const char* label) {
    is_wet = source.wetness.size() == source.vertex_count() &&
             std::any_of(source.wetness.begin(), source.wetness.end(),
                         [](uint8_t wet) { return wet > 0; });
    if (!is_wet) {
        glDisableVertexAttribArray(kWetnessPlace);
        return;
    }
    if (wetness.name() == 0) wetness = GlBuffer(label);
    upload(GL_ARRAY_BUFFER, wetness, source.wetness.size(), source.wetness.data());
    glEnableVertexAttribArray(kWetnessPlace);
    glVertexAttribPointer(kWetnessPlace, 1, GL_UNSIGNED_BYTE, GL_TRUE, 1, nullptr);
}

void GpuMesh::fill_skin(const Mesh& source, const Skin& skin, const char* label) {
    parts.clear();
    if (skin.parts.empty() || skin.places.size() != 2 * source.vertex_count()) {
        glDisableVertexAttribArray(kSkinPlace);
        return;
    }
    const auto end = static_cast<uint32_t>(source.indices.size());
    uint32_t done = 0;
    for (const Skin::Part& part : skin.parts) {
        const uint32_t begin = std::clamp(part.index_begin, done, end);
        const uint32_t count = std::min(part.index_count, end - begin);
        if (begin > done) parts.push_back({{}, done, begin - done});
        if (count > 0) parts.push_back({part.texture, begin, count});
        done = begin + count;
    }
    if (done < end) parts.push_back({{}, done, end - done});
    if (places.name() == 0) places = GlBuffer(label);
    upload(GL_ARRAY_BUFFER, places, skin.places.size() * sizeof(float), skin.places.data());
    glEnableVertexAttribArray(kSkinPlace);
    glVertexAttribPointer(kSkinPlace, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void GpuMesh::draw(uint32_t index_begin, uint32_t count) const {
    glBindVertexArray(layout.name());
    if (!is_wet) glVertexAttrib1f(kWetnessPlace, 0);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(uintptr_t{index_begin} * sizeof(uint32_t)));
}

}  // namespace bsoil::render
