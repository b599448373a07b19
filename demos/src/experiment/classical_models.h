/// The classical models of terramechanics in closed form or as one integral, to stand beside the
/// soil's results. Pure functions, SI units.
#pragma once

#include <span>

namespace bsoil::experiment {

/// Pressure-sinkage relation p = (kc / b + kphi) z^n (M. G. Bekker, Introduction to Terrain-Vehicle
/// Systems, 1969). b: radius of a circular plate, shorter side of a rectangle or a wheel's contact.
struct BekkerSoil {
    double kc = 0;    ///< [N/m^(n+1)]
    double kphi = 0;  ///< [N/m^(n+2)]
    double n = 1;
    double stiffness(double b_m) const { return kc / b_m + kphi; }  ///< [N/m^(n+2)]
};
double bekker_pressure_pa(const BekkerSoil& soil, double b_m, double sinkage_m);

/// A measured point of a plate test.
struct PlateReading {
    double b_m = 0, sinkage_m = 0, pressure_pa = 0;
};
/// The parameters that fit plate tests: a least squares line through the logarithms with the
/// pressures squared as weights (J. Y. Wong, J. Terramechanics 17(1), 1980), with one n for all
/// plates; kc is 0 for plates of one size. Readings without pressure or sinkage are left out.
BekkerSoil fit_bekker(std::span<const PlateReading> readings);

/// Share 1 - exp(-j / K) of the shear strength after a shear displacement j (Z. Janosi and
/// B. Hanamoto, 1961). 1 where K is 0.
double janosi_share(double displacement_m, double k_m);

/// Shear strength c + sigma tan phi (Mohr and Coulomb) and its development.
struct ShearSoil {
    double cohesion_pa = 0;
    double friction_angle_rad = 0;
    double shear_displacement_m = 0;  ///< Janosi and Hanamoto's K
    double strength_pa(double normal_stress_pa) const;
};

/// A measured point of a shear test.
struct ShearReading {
    double displacement_m = 0, stress_pa = 0;
};
/// A curve of shear stress over displacement, stress_pa (1 - exp(-j / k_m)).
struct JanosiCurve {
    double stress_pa = 0, k_m = 0;
    double at_pa(double displacement_m) const {
        return stress_pa * janosi_share(displacement_m, k_m);
    }
};
/// The largest measured stress, and K by weighted least squares (J. Y. Wong, J. Terramechanics
/// 17(1), 1980).
JanosiCurve fit_janosi(std::span<const ShearReading> readings);

/// A rigid wheel on soil under load.
struct ClassicalWheel {
    double radius_m = 0;
    double shear_radius_m = 0;  ///< where soil shears: of the rim, or of the lugs' tips
    double width_m = 0;
    double load_n = 0;
    double slip_ratio = 0;      ///< as of the traction rig: -1 locked, below 1
    double slip_angle_rad = 0;  ///< from the travel to the heading, to the left positive
    double peak_stress_c1 = 0;  ///< sigma is largest at (c1 + c2 slip) of the entry angle
    double peak_stress_c2 = 0;
};
struct WheelForces {
    double tractive_n = 0;  ///< along the heading
    double lateral_n = 0;   ///< to the left of the heading
    double torque_n_m = 0;
    double sinkage_m = 0;
};
/// Stresses under the rim after J.-Y. Wong and A. R. Reece (J. Terramechanics 4(1) and 4(2), 1967)
/// with Bekker's pressure before the largest stress and its mirror image, stretched to an exit
/// angle of 0, behind it; Janosi's shear along and across the heading (across: G. Ishigami et al.,
/// J. Field Robotics 24, 2007, without the soil that the wheel's flank pushes), bounded together by
/// Mohr and Coulomb; lugs shear at their tips (L. Ding et al., J. Terramechanics 48(1), 2011). The
/// entry angle is the one that bears the load. A wheel that the soil cannot bear sinks to its axle.
WheelForces wong_reece_wheel(const ClassicalWheel& wheel, const BekkerSoil& bearing,
                             const ShearSoil& shear);

/// A flat blade that moves level through soil with a level surface.
struct ClassicalBlade {
    double width_m = 0, depth_m = 0;
    double rake_rad = 0;            ///< between face and horizontal, before the tip
    double friction_angle_rad = 0;  ///< of soil on the blade
};
struct WedgeForce {
    double draft_n = 0;            ///< against the travel
    double lift_n = 0;             ///< of the soil on the blade, up
    double failure_angle_rad = 0;  ///< of the wedge's base
};
/// Passive wedge in front of a blade with the two crescents at its sides, at the failure angle of
/// least force, without cohesion (E. McKyes and O. S. Ali, J. Terramechanics 14(2), 1977). For an
/// endless width it is Coulomb's wedge.
WedgeForce mckyes_ali_wedge(const ClassicalBlade& blade, double unit_weight_n_m3,
                            double friction_angle_rad);

}  // namespace bsoil::experiment
