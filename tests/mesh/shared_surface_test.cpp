/// The surface as a host's own OpenGL context reads it.
#include "bsoil/shared_surface.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "mesh/kept_meshes.h"
#include "mesh_checks.h"
#include "mixed_wet_tiles.h"
#include "voxel_tiles.h"

namespace bsoil::shared_surface_test {
namespace {

using test::fill_with_hills;
using test::fill_with_noise;
using test::MixedWetTiles;
using test::VoxelTiles;

/// A host's context without a window; current while it lives, if it could be made.
class HostContext {
  public:
    explicit HostContext(EGLenum api = EGL_OPENGL_API) {
        display_ =
            eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr)) return;
        eglBindAPI(api);
        const EGLint desktop[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                                  EGL_NONE};
        const EGLint embedded[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
        context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT,
                                    api == EGL_OPENGL_API ? desktop : embedded);
        is_current_ = context_ != EGL_NO_CONTEXT &&
                      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
    }
    ~HostContext() {
        if (context_ != EGL_NO_CONTEXT) {
            eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            eglDestroyContext(display_, context_);
        }
        eglBindAPI(EGL_OPENGL_API);
    }
    HostContext(const HostContext&) = delete;
    HostContext& operator=(const HostContext&) = delete;
    bool is_current() const { return is_current_; }
    EGLContext context() const { return context_; }
    EGLDisplay display() const { return display_; }

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    bool is_current_ = false;
};

/// A whole buffer, read in the context that is current.
template <typename T>
std::vector<T> content_of(GLuint buffer) {
    GLint64 bytes = 0;
    glGetNamedBufferParameteri64v(buffer, GL_BUFFER_SIZE, &bytes);
    std::vector<T> content(static_cast<size_t>(bytes) / sizeof(T));
    glGetNamedBufferSubData(buffer, 0, static_cast<GLsizeiptr>(content.size() * sizeof(T)),
                            content.data());
    return content;
}

/// Empty where a tile's block, as the host reads it, is the CPU's mesh; else what differs. Indices,
/// positions, weights and wetness have to be the same bits. Normals, and colours of mixtures, may
/// differ by how a device rounds a root.
std::string difference(const SharedSurface& surface, int tx, int ty,
                       const std::vector<SharedVertex>& vertices,
                       const std::vector<uint32_t>& indices, const Mesh& expected) {
    const SharedBlock block = surface.block(tx, ty);
    if (block.vertex_count != static_cast<int64_t>(expected.vertex_count())) return "vertex count";
    if (block.index_count != static_cast<int64_t>(expected.indices.size())) return "index count";
    if (!std::equal(expected.indices.begin(), expected.indices.end(),
                    indices.begin() + block.index_at)) {
        return "indices";
    }
    const std::array<double, 16> model = surface.model();
    for (size_t v = 0; v < expected.vertex_count(); ++v) {
        const SharedVertex& vertex = vertices[static_cast<size_t>(block.vertex_at) + v];
        double normal[3] = {0, 0, 0};
        for (size_t axis = 0; axis < 3; ++axis) {
            double at = model[12 + axis];
            for (size_t k = 0; k < 3; ++k) {
                at += model[4 * k + axis] * static_cast<double>(vertex.position[k]);
                normal[axis] += model[4 * k + axis] * static_cast<double>(vertex.normal[k]);
            }
            if (std::abs(at - static_cast<double>(expected.positions[3 * v + axis])) > 1e-6) {
                return "position";
            }
            const float color = expected.colors[3 * v + axis];
            if (std::abs(vertex.color[axis] - color) > 1e-6f) return "color";
        }
        const double scale = std::hypot(normal[0], normal[1], normal[2]);
        for (size_t axis = 0; axis < 3; ++axis) {
            const double own = static_cast<double>(expected.normals[3 * v + axis]);
            if (std::abs(normal[axis] / scale - own) > 2e-6) return "normal";
        }
        if (!expected.weights.empty() &&
            !std::equal(expected.weights[v].begin(), expected.weights[v].end(), vertex.weights)) {
            return "weights";
        }
        const float wetness =
            expected.wetness.empty() ? 0 : static_cast<float>(expected.wetness[v]) / 255;
        if (vertex.wetness != wetness) return "wetness";
    }
    return "";
}

