#include "bsoil/render/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "bsoil/render/primitives.h"
#include "gl_context.h"
#include "gl_objects.h"
#include "shader_sources.h"

namespace bsoil::render {
namespace {

constexpr int kPictureSideMax = 8192;
constexpr int kNoiseSide = 32;        ///< texels of the grain volume along each axis
constexpr double kCoarsePeriods = 8;  ///< fine periods in one of the coarse grain pattern
constexpr double kOcclusionShare =
    0.05;                           ///< radius of ambient occlusion, of the distance to the target
constexpr double kFadeBegin = 0.9;  ///< where the floor starts to fade, of the scene's radius
constexpr double kFadeEnd = 1.5;    ///< and is gone, at the distance to the target further out
constexpr glm::vec3 kHorizonColor{0.66f, 0.74f, 0.82f};  ///< linear
constexpr glm::vec3 kZenithColor{0.16f, 0.31f, 0.58f};
constexpr Color kFloorColor{0.50f, 0.52f, 0.55f};

glm::dvec3 to_glm(Vec3 v) { return {v.x, v.y, v.z}; }

/// Which texture unit holds what, in all shaders.
enum Unit { kShadowUnit, kOcclusionUnit, kGrainUnit, kDepthUnit };

struct GpuMesh {
    GlVertexArray layout;
    GlBuffer positions, normals, colors, indices;
    GLsizei index_count = 0;
    glm::dvec3 low{0}, high{0};  ///< bounds in the mesh's frame
    bool used = false;
};

/// One target of a size: depth, and colour where wanted.
struct Target {
    GlFramebuffer framebuffer;
    GlTexture2D color, depth;
    int width = 0, height = 0;
};

void set_filter(GLenum target, GLint filter, GLint wrap) {
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, wrap);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, wrap);
}

/// A depth texture of a new framebuffer without colour.
Target create_depth_target(const char* label, int width, int height) {
    Target target{GlFramebuffer(label), {}, GlTexture2D(label), width, height};
    glBindTexture(GL_TEXTURE_2D, target.depth.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, width, height, 0, GL_DEPTH_COMPONENT,
                 GL_FLOAT, nullptr);
    set_filter(GL_TEXTURE_2D, GL_NEAREST, GL_CLAMP_TO_EDGE);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target.depth.name(),
                           0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    return target;
}

Target create_color_target(const char* label, int width, int height, GLint format) {
    Target target{GlFramebuffer(label), GlTexture2D(label), {}, width, height};
    glBindTexture(GL_TEXTURE_2D, target.color.name());
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    set_filter(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.color.name(),
                           0);
    return target;
}

/// Smooth random values that repeat; mip levels let far grains fade to their mean.
GlTexture3D create_grains() {
    std::mt19937 random(20);  // any fixed seed: pictures of one scene are equal
    std::vector<uint8_t> texels(4 * kNoiseSide * kNoiseSide * kNoiseSide);
    for (uint8_t& value : texels) value = static_cast<uint8_t>(random() >> 24);
    GlTexture3D texture("grains");
    glBindTexture(GL_TEXTURE_3D, texture.name());
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, kNoiseSide, kNoiseSide, kNoiseSide, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, texels.data());
    glGenerateMipmap(GL_TEXTURE_3D);
    set_filter(GL_TEXTURE_3D, GL_LINEAR, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_REPEAT);
    return texture;
}

void upload(GLenum target, const GlBuffer& buffer, size_t bytes, const void* data) {
    glBindBuffer(target, buffer.name());
    glBufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
}

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
    void set(const char* name, float value) const { glUniform1f(at(name), value); }
    void set_unit(const char* name, Unit unit) const { glUniform1i(at(name), unit); }
};

template <typename Texture>
void bind_texture(Unit unit, GLenum target, const Texture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture.name());
}

Error out_of_range(const char* field, double value, const char* range) {
    return {std::string(field) + " = " + std::to_string(value) + " must be " + range};
}

