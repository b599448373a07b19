/// The mass of a robot's body: of URDF inertials and of solids, merged.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "scene/scene.h"

namespace bsoil::scene {

/// Mass and its first and second moments in one frame.
class MassSum {
  public:
    /// A mass whose inertia [kg m2] is given about its own centre, in the axes of `frame`.
    void add(double mass_kg, const Eigen::Matrix3d& inertia_kg_m2, const Pose& frame);
    /// A solid of even density, placed by its own pose within `frame`.
    void add_solid(const ShapeItem& solid, const Pose& frame, double density_kg_m3);
    void add(const MassSum& other);

    double mass_kg() const { return mass_kg_; }
    /// Centre of mass, principal axes and moments. Only where there is mass.
    Inertial principal() const;

  private:
    double mass_kg_ = 0;
    Eigen::Vector3d moment_ = Eigen::Vector3d::Zero();  // of mass about the frame's origin
    Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();  // integral of r r^T dm
};

/// Volume [m3] of a box, sphere, cylinder, hull or mesh of a robot.
double solid_volume_m3(const ShapeItem& solid);

/// What is wrong with an inertia tensor about the centre of mass: nothing where the moments are
/// finite, none is negative and none exceeds the sum of the other two by more than a thousandth.
std::optional<std::string> inertia_fault(const Eigen::Matrix3d& inertia_kg_m2);

}  // namespace bsoil::scene
