/// Three-dimensional resistive force theory on a flat bed, summed over exact surfaces: not in the
/// thesis. Agarwal, Goldman, Kamrin, "Mechanistic framework for reduced-order models in soft
/// materials: application to three-dimensional granular intrusion" (2023).
#pragma once

#include <vector>

#include "bsoil/body.h"
#include "bsoil/geometry.h"

namespace oracle {

using bsoil::Vec3;

/// A piece of a body's surface, in the body's frame.
struct Facet {
    Vec3 at, normal;  ///< normal: unit, outward
    double area_m2 = 0;
    double share = 1;      ///< of it that is there
    double friction = -1;  ///< of this facet; negative: Sand::surface_friction
    Vec3 root = {};        ///< from the facet to what it bears as deep as; the body's frame
};

/// The outer surface of solids that may overlap, cut into facets no longer than `edge_m`: what lies
/// within another of the solids is left out. Boxes, spheres and cylinders.
std::vector<Facet> surface_of(const std::vector<bsoil::ConvexShape>& solids, double edge_m);

/// Whether a point of the body's frame lies in one of the solids.
bool is_inside(const std::vector<bsoil::ConvexShape>& solids, Vec3 at);

/// Dry sand.
struct Sand {
    double density_kg_m3 = 0, friction_angle_rad = 0;
    double surface_friction = 0;  ///< of the body on it
    bool has_wedge = false;       ///< walls meet no more than their passive wedge
};

/// Passive coefficient of a vertical wall by the moments of a log spiral about its pole, the slices
/// of which are summed one by one.
double passive_factor(double friction_angle_rad, double wall_rad);

/// A body in it. The bed's surface is level at z = 0, up is z, gravity 9.81 m/s2.
struct Intruder {
    bsoil::Pose pose;   ///< body frame to world
    Vec3 velocity_m_s;  ///< of the body frame's origin
    Vec3 angular_velocity_rad_s;
};

/// Stress over xi and depth: normal and direction are unit vectors.
Vec3 resistive_stress(Vec3 normal, Vec3 direction, double surface_friction);

/// Force and its moment about the origin of the body's frame.
struct Wrench {
    Vec3 force_n, moment_n_m;
};
Wrench resistive_force(const std::vector<Facet>& surface, const Intruder& intruder,
                       const Sand& sand);

}  // namespace oracle
