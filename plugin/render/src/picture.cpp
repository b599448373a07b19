#include "picture.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "callers_state.h"
#include "shader_sources.h"
#include "uniforms.h"

namespace bsoil::render {
namespace {

/// Along a surface's normal: keeps it out of its own shadow.
constexpr double kShadowBiasTexels = 1.5;
constexpr double kOcclusionShare =
    0.05;  ///< radius of ambient occlusion, of the distance to the target
constexpr glm::vec3 kHorizonColor{0.66f, 0.74f, 0.82f};  ///< linear
constexpr glm::vec3 kZenithColor{0.16f, 0.31f, 0.58f};
constexpr size_t kLineFloats = 9;  ///< of a line on the device: both ends and the colour
/// Samples a pixel from which on it is lit in 2 x 2 places.
constexpr int kManySamples = 4;

/// Of a surface's grains: a texel of the blend map. What is seen as a lump has about five.
constexpr double kBlendTexelGrains = 0.4;

/// A shader's text with something defined in it.
std::string defined(const std::string& text, const char* name) {
    const size_t first_line = text.find('\n') + 1;
    return text.substr(0, first_line) + "#define " + name + "\n" + text.substr(first_line);
}

glm::vec2 texel_of(const Target& target) {
    return {1.0f / static_cast<float>(target.width), 1.0f / static_cast<float>(target.height)};
}

}  // namespace

Status Picture::create() {
    const std::string mixed_vertex = defined(shaders::surface_vert, "MIXED"),
                      mixed_fragment = defined(shaders::surface_frag, "MIXED"),
                      textured_vertex = defined(shaders::surface_vert, "TEXTURED"),
                      textured_fragment = defined(shaders::surface_frag, "TEXTURED"),
                      cascaded_fragment = defined(shaders::light_frag, "CASCADED");
    const struct {
        GlProgram& program;
        const char* label;
        const char* vertex_text;
        const char* fragment_text;
    } programs[] = {
        {march_, "march", shaders::screen_vert, shaders::march_frag},
        {veil_, "veil", shaders::screen_vert, shaders::veil_frag},
        {mixed_, "mixed surface", mixed_vertex.c_str(), mixed_fragment.c_str()},
        {textured_, "textured surface", textured_vertex.c_str(), textured_fragment.c_str()},
        {depth_, "depth", shaders::depth_vert, shaders::depth_frag},
        {surface_, "surface", shaders::surface_vert, shaders::surface_frag},
        {occlusion_, "occlusion", shaders::screen_vert, shaders::occlusion_frag},
        {smooth_, "smooth", shaders::screen_vert, shaders::smooth_frag},
        {light_, "light", shaders::screen_vert, shaders::light_frag},
        {light_cascaded_, "light with cascades", shaders::screen_vert, cascaded_fragment.c_str()},
        {line_, "line", shaders::line_vert, shaders::line_frag},
        {sky_, "sky", shaders::screen_vert, shaders::sky_frag},
        {finish_, "finish", shaders::screen_vert, shaders::finish_frag},
        {edges_, "edges", shaders::screen_vert, shaders::edges_frag},
        {buffers_, "buffers", shaders::surface_vert, shaders::buffers_frag},
        {dust_, "dust", shaders::dust_vert, shaders::dust_frag},
        {grain_, "grain", shaders::grain_vert, shaders::surface_frag},
        {grain_depth_, "depth of grains", shaders::grain_vert, shaders::depth_frag},
        {grain_buffers_, "buffers of grains", shaders::grain_vert, shaders::buffers_frag},
    };
    for (const auto& entry : programs) {
        Result<GlProgram> linked =
            link_program(entry.label, entry.vertex_text, entry.fragment_text);
        if (!linked) return Error{linked.error()};
        entry.program = std::move(*linked);
    }
    no_vertices_ = GlVertexArray("no vertices");
    grains_ = create_grains();
    materials_ = GlTexture2D("materials");
    GLint side_max = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max);
    cascades_most_ = std::clamp<size_t>(
        static_cast<size_t>(side_max / std::max(1, def_.shadow_map_size)), 1, kCascadesMost);
    create_shadow_maps(1);

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
    grain_layer_.create();
    dust_layer_.create();
    timer_.create();
    return Done{};
}

