/// A law on exact surfaces in a flat bed, as the coupling would find its forces at yield.
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/body.h"
#include "flat_bed_bow.h"
#include "oracle/resistive_force.h"

namespace bsoil::flat_bed {

constexpr double kPi = std::numbers::pi;
inline double radians(double degrees) { return degrees * kPi / 180; }

/// What a law is changed by. Each is tried alone and with others.
struct Rules {
    bool wedge = false;         ///< a wall meets no more than its passive wedge: the library's rule
    bool bearing = false;       ///< a sole bears no less than its bearing capacity
    Bow bow = Bow::none;        ///< soil goes with the front
    double shear_k_m = 0;       ///< Janosi's K; 0: shear is there at once
    bool smooth_metal = false;  ///< rims have two thirds of the soil's angle, else all of it
    /// trapped: the library's rule; full: the same, the space between lugs taken as filled
    enum class Lugs { apart, cylinder, full, trapped } lugs = Lugs::apart;
};

struct Law {
    std::string name;
    bool is_granular = false;
    Rules rules;
};

struct Soil {
    double density_kg_m3, friction_angle_deg, cohesion_pa = 0;
    std::optional<double> loose_kg_m3 = {}, compacted_kg_m3 = {};
    double published_k_m = 0;  ///< what the experiments of `bsoil validate` give today's law
};

/// A body in a flat bed, pushed in a given way.
struct Case {
    Soil soil;
    double friction = 0;
    const std::vector<oracle::Facet>* surface = nullptr;
    const std::vector<ToothRow>* teeth = nullptr;  ///< of each facet, in the body's frame
    oracle::Intruder motion;
    double radius_m = 0;  ///< of a wheel about its y axis, for the shear displacement; else 0
    double edge_m = 0.01;
};

/// Forces of the law on exact surfaces. Each element that moves into the soil gives its limit and
/// its friction along its sliding, as a row of the coupling at yield does.
oracle::Wrench force_of(const Law& law, const Case& c, double sinkage_m);

/// About z, or about y where it lies.
ConvexShape cylinder(double radius_m, double width_m, bool lies);

}  // namespace bsoil::flat_bed
