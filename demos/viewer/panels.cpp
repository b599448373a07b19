#include "panels.h"

#include <LinearMath/btIDebugDraw.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "soil_panel.h"

namespace bsoil::viewer {
namespace {

constexpr float kMargin = 10;
constexpr const char* kKeyNames[] = {"A / Q", "S / W", "D / E", "F / R", "G / T", "H / Y", "J / U"};

void row(const char* name, const std::string& value) {
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(150);
    ImGui::TextUnformatted(value.c_str());
}

void lay_out_transport(ViewState& state, Simulation& simulation, Widgets& widgets,
                       ViewOrders& orders) {
    const RunStatus& s = state.status;
    const float third = (kPanelWidth - 24 - 16) / 3;
    orders.toggle_pause |= widgets.button(s.is_paused ? "Run" : "Pause", {third, 0});
    ImGui::SameLine();
    orders.step |= widgets.button("Step", {third, 0});
    ImGui::SameLine();
    orders.reset |= widgets.button("Reset", {third, 0});
    orders.save |= widgets.button("Save", {third, 0});
    ImGui::SameLine();
    orders.load |= widgets.button("Load", {third, 0});
    ImGui::SameLine();
    orders.camera_reset |= widgets.button("Home", {third, 0});
    ImGui::SetNextItemWidth(-90);
    if (widgets.slider("Pace", &state.pace, 0.05f, 4, "%.2fx", ImGuiSliderFlags_Logarithmic)) {
        simulation.set_pace(static_cast<double>(state.pace));
    }
    row("time", fmt::format("{:.2f} s   step {}", s.time_s, s.step_count));
    if (state.show_times) {
        const double real = s.steps_per_s * s.step_s;
        row("speed", fmt::format("{:.1f} steps/s   {:.2f}x", s.steps_per_s, real));
    }
}

void lay_out_camera(ViewState& state, Widgets& widgets) {
    Widgets::heading("Camera");
    constexpr const char* kModes[] = {"Orbit", "Follow", "Cab"};
    for (int m = 0; m < 3; ++m) {
        if (m > 0) ImGui::SameLine();
        if (widgets.radio(kModes[m], static_cast<int>(state.camera_mode) == m)) {
            state.camera_mode = static_cast<CameraMode>(m);
        }
    }
    if (state.bodies.empty()) return;
    ImGui::SetNextItemWidth(-90);
    const auto current = static_cast<size_t>(state.body);
    if (widgets.combo("Body", state.bodies[current].c_str())) {
        for (size_t b = 0; b < state.bodies.size(); ++b) {
            if (ImGui::Selectable(state.bodies[b].c_str(), b == current)) {
                state.body = static_cast<int>(b);
            }
        }
        ImGui::EndCombo();
    }
    if (state.camera_mode == CameraMode::cab) {
        ImGui::DragFloat3("Eye [m]", state.cab_eye_m.data(), 0.02f, -10, 10, "%.2f");
    }
}

void lay_out_tools(ViewState& state, Widgets& widgets) {
    Widgets::heading("Left button of the mouse");
    constexpr const char* kTools[] = {"Look", "Hand", "Dig", "Heap"};
    for (int t = 0; t < 4; ++t) {
        if (t > 0) ImGui::SameLine();
        if (widgets.radio(kTools[t], static_cast<int>(state.tool) == t)) {
            state.tool = static_cast<Tool>(t);
        }
    }
    if (state.tool == Tool::dig || state.tool == Tool::heap) {
        ImGui::SetNextItemWidth(-90);
        widgets.slider("Radius", &state.brush_radius_m, 0.05f, 2, "%.2f m",
                       ImGuiSliderFlags_Logarithmic);
    }
    if (!state.status.hand_text.empty()) row("in hand", state.status.hand_text);
    if (state.has_soil) {
        ImGui::TextDisabled("soil units");
        ImGui::TextWrapped("%s", state.status.units_text.c_str());
    }
}

void lay_out_drive(ViewState& state, Widgets& widgets) {
    if (state.levers.empty() && !state.has_raycast_vehicle) {
        ImGui::TextWrapped("No joint of this scene has a motor.");
        return;
    }
    widgets.checkbox("I drive", &state.is_driving);
    ImGui::SameLine();
    if (widgets.button("All to zero")) {
        std::fill(state.lever_values.begin(), state.lever_values.end(), 0.0f);
        state.throttle = state.steering = state.brake = 0;
    }
    const bool has_wheels = state.has_raycast_vehicle ||
                            std::any_of(state.levers.begin(), state.levers.end(),
                                        [](const Lever& lever) { return lever.is_wheel(); });
    if (has_wheels) {
        Widgets::heading("Wheels");
        ImGui::SetNextItemWidth(-120);
        bool used = widgets.slider("Throttle", &state.throttle, -1, 1, "%.2f");
        ImGui::SetNextItemWidth(-120);
        used |= widgets.slider("Steering", &state.steering, -1, 1, "%.2f");
        if (state.has_raycast_vehicle) {
            ImGui::SetNextItemWidth(-120);
            used |= widgets.slider("Brake", &state.brake, 0, 1, "%.2f");
        }
        state.is_driving |= used;
        ImGui::TextDisabled("arrow keys; left stick and triggers");
        if (state.has_raycast_vehicle) ImGui::TextDisabled("B, button A: brake");
    }
    if (state.levers.empty()) return;
    Widgets::heading("Levers");
    size_t arm = 0;
    for (size_t l = 0; l < state.levers.size(); ++l) {
        const Lever& lever = state.levers[l];
        if (lever.is_wheel() && state.levers.size() > 12) continue;  // tracks have dozens
        ImGui::PushID(static_cast<int>(l));
        ImGui::SetNextItemWidth(-120);
        state.is_driving |=
            widgets.slider(lever.name.c_str(), &state.lever_values[l], -1, 1, "%.2f");
        const double position = static_cast<size_t>(lever.joint) < state.status.levers.size()
                                    ? state.status.levers[static_cast<size_t>(lever.joint)].position
                                    : 0.0;
        std::string text = lever.slides
                               ? fmt::format("{:.3f} m", position)
                               : fmt::format("{:.1f} deg", position * 180 / std::numbers::pi);
        if (!lever.is_wheel()) {
            if (arm < std::size(kKeyNames)) text += fmt::format("   keys {}", kKeyNames[arm]);
            ++arm;
        }
        ImGui::TextDisabled("%s", text.c_str());
        ImGui::PopID();
    }
}

void lay_out_soil(ViewState& state, Simulation& simulation, Widgets& widgets) {
    if (!state.has_soil) {
        ImGui::TextWrapped("This scene has no soil.");
        return;
    }
    Widgets::heading("Soil on tools");
    bool changed = widgets.checkbox("My own figures", &state.own_surface);
    ImGui::SetNextItemWidth(-120);
    changed |= widgets.slider("Friction", &state.friction, 0, 1.5f, "%.2f");
    ImGui::SetNextItemWidth(-120);
    changed |= widgets.slider("Adhesion", &state.adhesion_kpa, 0, 20, "%.1f kPa");
    if (changed) {
        SurfaceFriction surface;
        if (state.own_surface) {
            surface.friction = static_cast<double>(state.friction);
            surface.adhesion_pa = 1e3 * static_cast<double>(state.adhesion_kpa);
        }
        simulation.set_tool_surface(surface);
    }
    if (lay_out_soil_parameters(state, widgets)) simulation.change_soil(state.soil);
}

void lay_out_show(ViewState& state, Simulation& simulation, Widgets& widgets) {
    if (state.has_soil) {
        Widgets::heading("Field of the soil");
        OverlayDef overlay = state.overlay;
        int place = 0;
        for (int f = 0; f < kFieldCount; ++f) {
            const auto field = static_cast<Field>(f);
            if (!scene::has_field(state.scene_soil.materials, field)) continue;
            if (place % 3 != 0) ImGui::SameLine(static_cast<float>(place % 3) * 100 + 12);
            ++place;
            if (widgets.radio(field_name(field), overlay.field == field)) {
                overlay.field = field;
                overlay.low = overlay.high = 0;
            }
        }
        if (overlay.field != Field::none) {
            widgets.checkbox("On the surface", &overlay.on_surface);
            ImGui::SameLine();
            widgets.checkbox("Slice", &overlay.slice);
            ImGui::SameLine();
        }
        widgets.checkbox("Volume", &overlay.volume);
        if (overlay.field != Field::none) {
            if (overlay.slice) {
                constexpr const char* kAxes[] = {"across x", "across y", "level"};
                for (int a = 0; a < 3; ++a) {
                    if (a > 0) ImGui::SameLine();
                    if (widgets.radio(kAxes[a], overlay.slice_axis == a)) overlay.slice_axis = a;
                }
                auto at = static_cast<float>(overlay.slice_at);
                ImGui::SetNextItemWidth(-90);
                if (widgets.slider("At", &at, 0, 1, "%.2f")) {
                    overlay.slice_at = static_cast<double>(at);
                }
            }
        }
        if (!(overlay == state.overlay)) {
            state.overlay = overlay;
            simulation.set_overlay(overlay);
        }
    }
    Widgets::heading("Bullet's lines");
    bool changed = widgets.checkbox("Forces of the soil", &state.show_forces);
    ImGui::SameLine();
    changed |= widgets.checkbox("Columns", &state.show_wireframe);
    changed |= widgets.checkbox("Boxes", &state.show_boxes);
    ImGui::SameLine();
    changed |= widgets.checkbox("Contacts", &state.show_contacts);
    ImGui::SameLine();
    changed |= widgets.checkbox("Joints", &state.show_joints);
    if (!changed) return;
    int mode = 0;
    if (state.show_forces) mode |= btIDebugDraw::DBG_DrawNormals;
    if (state.show_wireframe) mode |= btIDebugDraw::DBG_DrawWireframe;
    if (state.show_boxes) mode |= btIDebugDraw::DBG_DrawAabb;
    if (state.show_contacts) mode |= btIDebugDraw::DBG_DrawContactPoints;
    if (state.show_joints) {
        mode |= btIDebugDraw::DBG_DrawConstraints | btIDebugDraw::DBG_DrawConstraintLimits;
    }
    simulation.set_debug_mode(mode);
}

void lay_out_plots(const ViewState& state) {
    for (const History& history : state.histories) {
        if (history.values.empty()) continue;
        const auto [low, high] = std::minmax_element(history.values.begin(), history.values.end());
        ImGui::TextDisabled("%s", history.name.c_str());
        const std::string now =
            fmt::format("{:.4g} {}", static_cast<double>(history.values.back()), history.unit);
        ImGui::SameLine(kPanelWidth - 24 - ImGui::CalcTextSize(now.c_str()).x);
        ImGui::TextUnformatted(now.c_str());
        const float room = 0.1f * std::max(1e-6f, *high - *low);
        ImGui::PushID(&history);
        ImGui::PlotLines("", history.values.data(), static_cast<int>(history.values.size()), 0,
                         nullptr, *low - room, *high + room, {kPanelWidth - 24, 54});
        ImGui::PopID();
    }
}

void lay_out_times(const ViewState& state) {
    const RunStatus& s = state.status;
    if (state.show_times) {
        const auto ms = [](double value) { return fmt::format("{:7.2f} ms", value); };
        Widgets::heading("A step");
        row("Bullet", ms(s.bullet_ms));
        row("voxelize", ms(s.stage_ms.voxelize));
        row("deform", ms(s.stage_ms.deform));
        row("advect", ms(s.stage_ms.advect));
        row("slip", ms(s.stage_ms.slip));
        row("contacts", ms(s.stage_ms.contacts));
        row("activity", ms(s.stage_ms.activity));
        row("meshes", ms(s.mesh_ms));
        Widgets::heading("A picture");
        row("shadows", ms(state.pass_times.shadow));
        row("surfaces", ms(state.pass_times.surface));
        row("occlusion", ms(state.pass_times.occlusion));
        row("light", ms(state.pass_times.light));
        row("finish", ms(state.pass_times.finish));
        row("whole frame", ms(state.frame_ms));
    }
    Widgets::heading("Work");
    row("active blocks", fmt::format("{}", s.block_active_count));
    row("tiles awake", fmt::format("{}", s.tile_awake_count));
    row("contact voxels", fmt::format("{}", s.contact_count));
}

ImU32 on_screen(const std::array<float, 3>& linear) {
    const auto level = [](float v) {
        return static_cast<int>(255 * std::pow(std::clamp(v, 0.0f, 1.0f), 1 / 2.2f));
    };
    return IM_COL32(level(linear[0]), level(linear[1]), level(linear[2]), 255);
}

/// The colour of each material and its name.
void lay_out_legend(const std::vector<MaterialDef>& materials) {
    const float side = ImGui::GetTextLineHeight();
    for (const MaterialDef& material : materials) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + side, at.y + side},
                                                  on_screen(material.color));
        ImGui::Dummy({side, side});
        ImGui::SameLine();
        ImGui::TextUnformatted(material.name.c_str());
    }
}

