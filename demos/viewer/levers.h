/// What a person can drive in a scene: a lever for each joint with a motor, and a throttle with
/// steering for the wheels among them.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace bsoil::viewer {

/// One lever.
struct Lever {
    std::string name;     ///< of the joint
    int joint = 0;        ///< in the order of BulletScene::joints()
    bool slides = false;  ///< its unit: m/s, else rad/s
    double speed = 0.5;   ///< at full deflection
    /// Of a wheel: the sign of a forward turn, else 0; and on which side of the vehicle it is (1
    /// left, -1 right, 0 the middle).
    int forward = 0, side = 0;

    bool is_wheel() const { return forward != 0; }
};

/// The levers of a scene. Full speed is the fastest that the scene's own motions drive the joint,
/// else a usual one.
std::vector<Lever> find_levers(const scene::Scene& scene);

/// Speed of a wheel for throttle and steering, -1..1 each: a vehicle turns by its sides' different
/// speeds, to the left for positive steering.
double wheel_speed(const Lever& wheel, double throttle, double steering);

}  // namespace bsoil::viewer
