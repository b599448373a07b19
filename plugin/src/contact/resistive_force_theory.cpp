#include "bsoil/contact/resistive_force_theory.h"

#include <algorithm>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

constexpr int kTermCount = 20;  ///< of a polynomial of degree 3 in three variables

/// Coefficients c1, c2, c3 of the polynomials f1, f2, f3, one row a term, in the order of
/// polynomial_terms(). Agarwal, Goldman and Kamrin (2023), supporting information, table of the
/// generic material.
constexpr double kCoefficients[kTermCount][3] = {
    {0.00212, -0.06796, -0.02634},  {-0.0232, -0.10941, -0.03436}, {-0.2089, 0.04725, 0.45256},
    {-0.43083, -0.06914, 0.00835},  {-0.00259, -0.05835, 0.02553}, {0.48872, -0.6588, -1.3129},
    {-0.00415, -0.11985, -0.05532}, {0.07204, -0.25739, 0.0679},   {-0.0275, -0.26834, -0.16404},
    {-0.08772, 0.02692, 0.02287},   {0.01992, -0.00736, 0.02927},  {-0.45961, 0.63758, 0.95406},
    {0.40799, 0.08997, -0.00131},   {-0.10107, 0.21069, -0.11028}, {-0.06576, 0.04748, 0.01487},
    {0.05664, 0.20406, -0.0273},    {-0.09269, 0.18589, 0.10911},  {0.01892, 0.04934, -0.04097},
    {0.01033, 0.13527, 0.07881},    {0.1512, -0.33207, -0.27519},
};

std::array<double, kTermCount> polynomial_terms(double x1, double x2, double x3) {
    return {1,
            x1,
            x2,
            x3,
            x1 * x1,
            x2 * x2,
            x3 * x3,
            x1 * x2,
            x2 * x3,
            x3 * x1,
            x1 * x1 * x1,
            x2 * x2 * x2,
            x3 * x3 * x3,
            x1 * x2 * x2,
            x2 * x1 * x1,
            x2 * x3 * x3,
            x3 * x2 * x2,
            x3 * x1 * x1,
            x1 * x3 * x3,
            x1 * x2 * x3};
}

/// Below this a horizontal part has no direction (of unit vectors). Ours: for the rounding. Larger:
/// hardly inclined faces count as level.
constexpr double kNoDirection = 1e-9;

/// The horizontal direction r of the paper: of the motion, else of the normal, else any.
Vec3 radial_direction(Vec3 normal, Vec3 direction, Vec3 up) {
    for (const Vec3 v : {direction, normal}) {
        const Vec3 h = v - dot(v, up) * up;
        const double size = length(h);
        if (size > kNoDirection) return h * (1 / size);
    }
    return unit_across(up);
}

/// The angles of an element in the cylinder coordinates of the paper.
struct Attitude {
    Vec3 r, theta, up;
    double sin_gamma, cos_gamma;  ///< of the motion, below the level
};

/// Stress on a surface with this side's normal, without friction's limit.
Vec3 generic_stress(const Attitude& a, Vec3 side) {
    const double cos_beta = -dot(side, a.up);
    const double sin_beta_r = dot(side, a.r), sin_beta_theta = dot(side, a.theta);
    const double x3 = sin_beta_r * a.cos_gamma + a.sin_gamma * cos_beta;
    const std::array<double, kTermCount> terms = polynomial_terms(a.sin_gamma, cos_beta, x3);
    double f1 = 0, f2 = 0, f3 = 0;
    for (int k = 0; k < kTermCount; ++k) {
        f1 += terms[k] * kCoefficients[k][0];
        f2 += terms[k] * kCoefficients[k][1];
        f3 += terms[k] * kCoefficients[k][2];
    }
    return (f1 * sin_beta_r + f2 * a.cos_gamma) * a.r + f1 * sin_beta_theta * a.theta +
           (-f1 * cos_beta - f2 * a.sin_gamma - f3) * a.up;
}

}  // namespace

// The paper's tilt beta goes from -90 to 90 deg: a plate has the same on both sides. Of a face that
// looks up the polynomials take the other side. At 90 deg the two differ by a fifth, so one goes
// over into the other as the face leans.
Vec3 resistive_stress(Vec3 normal, Vec3 direction, Vec3 up, double surface_friction) {
    if (dot(normal, direction) <= 0) return {};
    const Vec3 r = radial_direction(normal, direction, up);
    const Attitude attitude{r, cross(up, r), up, -dot(direction, up), dot(direction, r)};
    const double turned = std::clamp(dot(normal, up) / kLeaningSine, 0.0, 1.0);
    Vec3 stress;
    if (turned < 1) stress += (1 - turned) * generic_stress(attitude, normal);
    if (turned > 0) stress += turned * generic_stress(attitude, -1.0 * normal);

    const double pressure = -dot(stress, normal);
    if (pressure <= 0) return {};  // beyond the fit: soil does not pull
    const Vec3 along_surface = stress + pressure * normal;
    const double surface = length(along_surface);
    const double most = surface_friction * pressure;
    return surface > most ? (most / surface) * along_surface - pressure * normal : stress;
}

double resistive_stiffness_pa_m(double density_kg_m3, double gravity_m_s2, double tan_phi) {
    const double m = tan_phi;
    return density_kg_m3 * gravity_m_s2 * (894 * m * m * m - 386 * m * m + 89 * m);
}

}  // namespace bsoil
