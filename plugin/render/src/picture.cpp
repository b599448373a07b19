#include "picture.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "bsoil/render/primitives.h"
#include "shader_sources.h"

namespace bsoil::render {
namespace {

constexpr int kNoiseSide = 32;        ///< texels of the grain volume along each axis
constexpr double kCoarsePeriods = 8;  ///< fine periods in one of the coarse grain pattern
constexpr double kOcclusionShare =
    0.05;                           ///< radius of ambient occlusion, of the distance to the target
constexpr double kFadeBegin = 0.9;  ///< where the floor starts to fade, of the scene's radius
constexpr double kFadeEnd = 1.5;    ///< and is gone, at the distance to the target further out
constexpr glm::vec3 kHorizonColor{0.66f, 0.74f, 0.82f};  ///< linear
constexpr glm::vec3 kZenithColor{0.16f, 0.31f, 0.58f};
constexpr Color kFloorColor{0.50f, 0.52f, 0.55f};
constexpr size_t kLineFloats = 9;  ///< of a line on the device: both ends and the colour

glm::dvec3 to_glm(Vec3 v) { return {v.x, v.y, v.z}; }

/// Which texture unit holds what, in all shaders.
enum Unit { kShadowUnit, kOcclusionUnit, kGrainUnit, kDepthUnit, kUnitCount };

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
    void set(const char* name, const glm::vec2& value) const {
        glUniform2fv(at(name), 1, glm::value_ptr(value));
    }
    void set(const char* name, float value) const { glUniform1f(at(name), value); }
    void set_unit(const char* name, Unit unit) const { glUniform1i(at(name), unit); }
};

template <typename Texture>
void bind_texture(Unit unit, GLenum target, const Texture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture.name());
}

glm::mat4 model_of(const Pose& pose, glm::dvec3 eye) {
    const glm::dvec3 columns[3] = {to_glm(rotate(pose.rotation, {1, 0, 0})),
                                   to_glm(rotate(pose.rotation, {0, 1, 0})),
                                   to_glm(rotate(pose.rotation, {0, 0, 1}))};
    const glm::dvec3 origin = to_glm(pose.position) - eye;
    return glm::mat4(glm::dmat4(glm::dvec4(columns[0], 0), glm::dvec4(columns[1], 0),
                                glm::dvec4(columns[2], 0), glm::dvec4(origin, 1)));
}

/// A square, two units wide, with its normal along `up`.
Mesh floor_mesh(Vec3 up) {
    const Vec3 aside = std::abs(up.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    Vec3 u = cross(aside, up);
    u = (1 / length(u)) * u;
    const Vec3 v = cross(up, u);
    return triangle_mesh({{-u - v, u - v, u + v, v - u}, {{0, 1, 2}, {0, 2, 3}}}, kFloorColor);
}

/// The six planes of a clip space, pointing inward.
std::array<glm::vec4, 6> clip_planes(const glm::mat4& clip) {
    const glm::mat4 rows = glm::transpose(clip);
    return {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
            rows[3] - rows[1], rows[3] + rows[2], rows[3] - rows[2]};
}

}  // namespace

/// A mesh and its place in the picture, about the eye.
struct Picture::Placed {
    const GpuMesh* mesh = nullptr;
    const Item* item = nullptr;  ///< null: the floor
    glm::mat4 model{1};

    glm::vec3 corner(int c) const {
        const glm::dvec4 at(c & 1 ? mesh->high.x : mesh->low.x, c & 2 ? mesh->high.y : mesh->low.y,
                            c & 4 ? mesh->high.z : mesh->low.z, 1);
        return glm::vec3(glm::dmat4(model) * at);
    }
    double distance() const {
        const glm::dvec3 middle = 0.5 * (mesh->low + mesh->high);
        return glm::length(glm::dvec3(glm::dmat4(model) * glm::dvec4(middle, 1)));
    }
    /// Whether some of its box may be within the clip space.
    bool is_seen(const std::array<glm::vec4, 6>& planes) const {
        for (const glm::vec4& plane : planes) {
            bool inside = false;
            for (int c = 0; c < 8 && !inside; ++c)
                inside = glm::dot(plane, glm::vec4(corner(c), 1)) >= 0;
            if (!inside) return false;
        }
        return true;
    }
};