void lay_out_bar(const ColorBar& bar, const std::vector<MaterialDef>& materials) {
    if (bar.title.empty()) return;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    constexpr float kWidth = 320, kHeight = 62;
    const bool is_legend = bar.title == "material";
    ImGui::SetNextWindowPos({screen.x - kMargin, kMargin}, 0, {1, 0});
    if (!is_legend) ImGui::SetNextWindowSize({kWidth, kHeight});
    ImGui::Begin("##bar", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     (is_legend ? ImGuiWindowFlags_AlwaysAutoResize : 0));
    if (is_legend) {
        lay_out_legend(materials);
        ImGui::End();
        return;
    }
    const std::string title =
        bar.unit.empty() ? bar.title : fmt::format("{} [{}]", bar.title, bar.unit);
    ImGui::TextUnformatted(title.c_str());
    const ImVec2 at = ImGui::GetCursorScreenPos();
    constexpr int kSteps = 64;
    constexpr float kBar = (kWidth - 24) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const std::array<float, 3> linear = ramp_color((i + 0.5) / kSteps);
        ImGui::GetWindowDrawList()->AddRectFilled(
            {at.x + static_cast<float>(i) * kBar, at.y},
            {at.x + static_cast<float>(i + 1) * kBar, at.y + 9}, on_screen(linear));
    }
    ImGui::Dummy({0, 9});
    ImGui::Text("%g", bar.low);
    const std::string high = fmt::format("{:g}", bar.high);
    ImGui::SameLine(kWidth - 12 - ImGui::CalcTextSize(high.c_str()).x);
    ImGui::TextUnformatted(high.c_str());
    ImGui::End();
}

