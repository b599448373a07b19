/// Plain geometry at the library's border, free of Bullet, Eigen and GL types. Host (world) axes,
/// metres.
#pragma once

#include <array>
#include <cmath>

#include "bsoil/cxx20.h"

namespace bsoil {

/// A vector or a point.
struct Vec3 {
    double x = 0, y = 0, z = 0;
    bool operator==(const Vec3&) const = default;  ///< bit for bit, but for signs of zeros
};

/// Arithmetic of vectors.
/// @{
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(Vec3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3 operator*(double s, Vec3 a) { return a * s; }
inline Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline bool is_finite(Vec3 a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
/// @}

/// Unit quaternion (x, y, z, w); the identity by default.
struct Quat {
    double x = 0, y = 0, z = 0, w = 1;
};

/// Arithmetic of rotations: a product turns by the right factor first.
/// @{
inline Quat operator*(Quat a, Quat b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
inline Quat conjugate(Quat q) { return {-q.x, -q.y, -q.z, q.w}; }
inline Vec3 rotate(Quat q, Vec3 v) {
    const Vec3 u{q.x, q.y, q.z};
    const Vec3 t = 2.0 * cross(u, v);
    return v + q.w * t + cross(u, t);
}
/// @}

/// A rigid transform: rotate, then translate.
struct Pose {
    Vec3 position;
    Quat rotation;
};

/// Arithmetic of transforms: a product applies the right factor first.
/// @{
inline Vec3 transform(const Pose& p, Vec3 v) { return p.position + rotate(p.rotation, v); }
inline Pose operator*(const Pose& a, const Pose& b) {
    return {transform(a, b.position), a.rotation * b.rotation};
}
inline Pose inverse(const Pose& p) {
    const Quat q = conjugate(p.rotation);
    return {rotate(q, -p.position), q};
}
inline bool is_finite(const Pose& p) {
    return is_finite(p.position) && std::isfinite(p.rotation.x) && std::isfinite(p.rotation.y) &&
           std::isfinite(p.rotation.z) && std::isfinite(p.rotation.w);
}
/// Finite, and its rotation a unit quaternion within a thousandth: what turns and moves, but does
/// not stretch.
inline bool is_rigid(const Pose& p) {
    const Quat& q = p.rotation;
    const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_finite(p.position) && square > 0.998 && square < 1.002;
}
/// @}

/// Axis-aligned box.
struct Aabb {
    Vec3 min, max;
};

/// The half space normal . p <= offset.
struct Plane {
    Vec3 normal;
    double offset = 0;
};

/// A point of the soil's surface. World axes.
struct SurfacePoint {
    Vec3 position_m;
    Vec3 normal;  ///< unit, upward
};

}  // namespace bsoil
