#include "camera_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bsoil::viewer {
namespace {

constexpr double kPitchMost = 1.5;                 ///< rad: never in line with up
constexpr double kNearest = 0.02, kFarthest = 50;  ///< distances, of the one at first

Vec3 unit(Vec3 v) { return v * (1 / length(v)); }

}  // namespace

Sight sight_through(const render::Camera& camera, double across, double down, double aspect) {
    const Vec3 ahead = unit(camera.target - camera.eye);
    const Vec3 right = unit(cross(ahead, camera.up));
    const Vec3 up = cross(right, ahead);
    const double half = std::tan(camera.fov_rad / 2);
    const double x = (2 * across - 1 - camera.shift) * half * aspect;
    const double y = (1 - 2 * down) * half;
    return {camera.eye, unit(ahead + right * x + up * y)};
}

CameraRig::CameraRig(const render::Camera& start) : start_(start) {
    const Vec3 up = unit(start.up);
    Vec3 back = start.eye - start.target;
    back = back - up * dot(back, up);
    if (length(back) < 1e-6) back = cross(up, Vec3{0.6, 0.64, 0.48});
    forward_ = unit(back);
    left_ = cross(up, forward_);
    reset();
}

void CameraRig::reset() {
    const Vec3 way = start_.eye - start_.target;
    distance_m_ = length(way);
    target_m_ = start_.target;
    yaw_rad_ = 0;
    pitch_rad_ = std::asin(std::clamp(dot(way, unit(start_.up)) / distance_m_, -1.0, 1.0));
    head_yaw_rad_ = 0;
    head_pitch_rad_ = -0.25;
}

void CameraRig::set_mode(CameraMode mode, const Pose& body) {
    // What was followed so far stays where the eye has got to.
    if (mode_ == CameraMode::follow) target_m_ += body.position - followed_from_m_;
    mode_ = mode;
    followed_from_m_ = body.position;
}

void CameraRig::turn(double yaw_rad, double pitch_rad) {
    double& yaw = mode_ == CameraMode::cab ? head_yaw_rad_ : yaw_rad_;
    double& pitch = mode_ == CameraMode::cab ? head_pitch_rad_ : pitch_rad_;
    yaw = std::remainder(yaw + yaw_rad, 2 * std::numbers::pi);
    pitch = std::clamp(pitch + pitch_rad, -kPitchMost, kPitchMost);
}

Vec3 CameraRig::direction(double yaw_rad, double pitch_rad) const {
    const Vec3 level = forward_ * std::cos(yaw_rad) + left_ * std::sin(yaw_rad);
    return level * std::cos(pitch_rad) + unit(start_.up) * std::sin(pitch_rad);
}

void CameraRig::pan(double right, double up) {
    if (mode_ == CameraMode::cab) return;
    const Vec3 back = direction(yaw_rad_, pitch_rad_);
    const Vec3 aside = unit(cross(unit(start_.up), back));
    const double height_m = 2 * distance_m_ * std::tan(start_.fov_rad / 2);
    target_m_ += (aside * right + cross(back, aside) * up) * height_m;
}

void CameraRig::zoom(double factor) {
    const double first_m = length(start_.eye - start_.target);
    distance_m_ = std::clamp(distance_m_ * factor, kNearest * first_m, kFarthest * first_m);
}

render::Camera CameraRig::camera(const Pose& body) const {
    render::Camera camera = start_;
    if (mode_ == CameraMode::cab) {
        // The body's own frame has x ahead; up is its second or third axis, as in the world.
        const bool y_up = std::abs(start_.up.y) > std::abs(start_.up.z);
        const auto in_body = [y_up](double ahead, double left, double up) {
            return y_up ? Vec3{ahead, up, -left} : Vec3{ahead, left, up};
        };
        camera.eye = transform(body, in_body(cab_eye_m_.x, cab_eye_m_.y, cab_eye_m_.z));
        const double level = std::cos(head_pitch_rad_);
        const Vec3 sight = in_body(level * std::cos(head_yaw_rad_), level * std::sin(head_yaw_rad_),
                                   std::sin(head_pitch_rad_));
        camera.target = camera.eye + rotate(body.rotation, sight) * 6.0;
        camera.up = rotate(body.rotation, in_body(0, 0, 1));
        camera.fov_rad = 1.1;
        return camera;
    }
    camera.target = target_m_;
    if (mode_ == CameraMode::follow) camera.target += body.position - followed_from_m_;
    camera.eye = camera.target + direction(yaw_rad_, pitch_rad_) * distance_m_;
    return camera;
}

}  // namespace bsoil::viewer
