#include "bsoil/contact/wheel_solver.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

/// Rounds through all rows. Ours: the four unknowns are few, and this leaves less than a hundredth
/// of the force. More takes longer; fewer, and parked wheels creep.
constexpr int kIterations = 40;

enum Unknown { kRise, kForward, kSide, kSpin, kUnknownCount };
using Unknowns = Eigen::Matrix<double, kUnknownCount, 1>;

/// A direction in the space of the unknowns along which impulses act.
struct Row {
    Unknowns jacobian = Unknowns::Zero();
    double target_m_s = 0;  ///< speed along it that the row aims at
    double softness = 0;    ///< speed that an impulse leaves: 0 is rigid [m/s per N s]
    double impulse = 0;
    double inverse_mass = 0;
};

class Solver {
  public:
    Solver(const Unknowns& start, const Unknowns& mass)
        : speed(start), inverse_mass_(mass.cwiseInverse()) {}

    Row row(const Unknowns& jacobian, double target_m_s = 0, double softness = 0) const {
        return {jacobian, target_m_s, softness, 0, jacobian.dot(inverse_mass_ * jacobian)};
    }
    double wanted(const Row& row) const {
        const double along = row.jacobian.dot(speed) - row.target_m_s + row.softness * row.impulse;
        return row.impulse - along / (row.inverse_mass + row.softness);
    }
    void apply(Row& row, double impulse) {
        speed += (impulse - row.impulse) * (inverse_mass_ * row.jacobian);
        row.impulse = impulse;
    }
    void solve(Row& row, double least, double most) {
        apply(row, std::clamp(wanted(row), least, most));
    }

    Unknowns speed;

  private:
    Eigen::DiagonalMatrix<double, kUnknownCount> inverse_mass_;
};

struct PatchRows {
    std::array<Row, 3> rows;  ///< normal, then two across it
    std::array<Vec3, 3> directions;
};

/// Starts from the last substep's force, shared out by the patches' limits: what the iterations
/// leave is then a part of the change, not of the force, and a parked wheel does not creep.
void start_from(const WheelContact& contact, Vec3 up, double substep_s,
                std::vector<PatchRows>& patches, Solver& solver) {
    double bearing_n = 0;
    for (const ContactPatch& p : contact.patches) {
        bearing_n += p.normal_limit_n * std::max(0.0, -dot(p.normal, up));
    }
    if (!(bearing_n > 0)) return;
    const double normal_n = std::max(0.0, dot(contact.last_force_n, up));
    const Vec3 across_n = contact.last_force_n - dot(contact.last_force_n, up) * up;
    for (size_t i = 0; i < patches.size(); ++i) {
        const ContactPatch& p = contact.patches[i];
        if (dot(p.normal, up) >= 0) continue;
        const double share = p.normal_limit_n / bearing_n;
        auto& [normal, first, second] = patches[i].rows;
        solver.apply(normal, std::min(1.0, share * normal_n / p.normal_limit_n) * p.normal_limit_n *
                                 substep_s);
        const double a = share * substep_s * dot(across_n, patches[i].directions[1]);
        const double b = share * substep_s * dot(across_n, patches[i].directions[2]);
        const double most =
            p.shear_share * (p.friction * normal.impulse + p.adhesion_n * substep_s);
        const double scale = std::min(1.0, most / std::max(std::hypot(a, b), 1e-30));
        solver.apply(first, scale * a);
        solver.apply(second, scale * b);
    }
}

}  // namespace