/// Compares all tiles, and the commands that draw them.
void expect_same(const SharedSurface& surface, const SurfaceMesher& host) {
    glWaitSync(static_cast<GLsync>(surface.fence()), 0, GL_TIMEOUT_IGNORED);
    const auto vertices = content_of<SharedVertex>(surface.vertex_buffer());
    const auto indices = content_of<uint32_t>(surface.index_buffer());
    const auto draws = content_of<uint32_t>(surface.draw_buffer());
    ASSERT_GE(draws.size(), 5 * static_cast<size_t>(surface.draw_count()));
    for (int ty = 0; ty < host.tile_count_y(); ++ty) {
        for (int tx = 0; tx < host.tile_count_x(); ++tx) {
            ASSERT_EQ(difference(surface, tx, ty, vertices, indices, host.tile_mesh(tx, ty)), "")
                << "tile " << tx << ", " << ty;
            const SharedBlock block = surface.block(tx, ty);
            const uint32_t* draw = &draws[5 * static_cast<size_t>(ty * host.tile_count_x() + tx)];
            EXPECT_EQ(draw[0], block.index_count);
            EXPECT_EQ(draw[1], 1u);
            EXPECT_EQ(draw[2], block.index_at);
            EXPECT_EQ(draw[3], block.vertex_at);
        }
    }
}

TEST(SharedSurface, a_hosts_context_reads_the_mesh_of_the_cpu) {
    const HostContext host;
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL 4.5 context by EGL";
    std::mt19937 random(41);
    for (int world = 0; world < 8; ++world) {
        VoxelTiles tiles(37, 21, 26);
        tiles.frame().voxel_m = 0.03;
        tiles.frame().grid_to_world = {{1.3, -4.5, 0.7}, {0.5, -0.5, 0.5, 0.5}};
        if (world % 2 == 0) fill_with_hills(tiles, world);
        if (world % 2 == 1) fill_with_noise(tiles, random, true);
        const MixedWetTiles mixed(tiles);
        SharedSurfaceDef def;
        def.level = world / 2;
        def.mesh.close_floor = world != 3;
        def.egl_display = host.display();
        def.egl_context = host.context();
        auto surface = SharedSurface::create(mixed, def);
        ASSERT_TRUE(surface) << surface.error();
        EXPECT_EQ(eglGetCurrentContext(), host.context());
        SurfaceMesher expected(mixed, def.mesh);
        const std::vector<uint8_t> levels(
            static_cast<size_t>(expected.tile_count_x() * expected.tile_count_y()),
            static_cast<uint8_t>(def.level));
        expected.update(levels);
        const auto updated = (*surface)->update();
        ASSERT_TRUE(updated) << updated.error();
        EXPECT_EQ(updated->tile_gl_count, updated->tile_built_count);
        EXPECT_EQ(eglGetCurrentContext(), host.context());
        SCOPED_TRACE("world " + std::to_string(world));
        expect_same(**surface, expected);
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    }
}

