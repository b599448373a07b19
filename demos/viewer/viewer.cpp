#include "viewer.h"

#include <SDL.h>
#include <backends/imgui_impl_sdl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include "clock.h"
#include "lever_input.h"
#include "panels.h"
#include "picture_cache.h"
#include "run/scene_models.h"
#include "view_script.h"
#include "volume_layer.h"
#include "window.h"

namespace bsoil::viewer {
namespace {

constexpr double kFrameS = 1.0 / 60;
constexpr float kTurnPerPixel = 0.006f;  ///< rad
constexpr double kZoomPerNotch = 0.87;
constexpr double kSightM = 400;  ///< how far the pointer reaches
constexpr int kBrushFrames = 6;  ///< frames from one stroke of a brush held down to the next

bool is_software(const std::string& device) {
    return device.find("llvmpipe") != std::string::npos ||
           device.find("softpipe") != std::string::npos ||
           device.find("SwiftShader") != std::string::npos;
}

class Viewer {
  public:
    Viewer(const scene::Scene& scene, const ViewDef& def)
        : scene_(scene), def_(def), camera_(scene::scene_camera(scene)) {}

    Status open();
    Status run();

  private:
    void take_events();
    void take_picture();
    void upload(WorldPicture& picture);
    void use_keys();
    void use_mouse();
    void carry_out(const ViewOrders& orders);
    void draw();
    render::View view() const;
    render::Camera shown_camera() const;
    Pose camera_body() const;

