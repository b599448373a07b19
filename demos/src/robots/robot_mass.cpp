#include "robot_mass.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "convex_hull.h"

namespace bsoil::scene {
namespace {

Eigen::Vector3d to_eigen(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Matrix3d matrix_of(Quat q) {
    return Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
}

/// Of even density 1, in the solid's own frame.
struct SolidMoments {
    double volume_m3 = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// A sum over the tetrahedra between the origin and each triangle.
SolidMoments moments_of(const TriangleMesh& mesh) {
    SolidMoments out;
    for (const auto& triangle : mesh.triangles) {
        std::array<Eigen::Vector3d, 3> p;
        for (size_t i = 0; i < 3; ++i) {
            p[i] = to_eigen(mesh.vertices[static_cast<size_t>(triangle[i])]);
        }
        const double volume_m3 = p[0].dot(p[1].cross(p[2])) / 6;
        const Eigen::Vector3d sum = p[0] + p[1] + p[2];
        Eigen::Matrix3d squares = sum * sum.transpose();
        for (const Eigen::Vector3d& v : p) squares += v * v.transpose();
        out.volume_m3 += volume_m3;
        out.first += volume_m3 / 4 * sum;
        out.second += volume_m3 / 20 * squares;
    }
    return out;
}

SolidMoments moments_of(const ShapeItem& solid) {
    SolidMoments out;
    const double r = solid.radius_m, h = solid.height_m;
    if (solid.shape == "box") {
        const Eigen::Vector3d size = to_eigen(solid.size_m);
        out.volume_m3 = size.prod();
        out.second.diagonal() = out.volume_m3 / 12 * size.cwiseAbs2();
    } else if (solid.shape == "sphere") {
        out.volume_m3 = 4 * std::numbers::pi / 3 * r * r * r;
        out.second.diagonal().setConstant(out.volume_m3 / 5 * r * r);
    } else if (solid.shape == "cylinder") {
        out.volume_m3 = std::numbers::pi * r * r * h;
        out.second.diagonal() = out.volume_m3 * Eigen::Vector3d(r * r / 4, r * r / 4, h * h / 12);
    } else if (solid.shape == "mesh") {
        out = moments_of(*solid.mesh);
    } else {
        out = moments_of(convex_hull(solid.points_m).surface);
    }
    return out;
}

}  // namespace

void MassSum::add(double mass_kg, const Eigen::Matrix3d& inertia_kg_m2, const Pose& frame) {
    const Eigen::Matrix3d turn = matrix_of(frame.rotation);
    const Eigen::Vector3d c = to_eigen(frame.position);
    // The trace of the inertia is twice that of the second moment.
    const Eigen::Matrix3d second =
        inertia_kg_m2.trace() / 2 * Eigen::Matrix3d::Identity() - inertia_kg_m2;
    mass_kg_ += mass_kg;
    moment_ += mass_kg * c;
    second_ += turn * second * turn.transpose() + mass_kg * c * c.transpose();
}

void MassSum::add_solid(const ShapeItem& solid, const Pose& frame, double density_kg_m3) {
    const SolidMoments m = moments_of(solid);
    const Pose pose = frame * solid.pose;
    const Eigen::Matrix3d turn = matrix_of(pose.rotation);
    const Eigen::Vector3d at = to_eigen(pose.position), first = turn * m.first;
    mass_kg_ += density_kg_m3 * m.volume_m3;
    moment_ += density_kg_m3 * (first + m.volume_m3 * at);
    second_ += density_kg_m3 * (turn * m.second * turn.transpose() + first * at.transpose() +
                                at * first.transpose() + m.volume_m3 * at * at.transpose());
}

void MassSum::add(const MassSum& other) {
    mass_kg_ += other.mass_kg_;
    moment_ += other.moment_;
    second_ += other.second_;
}

Inertial MassSum::principal() const {
    const Eigen::Vector3d center = moment_ / mass_kg_;
    const Eigen::Matrix3d second = second_ - mass_kg_ * center * center.transpose();
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
    Eigen::Matrix3d axes = solver.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) *= -1;
    const Eigen::Quaterniond q(axes);
    constexpr double kLeast = 1e-9;  // [m2] of a point mass: Bullet divides by moments
    return {{from_eigen(center), {q.x(), q.y(), q.z(), q.w()}},
            from_eigen(solver.eigenvalues().cwiseMax(kLeast * mass_kg_))};
}

double solid_volume_m3(const ShapeItem& solid) { return moments_of(solid).volume_m3; }

std::optional<std::string> inertia_fault(const Eigen::Matrix3d& inertia_kg_m2) {
    if (!inertia_kg_m2.allFinite()) return "its inertia is not finite";
    const Eigen::Vector3d m =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia_kg_m2, Eigen::EigenvaluesOnly)
            .eigenvalues();  // rising
    const std::string moments = fmt::format("{:.4g}, {:.4g} and {:.4g} kg m2", m[0], m[1], m[2]);
    constexpr double kRounding = 1e-3;  // files are written with few digits
    if (m[0] < -kRounding * m[2]) {
        return "its principal moments of inertia are " + moments + ": none may be negative";
    }
    if (m[2] > (m[0] + m[1]) * (1 + kRounding) + 1e-12) {
        return "its principal moments of inertia are " + moments +
               ": no solid has one that exceeds the sum of the other two";
    }
    return std::nullopt;
}

}  // namespace bsoil::scene