TEST(SharedSurface, only_what_changed_is_meshed_again_and_the_rest_stays) {
    const HostContext host;
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL 4.5 context by EGL";
    VoxelTiles tiles(80, 80, 24);
    fill_with_hills(tiles, 0);
    auto surface = SharedSurface::create(tiles);  // for the context that is current
    ASSERT_TRUE(surface) << surface.error();
    SurfaceMesher expected(tiles);
    expected.update();
    ASSERT_TRUE((*surface)->update());
    EXPECT_EQ((*surface)->changed_tiles().size(), 100u);
    std::mt19937 random(42);
    std::uniform_int_distribution<int> place(0, 79);
    for (int round = 0; round < 40; ++round) {  // towers grow and go: meshes move, buffers grow
        const int x = place(random), y = place(random);
        for (int z = 0; z < 24; ++z) {
            tiles.volume(x, y, z) = z < (round * 7) % 24 || (z + round) % 5 < 2 ? 1.0f : 0.0f;
        }
        tiles.touch(x, y);
        const SurfaceMeshReport report = expected.update();
        // The host has drawn from the buffers.
        const GLsync drawn = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        glFlush();
        const auto updated = (*surface)->update(drawn);
        glDeleteSync(drawn);
        ASSERT_TRUE(updated) << updated.error();
        EXPECT_EQ(updated->tile_built_count, report.tile_built_count);
        EXPECT_LE(report.tile_built_count, 25);
        ASSERT_TRUE(std::ranges::equal((*surface)->changed_tiles(), expected.changed_tiles()));
        expect_same(**surface, expected);
        if (HasFatalFailure()) return;
    }
    EXPECT_EQ((*surface)->update()->tile_built_count, 0);
    // Far more than there was room for: the buffers are others now.
    const uint32_t old_name = (*surface)->vertex_buffer();
    fill_with_noise(tiles, random, true);
    for (int tile = 0; tile < 100; ++tile) tiles.touch(tile % 10 * 8, tile / 10 * 8);
    expected.update();
    ASSERT_TRUE((*surface)->update());
    EXPECT_NE((*surface)->vertex_buffer(), old_name);
    expect_same(**surface, expected);
}

/// Draws the buffers in the host's context, from above, and counts the pixels that they cover.
int drawn_pixel_count(const SharedSurface& surface, int width, int height) {
    const auto compile = [](GLenum kind, const char* text) {
        const GLuint shader = glCreateShader(kind);
        glShaderSource(shader, 1, &text, nullptr);
        glCompileShader(shader);
        return shader;
    };
    const GLuint program = glCreateProgram();
    glAttachShader(program, compile(GL_VERTEX_SHADER, R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 0) uniform vec2 size;
void main() { gl_Position = vec4(2.0 * position.xy / size - 1.0, 0.0, 1.0); })"));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, R"(#version 450 core
out vec4 color;
void main() { color = vec4(1.0); })"));
    glLinkProgram(program);
    GLuint target = 0, framebuffer = 0, array = 0;
    glCreateRenderbuffers(1, &target);
    glNamedRenderbufferStorage(target, GL_RGBA8, width, height);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferRenderbuffer(framebuffer, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
    glClear(GL_COLOR_BUFFER_BIT);
    glCreateVertexArrays(1, &array);
    glBindVertexArray(array);
    glWaitSync(static_cast<GLsync>(surface.fence()), 0, GL_TIMEOUT_IGNORED);
    glBindBuffer(GL_ARRAY_BUFFER, surface.vertex_buffer());
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(SharedVertex), nullptr);
    glEnableVertexAttribArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, surface.index_buffer());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, surface.draw_buffer());
    glUseProgram(program);
    glUniform2f(0, static_cast<float>(width), static_cast<float>(height));
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, surface.draw_count(), 0);
    std::vector<unsigned char> pixels(4 * static_cast<size_t>(width) * static_cast<size_t>(height));
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    int count = 0;
    for (size_t p = 0; p < pixels.size(); p += 4) count += pixels[p] == 255;
    return count;
}

