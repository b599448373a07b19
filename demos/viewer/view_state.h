/// What a person has set in the window.
#pragma once

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "camera_rig.h"
#include "field_overlay.h"
#include "levers.h"
#include "world_picture.h"

namespace bsoil::viewer {

enum class Tool { look, hand, dig, heap };

/// Figures over time, for plots.
struct History {
    static constexpr size_t kLength = 400;
    std::string name, unit;
    std::vector<float> values;
    void add(double value) {
        if (values.size() == kLength) values.erase(values.begin());
        values.push_back(static_cast<float>(value));
    }
};

struct ViewState {
    RunStatus status;
    float pace = 1;
    Tool tool = Tool::look;
    float brush_radius_m = 0.3f;

    std::vector<std::string> bodies;  ///< names
    int body = 0;                     ///< that the camera goes along with, and of the force plot
    CameraMode camera_mode = CameraMode::orbit;
    std::array<float, 3> cab_eye_m{0.3f, 0, 1.2f};

    std::vector<Lever> levers;
    std::vector<float> lever_values;  ///< deflections of the sliders, -1..1
    std::vector<float> deflections;   ///< of sliders, keys and game pad together
    bool is_driving = false;          ///< levers, not the scene's motions
    bool has_raycast_vehicle = false;
    float throttle = 0, steering = 0, brake = 0;

    OverlayDef overlay;
    bool show_forces = false, show_boxes = false, show_wireframe = false, show_contacts = false,
         show_joints = false;
    bool show_panels = true;

    SoilDef scene_soil;        ///< with `materials`, not `material`
    SoilDef soil;              ///< the same with what was changed
    size_t material = 0;       ///< of the sliders
    bool own_surface = false;  ///< friction and adhesion of the sliders, not of the scene
    float friction = 0.4f, adhesion_kpa = 0;
    bool has_soil = false;
    std::vector<MaterialDef> materials;  ///< the soil's

    std::vector<History> histories;
    bool show_times = true;  ///< of the wall clock; off where pictures are to be equal
    double frame_ms = 0;
    render::PassTimes pass_times;
};

}  // namespace bsoil::viewer