Status validate_view(const View& view) {
    if (view.width < 1 || view.width > kPictureSideMax) {
        return out_of_range("View::width", view.width, "in 1..8192 pixels");
    }
    if (view.height < 1 || view.height > kPictureSideMax) {
        return out_of_range("View::height", view.height, "in 1..8192 pixels");
    }
    const Camera& camera = view.camera;
    if (!(camera.fov_rad >= 0.05 && camera.fov_rad <= 2.5)) {
        return out_of_range("Camera::fov_rad", camera.fov_rad, "in 0.05..2.5 rad");
    }
    const Vec3 sight = camera.target - camera.eye;
    if (!is_finite(camera.eye) || !is_finite(sight) || !is_finite(camera.up) ||
        !(length(cross(sight, camera.up)) > 1e-9 * length(sight) * length(camera.up))) {
        return Error{"Camera: eye, target and up must be finite and not in one line"};
    }
    if (!is_finite(view.to_sun) || !(length(view.to_sun) > 0)) {
        return Error{"View::to_sun must be finite and not zero"};
    }
    return Done{};
}

}  // namespace

Status RendererDef::validate() const {
    if (sample_count < 1 || sample_count > 8) {
        return out_of_range("RendererDef::sample_count", sample_count, "in 1..8");
    }
    if (shadow_map_size < 256 || shadow_map_size > 8192) {
        return out_of_range("RendererDef::shadow_map_size", shadow_map_size, "in 256..8192");
    }
    return Done{};
}

/// All GL objects; made and destroyed with the context current.
struct Scene {
    GlProgram surface, depth, sky, occlusion, smooth;
    GlVertexArray no_vertices;
    GlTexture3D grains;
    Target shadow, view_depth, rough_occlusion, smooth_occlusion;
    GlFramebuffer samples, picture;
    GlRenderbuffer samples_color, samples_depth, picture_color;
    int width = 0, height = 0;
    std::vector<GpuMesh> meshes;
    GpuMesh floor;
};

struct Renderer::Impl {
    std::unique_ptr<GlContext> context;
    std::unique_ptr<Scene> scene;
    RendererDef def;
    std::string device_name;

    ~Impl() {
        if (!scene) return;
        const CurrentContext current(*context);
        scene.reset();
    }

    Status create_scene();
    void create_targets(int width, int height);
    void fill(GpuMesh& mesh, const Mesh& source, const char* label);
    Result<Image> draw(const View& view);
};

