/// The soil's parameters, on sliders: what Soil::change() takes while the soil runs.
#pragma once

#include "view_state.h"
#include "widgets.h"

namespace bsoil::viewer {

/// Of ViewState::soil. Whether something was changed.
bool lay_out_soil_parameters(ViewState& state, Widgets& widgets);

}  // namespace bsoil::viewer
