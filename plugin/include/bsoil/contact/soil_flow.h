/// Which way soil goes that a face pushes, and what is left of the face's sliding past it.
#pragma once

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// How fast soil flows along a face over how fast the face pushes it: tan(45 deg - phi / 2), as in
/// a passive wedge, which slides along a plane at that angle to the wall's normal. For rims: Wong
/// and Reece (1967).
double flow_slope(double friction_angle_rad);

/// Sliding of a face past the soil beside it. Soil that is pushed can flow along the face towards
/// the free surface, as fast as `slope` times the approach. A face that slides there no faster goes
/// with the soil, and nothing rubs. One that slides faster rubs with the rest. Against the flow or
/// across it all of the sliding counts: soil sticks to a rough face rather than flow past it.
/// No soil flows along a face that is level to within kLeaningSine of it, in proportion: it has no
/// such direction.
/// slide: along the face; approach: along the outward unit normal; in one unit.
Vec3 slide_past_flow(Vec3 slide, double approach, Vec3 normal, Vec3 up, double slope);

/// Share 0..1 of a sliding past the soil that drags it up along the face, towards the free surface.
/// None along a face that is level, in proportion as above.
double upward_share(Vec3 past, Vec3 normal, Vec3 up);

/// What a face that drags its soil towards the free surface bears, over what it bears without
/// friction. The fan of slip lines from the face to the surface (Sokolovskii 1965) is narrower by
/// the turn of the principal stress on the face, (asin(sin d / sin phi) + d) / 2:
///
///     cos d (cos d + sqrt(sin^2 phi - sin^2 d)) / (1 + sin phi) exp(-(asin(sin d / sin phi) + d)
///     tan phi),   d = atan(friction) <= phi
///
/// For weightless soil under a surface load it is exact while a fan is left: up to an inclination
/// of 45 deg - phi / 2 with all friction. For steeper faces it is taken on. 1 without friction;
/// 0.16 at phi = 29 deg with all of it. friction: 0..tan phi.
double fan_share(double friction_angle_rad, double friction);

}  // namespace bsoil
#pragma GCC visibility pop
