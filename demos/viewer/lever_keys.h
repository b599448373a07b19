/// Which keys and sticks move the levers.
#pragma once

#include <SDL.h>

namespace bsoil::viewer {

/// Keys of the levers, in their order: backward and forward.
inline constexpr SDL_Scancode kLeverKeys[][2] = {
    {SDL_SCANCODE_A, SDL_SCANCODE_Q}, {SDL_SCANCODE_S, SDL_SCANCODE_W},
    {SDL_SCANCODE_D, SDL_SCANCODE_E}, {SDL_SCANCODE_F, SDL_SCANCODE_R},
    {SDL_SCANCODE_G, SDL_SCANCODE_T}, {SDL_SCANCODE_H, SDL_SCANCODE_Y},
    {SDL_SCANCODE_J, SDL_SCANCODE_U}};
/// Sticks of the levers, in their order, as an excavator has them: swing, boom, stick, bucket.
inline constexpr SDL_GameControllerAxis kLeverSticks[] = {
    SDL_CONTROLLER_AXIS_LEFTX, SDL_CONTROLLER_AXIS_RIGHTY, SDL_CONTROLLER_AXIS_LEFTY,
    SDL_CONTROLLER_AXIS_RIGHTX};

}  // namespace bsoil::viewer
