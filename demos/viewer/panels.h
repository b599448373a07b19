/// What is laid out over the picture: transport, levers, soil, overlays, plots, times, status.
#pragma once

#include "simulation.h"
#include "view_state.h"
#include "widgets.h"

namespace bsoil::viewer {

inline constexpr float kPanelWidth = 344;  ///< of the one on the left [pixels]

/// Orders that panels and keys have in common.
struct ViewOrders {
    bool toggle_pause = false, step = false, reset = false, save = false, load = false;
    bool camera_reset = false;
};

/// Lays the panels out; what is asked for goes to the simulation or comes back.
ViewOrders lay_out_panels(const std::string& title, ViewState& state, Simulation& simulation,
                          Widgets& widgets);

}  // namespace bsoil::viewer
