#include "classical_models.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "line_fit.h"

namespace bsoil::experiment {
namespace {

/// Elements of the rim: twice as many change no figure by more than 1e-5 of itself.
constexpr int kRimElements = 400;
/// Halvings of an interval of angles, down to double precision.
constexpr int kHalvings = 60;
/// Steps of the failure angle in the first search for the least force.
constexpr int kAngleSteps = 500;
/// A locked wheel's travel for each radian it turns, in radii: it slides throughout.
constexpr double kLockedTravel = 1e9;

/// Forces of a wheel with a given entry angle; what it bears is its vertical force.
struct RimForces {
    double vertical_n = 0;
    WheelForces of_wheel;
};

RimForces rim_forces(const ClassicalWheel& wheel, const BekkerSoil& bearing, const ShearSoil& shear,
                     double entry_rad) {
    const double s = wheel.slip_ratio;
    // travel along the heading and across it while the wheel turns by one radian, in radii
    const double travel =
        s >= 0 ? 1 - s : std::min(kLockedTravel, 1 / std::max(1 + s, 1 / kLockedTravel));
    const double along = travel * std::cos(wheel.slip_angle_rad);
    const double across = travel * std::sin(wheel.slip_angle_rad);
    const double peak_rad =
        std::clamp(wheel.peak_stress_c1 + wheel.peak_stress_c2 * std::max(0.0, s), 0.0, 1.0) *
        entry_rad;
    const double stiffness = bearing.stiffness(wheel.width_m);
    RimForces out;
    for (int i = 0; i < kRimElements; ++i) {
        const double angle = entry_rad * (i + 0.5) / kRimElements;
        // an angle behind the largest stress has that of one before it
        const double front =
            angle >= peak_rad ? angle : entry_rad - angle / peak_rad * (entry_rad - peak_rad);
        const double sinkage_m = wheel.radius_m * (std::cos(front) - std::cos(entry_rad));
        const double stress_pa = stiffness * std::pow(std::max(0.0, sinkage_m), bearing.n);
        const double turned = entry_rad - angle;
        const double slid = wheel.shear_radius_m * turned -
                            wheel.radius_m * along * (std::sin(entry_rad) - std::sin(angle));
        const double drifted = wheel.radius_m * across * turned;
        const double displacement_m = std::hypot(slid, drifted);
        double along_pa = 0, across_pa = 0;
        if (displacement_m > 0) {
            const double shear_pa = shear.strength_pa(stress_pa) *
                                    janosi_share(displacement_m, shear.shear_displacement_m);
            along_pa = shear_pa * slid / displacement_m;
            across_pa = shear_pa * drifted / displacement_m;
        }
        const double rim_m2 = wheel.width_m * wheel.radius_m * entry_rad / kRimElements;
        const double lug_m2 = rim_m2 * wheel.shear_radius_m / wheel.radius_m;
        out.vertical_n +=
            rim_m2 * stress_pa * std::cos(angle) + lug_m2 * along_pa * std::sin(angle);
        out.of_wheel.tractive_n +=
            lug_m2 * along_pa * std::cos(angle) - rim_m2 * stress_pa * std::sin(angle);
        out.of_wheel.lateral_n += lug_m2 * across_pa;
        out.of_wheel.torque_n_m += lug_m2 * wheel.shear_radius_m * along_pa;
    }
    out.of_wheel.sinkage_m = wheel.radius_m * (1 - std::cos(entry_rad));
    return out;
}

}  // namespace

double bekker_pressure_pa(const BekkerSoil& soil, double b_m, double sinkage_m) {
    return sinkage_m > 0 ? soil.stiffness(b_m) * std::pow(sinkage_m, soil.n) : 0;
}

BekkerSoil fit_bekker(std::span<const PlateReading> readings) {
    // Logarithms of sinkage and pressure, and weights, by plate.
    struct Plate {
        std::vector<double> x, y, w;
    };
    std::map<double, Plate> plates;
    for (const PlateReading& r : readings) {
        if (!(r.sinkage_m > 0) || !(r.pressure_pa > 0)) continue;
        Plate& plate = plates[r.b_m];
        plate.x.push_back(std::log(r.sinkage_m));
        plate.y.push_back(std::log(r.pressure_pa));
        plate.w.push_back(r.pressure_pa * r.pressure_pa);
    }
    // One exponent for all plates: about each plate's own mean.
    const auto count = static_cast<Eigen::Index>(plates.size());
    Eigen::VectorXd x_mean(count), y_mean(count), inverse_b(count);
    double xy = 0, xx = 0;
    Eigen::Index i = 0;
    for (const auto& [b_m, plate] : plates) {
        const auto size = static_cast<Eigen::Index>(plate.x.size());
        const Eigen::Map<const Eigen::ArrayXd> x(plate.x.data(), size), y(plate.y.data(), size),
            w(plate.w.data(), size);
        x_mean[i] = (w * x).sum() / w.sum();
        y_mean[i] = (w * y).sum() / w.sum();
        xy += (w * (x - x_mean[i]) * (y - y_mean[i])).sum();
        xx += (w * (x - x_mean[i]).square()).sum();
        inverse_b[i++] = 1 / b_m;
    }
    BekkerSoil soil;
    if (!(xx > 0)) return soil;
    soil.n = xy / xx;
    // The stiffness of each plate is kc / b + kphi.
    const Eigen::VectorXd stiffness = (y_mean - soil.n * x_mean).array().exp();
    const auto line = fit_line(inverse_b, stiffness, Eigen::VectorXd::Ones(count));
    soil.kc = line ? line->slope : 0;
    soil.kphi = line ? line->offset : stiffness.mean();
    return soil;
}

double janosi_share(double displacement_m, double k_m) {
    return k_m > 0 ? -std::expm1(-displacement_m / k_m) : 1;
}

JanosiCurve fit_janosi(std::span<const ShearReading> readings) {
    JanosiCurve curve;
    for (const ShearReading& r : readings) curve.stress_pa = std::max(curve.stress_pa, r.stress_pa);
    double jj = 0, jl = 0;
    for (const ShearReading& r : readings) {
        const double missing = 1 - r.stress_pa / curve.stress_pa;
        if (!(missing > 0)) continue;  // the logarithm of the largest has no end
        jj += missing * missing * r.displacement_m * r.displacement_m;
        jl += missing * missing * r.displacement_m * std::log(missing);
    }
    if (jl < 0) curve.k_m = -jj / jl;
    return curve;
}

double ShearSoil::strength_pa(double normal_stress_pa) const {
    return cohesion_pa + normal_stress_pa * std::tan(friction_angle_rad);
}

WheelForces wong_reece_wheel(const ClassicalWheel& wheel, const BekkerSoil& bearing,
                             const ShearSoil& shear) {
    double low = 0, high = std::numbers::pi / 2;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = (low + high) / 2;
        (rim_forces(wheel, bearing, shear, middle).vertical_n < wheel.load_n ? low : high) = middle;
    }
    return rim_forces(wheel, bearing, shear, high).of_wheel;
}