TEST(SharedSurface, a_host_draws_all_of_it_with_one_call) {
    const HostContext host;
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL 4.5 context by EGL";
    VoxelTiles tiles(40, 24, 16);
    tiles.fill_heights([](double x, double) { return x < 20 ? 6.0 : 0.0; });
    auto surface = SharedSurface::create(tiles);
    ASSERT_TRUE(surface) << surface.error();
    ASSERT_TRUE((*surface)->update());
    // A pixel a column: the half that has soil, which ends half way to the next column.
    const int pixels = drawn_pixel_count(**surface, 40, 24);
    EXPECT_GE(pixels, 20 * 24);
    EXPECT_LE(pixels, 21 * 24);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

TEST(SharedSurface, the_mesh_is_closed_and_has_the_soils_volume) {
    const HostContext host;
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL 4.5 context by EGL";
    VoxelTiles tiles(40, 40, 24);
    tiles.frame().voxel_m = 0.05;
    tiles.fill_heights([](double x, double y) { return 9 + 4 * std::sin(0.2 * x) + 0.1 * y; });
    auto surface = SharedSurface::create(tiles);
    ASSERT_TRUE(surface) << surface.error();
    ASSERT_TRUE((*surface)->update());
    glWaitSync(static_cast<GLsync>((*surface)->fence()), 0, GL_TIMEOUT_IGNORED);
    const auto vertices = content_of<SharedVertex>((*surface)->vertex_buffer());
    const auto indices = content_of<uint32_t>((*surface)->index_buffer());
    Mesh all;
    for (int tile = 0; tile < (*surface)->draw_count(); ++tile) {
        const SharedBlock block = (*surface)->block(tile % 5, tile / 5);
        const auto first = static_cast<uint32_t>(all.vertex_count());
        for (int64_t v = block.vertex_at; v < block.vertex_at + block.vertex_count; ++v) {
            const SharedVertex& vertex = vertices[static_cast<size_t>(v)];
            all.positions.insert(all.positions.end(), vertex.position, vertex.position + 3);
        }
        for (int64_t i = block.index_at; i < block.index_at + block.index_count; ++i) {
            all.indices.push_back(first + indices[static_cast<size_t>(i)]);
        }
    }
    EXPECT_EQ(test::open_edge_count(all), 0);
    double soil = 0;
    tiles.for_each_voxel(
        [&](int x, int y, int z) { soil += static_cast<double>(tiles.volume(x, y, z)); });
    EXPECT_NEAR(test::enclosed_volume(all), soil, 0.01 * soil);
}

TEST(SharedSurface, says_why_contexts_cannot_share) {
    VoxelTiles tiles(8, 8, 8);
    const auto none = SharedSurface::create(tiles);
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().find("no EGL context is current"), std::string::npos) << none.error();
    const HostContext host;
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL 4.5 context by EGL";
    int nothing = 0;
    SharedSurfaceDef def;
    def.egl_display = host.display();
    def.egl_context = &nothing;
    const auto foreign = SharedSurface::create(tiles, def);
    ASSERT_FALSE(foreign);
    EXPECT_NE(foreign.error().find("none of its EGL display"), std::string::npos)
        << foreign.error();
    def = {};
    def.level = 4;
    const auto coarse = SharedSurface::create(tiles, def);
    ASSERT_FALSE(coarse);
    EXPECT_NE(coarse.error().find("SharedSurfaceDef::level is 4"), std::string::npos);
}

TEST(SharedSurface, does_not_share_with_opengl_es) {
    const HostContext host(EGL_OPENGL_ES_API);
    if (!host.is_current()) GTEST_SKIP() << "no OpenGL ES 3 context by EGL";
    VoxelTiles tiles(8, 8, 8);
    const auto made = SharedSurface::create(tiles);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().find("OpenGL ES"), std::string::npos) << made.error();
    EXPECT_EQ(eglGetCurrentContext(), host.context());
}

TEST(RangeList, joins_what_is_given_back) {
    mesh::RangeList ranges;
    EXPECT_EQ(ranges.take(10), 0);
    EXPECT_EQ(ranges.take(5), 10);
    EXPECT_EQ(ranges.take(7), 15);
    ranges.give_back(10, 5);
    EXPECT_EQ(ranges.take(3), 10);
    ranges.give_back(0, 10);
    ranges.give_back(10, 3);
    EXPECT_EQ(ranges.take(15), 0);  // 0..15 is one range again
    EXPECT_EQ(ranges.end(), 22);
}

}  // namespace
}  // namespace bsoil::shared_surface_test