    const scene::Scene& scene_;
    const ViewDef def_;
    std::unique_ptr<Window> window_;
    std::unique_ptr<render::Renderer> renderer_;
    std::unique_ptr<PictureCache> cache_;
    std::unique_ptr<Simulation> simulation_;
    std::optional<ViewScript> script_;
    CameraRig camera_;
    ViewState state_;
    Widgets widgets_;
    std::set<SDL_Scancode> keys_down_, keys_hit_;
    WorldPicture picture_;
    uint64_t world_ = 0;
    std::map<std::pair<SurfaceKind, int>, render::MeshId> patches_;
    std::vector<render::MeshId> body_meshes_;
    VolumeLayer volume_;
    LeverInput lever_input_;
    bool must_draw_ = true, must_quit_ = false;
    bool is_dragging_hand_ = false;
    int brush_wait_ = 0;
};

Status Viewer::open() {
    if (!def_.script.empty()) {
        auto script = ViewScript::read(def_.script);
        if (!script) return Error{script.error()};
        script_ = std::move(*script);
        state_.show_times = false;
    }
    auto window = Window::create({.title = "BulletSoil: " + scene_.title,
                                  .width = def_.width,
                                  .height = def_.height,
                                  .is_resizable = !script_,
                                  .waits_for_screen = !script_});
    if (!window) return Error{window.error()};
    window_ = std::move(*window);
    const GLubyte* name = glGetString(GL_RENDERER);
    const bool software = is_software(name ? reinterpret_cast<const char*>(name) : "");
    render::RendererDef renderer_def;
    renderer_def.callers_context = true;
    renderer_def.sample_count = def_.sample_count > 0 ? def_.sample_count : software ? 2 : 4;
    auto renderer = render::Renderer::create(renderer_def);
    if (!renderer) return Error{renderer.error()};
    renderer_ = std::move(*renderer);
    cache_ = std::make_unique<PictureCache>();
    auto simulation = Simulation::create(scene_, def_.run, def_.snapshot);
    if (!simulation) return Error{simulation.error()};
    simulation_ = std::move(*simulation);
    std::vector<std::string> notes;
    body_meshes_ = scene::add_body_meshes(scene_, *renderer_, notes);
    for (const std::string& note : notes) fmt::print(stderr, "{}\n", note);
    for (const scene::BodyItem& body : scene_.bodies) {
        state_.bodies.push_back(body.name);
        if (body.name == scene_.camera.follow) {
            state_.body = static_cast<int>(state_.bodies.size()) - 1;
            state_.camera_mode = CameraMode::follow;
            camera_.set_mode(CameraMode::follow,
                             simulation_->start_poses()[state_.bodies.size() - 1]);
        }
    }
    if (scene_.camera.follow.empty()) {
        const auto heaviest =
            std::max_element(scene_.bodies.begin(), scene_.bodies.end(),
                             [](const auto& a, const auto& b) { return a.mass_kg < b.mass_kg; });
        state_.body = static_cast<int>(heaviest - scene_.bodies.begin());
    }
    state_.has_soil = scene_.soil.has_value();
    state_.materials = soil_def(scene_).materials;
    state_.scene_soil = simulation_->scene_soil();
    state_.soil = simulation_->first_soil();
    state_.has_raycast_vehicle = !scene_.raycast_vehicles.empty();
    state_.levers = find_levers(scene_);
    state_.lever_values.assign(state_.levers.size(), 0);
    state_.deflections = state_.lever_values;
    state_.histories.push_back({"soil's force on the body", "N", {}});
    for (const scene::ProbeItem& probe : scene_.probes) {
        if (probe.kind == "mass_inside") state_.histories.push_back({probe.name, "kg", {}});
    }
    state_.histories.push_back({"active blocks", "", {}});
    lever_input_.find_pad();
    return Done{};
}

void Viewer::take_events() {
    keys_hit_.clear();
    SDL_Event event;
    while (SDL_PollEvent(&event)) {
        ImGui_ImplSDL2_ProcessEvent(&event);
        switch (event.type) {
            case SDL_QUIT:
                must_quit_ = true;
                break;
            case SDL_WINDOWEVENT:
                must_draw_ = true;
                break;
            case SDL_KEYDOWN:
                if (ImGui::GetIO().WantTextInput) break;
                if (!event.key.repeat) keys_hit_.insert(event.key.keysym.scancode);
                keys_down_.insert(event.key.keysym.scancode);
                break;
            case SDL_KEYUP:
                keys_down_.erase(event.key.keysym.scancode);
                break;
            case SDL_CONTROLLERDEVICEADDED:
            case SDL_CONTROLLERDEVICEREMOVED:
                lever_input_.find_pad();
                break;
            default:
                break;
        }
    }
}

void Viewer::upload(WorldPicture& picture) {
    if (picture.world != world_) {
        for (const auto& [key, mesh] : patches_) renderer_->remove_mesh(mesh);
        patches_.clear();
        for (History& history : state_.histories) history.values.clear();
        world_ = picture.world;
    }
    if (const Status taken = volume_.take(*renderer_, picture); !taken) {
        picture.status.conditions.push_back(taken.error());
    }
    for (const SurfacePatch& patch : picture.patches) {
        render::MeshId& mesh = patches_[{patch.kind, patch.index}];
        if (mesh.value != 0) {
            renderer_->set_mesh(mesh, patch.mesh);
        } else {
            mesh = renderer_->add_mesh(patch.mesh);
        }
    }
}

void Viewer::take_picture() {
    if (script_) simulation_->finish_orders();
    WorldPicture picture;
    const long long before = state_.status.step_count;
    while (simulation_->take(picture)) {
        upload(picture);
        picture_.bodies = std::move(picture.bodies);
        picture_.lines = std::move(picture.lines);
        picture_.grains = std::move(picture.grains);
        picture_.dust = std::move(picture.dust);
        picture_.slice = picture.slice;
        state_.status = std::move(picture.status);
        must_draw_ = true;
        if (state_.status.step_count != before) {
            size_t h = 0;
            const auto& forces = state_.status.forces_n;
            const auto body = static_cast<size_t>(state_.body);
            state_.histories[h++].add(body < forces.size() ? forces[body] : 0);
            size_t load = 0;
            for (const scene::ProbeItem& probe : scene_.probes) {
                if (probe.kind == "mass_inside" && load < state_.status.loads_kg.size()) {
                    state_.histories[h++].add(state_.status.loads_kg[load]);
                }
                ++load;
            }
            state_.histories[h].add(state_.status.block_active_count);
        }
        if (!script_) break;
        simulation_->finish_orders();
    }
}

Pose Viewer::camera_body() const {
    const auto body = static_cast<size_t>(state_.body);
    return body < picture_.bodies.size() ? picture_.bodies[body] : Pose{};
}

/// The target is in the middle of what panels leave free, and what the scene's camera frames fits
/// there.
render::Camera Viewer::shown_camera() const {
    render::Camera camera = camera_.camera(camera_body());
    if (!state_.show_panels) return camera;
    camera.shift = std::min(0.5, static_cast<double>(kPanelWidth) / window_->width());
    if (state_.camera_mode != CameraMode::cab) {
        camera.fov_rad = 2 * std::atan(std::tan(camera.fov_rad / 2) / (1 - camera.shift));
    }
    return camera;
}

render::View Viewer::view() const {
    render::View view;
    view.width = window_->width();
    view.height = window_->height();
    view.camera = shown_camera();
    view.to_sun = scene::sun_beside(scene::scene_camera(scene_));
    if (scene_.world.ground_plane) view.floor_height_m = scene_.world.ground_height_m;
    if (picture_.slice) {
        // Open towards the eye: the slice is seen.
        const Plane& slice = *picture_.slice;
        const double side = dot(slice.normal, view.camera.eye) < slice.offset ? -1 : 1;
        view.cut = Plane{slice.normal * side, slice.offset * side};
    }
    volume_.append_to(view);
    for (const auto& [key, mesh] : patches_) {
        if (key.first == SurfaceKind::soil && volume_.is_shown()) continue;
        render::Item item;
        item.mesh = mesh;
        item.is_closed = key.first == SurfaceKind::soil || key.first == SurfaceKind::terrain;
        const bool is_colored = state_.overlay.field != Field::none && state_.overlay.on_surface;
        if (key.first == SurfaceKind::soil) {
            item.grain_m = is_colored ? 0 : scene::kSoilGrainM;
            item.emission = is_colored ? 0.5f : 0;
            item.is_cut = true;
        } else if (key.first == SurfaceKind::terrain) {
            item.grain_m = scene::kTerrainGrainM;
        } else {
            item.emission = 1;
        }
        view.items.push_back(item);
    }
    for (size_t b = 0; b < body_meshes_.size() && b < picture_.bodies.size(); ++b) {
        // Who looks out of a cab does not see it.
        if (state_.camera_mode == CameraMode::cab && static_cast<int>(b) == state_.body) continue;
        render::Item item;
        item.mesh = body_meshes_[b];
        item.pose = picture_.bodies[b];
        item.gloss = scene::kBodyGloss;
        item.label = static_cast<uint32_t>(b) + 1;
        view.items.push_back(item);
    }
    view.grains = picture_.grains;
    view.dust = picture_.dust;
    view.time_s = state_.status.time_s;
    view.front_lines = picture_.lines;  // columns and forces lie inside of soil and bodies
    return view;
}

void Viewer::use_mouse() {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse && !is_dragging_hand_) return;
    const Sight sight =
        sight_through(shown_camera(), static_cast<double>(io.MousePos.x / io.DisplaySize.x),
                      static_cast<double>(io.MousePos.y / io.DisplaySize.y),
                      static_cast<double>(io.DisplaySize.x / io.DisplaySize.y));
    const Vec3 far_m = sight.from_m + sight.direction * kSightM;
    const auto turn = [&] {
        if (io.MouseDelta.x == 0 && io.MouseDelta.y == 0) return;
        camera_.turn(static_cast<double>(-io.MouseDelta.x * kTurnPerPixel),
                     static_cast<double>(io.MouseDelta.y * kTurnPerPixel));
        must_draw_ = true;
    };
    if (io.MouseDown[1]) turn();
    if (io.MouseDown[2] && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
        camera_.pan(static_cast<double>(-io.MouseDelta.x / io.DisplaySize.y),
                    static_cast<double>(io.MouseDelta.y / io.DisplaySize.y));
        must_draw_ = true;
    }
    if (io.MouseWheel != 0) {
        camera_.zoom(std::pow(kZoomPerNotch, static_cast<double>(io.MouseWheel)));
        must_draw_ = true;
    }
    const bool is_down = io.MouseDown[0], is_hit = ImGui::IsMouseClicked(0);
    if (brush_wait_ > 0) --brush_wait_;
    switch (state_.tool) {
        case Tool::look:
            if (is_down) turn();
            break;
        case Tool::hand:
            if (is_hit) {
                simulation_->take_by_hand(sight.from_m, far_m);
                is_dragging_hand_ = true;
            } else if (is_dragging_hand_ && !is_down) {
                simulation_->let_go();
                is_dragging_hand_ = false;
            } else if (is_dragging_hand_ && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
                simulation_->drag_hand(sight.from_m, sight.direction);
            }
            break;
        case Tool::dig:
        case Tool::heap:
            if (is_down && brush_wait_ == 0) {
                simulation_->use_brush(state_.tool == Tool::dig ? Brush::dig : Brush::heap,
                                       static_cast<double>(state_.brush_radius_m), sight.from_m,
                                       far_m);
                brush_wait_ = kBrushFrames;
            }
            break;
    }
}

void Viewer::use_keys() {
    ViewOrders orders;
    const auto hit = [this](SDL_Scancode key) { return keys_hit_.count(key) != 0; };
    orders.toggle_pause = hit(SDL_SCANCODE_SPACE);
    orders.step = hit(SDL_SCANCODE_N);
    orders.reset = hit(SDL_SCANCODE_BACKSPACE);
    orders.save = hit(SDL_SCANCODE_F5);
    orders.load = hit(SDL_SCANCODE_F9);
    orders.camera_reset = hit(SDL_SCANCODE_HOME);
    if (hit(SDL_SCANCODE_TAB)) {
        state_.show_panels = !state_.show_panels;
        must_draw_ = true;
    }
    if (hit(SDL_SCANCODE_C)) {
        state_.camera_mode =
            static_cast<CameraMode>((static_cast<int>(state_.camera_mode) + 1) % 3);
    }
    if (hit(SDL_SCANCODE_ESCAPE)) must_quit_ = true;
    carry_out(orders);
}

void Viewer::carry_out(const ViewOrders& orders) {
    const std::string snapshot = def_.snapshot.empty() ? "view.snapshot" : def_.snapshot;
    if (orders.toggle_pause) simulation_->set_paused(!state_.status.is_paused);
    if (orders.step) simulation_->make_steps(1);
    if (orders.reset) simulation_->reset();
    if (orders.save) simulation_->save(snapshot);
    if (orders.load) simulation_->load(snapshot);
    if (orders.camera_reset) {
        camera_.reset();
        must_draw_ = true;
    }
}

void Viewer::draw() {
    const int width = window_->width(), height = window_->height();
    must_draw_ |= !cache_->has_size(width, height);
    if (must_draw_) {
        cache_->resize(width, height);
        const render::View shown = view();
        simulation_->follow(shown);
        const Status drawn = renderer_->draw(shown, cache_->framebuffer());
        if (!drawn) state_.status.conditions.push_back(drawn.error());
        state_.pass_times = renderer_->pass_times();
        must_draw_ = false;
    }
    cache_->show();
    window_->draw_panels();
}

Status Viewer::run() {
    CameraMode mode = camera_.mode();
    int body = state_.body;
    std::array<float, 3> cab_eye = state_.cab_eye_m;
    double next_s = now_s();
    while (!must_quit_) {
        const double start_s = now_s();
        take_events();
        window_->begin();
        if (script_ && !script_->begin_frame(*simulation_, widgets_, ImGui::GetIO().DisplaySize)) {
            must_quit_ = true;
        }
        ImGui::NewFrame();
        take_picture();
        carry_out(lay_out_panels(scene_.title, state_, *simulation_, widgets_));
        use_keys();
        use_mouse();
        lever_input_.use(keys_down_, state_, *simulation_);
        if (mode != state_.camera_mode || body != state_.body) {
            camera_.set_mode(state_.camera_mode, camera_body());
            must_draw_ = true;
            mode = state_.camera_mode;
            body = state_.body;
        }
        if (cab_eye != state_.cab_eye_m) {
            cab_eye = state_.cab_eye_m;
            camera_.set_cab_eye({static_cast<double>(cab_eye[0]), static_cast<double>(cab_eye[1]),
                                 static_cast<double>(cab_eye[2])});
            must_draw_ = true;
        }
        window_->end();
        draw();
        if (script_) script_->end_frame(*window_);
        window_->swap();
        const double end_s = now_s();
        state_.frame_ms = 1e3 * (end_s - start_s);
        // No faster than a screen shows it: the processor is the simulation's.
        next_s = std::max(next_s + kFrameS, end_s - kFrameS);
        if (!script_ && next_s > end_s) SDL_Delay(static_cast<Uint32>(1e3 * (next_s - end_s)));
    }
    if (script_ && !script_->error().empty()) return Error{script_->error()};
    if (!state_.status.failure.empty()) return Error{state_.status.failure};
    return Done{};
}

}  // namespace

Status view_scene(const scene::Scene& scene, const ViewDef& def) {
    Viewer viewer(scene, def);
    if (const Status opened = viewer.open(); !opened) return opened;
    return viewer.run();
}

}  // namespace bsoil::viewer