void Picture::create_targets(int width, int height) {
    if (width_ == width && height_ == height) return;
    width_ = width;
    height_ = height;
    GLint side_max = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max);
    samples_aside_ =
        def_.sample_count >= kManySamples && 2 * std::max(width, height) <= side_max ? 2 : 1;
    seen_ = create_surface_target("what is seen", samples_aside_ * width, samples_aside_ * height);
    // Ambient occlusion is soft: half the resolution does.
    const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    rough_occlusion_ = create_color_target("rough occlusion", half_width, half_height, GL_RG32F);
    smooth_occlusion_ = create_color_target("occlusion", half_width, half_height, GL_R8);
    lit_ = create_lit_target("lit", seen_.width, seen_.height);
    picture_ = create_color_target("picture", width, height, GL_RGBA8);
}

/// Side by side in one texture.
void Picture::create_shadow_maps(size_t count) {
    if (count <= shadow_map_count_) return;
    shadow_map_count_ = count;
    shadow_ = create_depth_target("shadow maps", static_cast<int>(count) * def_.shadow_map_size,
                                  def_.shadow_map_size);
    glBindTexture(GL_TEXTURE_2D, shadow_.depth.name());
    set_filter(GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

void Picture::draw_screen() const {
    glBindVertexArray(no_vertices_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// Depth as the sun sees it.
void Picture::draw_shadows(const Frame& f) {
    create_shadow_maps(f.cascades.size());
    shadow_.bind();
    glClear(GL_DEPTH_BUFFER_BIT);
    // Slope-scaled: a sunlit slope must not fall into its own shadow between two texels.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
    for (size_t c = 0; c < f.cascades.size(); ++c) {
        const ShadowCascade& cascade = f.cascades[c];
        glViewport(static_cast<GLint>(c) * def_.shadow_map_size, 0, def_.shadow_map_size,
                   def_.shadow_map_size);
        const Uniforms uniforms(depth_);
        uniforms.set("clip", cascade.clip);
        uniforms.draw(f.casters[c]);
        if (!grain_layer_.casts_shadows()) continue;
        const Uniforms grain_uniforms(grain_depth_);
        grain_uniforms.set("clip", cascade.clip);
        grain_uniforms.set("facing", glm::vec3(f.to_sun));
        grain_layer_.draw_casters();
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
}

/// Colour, material, normal and depth of what each pixel shows.
void Picture::draw_surface(const Frame& f) {
    seen_.bind();
    glClear(GL_DEPTH_BUFFER_BIT);
    const Uniforms uniforms(surface_);
    uniforms.set("clip", f.clip);
    const GLint material = uniforms.at("material");
    bool any_mixed = false, any_textured = false;
    for (const Placed& placed : f.items) {
        any_mixed |= placed.is_mixed();
        any_textured |= placed.is_textured();
        if (placed.is_mixed() || placed.is_textured()) continue;
        glUniform1f(material, static_cast<float>(placed.material) / 255);
        uniforms.draw_seen(placed, f.cut);
    }
    if (any_mixed) draw_mixed(f);
    if (any_textured) draw_textured(f);
    if (grain_layer_.is_empty()) return;
    const Uniforms grain_uniforms(grain_);
    grain_uniforms.set("clip", f.clip);
    grain_uniforms.set("facing", glm::vec3(0));
    grain_uniforms.set("bright", glm::vec3(f.to_sun));
    grain_uniforms.set("material", static_cast<float>(f.grain_material) / 255);
    grain_layer_.draw();
}

/// Surfaces of several materials.
void Picture::draw_mixed(const Frame& f) {
    if (blend_map_.name() == 0) blend_map_ = create_blend_map();
    bind_texture(kBlendUnit, GL_TEXTURE_3D, blend_map_);
    const Uniforms uniforms(mixed_);
    uniforms.set("clip", f.clip);
    uniforms.set_unit("blend_map", kBlendUnit);
    uniforms.set("pixel_m", 2 * f.to_view().y / static_cast<float>(seen_.height));
    const GLint material = uniforms.at("material");
    for (const Placed& placed : f.items) {
        if (!placed.is_mixed()) continue;
        std::array<glm::vec3, limits::kMaterialCapacity> palette{};
        std::copy_n(placed.mesh->palette.begin(),
                    std::min(palette.size(), placed.mesh->palette.size()), palette.begin());
        uniforms.set("palette", palette);
        const double texel_m = kBlendTexelGrains * static_cast<double>(placed.item->grain_m);
        const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 1.0, glm::dvec3(0.36, 0.48, 0.8));
        const glm::dmat3 periods = glm::dmat3(turn) / (kBlendTexels * texel_m);
        const glm::dvec3 place = periods * f.eye;
        glm::dmat4 blend_place(periods);
        blend_place[3] = glm::dvec4(place - glm::floor(place), 1);
        uniforms.set("blend_place", glm::mat4(blend_place));
        uniforms.set("blend_texel_m", static_cast<float>(texel_m));
        glUniform1f(material, static_cast<float>(placed.material) / 255);
        uniforms.draw_seen(placed, f.cut);
    }
}

/// Ambient occlusion from the depth. Without it all is open.
void Picture::draw_occlusion(const Frame& f) {
    const GLfloat nothing_seen[4] = {0, 0, 0, 0}, all_open[4] = {1, 1, 1, 1};
    smooth_occlusion_.bind();
    glClearBufferfv(GL_COLOR, 0, all_open);
    if (!def_.occlusion) return;
    bind_texture(kDepthUnit, GL_TEXTURE_2D, seen_.depth);
    rough_occlusion_.bind();
    glClearBufferfv(GL_COLOR, 0, nothing_seen);
    const Uniforms uniforms(occlusion_);
    uniforms.set_unit("depth", kDepthUnit);
    uniforms.set("depth_to_distance", f.depth_to_distance());
    uniforms.set("to_view", f.to_view());
    uniforms.set("radius_m", static_cast<float>(kOcclusionShare * f.sight_m));
    uniforms.set("focal", static_cast<float>(f.projection[1][1]));
    uniforms.set("texel", texel_of(rough_occlusion_));
    draw_screen();
    smooth_occlusion_.bind();
    const Uniforms smooth_uniforms(smooth_);
    smooth_uniforms.set_unit("occlusion", kOcclusionUnit);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, rough_occlusion_.color);
    draw_screen();
}

/// Which shadow map shows what. Within a map coordinates are 0..1.
void Picture::set_shadows(const Uniforms& uniforms, const Frame& f) const {
    const glm::dmat4 to_texture{0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1};
    std::array<glm::mat4, kCascadesMost> clips{};
    std::array<float, kCascadesMost> biases{};
    for (size_t c = 0; c < kCascadesMost; ++c) {
        // Of maps that there are not the last one stands in.
        const ShadowCascade& cascade = f.cascades[std::min(c, f.cascades.size() - 1)];
        clips[c] = glm::mat4(to_texture * glm::dmat4(cascade.clip));
        biases[c] = static_cast<float>(kShadowBiasTexels * cascade.texel_m);
    }
    uniforms.set("shadow_clip", clips);
    uniforms.set("shadow_bias_m", biases);
    uniforms.set("map_count", static_cast<float>(shadow_map_count_));
}

/// Light on what is seen.
void Picture::light(const Frame& f) {
    const Uniforms uniforms(f.cascades.size() > 1 ? light_cascaded_ : light_);
    uniforms.set_unit("depth", kDepthUnit);
    uniforms.set_unit("albedo_material", kColorUnit);
    uniforms.set_unit("octahedral", kNormalUnit);
    uniforms.set_unit("materials", kMaterialUnit);
    uniforms.set_unit("shadow_map", kShadowUnit);
    uniforms.set_unit("occlusion", kOcclusionUnit);
    uniforms.set_unit("grains", kGrainUnit);
    bind_texture(kDepthUnit, GL_TEXTURE_2D, seen_.depth);
    bind_texture(kColorUnit, GL_TEXTURE_2D, seen_.color);
    bind_texture(kNormalUnit, GL_TEXTURE_2D, seen_.more);
    bind_texture(kShadowUnit, GL_TEXTURE_2D, shadow_.depth);
    bind_texture(kOcclusionUnit, GL_TEXTURE_2D, smooth_occlusion_.color);
    bind_texture(kGrainUnit, GL_TEXTURE_3D, grains_);
    bind_texture(kMaterialUnit, GL_TEXTURE_2D, materials_);
    static_assert(sizeof(SurfaceMaterial) == 8 * sizeof(float));
    if (!f.materials.empty()) fill_table(2, {&f.materials[0].look.x, 8 * f.materials.size()});

    set_rays(uniforms, f);
    uniforms.set("depth_to_distance", f.depth_to_distance());
    uniforms.set("pixel_m", 2 * f.to_view().y / static_cast<float>(lit_.height));
    uniforms.set("up", glm::vec3(f.up));
    uniforms.set("to_sun", glm::vec3(f.to_sun));
    uniforms.set("horizon_color", kHorizonColor);
    set_shadows(uniforms, f);
    uniforms.set("fade_center", glm::vec3(f.floor_center));
    uniforms.set("fade_begin_m", static_cast<float>(f.fade_begin_m));
    uniforms.set("fade_end_m", static_cast<float>(f.fade_end_m));
    glDepthFunc(GL_GREATER);
    draw_screen();
    glDepthFunc(GL_LEQUAL);
}

/// The sky, where the depth says that nothing is seen.
void Picture::draw_sky(const Frame& f) const {
    const Uniforms uniforms(sky_);
    set_rays(uniforms, f);
    uniforms.set("up", glm::vec3(f.up));
    uniforms.set("to_sun", glm::vec3(f.to_sun));
    uniforms.set("horizon_color", kHorizonColor);
    uniforms.set("zenith_color", kZenithColor);
    draw_screen();
}

void Picture::draw_lines(const View& view, const std::vector<Line>& lines, const Frame& f) {
    if (lines.empty()) return;
    line_floats_.clear();
    for (const Line& line : lines) {
        for (const Vec3 end : {line.from, line.to}) {
            const glm::vec3 at(glm::dvec3(end.x, end.y, end.z) - f.eye);
            line_floats_.insert(line_floats_.end(), {at.x, at.y, at.z});
        }
        line_floats_.insert(line_floats_.end(), line.color.begin(), line.color.end());
    }
    const Uniforms uniforms(line_);
    uniforms.set("clip", f.clip);
    uniforms.set("picture_size", glm::vec2(view.width, view.height));
    uniforms.set("width", view.line_width);
    glBindVertexArray(line_layout_.name());
    glBindBuffer(GL_ARRAY_BUFFER, line_ends_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(line_floats_.size() * sizeof(float)),
                 line_floats_.data(), GL_STREAM_DRAW);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(lines.size()));
}

/// The lit picture in its last size, into the bound framebuffer.
void Picture::finish() const {
    const bool has_edges = samples_aside_ == 1 && def_.sample_count > 1;
    const Uniforms uniforms(has_edges ? edges_ : finish_);
    uniforms.set_unit("lit", kColorUnit);
    bind_texture(kColorUnit, GL_TEXTURE_2D, lit_.color);
    draw_screen();
}

Status Picture::draw(const View& view, GLuint framebuffer) {
    timer_.poll();
    create_targets(view.width, view.height);
    const Frame frame = make_frame(view);
    grain_layer_.fill(view, frame, samples_aside_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    timer_.mark(PassTimer::kBegin);
    draw_shadows(frame);
    timer_.mark(PassTimer::kShadow);
    draw_surface(frame);
    timer_.mark(PassTimer::kSurface);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    draw_occlusion(frame);
    timer_.mark(PassTimer::kOcclusion);
    // A copy of the depth: what a pass tests against it must not read.
    copy_depth(seen_, lit_);
    lit_.bind();
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    light(frame);
    draw_sky(frame);
    draw_volumes(view, frame);
    draw_dust(view, frame);
    glDepthMask(GL_TRUE);
    timer_.mark(PassTimer::kLight);
    // The scene's depth does not end lines that reach out of it.
    glEnable(GL_DEPTH_CLAMP);
    draw_lines(view, view.lines, frame);
    glDisable(GL_DEPTH_TEST);
    draw_lines(view, view.front_lines, frame);
    glDisable(GL_DEPTH_CLAMP);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, view.width, view.height);
    finish();
    timer_.mark(PassTimer::kFinish);
    restore_state(view, framebuffer);
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) return Done{};
    return Error{"OpenGL reports error " + std::to_string(error) + " for a picture of " +
                 std::to_string(view.width) + " x " + std::to_string(view.height) +
                 " pixels; take fewer pixels, or another driver"};
}

void Picture::restore_state(const View& view, GLuint framebuffer) const {
    set_first_state();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, view.width, view.height);
}

}  // namespace bsoil::render
