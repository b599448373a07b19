#include "bsoil/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "callers_state.h"
#include "gl_context.h"
#include "picture.h"

namespace bsoil::render {
namespace {

constexpr int kPictureSideMax = 8192;
constexpr int kVolumeSideMax = 2048;  ///< what OpenGL 3.3 promises is 256; most devices have this

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
    if (!(std::abs(camera.shift) <= 0.9)) {
        return out_of_range("Camera::shift", camera.shift, "in -0.9..0.9 half widths");
    }
    const Vec3 sight = camera.target - camera.eye;
    if (!is_finite(camera.eye) || !is_finite(sight) || !is_finite(camera.up) ||
        !(length(cross(sight, camera.up)) > 1e-9 * length(sight) * length(camera.up))) {
        return Error{"Camera: eye, target and up must be finite and not in one line"};
    }
    if (!is_finite(view.to_sun) || !(length(view.to_sun) > 0)) {
        return Error{"View::to_sun must be finite and not zero"};
    }
    if (!(view.line_width >= 0.5f && view.line_width <= 16)) {
        return out_of_range("View::line_width", view.line_width, "in 0.5..16 pixels");
    }
    if (!std::isfinite(view.time_s)) return Error{"View::time_s must be finite"};
    if (view.floor_height_m && !std::isfinite(*view.floor_height_m)) {
        return Error{"View::floor_height_m must be finite"};
    }
    for (const Volume& volume : view.volumes) {
        if (!(volume.voxel_m > 0 && std::isfinite(volume.voxel_m))) {
            return out_of_range("Volume::voxel_m", volume.voxel_m, "above 0");
        }
        if (!(volume.sight_m > 0 && std::isfinite(volume.sight_m))) {
            return out_of_range("Volume::sight_m", volume.sight_m, "above 0");
        }
        if (!(volume.threshold >= 0 && volume.threshold <= 0.9)) {
            return out_of_range("Volume::threshold", volume.threshold, "in 0..0.9");
        }
        if (!is_finite(volume.pose)) return Error{"Volume::pose must be finite"};
    }
    if (view.cut && !(is_finite(view.cut->normal) && std::isfinite(view.cut->offset))) {
        return Error{"View::cut must be finite"};
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

Status VolumeData::validate() const {
    size_t bytes = 4;
    for (const int side : size) {
        if (side < 1 || side > kVolumeSideMax) {
            return out_of_range("VolumeData::size", side, "in 1..2048 voxels");
        }
        bytes *= static_cast<size_t>(side);
    }
    if (rgba.size() != bytes) {
        return Error{"VolumeData::rgba has " + std::to_string(rgba.size()) +
                     " bytes; must be four for " + "each voxel of VolumeData::size, " +
                     std::to_string(bytes)};
    }
    return Done{};
}

struct Renderer::Impl {
    std::unique_ptr<GlContext> context;  ///< null: the caller's
    std::unique_ptr<Picture> picture;
    std::string device_name;

    ~Impl() {
        if (!picture) return;
        const Use use(*this, State::any);
        std::optional<ForgetGlObjects> forget;  // what is current is another's, with names alike
        if (!use.ok()) forget.emplace();
        picture.reset();
    }

    /// What a call needs of GL's state in a caller's context.
    enum class State {
        any,          ///< it depends on none, and leaves what it changes as it is at first
        as_at_first,  ///< the caller's is there again afterwards
        with_target   ///< so it is but for framebuffers and viewport
    };
    /// While it lives the renderer's context is current.
    class Use {
      public:
        explicit Use(const Impl& impl, State state = State::as_at_first) {
            if (impl.context) {
                current_.emplace(*impl.context);
            } else if (state != State::any) {
                callers_.emplace(state == State::with_target);
            }
        }
        bool ok() const { return !current_ || current_->ok(); }

      private:
        std::optional<CurrentContext> current_;
        std::optional<CallersState> callers_;
    };
};

namespace {

Error no_context() {
    return {"EGL cannot make its context current: another window system's is; release that first"};
}

/// Where its context is not current its GL objects wait for who gets the id next.
template <typename Kept>
void set_free(Kept& kept, bool is_current) {
    if (is_current) kept = {};
    kept.used = false;
}

}  // namespace

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererDef& def) {
    if (const Status valid = def.validate(); !valid) return Error{valid.error()};
    auto impl = std::make_unique<Impl>();
    if (!def.callers_context) {
        Result<std::unique_ptr<GlContext>> context = GlContext::create();
        if (!context) return Error{context.error()};
        impl->context = std::move(*context);
    }
    if (def.callers_context && epoxy_gl_version() < 33) {
        return Error{"RendererDef::callers_context: OpenGL 3.3 core must be current"};
    }
    const Impl::Use use(*impl);
    if (!use.ok()) return no_context();
    impl->picture = std::make_unique<Picture>(def);
    if (const Status made = impl->picture->create(); !made) return Error{made.error()};
    const GLubyte* name = glGetString(GL_RENDERER);
    impl->device_name = name ? reinterpret_cast<const char*>(name) : "unknown";
    return std::unique_ptr<Renderer>(new Renderer(std::move(impl)));
}

MeshId Renderer::add_mesh(const Mesh& mesh, const Skin& skin) {
    auto& meshes = impl_->picture->meshes();
    const auto free = std::find_if(meshes.begin(), meshes.end(),
                                   [](const GpuMesh& candidate) { return !candidate.used; });
    const MeshId id{static_cast<uint32_t>(free - meshes.begin()) + 1};
    if (free == meshes.end()) meshes.emplace_back();
    GpuMesh& added = meshes[id.value - 1];
    added.used = true;  // without triangles too: no one else gets the id
    added.index_count = 0;
    const Impl::Use use(*impl_, Impl::State::any);
    if (use.ok()) added.fill(mesh, skin, "mesh");
    return id;
}

void Renderer::set_mesh(MeshId id, const Mesh& mesh) {
    auto& meshes = impl_->picture->meshes();
    if (id.value == 0 || id.value > meshes.size()) return;
    const Impl::Use use(*impl_, Impl::State::any);
    if (use.ok()) meshes[id.value - 1].fill(mesh, {}, "mesh");
}

void Renderer::remove_mesh(MeshId id) {
    auto& meshes = impl_->picture->meshes();
    if (id.value == 0 || id.value > meshes.size()) return;
    const Impl::Use use(*impl_, Impl::State::any);
    set_free(meshes[id.value - 1], use.ok());
}

Result<TextureId> Renderer::add_texture(const TextureData& data) {
    if (const Status valid = data.validate(); !valid) return Error{valid.error()};
    auto& textures = impl_->picture->textures();
    const auto free = std::find_if(textures.begin(), textures.end(),
                                   [](const GpuTexture& candidate) { return !candidate.used; });
    const TextureId id{static_cast<uint32_t>(free - textures.begin()) + 1};
    if (free == textures.end()) textures.emplace_back();
    const Impl::Use use(*impl_);
    if (!use.ok()) return no_context();
    if (const Status filled = textures[id.value - 1].fill(data); !filled) {
        return Error{filled.error()};
    }
    return id;
}

void Renderer::remove_texture(TextureId id) {
    auto& textures = impl_->picture->textures();
    if (id.value == 0 || id.value > textures.size()) return;
    const Impl::Use use(*impl_, Impl::State::any);
    set_free(textures[id.value - 1], use.ok());
}

Result<VolumeId> Renderer::add_volume(const VolumeData& data) {
    auto& volumes = impl_->picture->volumes();
    const auto free = std::find_if(volumes.begin(), volumes.end(),
                                   [](const GpuVolume& candidate) { return !candidate.used; });
    const VolumeId id{static_cast<uint32_t>(free - volumes.begin()) + 1};
    if (free == volumes.end()) volumes.emplace_back();
    if (const Status set = set_volume(id, data); !set) return Error{set.error()};
    return id;
}

Status Renderer::set_volume(VolumeId id, const VolumeData& data) {
    auto& volumes = impl_->picture->volumes();
    if (id.value == 0 || id.value > volumes.size()) {
        return Error{"there is no such volume; take an id that add_volume() gave"};
    }
    if (const Status valid = data.validate(); !valid) return valid;
    const Impl::Use use(*impl_);
    if (!use.ok()) return no_context();
    return volumes[id.value - 1].fill(data);
}

void Renderer::remove_volume(VolumeId id) {
    auto& volumes = impl_->picture->volumes();
    if (id.value == 0 || id.value > volumes.size()) return;
    const Impl::Use use(*impl_, Impl::State::any);
    set_free(volumes[id.value - 1], use.ok());
}

Result<Image> Renderer::render(const View& view) {
    if (const Status valid = validate_view(view); !valid) return Error{valid.error()};
    const Impl::Use use(*impl_);
    if (!use.ok()) return no_context();
    return impl_->picture->take(view);
}

Status Renderer::draw(const View& view, uint32_t framebuffer) {
    if (const Status valid = validate_view(view); !valid) return valid;
    if (impl_->context) {
        return Error{
            "Renderer::draw() is for RendererDef::callers_context: what the caller shows "
            "is in another context; call render(), or make a renderer so"};
    }
    const Impl::Use use(*impl_, Impl::State::with_target);
    return impl_->picture->draw(view, framebuffer);
}

Result<Buffers> Renderer::buffers(const View& view) {
    if (const Status valid = validate_view(view); !valid) return Error{valid.error()};
    const Impl::Use use(*impl_);
    if (!use.ok()) return no_context();
    return impl_->picture->take_buffers(view);
}

PassTimes Renderer::pass_times() const {
    const Impl::Use use(*impl_, Impl::State::any);
    if (use.ok()) impl_->picture->timer().poll();
    return impl_->picture->timer().times();
}

const std::string& Renderer::device_name() const { return impl_->device_name; }

}  // namespace bsoil::render