void lay_out_conditions(const RunStatus& status) {
    if (status.conditions.empty()) return;
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({screen.x - kMargin, screen.y - kMargin}, 0, {1, 1});
    const float width = screen.x - kPanelWidth - 4 * kMargin;
    ImGui::SetNextWindowSizeConstraints({200, 0}, {width, 200});
    ImGui::Begin("##conditions", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    // The newest of both kinds: an order that failed is seen however many conditions there are.
    constexpr size_t kLines = 5, kNotesLeast = 2;
    const size_t notes = status.note_count, conditions = status.conditions.size() - notes;
    const size_t notes_room = kLines - std::min(conditions, kLines - kNotesLeast);
    const size_t first_note = notes - std::min(notes, notes_room);
    const size_t conditions_room = kLines - (notes - first_note);
    const size_t first_condition = notes + conditions - std::min(conditions, conditions_room);
    ImGui::PushTextWrapPos(width - 2 * kMargin);
    for (size_t c = first_note; c < status.conditions.size(); ++c) {
        if (c >= notes && c < first_condition) continue;
        ImGui::TextUnformatted(status.conditions[c].c_str());
    }
    ImGui::PopTextWrapPos();
    ImGui::End();
}

}  // namespace

ViewOrders lay_out_panels(const std::string& title, ViewState& state, Simulation& simulation,
                          Widgets& widgets) {
    ViewOrders orders;
    widgets.begin();
    lay_out_bar(state.status.bar, state.materials);
    if (!state.show_panels) return orders;
    lay_out_conditions(state.status);
    const ImVec2 screen = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({kMargin, kMargin});
    ImGui::SetNextWindowSize({kPanelWidth, screen.y - 2 * kMargin});
    ImGui::Begin("##panel", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
    ImGui::TextColored({0.93f, 0.60f, 0.16f, 1}, "BulletSoil");
    ImGui::SameLine();
    ImGui::TextUnformatted(title.c_str());
    lay_out_transport(state, simulation, widgets, orders);
    ImGui::Separator();
    if (ImGui::BeginTabBar("tabs")) {
        // What is longer than the window scrolls below the transport.
        const auto tab = [&widgets](const char* name, const auto& lay_out) {
            if (!widgets.tab(name)) return;
            ImGui::BeginChild("##content");
            lay_out();
            ImGui::EndChild();
            ImGui::EndTabItem();
        };
        tab("View", [&] {
            lay_out_camera(state, widgets);
            lay_out_tools(state, widgets);
        });
        tab("Drive", [&] { lay_out_drive(state, widgets); });
        tab("Soil", [&] { lay_out_soil(state, simulation, widgets); });
        tab("Show", [&] { lay_out_show(state, simulation, widgets); });
        tab("Plots", [&] { lay_out_plots(state); });
        tab("Times", [&] { lay_out_times(state); });
        ImGui::EndTabBar();
    }
    ImGui::End();
    return orders;
}

}  // namespace bsoil::viewer