/// Where everything of a view is, about its eye.
struct Picture::Frame {
    glm::dvec3 eye{0}, up{0}, to_sun{0};
    double sight_m = 1;
    std::vector<Placed> items;    ///< near ones first
    std::vector<Placed> casters;  ///< of shadows
    glm::dmat4 projection{1}, look{1};
    glm::mat4 clip{1}, sun_clip{1};
    double shadow_texel_m = 0;
    glm::dvec3 floor_center{0};
    double fade_begin_m = 0, fade_end_m = 0;
    glm::vec2 size{1};

    void draw(const Uniforms& uniforms, const std::vector<Placed>& list) const {
        const GLint model = uniforms.at("model");
        for (const Placed& placed : list) {
            glUniformMatrix4fv(model, 1, GL_FALSE, glm::value_ptr(placed.model));
            glBindVertexArray(placed.mesh->layout.name());
            glDrawElements(GL_TRIANGLES, placed.mesh->index_count, GL_UNSIGNED_INT, nullptr);
        }
    }
};

Status Picture::create() {
    const struct {
        GlProgram& program;
        const char* label;
        const char* vertex_text;
        const char* fragment_text;
    } programs[] = {
        {surface_, "surface", shaders::surface_vert, shaders::surface_frag},
        {depth_, "depth", shaders::depth_vert, shaders::depth_frag},
        {sky_, "sky", shaders::screen_vert, shaders::sky_frag},
        {occlusion_, "occlusion", shaders::screen_vert, shaders::occlusion_frag},
        {smooth_, "smooth", shaders::screen_vert, shaders::smooth_frag},
        {buffers_, "buffers", shaders::surface_vert, shaders::buffers_frag},
        {line_, "line", shaders::line_vert, shaders::line_frag},
    };
    for (const auto& entry : programs) {
        Result<GlProgram> linked =
            link_program(entry.label, entry.vertex_text, entry.fragment_text);
        if (!linked) return Error{linked.error()};
        entry.program = std::move(*linked);
    }
    no_vertices_ = GlVertexArray("no vertices");
    grains_ = create_grains();
    shadow_ = create_depth_target("shadow map", def_.shadow_map_size, def_.shadow_map_size);
    glBindTexture(GL_TEXTURE_2D, shadow_.depth.name());
    set_filter(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    GLint sample_max = 1;
    glGetIntegerv(GL_MAX_SAMPLES, &sample_max);
    def_.sample_count = std::min(def_.sample_count, static_cast<int>(sample_max));

    line_layout_ = GlVertexArray("lines");
    line_ends_ = GlBuffer("lines");
    glBindVertexArray(line_layout_.name());
    glBindBuffer(GL_ARRAY_BUFFER, line_ends_.name());
    for (GLuint a = 0; a < 3; ++a) {
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 3, GL_FLOAT, GL_FALSE, kLineFloats * sizeof(float),
                              reinterpret_cast<const void*>(3 * a * sizeof(float)));
        glVertexAttribDivisor(a, 1);
    }
    glBindVertexArray(0);
    timer_.create();
    return Done{};
}

void Picture::create_targets(int width, int height) {
    if (width_ == width && height_ == height) return;
    width_ = width;
    height_ = height;
    // Ambient occlusion is soft: half the resolution does.
    const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    view_depth_ = create_depth_target("view depth", half_width, half_height);
    rough_occlusion_ = create_color_target("rough occlusion", half_width, half_height, GL_R8);
    smooth_occlusion_ = create_color_target("occlusion", half_width, half_height, GL_R8);
    const auto storage = [&](GlRenderbuffer& buffer, const char* label, int samples,
                             GLenum format) {
        buffer = GlRenderbuffer(label);
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    };
    storage(samples_color_, "samples", def_.sample_count, GL_RGBA8);
    storage(samples_depth_, "samples' depth", def_.sample_count, GL_DEPTH_COMPONENT24);
    storage(picture_color_, "picture", 0, GL_RGBA8);
    samples_ = GlFramebuffer("samples");
    glBindFramebuffer(GL_FRAMEBUFFER, samples_.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              samples_color_.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                              samples_depth_.name());
    picture_ = GlFramebuffer("picture");
    glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              picture_color_.name());
}

