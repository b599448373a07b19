/// Banks of cohesive soil that fail as a whole: the slope stability (1) to (4) of the thesis for
/// plane wedges of any width, where the thesis has wedges between neighbouring columns only (its
/// section 2.1.2).
///
/// A plane starts at a toe and comes out at the surface in the middle of a column further on. It
/// starts half a column before the first where the ground goes on rising as it begins to, at the
/// first where it rises as a wall, in between by the second rise over the first. Of the planes that
/// fail the flattest counts. A voxel's bonded soil lies below the rest of it.
#pragma once

#include <functional>
#include <set>

#include "bsoil/material.h"
#include "oracle/field.h"

namespace oracle {

struct BankSoil {
    double cohesion_height = 0;  ///< cohesion over unit weight [voxels]
    double friction = 0;         ///< tan(phi)
    bool is_cohesive = false;    ///< set by failing_planes
};
using BankSoilLookup = std::function<BankSoil(const Voxel& soil, bool bonded)>;

/// Cohesion over unit weight [m] of moved soil of a relative density, after Hvorslev (1937): a
/// share of the pressure that belongs to the density, here from 1 kPa (0) to 1 MPa (1),
/// logarithmically. No less than it keeps, no more than it had.
double moved_strength_m(const bsoil::MaterialDef& soil, double relative_density,
                        double gravity_m_s2);

/// tan(phi) of soil that was never moved, after Bolton (1986, 1987): the critical angle and
/// `dilatancy_angle_rad` for each unit of 5 I - 1, 0 to 4.
double peak_friction(const bsoil::MaterialDef& soil, double relative_density);

/// Relative density of a voxel's soil, 0..1; 0 where it does not change.
double relative_density(const Model& model, const Voxel& voxel);

/// From a column, so many columns along x and y a step.
struct Way {
    int x = 0, y = 0, dx = 0, dy = 0;
    auto operator<=>(const Way&) const = default;
};

struct FailingPlanes {
    std::vector<double> lowest;  ///< height per column [y * nx + x]; infinity where none fails
    std::set<Way> ways;          ///< from their toes
};

/// Cohesion counts times `strength`. It and friction are the largest within `blur` of the plane
/// where `strength` is above 1, else the least. least_friction: of all materials. asks: of a way
/// that is steep enough, whether planes are looked for.
FailingPlanes failing_planes(const Model& model, const Field& field, const BankSoilLookup& soil,
                             double least_friction, double strength, double blur,
                             const std::function<bool(const Way&)>& asks);

}  // namespace oracle
