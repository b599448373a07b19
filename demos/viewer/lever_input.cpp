#include "lever_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "lever_keys.h"

namespace bsoil::viewer {
namespace {

constexpr float kStickDead = 0.15f;  ///< deflection of a game pad's stick that counts as none

}  // namespace

void LeverInput::find_pad() {
    if (pad_ && !SDL_GameControllerGetAttached(pad_)) {
        SDL_GameControllerClose(pad_);
        pad_ = nullptr;
    }
    for (int p = 0; p < SDL_NumJoysticks() && !pad_; ++p) {
        if (SDL_IsGameController(p)) pad_ = SDL_GameControllerOpen(p);
    }
}

float LeverInput::stick(SDL_GameControllerAxis axis) const {
    if (!pad_) return 0;
    const float value = static_cast<float>(SDL_GameControllerGetAxis(pad_, axis)) / 32767.0f;
    return std::abs(value) < kStickDead ? 0 : value;
}

void LeverInput::use(const std::set<SDL_Scancode>& keys_down, ViewState& state,
                     Simulation& simulation) {
    sent_.resize(state.levers.size());
    const auto pressed = [&](SDL_Scancode key) { return keys_down.count(key) != 0; };
    const auto key_value = [&](SDL_Scancode back, SDL_Scancode ahead) {
        return (pressed(ahead) ? 1.0f : 0.0f) - (pressed(back) ? 1.0f : 0.0f);
    };
    const bool has_wheels = state.has_raycast_vehicle ||
                            std::any_of(state.levers.begin(), state.levers.end(),
                                        [](const Lever& lever) { return lever.is_wheel(); });
    float throttle = key_value(SDL_SCANCODE_DOWN, SDL_SCANCODE_UP);
    float steering = key_value(SDL_SCANCODE_RIGHT, SDL_SCANCODE_LEFT);
    if (has_wheels) {
        throttle +=
            stick(SDL_CONTROLLER_AXIS_TRIGGERRIGHT) - stick(SDL_CONTROLLER_AXIS_TRIGGERLEFT);
        steering -= stick(SDL_CONTROLLER_AXIS_LEFTX);
    }
    float brake = pressed(SDL_SCANCODE_B) ? 1.0f : 0.0f;
    if (pad_ && SDL_GameControllerGetButton(pad_, SDL_CONTROLLER_BUTTON_A)) brake = 1;
    bool is_used = has_wheels && (throttle != 0 || steering != 0 || brake != 0);
    brake = std::max(brake, state.brake);
    throttle = std::clamp(throttle + state.throttle, -1.0f, 1.0f);
    steering = std::clamp(steering + state.steering, -1.0f, 1.0f);
    size_t arm = 0;
    for (size_t l = 0; l < state.levers.size(); ++l) {
        const Lever& lever = state.levers[l];
        float value = state.lever_values[l];
        double speed = 0;
        if (lever.is_wheel()) {
            speed =
                wheel_speed(lever, static_cast<double>(throttle), static_cast<double>(steering));
        } else {
            float hand = 0;
            if (arm < std::size(kLeverKeys)) {
                hand += key_value(kLeverKeys[arm][0], kLeverKeys[arm][1]);
            }
            if (!has_wheels && arm < std::size(kLeverSticks)) hand += stick(kLeverSticks[arm]);
            is_used |= hand != 0;
            value = std::clamp(value + hand, -1.0f, 1.0f);
            ++arm;
        }
        speed += static_cast<double>(value) * lever.speed;
        state.deflections[l] = value;
        const std::optional<double> wanted =
            state.is_driving || is_used ? std::optional<double>(speed) : std::nullopt;
        if (wanted == sent_[l]) continue;
        simulation.set_lever(lever.joint, wanted);
        sent_[l] = wanted;
    }
    state.is_driving |= is_used;
    if (!state.has_raycast_vehicle) return;
    std::optional<scene::DriveCommand> drive;
    if (state.is_driving) {
        drive = scene::DriveCommand{static_cast<double>(throttle), static_cast<double>(steering),
                                    static_cast<double>(brake)};
    }
    if (drive == sent_drive_) return;
    simulation.set_drive(drive);
    sent_drive_ = drive;
}

}  // namespace bsoil::viewer