void Picture::fill(GpuMesh& mesh, const Mesh& source, const char* label) {
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

Picture::Frame Picture::prepare(const View& view) {
    Frame f;
    f.size = glm::vec2(view.width, view.height);
    f.eye = to_glm(view.camera.eye);
    const glm::dvec3 target = to_glm(view.camera.target) - f.eye;
    f.up = glm::normalize(to_glm(view.camera.up));
    f.to_sun = glm::normalize(to_glm(view.to_sun));
    f.sight_m = glm::length(target);

    glm::dvec3 low(1e300), high(-1e300);
    for (const Item& item : view.items) {
        if (item.mesh.value == 0 || item.mesh.value > meshes_.size()) continue;
        const GpuMesh& mesh = meshes_[item.mesh.value - 1];
        if (!mesh.used || mesh.index_count == 0) continue;
        f.items.push_back({&mesh, &item, model_of(item.pose, f.eye)});
        for (int c = 0; c < 8; ++c) {
            const glm::dvec3 p(f.items.back().corner(c));
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    const bool is_empty = f.items.empty();
    const glm::dvec3 center = is_empty ? glm::dvec3(0) : 0.5 * (low + high);
    const double radius = is_empty ? 1.0 : std::max(1e-3, 0.5 * glm::length(high - low));
    f.casters = f.items;  // the floor, which is added next, casts no shadow
    f.fade_begin_m = kFadeBegin * radius;
    f.fade_end_m = kFadeEnd * radius + f.sight_m;
    f.floor_center = center;
    if (view.floor_height_m) {
        fill(floor_, floor_mesh({f.up.x, f.up.y, f.up.z}), "floor");
        f.floor_center += (*view.floor_height_m - glm::dot(f.eye + center, f.up)) * f.up;
        const glm::dmat4 model =
            glm::scale(glm::translate(glm::dmat4(1), f.floor_center), glm::dvec3(f.fade_end_m));
        f.items.push_back({&floor_, nullptr, glm::mat4(model)});
    }

    // View. The near plane is far enough out for 24 bits of depth.
    const double far_m = glm::length(center) + radius + 2 * f.fade_end_m;
    const double near_m = std::max(1e-3 * far_m, 0.02 * f.sight_m) * 0.5;
    const double aspect = static_cast<double>(view.width) / view.height;
    f.look = glm::lookAt(glm::dvec3(0), target, f.up);
    f.projection = glm::perspective(view.camera.fov_rad, aspect, near_m, far_m);
    f.projection[2][0] = -view.camera.shift;  // clip x = ... + shift * distance
    f.clip = glm::mat4(f.projection * f.look);
    // Sun: the whole scene, or its part around the target when it is much larger than the view.
    const bool whole = radius < 2.0 * f.sight_m;
    const double shadow_radius = whole ? radius : 2.0 * f.sight_m;
    const glm::dvec3 shadow_center = whole ? center : target;
    const double depth_radius = radius + glm::length(center - shadow_center);
    const glm::dvec3 sun_up =
        std::abs(glm::dot(f.to_sun, f.up)) < 0.99 ? f.up : glm::dvec3(f.up.y, f.up.z, f.up.x);
    const glm::dmat4 sun_look =
        glm::lookAt(shadow_center + depth_radius * f.to_sun, shadow_center, sun_up);
    f.sun_clip = glm::mat4(glm::ortho(-shadow_radius, shadow_radius, -shadow_radius, shadow_radius,
                                      0.0, 2 * depth_radius) *
                           sun_look);
    f.shadow_texel_m = 2 * shadow_radius / def_.shadow_map_size;

    // Near items first: what they hide is not shaded. What is out of the picture is not drawn.
    const auto eye_planes = clip_planes(f.clip), sun_planes = clip_planes(f.sun_clip);
    std::erase_if(f.items, [&](const Placed& placed) { return !placed.is_seen(eye_planes); });
    std::erase_if(f.casters, [&](const Placed& placed) { return !placed.is_seen(sun_planes); });
    std::stable_sort(f.items.begin(), f.items.end(), [](const Placed& a, const Placed& b) {
        if (!a.item || !b.item) return a.item != nullptr && !b.item;  // the floor last
        return a.distance() < b.distance();
    });
    return f;
}

void Picture::draw_screen() const {
    glBindVertexArray(no_vertices_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// Depth as the sun sees it.
void Picture::draw_shadows(const Frame& f) {
    glViewport(0, 0, def_.shadow_map_size, def_.shadow_map_size);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_.framebuffer.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    // Slope-scaled: a sunlit slope must not fall into its own shadow between two texels.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
    const Uniforms uniforms(depth_);
    uniforms.set("clip", f.sun_clip);
    f.draw(uniforms, f.casters);
    glDisable(GL_POLYGON_OFFSET_FILL);
}

/// Depth as the eye sees it, and ambient occlusion from that. Without occlusion all is open.
void Picture::draw_occlusion(const Frame& f) {
    if (!def_.occlusion) {
        glBindFramebuffer(GL_FRAMEBUFFER, smooth_occlusion_.framebuffer.name());
        glClearColor(1, 1, 1, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        glClearColor(0, 0, 0, 0);
        return;
    }
    glViewport(0, 0, view_depth_.width, view_depth_.height);
    glBindFramebuffer(GL_FRAMEBUFFER, view_depth_.framebuffer.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    const Uniforms depth_uniforms(depth_);
    depth_uniforms.set("clip", f.clip);
    f.draw(depth_uniforms, f.items);

    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, rough_occlusion_.framebuffer.name());
    const Uniforms uniforms(occlusion_);
    uniforms.set_unit("depth", kDepthUnit);
    uniforms.set("to_view", glm::mat4(glm::inverse(f.projection)));
    uniforms.set("radius_m", static_cast<float>(kOcclusionShare * f.sight_m));
    uniforms.set("focal", static_cast<float>(f.projection[1][1]));
    bind_texture(kDepthUnit, GL_TEXTURE_2D, view_depth_.depth);
    draw_screen();
    glBindFramebuffer(GL_FRAMEBUFFER, smooth_occlusion_.framebuffer.name());
    const Uniforms smooth_uniforms(smooth_);
    smooth_uniforms.set_unit("depth", kDepthUnit);
    smooth_uniforms.set_unit("occlusion", kOcclusionUnit);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, rough_occlusion_.color);
    draw_screen();
    glEnable(GL_DEPTH_TEST);
}

void Picture::draw_surface(const View& view, const Frame& f) {
    glViewport(0, 0, view.width, view.height);
    glBindFramebuffer(GL_FRAMEBUFFER, samples_.name());
    glClear(GL_DEPTH_BUFFER_BIT);
    const glm::dmat4 to_texture =
        glm::translate(glm::dmat4(1), glm::dvec3(0.5)) * glm::scale(glm::dmat4(1), glm::dvec3(0.5));
    const Uniforms surface(surface_);
    surface.set_unit("shadow_map", kShadowUnit);
    surface.set_unit("occlusion", kOcclusionUnit);
    surface.set_unit("grains", kGrainUnit);
    bind_texture(kShadowUnit, GL_TEXTURE_2D, shadow_.depth);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, smooth_occlusion_.color);
    bind_texture(kGrainUnit, GL_TEXTURE_3D, grains_);
    surface.set("clip", f.clip);
    surface.set("shadow_clip", glm::mat4(to_texture * glm::dmat4(f.sun_clip)));
    surface.set("shadow_bias_m", static_cast<float>(1.5 * f.shadow_texel_m));
    surface.set("up", glm::vec3(f.up));
    surface.set("to_sun", glm::vec3(f.to_sun));
    surface.set("horizon_color", kHorizonColor);
    surface.set("fade_center", glm::vec3(f.floor_center));
    surface.set("fade_begin_m", static_cast<float>(f.fade_begin_m));
    surface.set("picture_size", f.size);
    const GLint grain_scale = surface.at("grain_scale"), grain_origin = surface.at("grain_origin"),
                gloss = surface.at("gloss"), emission = surface.at("emission"),
                fade_end = surface.at("fade_end_m"), model = surface.at("model");
    const Item floor;
    for (const Placed& placed : f.items) {
        const Item& item = placed.item ? *placed.item : floor;
        // A period has kNoiseSide grains. Origins are reduced to one period in double precision.
        const double scale = item.grain_m > 0 ? 1.0 / (kNoiseSide * item.grain_m) : 0;
        const glm::dvec3 periods = f.eye * scale;
        const glm::vec3 origin(periods - kCoarsePeriods * glm::floor(periods / kCoarsePeriods));
        glUniform1f(grain_scale, static_cast<float>(scale));
        glUniform3fv(grain_origin, 1, glm::value_ptr(origin));
        glUniform1f(gloss, item.gloss);
        glUniform1f(emission, item.emission);
        glUniform1f(fade_end, placed.item ? 0.0f : static_cast<float>(f.fade_end_m));
        glUniformMatrix4fv(model, 1, GL_FALSE, glm::value_ptr(placed.model));
        glBindVertexArray(placed.mesh->layout.name());
        glDrawElements(GL_TRIANGLES, placed.mesh->index_count, GL_UNSIGNED_INT, nullptr);
    }
}

void Picture::draw_sky(const Frame& f) {
    const Uniforms sky(sky_);
    sky.set("to_world", glm::mat4(glm::inverse(f.projection * f.look)));
    sky.set("up", glm::vec3(f.up));
    sky.set("to_sun", glm::vec3(f.to_sun));
    sky.set("horizon_color", kHorizonColor);
    sky.set("zenith_color", kZenithColor);
    draw_screen();
}

void Picture::draw_lines(const View& view, const std::vector<Line>& lines, const Frame& f) {
    if (lines.empty()) return;
    line_floats_.clear();
    for (const Line& line : lines) {
        for (const Vec3 end : {line.from, line.to}) {
            const glm::vec3 at(to_glm(end) - f.eye);
            line_floats_.insert(line_floats_.end(), {at.x, at.y, at.z});
        }
        line_floats_.insert(line_floats_.end(), line.color.begin(), line.color.end());
    }
    const Uniforms uniforms(line_);
    uniforms.set("clip", f.clip);
    uniforms.set("picture_size", f.size);
    uniforms.set("width", view.line_width);
    glBindVertexArray(line_layout_.name());
    glBindBuffer(GL_ARRAY_BUFFER, line_ends_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(line_floats_.size() * sizeof(float)),
                 line_floats_.data(), GL_STREAM_DRAW);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines.size()));
}

Status Picture::draw(const View& view, GLuint framebuffer) {
    timer_.poll();
    create_targets(view.width, view.height);
    const Frame frame = prepare(view);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    timer_.mark(PassTimer::kBegin);
    draw_shadows(frame);
    timer_.mark(PassTimer::kShadow);
    draw_occlusion(frame);
    timer_.mark(PassTimer::kOcclusion);
    draw_surface(view, frame);
    draw_sky(frame);
    timer_.mark(PassTimer::kSurface);
    draw_lines(view, view.lines, frame);
    glDisable(GL_DEPTH_TEST);
    draw_lines(view, view.front_lines, frame);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, samples_.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glBlitFramebuffer(0, 0, view.width, view.height, 0, 0, view.width, view.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    timer_.mark(PassTimer::kLines);
    restore_state(view, framebuffer);
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) return Done{};
    return Error{"OpenGL reports error " + std::to_string(error) + " for a picture of " +
                 std::to_string(view.width) + " x " + std::to_string(view.height) + " pixels"};
}

void Picture::restore_state(const View& view, GLuint framebuffer) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, view.width, view.height);
    glDepthFunc(GL_LESS);
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glUseProgram(0);
    for (GLenum unit = 0; unit < kUnitCount; ++unit) {
        glActiveTexture(GL_TEXTURE0 + unit);
        glBindTexture(GL_TEXTURE_2D, 0);
        glBindTexture(GL_TEXTURE_3D, 0);
    }
    glActiveTexture(GL_TEXTURE0);
}

