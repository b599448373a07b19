/// Scripted movements: key frames and what lies between them.
#pragma once

#include <vector>

#include "scene/scene.h"

namespace bsoil::scene {

/// A number over time through key frames.
class Curve {
  public:
    enum class Interpolation { smooth, linear, step };
    /// Times rise. `smooth` is the monotone cubic of Fritsch and Carlson (1980), at rest at both
    /// ends: it never leaves the range of the two keys it runs between, so that no tool overshoots
    /// into the ground.
    Curve(std::vector<double> t_s, std::vector<double> values, Interpolation interpolation);
    /// Before the first key and after the last the curve stands still.
    double value(double t_s) const;

  private:
    std::vector<double> t_s_, values_, slopes_;
    Interpolation interpolation_;
};

/// One [[motion]] of a scene, with its rounds.
class Motion {
  public:
    explicit Motion(const MotionItem& item);
    enum class Quantity { position, velocity, pose };
    Quantity quantity() const { return quantity_; }
    /// Of a joint: rad or m; as velocity rad/s or m/s.
    double value(double t_s) const { return curves_[0].value(local_time(t_s)); }
    /// Of a kinematic body.
    Pose pose(double t_s) const;

  private:
    double local_time(double t_s) const;

    Quantity quantity_ = Quantity::position;
    double period_s_ = 0;
    int repeat_count_ = 1;
    std::vector<Curve> curves_;  // one, or x, y, z and the place between rotations
    std::vector<Quat> rotations_;
};

}  // namespace bsoil::scene
