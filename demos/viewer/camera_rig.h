/// How the window looks at the world: around a point, along with a body, or from a body's cab.
#pragma once

#include "bsoil/render/renderer.h"

namespace bsoil::viewer {

enum class CameraMode { orbit, follow, cab };

/// What a place of the picture looks along.
struct Sight {
    Vec3 from_m, direction;
};

/// Through a place of the picture, from its upper left corner: shares of its width and height, 0 to
/// 1. `aspect` is width over height.
Sight sight_through(const render::Camera& camera, double across, double down, double aspect);

class CameraRig {
  public:
    explicit CameraRig(const render::Camera& start);

    CameraMode mode() const { return mode_; }
    void set_mode(CameraMode mode, const Pose& body);
    /// Back to where it was at first.
    void reset();

    /// Angles [rad]; around the target, or of the head in a cab.
    void turn(double yaw_rad, double pitch_rad);
    /// Across the line of sight, as fractions of the picture's height.
    void pan(double right, double up);
    /// Factor of the distance.
    void zoom(double factor);
    /// The eye of a cab, in the body's frame: ahead, to the left, up [m].
    void set_cab_eye(Vec3 eye_m) { cab_eye_m_ = eye_m; }
    Vec3 cab_eye_m() const { return cab_eye_m_; }

    /// The camera, with the body it goes along with at this pose.
    render::Camera camera(const Pose& body) const;

  private:
    Vec3 direction(double yaw_rad, double pitch_rad) const;

    render::Camera start_;
    Vec3 forward_, left_;  ///< level axes that yaw counts from
    CameraMode mode_ = CameraMode::orbit;
    Vec3 target_m_;
    double yaw_rad_ = 0, pitch_rad_ = 0, distance_m_ = 1;
    Vec3 followed_from_m_;
    double head_yaw_rad_ = 0, head_pitch_rad_ = -0.25;
    Vec3 cab_eye_m_{0.3, 0, 1.2};
};

}  // namespace bsoil::viewer