namespace {

/// GL counts rows from below.
template <typename T>
void turn_over(std::vector<T>& pixels, int width, int height, size_t parts) {
    const size_t row = parts * static_cast<size_t>(width);
    for (int y = 0; y < height / 2; ++y) {
        T* upper = &pixels[row * static_cast<size_t>(y)];
        std::swap_ranges(upper, upper + row, &pixels[row * static_cast<size_t>(height - 1 - y)]);
    }
}

}  // namespace

Result<Image> Picture::take(const View& view) {
    create_targets(view.width, view.height);
    if (const Status drawn = draw(view, picture_.name()); !drawn) return Error{drawn.error()};
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    Image image{view.width, view.height, {}};
    image.rgba.resize(4 * static_cast<size_t>(view.width) * static_cast<size_t>(view.height));
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    turn_over(image.rgba, view.width, view.height, 4);
    return image;
}

Result<Buffers> Picture::take_buffers(const View& view) {
    const Frame f = prepare(view);
    const GlFramebuffer framebuffer("buffers");
    const GlTexture2D normal_depth("normals and depth"), labels("labels");
    const GlRenderbuffer depth("depth of buffers");
    glBindTexture(GL_TEXTURE_2D, normal_depth.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, view.width, view.height, 0, GL_RGBA, GL_FLOAT,
                 nullptr);
    glBindTexture(GL_TEXTURE_2D, labels.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32UI, view.width, view.height, 0, GL_RED_INTEGER,
                 GL_UNSIGNED_INT, nullptr);
    glBindRenderbuffer(GL_RENDERBUFFER, depth.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, view.width, view.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, normal_depth.name(),
                           0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, labels.name(), 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.name());
    const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, attachments);
    const GLfloat nothing[4] = {0, 0, 0, 0}, far = 1;
    const GLuint no_label[4] = {0, 0, 0, 0};
    glViewport(0, 0, view.width, view.height);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glClearBufferfv(GL_COLOR, 0, nothing);
    glClearBufferuiv(GL_COLOR, 1, no_label);
    glClearBufferfv(GL_DEPTH, 0, &far);
    const Uniforms uniforms(buffers_);
    uniforms.set("clip", f.clip);
    uniforms.set("shadow_clip", f.clip);
    uniforms.set("sight", glm::normalize(glm::vec3(glm::transpose(f.look)[2]) * -1.0f));
    const GLint model = uniforms.at("model"), label = uniforms.at("item_label");
    for (const Placed& placed : f.items) {
        glUniform1ui(label, placed.item ? placed.item->label : 0);
        glUniformMatrix4fv(model, 1, GL_FALSE, glm::value_ptr(placed.model));
        glBindVertexArray(placed.mesh->layout.name());
        glDrawElements(GL_TRIANGLES, placed.mesh->index_count, GL_UNSIGNED_INT, nullptr);
    }
    Buffers out;
    out.width = view.width;
    out.height = view.height;
    const size_t pixel_count = static_cast<size_t>(view.width) * static_cast<size_t>(view.height);
    std::vector<float> both(4 * pixel_count);
    out.labels.resize(pixel_count);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_FLOAT, both.data());
    glReadBuffer(GL_COLOR_ATTACHMENT1);
    glReadPixels(0, 0, view.width, view.height, GL_RED_INTEGER, GL_UNSIGNED_INT, out.labels.data());
    turn_over(both, view.width, view.height, 4);
    turn_over(out.labels, view.width, view.height, 1);
    out.normals.reserve(3 * pixel_count);
    out.depths_m.reserve(pixel_count);
    for (size_t p = 0; p < pixel_count; ++p) {
        out.normals.insert(out.normals.end(), &both[4 * p], &both[4 * p + 3]);
        out.depths_m.push_back(both[4 * p + 3]);
    }
    glDisable(GL_DEPTH_TEST);
    restore_state(view, 0);
    const GLenum error = glGetError();
    if (error != GL_NO_ERROR)
        return Error{"OpenGL reports error " + std::to_string(error) + " for buffers of " +
                     std::to_string(view.width) + " x " + std::to_string(view.height) + " pixels"};
    return out;
}

}  // namespace bsoil::render