Status Renderer::Impl::create_scene() {
    scene = std::make_unique<Scene>();
    const struct {
        GlProgram& program;
        const char* label;
        const char* vertex_text;
        const char* fragment_text;
    } programs[] = {
        {scene->surface, "surface", shaders::surface_vert, shaders::surface_frag},
        {scene->depth, "depth", shaders::depth_vert, shaders::depth_frag},
        {scene->sky, "sky", shaders::screen_vert, shaders::sky_frag},
        {scene->occlusion, "occlusion", shaders::screen_vert, shaders::occlusion_frag},
        {scene->smooth, "smooth", shaders::screen_vert, shaders::smooth_frag},
    };
    for (const auto& entry : programs) {
        Result<GlProgram> linked =
            link_program(entry.label, entry.vertex_text, entry.fragment_text);
        if (!linked) return Error{linked.error()};
        entry.program = std::move(*linked);
    }
    scene->no_vertices = GlVertexArray("no vertices");
    scene->grains = create_grains();
    scene->shadow = create_depth_target("shadow map", def.shadow_map_size, def.shadow_map_size);
    glBindTexture(GL_TEXTURE_2D, scene->shadow.depth.name());
    set_filter(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    GLint sample_max = 1;
    glGetIntegerv(GL_MAX_SAMPLES, &sample_max);
    def.sample_count = std::min(def.sample_count, static_cast<int>(sample_max));
    const GLubyte* name = glGetString(GL_RENDERER);
    device_name = name ? reinterpret_cast<const char*>(name) : "unknown";
    return Done{};
}

void Renderer::Impl::create_targets(int width, int height) {
    if (scene->width == width && scene->height == height) return;
    scene->width = width;
    scene->height = height;
    // Ambient occlusion is soft: half the resolution does.
    const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    scene->view_depth = create_depth_target("view depth", half_width, half_height);
    scene->rough_occlusion = create_color_target("rough occlusion", half_width, half_height, GL_R8);
    scene->smooth_occlusion = create_color_target("occlusion", half_width, half_height, GL_R8);
    const auto storage = [&](GlRenderbuffer& buffer, const char* label, int samples,
                             GLenum format) {
        buffer = GlRenderbuffer(label);
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    };
    storage(scene->samples_color, "samples", def.sample_count, GL_RGBA8);
    storage(scene->samples_depth, "samples' depth", def.sample_count, GL_DEPTH_COMPONENT24);
    storage(scene->picture_color, "picture", 0, GL_RGBA8);
    scene->samples = GlFramebuffer("samples");
    glBindFramebuffer(GL_FRAMEBUFFER, scene->samples.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              scene->samples_color.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                              scene->samples_depth.name());
    scene->picture = GlFramebuffer("picture");
    glBindFramebuffer(GL_FRAMEBUFFER, scene->picture.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              scene->picture_color.name());
}

void Renderer::Impl::fill(GpuMesh& mesh, const Mesh& source, const char* label) {
    if (mesh.layout.name() == 0) {
        mesh.layout = GlVertexArray(label);
        mesh.positions = GlBuffer(label);
        mesh.normals = GlBuffer(label);
        mesh.colors = GlBuffer(label);
        mesh.indices = GlBuffer(label);
    }
    mesh.used = true;
    mesh.index_count = static_cast<GLsizei>(source.indices.size());
    glBindVertexArray(mesh.layout.name());
    const struct {
        const GlBuffer& buffer;
        const std::vector<float>& values;
    } attributes[3] = {{mesh.positions, source.positions},
                       {mesh.normals, source.normals},
                       {mesh.colors, source.colors}};
    for (GLuint a = 0; a < 3; ++a) {
        const auto& values = attributes[a].values;
        upload(GL_ARRAY_BUFFER, attributes[a].buffer, values.size() * sizeof(float), values.data());
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    }
    upload(GL_ELEMENT_ARRAY_BUFFER, mesh.indices, source.indices.size() * sizeof(uint32_t),
           source.indices.data());
    glBindVertexArray(0);
    mesh.low = glm::dvec3(1e300);
    mesh.high = glm::dvec3(-1e300);
    for (size_t i = 0; i + 2 < source.positions.size(); i += 3) {
        const glm::dvec3 p{source.positions[i], source.positions[i + 1], source.positions[i + 2]};
        mesh.low = glm::min(mesh.low, p);
        mesh.high = glm::max(mesh.high, p);
    }
}

namespace {

/// A mesh and its place in the picture, about the eye.
struct Placed {
    const GpuMesh* mesh = nullptr;
    glm::mat4 model{1};
    float grain_m = 0, gloss = 0;
    bool is_floor = false;
};

glm::mat4 model_of(const Pose& pose, glm::dvec3 eye) {
    const glm::dvec3 columns[3] = {to_glm(rotate(pose.rotation, {1, 0, 0})),
                                   to_glm(rotate(pose.rotation, {0, 1, 0})),
                                   to_glm(rotate(pose.rotation, {0, 0, 1}))};
    const glm::dvec3 origin = to_glm(pose.position) - eye;
    return glm::mat4(glm::dmat4(glm::dvec4(columns[0], 0), glm::dvec4(columns[1], 0),
                                glm::dvec4(columns[2], 0), glm::dvec4(origin, 1)));
}

/// Sphere around all items, about the eye.
struct Bounds {
    glm::dvec3 low{1e300}, high{-1e300};
    void add(const Placed& item) {
        for (int c = 0; c < 8; ++c) {
            const GpuMesh& m = *item.mesh;
            const glm::dvec4 corner(c & 1 ? m.high.x : m.low.x, c & 2 ? m.high.y : m.low.y,
                                    c & 4 ? m.high.z : m.low.z, 1);
            const glm::dvec3 p(glm::dmat4(item.model) * corner);
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    bool empty() const { return low.x > high.x; }
    glm::dvec3 center() const { return empty() ? glm::dvec3(0) : 0.5 * (low + high); }
    double radius() const { return empty() ? 1.0 : std::max(1e-3, 0.5 * glm::length(high - low)); }
};

/// A square, two units wide, with its normal along `up`.
Mesh floor_mesh(Vec3 up) {
    const Vec3 aside = std::abs(up.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    Vec3 u = cross(aside, up);
    u = (1 / length(u)) * u;
    const Vec3 v = cross(up, u);
    return triangle_mesh({{-u - v, u - v, u + v, v - u}, {{0, 1, 2}, {0, 2, 3}}}, kFloorColor);
}

void draw_items(const Uniforms& uniforms, const std::vector<Placed>& items) {
    for (const Placed& item : items) {
        uniforms.set("model", item.model);
        glBindVertexArray(item.mesh->layout.name());
        glDrawElements(GL_TRIANGLES, item.mesh->index_count, GL_UNSIGNED_INT, nullptr);
    }
}

void draw_screen(const Scene& scene) {
    glBindVertexArray(scene.no_vertices.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

Result<Image> Renderer::Impl::draw(const View& view) {
    create_targets(view.width, view.height);
    const glm::dvec3 eye = to_glm(view.camera.eye);
    const glm::dvec3 target = to_glm(view.camera.target) - eye;
    const glm::dvec3 up = glm::normalize(to_glm(view.camera.up));
    const glm::dvec3 to_sun = glm::normalize(to_glm(view.to_sun));
    const double sight_m = glm::length(target);

    std::vector<Placed> items;
    Bounds bounds;
    for (const Item& item : view.items) {
        if (item.mesh.value == 0 || item.mesh.value > scene->meshes.size()) continue;
        const GpuMesh& mesh = scene->meshes[item.mesh.value - 1];
        if (!mesh.used || mesh.index_count == 0) continue;
        items.push_back({&mesh, model_of(item.pose, eye), item.grain_m, item.gloss});
        bounds.add(items.back());
    }
    // Near items first: what they hide is not shaded.
    const auto distance_of = [](const Placed& item) {
        const glm::dvec3 middle = 0.5 * (item.mesh->low + item.mesh->high);
        return glm::length(glm::dvec3(glm::dmat4(item.model) * glm::dvec4(middle, 1)));
    };
    std::stable_sort(items.begin(), items.end(), [&](const Placed& a, const Placed& b) {
        return distance_of(a) < distance_of(b);
    });
    const std::vector<Placed> casters = items;  // the floor, which is added next, casts no shadow
    const glm::dvec3 center = bounds.center();
    const double fade_begin_m = kFadeBegin * bounds.radius();
    const double fade_end_m = kFadeEnd * bounds.radius() + sight_m;
    glm::dvec3 floor_center = center;
    if (view.floor_height_m) {
        fill(scene->floor, floor_mesh({up.x, up.y, up.z}), "floor");
        floor_center += (*view.floor_height_m - glm::dot(eye + center, up)) * up;
        const glm::dmat4 model =
            glm::scale(glm::translate(glm::dmat4(1), floor_center), glm::dvec3(fade_end_m));
        items.push_back({&scene->floor, glm::mat4(model), 0, 0, true});
    }

    // View. The near plane is far enough out for 24 bits of depth.
    const double far_m = glm::length(center) + bounds.radius() + 2 * fade_end_m;
    const double near_m = std::max(1e-3 * far_m, 0.02 * sight_m) * 0.5;
    const double aspect = static_cast<double>(view.width) / view.height;
    const glm::dmat4 look = glm::lookAt(glm::dvec3(0), target, up);
    const glm::dmat4 projection = glm::perspective(view.camera.fov_rad, aspect, near_m, far_m);
    const glm::mat4 clip(projection * look);
    // Sun: the whole scene, or its part around the target when it is much larger than the view.
    const bool whole = bounds.radius() < 2.0 * sight_m;
    const double shadow_radius = whole ? bounds.radius() : 2.0 * sight_m;
    const glm::dvec3 shadow_center = whole ? center : target;
    const double depth_radius = bounds.radius() + glm::length(center - shadow_center);
    const glm::dvec3 sun_up =
        std::abs(glm::dot(to_sun, up)) < 0.99 ? up : glm::dvec3(up.y, up.z, up.x);
    const glm::dmat4 sun_look =
        glm::lookAt(shadow_center + depth_radius * to_sun, shadow_center, sun_up);
    const glm::dmat4 sun_clip = glm::ortho(-shadow_radius, shadow_radius, -shadow_radius,
                                           shadow_radius, 0.0, 2 * depth_radius) *
                                sun_look;
    const glm::dmat4 to_texture =
        glm::translate(glm::dmat4(1), glm::dvec3(0.5)) * glm::scale(glm::dmat4(1), glm::dvec3(0.5));
    const double shadow_texel_m = 2 * shadow_radius / def.shadow_map_size;

    // Depth from the sun, then from the eye.
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_TRUE);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glViewport(0, 0, def.shadow_map_size, def.shadow_map_size);
    glBindFramebuffer(GL_FRAMEBUFFER, scene->shadow.framebuffer.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    // Slope-scaled: a sunlit slope must not fall into its own shadow between two texels.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
    const Uniforms depth_uniforms(scene->depth);
    depth_uniforms.set("clip", glm::mat4(sun_clip));
    draw_items(depth_uniforms, casters);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glViewport(0, 0, scene->view_depth.width, scene->view_depth.height);
    glBindFramebuffer(GL_FRAMEBUFFER, scene->view_depth.framebuffer.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    depth_uniforms.set("clip", clip);
    draw_items(depth_uniforms, items);

    // Ambient occlusion from the depth.
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, scene->rough_occlusion.framebuffer.name());
    const Uniforms occlusion_uniforms(scene->occlusion);
    occlusion_uniforms.set_unit("depth", kDepthUnit);
    occlusion_uniforms.set("to_view", glm::mat4(glm::inverse(projection)));
    occlusion_uniforms.set("radius_m", static_cast<float>(kOcclusionShare * sight_m));
    occlusion_uniforms.set("focal", static_cast<float>(projection[1][1]));
    bind_texture(kDepthUnit, GL_TEXTURE_2D, scene->view_depth.depth);
    draw_screen(*scene);
    glBindFramebuffer(GL_FRAMEBUFFER, scene->smooth_occlusion.framebuffer.name());
    const Uniforms smooth_uniforms(scene->smooth);
    smooth_uniforms.set_unit("depth", kDepthUnit);
    smooth_uniforms.set_unit("occlusion", kOcclusionUnit);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, scene->rough_occlusion.color);
    draw_screen(*scene);

    // The picture.
    glEnable(GL_DEPTH_TEST);
    glViewport(0, 0, view.width, view.height);
    glBindFramebuffer(GL_FRAMEBUFFER, scene->samples.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    const Uniforms surface(scene->surface);
    surface.set_unit("shadow_map", kShadowUnit);
    surface.set_unit("occlusion", kOcclusionUnit);
    surface.set_unit("grains", kGrainUnit);
    bind_texture(kShadowUnit, GL_TEXTURE_2D, scene->shadow.depth);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, scene->smooth_occlusion.color);
    bind_texture(kGrainUnit, GL_TEXTURE_3D, scene->grains);
    surface.set("clip", clip);
    surface.set("shadow_clip", glm::mat4(to_texture * sun_clip));
    surface.set("shadow_bias_m", static_cast<float>(1.5 * shadow_texel_m));
    surface.set("up", glm::vec3(up));
    surface.set("to_sun", glm::vec3(to_sun));
    surface.set("horizon_color", kHorizonColor);
    surface.set("fade_center", glm::vec3(floor_center));
    surface.set("fade_begin_m", static_cast<float>(fade_begin_m));
    glUniform2f(surface.at("picture_size"), static_cast<float>(view.width),
                static_cast<float>(view.height));
    for (const Placed& item : items) {
        // A period has kNoiseSide grains. Origins are reduced to one period in double precision.
        const double scale = item.grain_m > 0 ? 1.0 / (kNoiseSide * item.grain_m) : 0;
        const glm::dvec3 periods = eye * scale;
        surface.set("grain_scale", static_cast<float>(scale));
        surface.set("grain_origin",
                    glm::vec3(periods - kCoarsePeriods * glm::floor(periods / kCoarsePeriods)));
        surface.set("gloss", item.gloss);
        surface.set("fade_end_m", item.is_floor ? static_cast<float>(fade_end_m) : 0.0f);
        surface.set("model", item.model);
        glBindVertexArray(item.mesh->layout.name());
        glDrawElements(GL_TRIANGLES, item.mesh->index_count, GL_UNSIGNED_INT, nullptr);
    }
    const Uniforms sky(scene->sky);
    sky.set("to_world", glm::mat4(glm::inverse(projection * look)));
    sky.set("up", glm::vec3(up));
    sky.set("to_sun", glm::vec3(to_sun));
    sky.set("horizon_color", kHorizonColor);
    sky.set("zenith_color", kZenithColor);
    draw_screen(*scene);

    glBindFramebuffer(GL_READ_FRAMEBUFFER, scene->samples.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, scene->picture.name());
    glBlitFramebuffer(0, 0, view.width, view.height, 0, 0, view.width, view.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, scene->picture.name());
    Image image{view.width, view.height, {}};
    const size_t row_bytes = 4 * static_cast<size_t>(view.width);
    image.rgba.resize(row_bytes * static_cast<size_t>(view.height));
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    for (int y = 0; y < view.height / 2; ++y) {  // GL counts rows from below
        std::swap_ranges(image.pixel(0, y), image.pixel(0, y) + row_bytes,
                         image.pixel(0, view.height - 1 - y));
    }
    const GLenum error = glGetError();
    if (error != GL_NO_ERROR) {
        return Error{"OpenGL reports error " + std::to_string(error) + " for a picture of " +
                     std::to_string(view.width) + " x " + std::to_string(view.height) + " pixels"};
    }
    return image;
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererDef& def) {
    if (const Status valid = def.validate(); !valid) return Error{valid.error()};
    Result<std::unique_ptr<GlContext>> context = GlContext::create();
    if (!context) return Error{context.error()};
    auto impl = std::make_unique<Impl>();
    impl->context = std::move(*context);
    impl->def = def;
    const CurrentContext current(*impl->context);
    if (!current.ok()) {
        return Error{"EGL cannot make its context current: another window system's is"};
    }
    if (const Status made = impl->create_scene(); !made) return Error{made.error()};
    return std::unique_ptr<Renderer>(new Renderer(std::move(impl)));
}

MeshId Renderer::add_mesh(const Mesh& mesh) {
    auto& meshes = impl_->scene->meshes;
    const auto free = std::find_if(meshes.begin(), meshes.end(),
                                   [](const GpuMesh& candidate) { return !candidate.used; });
    const MeshId id{static_cast<uint32_t>(free - meshes.begin()) + 1};
    if (free == meshes.end()) meshes.emplace_back();
    set_mesh(id, mesh);
    return id;
}

void Renderer::set_mesh(MeshId id, const Mesh& mesh) {
    if (id.value == 0 || id.value > impl_->scene->meshes.size()) return;
    const CurrentContext current(*impl_->context);
    if (current.ok()) impl_->fill(impl_->scene->meshes[id.value - 1], mesh, "mesh");
}

void Renderer::remove_mesh(MeshId id) {
    if (id.value == 0 || id.value > impl_->scene->meshes.size()) return;
    const CurrentContext current(*impl_->context);
    impl_->scene->meshes[id.value - 1] = {};
}

Result<Image> Renderer::render(const View& view) {
    if (const Status valid = validate_view(view); !valid) return Error{valid.error()};
    const CurrentContext current(*impl_->context);
    if (!current.ok()) {
        return Error{"EGL cannot make its context current: another window system's is"};
    }
    return impl_->draw(view);
}

const std::string& Renderer::device_name() const { return impl_->device_name; }

SurfaceItems::SurfaceItems(Renderer& renderer, const SurfaceMesher& mesher, float grain_m)
    : renderer_(renderer), mesher_(mesher), grain_m_(grain_m) {
    tiles_.resize(static_cast<size_t>(mesher.tile_count_x()) *
                  static_cast<size_t>(mesher.tile_count_y()));
}

SurfaceItems::~SurfaceItems() {
    for (const Tile& tile : tiles_) renderer_.remove_mesh(tile.mesh);
}

void SurfaceItems::update() {
    for (size_t t = 0; t < tiles_.size(); ++t) {
        const int tx = static_cast<int>(t) % mesher_.tile_count_x();
        const int ty = static_cast<int>(t) / mesher_.tile_count_x();
        Tile& tile = tiles_[t];
        const uint64_t revision = mesher_.tile_mesh_revision(tx, ty);
        if (tile.revision == revision) continue;
        const Mesh& mesh = mesher_.tile_mesh(tx, ty);
        tile.revision = revision;
        tile.empty = mesh.indices.empty();
        if (tile.mesh.value != 0) {
            renderer_.set_mesh(tile.mesh, mesh);
        } else if (!tile.empty) {
            tile.mesh = renderer_.add_mesh(mesh);
        }
    }
}

void SurfaceItems::append_to(std::vector<Item>& items) const {
    for (const Tile& tile : tiles_) {
        if (!tile.empty) items.push_back({tile.mesh, {}, grain_m_, 0});
    }
}

}  // namespace bsoil::render
