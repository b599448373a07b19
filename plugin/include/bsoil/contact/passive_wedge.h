/// The wedge of soil that a wall pushes up before it: what bounds its resistance.
#pragma once

#include "bsoil/cxx20.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Coulomb's passive coefficient for a vertical wall with friction angle `wall_rad` and level
/// ground; 1e6 where no plane of failure takes any push.
double passive_pressure_factor(double friction_angle_rad, double wall_rad);

/// Normal stress on a wall that leans back, over that on an upright one at the same depth: soil
/// lies on it, and the easiest plane through its foot asks for less (Coulomb 1776; for blades
/// McKyes and Ali 1977). look_up: cosine between the wall's normal and up, 0 upright to 1 level.
/// tan_phi >= 0; tan_wall: 0..tan_phi.
double leaning_wedge_share(double tan_phi, double tan_wall, double look_up);

/// Passive earth pressure coefficient of a vertical wall and level ground: the resultant, inclined
/// by the wall's friction angle, over half the soil's weight times the height squared.
/// Soil turns as one about the pole of a logarithmic spiral from the wall's foot to the surface.
/// Reactions on the spiral pass through its pole, so the moments of wall and weight about it
/// balance. The pole counts that asks for the least force (Terzaghi 1943; Soubra and Macuh 2002).
/// Coulomb's plane is as good for a smooth wall and has no bound for a rough one; the lesser of the
/// two is taken. friction_angle_rad: 0..1.2; wall_rad: 0..friction_angle_rad. Cost: some thousand
/// moments.
double log_spiral_passive_factor(double friction_angle_rad, double wall_rad);

/// What a wall of finite width meets over what the same stretch of an endless one does: 1 +
/// (Kp - Ka)^(2/3) 1.6 / (1 + 5 width / depth), no more than 2. Ovesen's tests on anchor slabs in
/// Brinch Hansen's form, for a wall that reaches the surface, with the limit that Duncan and Mokwa
/// (2001) set. Ka: Rankine's.
double passive_width_factor(double passive_factor, double friction_angle_rad, double width_m,
                            double depth_m);
/// What all walls in one soil have of it: (Kp - Ka)^(2/3) 1.6.
double passive_width_growth(double passive_factor, double friction_angle_rad);
/// The factor of a wall `width_m` wide whose wedge reaches `depth_m` down, from the growth that its
/// soil has: no units.
double passive_width_factor(double growth, double width_m, double depth_m);

}  // namespace bsoil
#pragma GCC visibility pop
