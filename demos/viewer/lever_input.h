/// What keys, the game pad and the panel's sliders ask of the levers, the throttle and the
/// steering.
#pragma once

#include <SDL.h>

#include <optional>
#include <set>
#include <vector>

#include "simulation.h"
#include "view_state.h"

namespace bsoil::viewer {

class LeverInput {
  public:
    /// Takes the first game pad there is, unless it has one that is still plugged in.
    void find_pad();
    /// Tells the simulation what has changed since the last call.
    void use(const std::set<SDL_Scancode>& keys_down, ViewState& state, Simulation& simulation);

  private:
    float stick(SDL_GameControllerAxis axis) const;

    SDL_GameController* pad_ = nullptr;
    std::vector<std::optional<double>> sent_;        ///< speed of each lever; none: the scene's own
    std::optional<scene::DriveCommand> sent_drive_;  ///< of raycast vehicles, likewise
};

}  // namespace bsoil::viewer