WheelForces solve_wheel(const WheelState& wheel, const WheelContact& contact, double substep_s,
                        std::vector<double>& patch_normal_n) {
    // Along the strut: m (w - w_before) = dt (N - F), F = strut_n + stiffness dt w.
    const bool is_elastic = wheel.strut_n > 0 && wheel.strut_n < wheel.strut_limit_n;
    const double strut_n = std::clamp(wheel.strut_n, 0.0, wheel.strut_limit_n);
    const double stiffness_n_m = is_elastic ? wheel.strut_stiffness_n_m : 0;
    const double rise_mass_kg = wheel.mass_kg + stiffness_n_m * substep_s * substep_s;
    const double free_rise_m_s =
        (wheel.mass_kg * wheel.rise_m_s - substep_s * strut_n) / rise_mass_kg;
    const double inertia_kg_m2 = 0.5 * wheel.mass_kg * wheel.radius_m * wheel.radius_m;
    Solver solver({free_rise_m_s, dot(wheel.chassis_velocity_m_s, wheel.forward),
                   dot(wheel.chassis_velocity_m_s, wheel.axle), wheel.spin_rad_s},
                  {rise_mass_kg, wheel.forward_mass_kg, wheel.side_mass_kg, inertia_kg_m2});

    // Rolling forward turns about -axle.
    const auto jacobian = [&wheel](Vec3 offset_m, Vec3 direction) {
        return Unknowns{dot(wheel.up, direction), dot(wheel.forward, direction),
                        dot(wheel.axle, direction), dot(cross(-wheel.axle, offset_m), direction)};
    };
    std::vector<PatchRows> patches;
    patches.reserve(contact.patches.size());
    for (const ContactPatch& p : contact.patches) {
        const Vec3 t = unit_across(p.normal);
        PatchRows& rows = patches.emplace_back();
        rows.directions = {-p.normal, t, cross(p.normal, t)};
        for (int k = 0; k < 3; ++k) {
            rows.rows[k] = solver.row(jacobian(
                (k == 0 ? p.point_m : p.shear_point_m) - contact.center_m, rows.directions[k]));
        }
    }
    start_from(contact, wheel.up, substep_s, patches, solver);
    Row lowest = solver.row({1, 0, 0, 0}, (wheel.length_m - wheel.length_most_m) / substep_s);
    Row highest = solver.row({-1, 0, 0, 0}, (wheel.length_least_m - wheel.length_m) / substep_s);
    const bool stiffens = contact.stiffness_n_m > 0;
    Row stiffening = solver.row({1, 0, 0, 0}, 0,
                                stiffens ? 1 / (contact.stiffness_n_m * substep_s * substep_s) : 0);
    // As in btRaycastVehicle, brakes work where the engine does not.
    const double engine_n_m_s = wheel.engine_force_n * wheel.radius_m * substep_s;
    Row engine = solver.row({0, 0, 0, 1}, std::copysign(wheel.engine_spin_rad_s, engine_n_m_s));
    Row brake = solver.row({0, 0, 0, 1});
    const double brake_n_m_s =
        wheel.engine_force_n == 0 ? std::max(0.0, wheel.brake_n_s) * wheel.radius_m : 0;

    const double infinity = std::numeric_limits<double>::infinity();
    const auto iterate = [&](bool has_end) {
        for (int i = 0; i < kIterations; ++i) {
            solver.solve(engine, std::min(0.0, engine_n_m_s), std::max(0.0, engine_n_m_s));
            solver.solve(brake, -brake_n_m_s, brake_n_m_s);
            for (size_t p = 0; p < patches.size(); ++p) {
                const ContactPatch& patch = contact.patches[p];
                auto& [normal, first, second] = patches[p].rows;
                solver.solve(normal, 0, patch.normal_limit_n * substep_s);
                const double most = patch.shear_share * (patch.friction * normal.impulse +
                                                         patch.adhesion_n * substep_s);
                const double a = solver.wanted(first), b = solver.wanted(second);
                const double scale = std::min(1.0, most / std::max(std::hypot(a, b), 1e-30));
                solver.apply(first, scale * a);
                solver.apply(second, scale * b);
            }
            if (stiffens) solver.solve(stiffening, 0, infinity);
            solver.solve(lowest, 0, infinity);
            if (has_end) solver.solve(highest, 0, infinity);
        }
    };
    // First without the end that the soil pushes the wheel to. The chassis feels nothing of what
    // that holds: all that a round of the patches gives too much it would keep, and the soil would
    // report.
    iterate(false);
    if (solver.wanted(highest) > 0) iterate(true);

    WheelForces out;
    out.rise_m_s = solver.speed[kRise];
    out.spin_rad_s = solver.speed[kSpin];
    Vec3 force_n = stiffening.impulse / substep_s * wheel.up;
    patch_normal_n.clear();
    for (const PatchRows& patch : patches) {
        for (int k = 0; k < 3; ++k) {
            const double row_n = patch.rows[k].impulse / substep_s;
            force_n += row_n * patch.directions[k];
            out.torque_n_m += row_n * patch.rows[k].jacobian[kSpin];
        }
        patch_normal_n.push_back(patch.rows[0].impulse / substep_s);
    }
    out.normal_n = dot(force_n, wheel.up);
    out.forward_n = dot(force_n, wheel.forward);
    out.side_n = dot(force_n, wheel.axle);
    // At the strut's end it is the soil that pushes, not the spring.
    out.is_at_end = lowest.impulse > 0;
    out.strut_n = strut_n + stiffness_n_m * substep_s * out.rise_m_s - lowest.impulse / substep_s;
    return out;
}

}  // namespace bsoil