WedgeForce mckyes_ali_wedge(const ClassicalBlade& blade, double unit_weight_n_m3,
                            double friction_angle_rad) {
    const auto cot = [](double angle) { return 1 / std::tan(angle); };
    const double attack = blade.rake_rad + blade.friction_angle_rad;
    const double d = blade.depth_m, w = blade.width_m;
    const auto force_n = [&](double failure_rad) {
        const double reach = cot(blade.rake_rad) + cot(failure_rad);  // of the wedge, in depths
        const double lean = cot(blade.rake_rad) / reach;
        const double sides = 2 * d * reach / (3 * w) * std::sqrt(std::max(0.0, 1 - lean * lean));
        const double resistance =
            std::cos(attack) + std::sin(attack) * cot(failure_rad + friction_angle_rad);
        const double factor = reach / 2 * (1 + sides) / resistance;
        return resistance > 0 && reach > 0 ? unit_weight_n_m3 * d * d * w * factor : HUGE_VAL;
    };
    // coarsely first: outside of the wedges that can slide there is no force to compare
    const double step = std::numbers::pi / 2 / kAngleSteps;
    int best = 1;
    for (int i = 1; i < kAngleSteps; ++i) {
        if (force_n(i * step) < force_n(best * step)) best = i;
    }
    double low = (best - 1) * step, high = (best + 1) * step;
    for (int i = 0; i < kHalvings; ++i) {
        const double third = (high - low) / 3;
        if (force_n(low + third) < force_n(high - third)) {
            high -= third;
        } else {
            low += third;
        }
    }
    const double failure_rad = (low + high) / 2, force = force_n(failure_rad);
    // soil slides up along the face: friction lifts an upright blade, a flat one is pressed down
    return {force * std::sin(attack), -force * std::cos(attack), failure_rad};
}

}  // namespace bsoil::experiment
