#include "oracle/resistive_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "oracle/coverage.h"

namespace oracle {
namespace {

using bsoil::ConvexShape;

/// A coefficient of f1, f2, f3 with the powers of x1, x2, x3 that it multiplies.
struct Term {
    int p1, p2, p3;
    double f1, f2, f3;
};
constexpr Term kTerms[] = {
    {0, 0, 0, 0.00212, -0.06796, -0.02634},  {1, 0, 0, -0.0232, -0.10941, -0.03436},
    {0, 1, 0, -0.2089, 0.04725, 0.45256},    {0, 0, 1, -0.43083, -0.06914, 0.00835},
    {2, 0, 0, -0.00259, -0.05835, 0.02553},  {0, 2, 0, 0.48872, -0.6588, -1.3129},
    {0, 0, 2, -0.00415, -0.11985, -0.05532}, {1, 1, 0, 0.07204, -0.25739, 0.0679},
    {0, 1, 1, -0.0275, -0.26834, -0.16404},  {1, 0, 1, -0.08772, 0.02692, 0.02287},
    {3, 0, 0, 0.01992, -0.00736, 0.02927},   {0, 3, 0, -0.45961, 0.63758, 0.95406},
    {0, 0, 3, 0.40799, 0.08997, -0.00131},   {1, 2, 0, -0.10107, 0.21069, -0.11028},
    {2, 1, 0, -0.06576, 0.04748, 0.01487},   {0, 1, 2, 0.05664, 0.20406, -0.0273},
    {0, 2, 1, -0.09269, 0.18589, 0.10911},   {2, 0, 1, 0.01892, 0.04934, -0.04097},
    {1, 0, 2, 0.01033, 0.13527, 0.07881},    {1, 1, 1, 0.1512, -0.33207, -0.27519},
};

/// Which side of a body a normal of its frame belongs to, and the way it looks.
size_t side_of(Vec3 n) {
    const double size[3] = {std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    size_t axis = 0;
    for (size_t k = 1; k < 3; ++k) {
        if (size[k] > size[axis]) axis = k;
    }
    return 2 * axis + ((axis == 0 ? n.x : axis == 1 ? n.y : n.z) < 0 ? 1 : 0);
}
Vec3 axis_of(size_t side) {
    const double sign = side % 2 == 0 ? 1 : -1;
    return {side / 2 == 0 ? sign : 0, side / 2 == 1 ? sign : 0, side / 2 == 2 ? sign : 0};
}

/// A flat patch spanned by two edges, cut into facets.
void add_patch(std::vector<Facet>& out, Vec3 corner, Vec3 a, Vec3 b, Vec3 normal, double edge_m) {
    const int na = std::max(1, static_cast<int>(std::ceil(length(a) / edge_m)));
    const int nb = std::max(1, static_cast<int>(std::ceil(length(b) / edge_m)));
    const double area = length(cross(a, b)) / na / nb;
    for (int i = 0; i < na; ++i) {
        for (int j = 0; j < nb; ++j) {
            out.push_back({corner + (i + 0.5) / na * a + (j + 0.5) / nb * b, normal, area});
        }
    }
}

void add_box(std::vector<Facet>& out, Vec3 h, double edge_m) {
    for (const double s : {-1.0, 1.0}) {
        add_patch(out, {s * h.x, -h.y, -h.z}, {0, 2 * h.y, 0}, {0, 0, 2 * h.z}, {s, 0, 0}, edge_m);
        add_patch(out, {-h.x, s * h.y, -h.z}, {2 * h.x, 0, 0}, {0, 0, 2 * h.z}, {0, s, 0}, edge_m);
        add_patch(out, {-h.x, -h.y, s * h.z}, {2 * h.x, 0, 0}, {0, 2 * h.y, 0}, {0, 0, s}, edge_m);
    }
}

void add_cylinder(std::vector<Facet>& out, double radius, double half_height, double edge_m) {
    const int around =
        std::max(16, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / edge_m)));
    const int along = std::max(1, static_cast<int>(std::ceil(2 * half_height / edge_m)));
    const int rings = std::max(4, static_cast<int>(std::ceil(radius / edge_m)));
    for (int i = 0; i < around; ++i) {
        const double t = 2 * std::numbers::pi * (i + 0.5) / around;
        const Vec3 out_of{std::cos(t), std::sin(t), 0};
        for (int j = 0; j < along; ++j) {
            out.push_back({radius * out_of + Vec3{0, 0, ((j + 0.5) / along * 2 - 1) * half_height},
                           out_of,
                           2 * std::numbers::pi * radius / around * 2 * half_height / along});
        }
        for (int j = 0; j < rings; ++j) {
            const double r = (j + 0.5) / rings * radius;
            for (const double s : {-1.0, 1.0}) {
                out.push_back({r * out_of + Vec3{0, 0, s * half_height},
                               {0, 0, s},
                               2 * std::numbers::pi * r / around * radius / rings});
            }
        }
    }
}

void add_sphere(std::vector<Facet>& out, double radius, double edge_m) {
    const int bands = std::max(16, static_cast<int>(std::ceil(std::numbers::pi * radius / edge_m)));
    for (int i = 0; i < bands; ++i) {
        // Bands of equal height have equal areas.
        const double z = (i + 0.5) / bands * 2 - 1, around = std::sqrt(1 - z * z);
        for (int j = 0; j < 2 * bands; ++j) {
            const double t = 2 * std::numbers::pi * (j + 0.5) / (2 * bands);
            const Vec3 n{around * std::cos(t), around * std::sin(t), z};
            out.push_back(
                {radius * n, n, 4 * std::numbers::pi * radius * radius / bands / (2 * bands)});
        }
    }
}

}  // namespace

namespace {

/// Radius of a ball about a solid's origin that holds it.
double bound_m(const ConvexShape& solid) {
    const double bare_m = solid.kind == ConvexShape::Kind::box ? length(solid.half_extents_m)
                          : solid.kind == ConvexShape::Kind::sphere
                              ? solid.radius_m
                              : solid.radius_m + solid.half_height_m;
    return bare_m + 2 * solid.rounding_m;  // a box's corners are square
}

}  // namespace

bool is_inside(const std::vector<ConvexShape>& solids, Vec3 at) {
    return std::any_of(solids.begin(), solids.end(), [&](const ConvexShape& solid) {
        return length(at - solid.local.position) <= bound_m(solid) &&
               inside_shape(solid, transform(inverse(solid.local), at));
    });
}

std::vector<Facet> surface_of(const std::vector<ConvexShape>& solids, double edge_m) {
    std::vector<Facet> out;
    for (size_t i = 0; i < solids.size(); ++i) {
        const ConvexShape& solid = solids[i];
        std::vector<Facet> own;
        if (solid.kind == ConvexShape::Kind::box) {
            add_box(own, solid.half_extents_m, edge_m);
        } else if (solid.kind == ConvexShape::Kind::sphere) {
            add_sphere(own, solid.radius_m, edge_m);
        } else {
            add_cylinder(own, solid.radius_m, solid.half_height_m, edge_m);
        }
        // Of a wheel's lugs few are near each other.
        std::vector<ConvexShape> near;
        for (size_t k = 0; k < solids.size(); ++k) {
            const double apart_m = length(solids[k].local.position - solid.local.position);
            if (k != i && apart_m <= bound_m(solids[k]) + bound_m(solid)) near.push_back(solids[k]);
        }
        for (Facet& facet : own) {
            facet.at = transform(solid.local, facet.at);
            facet.normal = rotate(solid.local.rotation, facet.normal);
            if (!is_inside(near, facet.at)) out.push_back(facet);
        }
    }
    return out;
}

namespace {

/// In the cylinder coordinates of the paper: r along the level part of the motion, z up. side: a
/// normal of the surface, of either side.
Vec3 generic_stress(Vec3 side, Vec3 direction, Vec3 r) {
    const Vec3 theta{-r.y, r.x, 0};
    // side = (sin b cos p, sin b sin p, -cos b), direction = (cos g, 0, -sin g); x3 is their
    // product.
    const double sin_g = -direction.z, cos_g = dot(direction, r), cos_b = -side.z;
    const double sin_b_cos_p = dot(side, r), sin_b_sin_p = dot(side, theta);
    const double x3 = dot(side, direction);
    double f1 = 0, f2 = 0, f3 = 0;
    for (const Term& term : kTerms) {
        const double x =
            std::pow(sin_g, term.p1) * std::pow(cos_b, term.p2) * std::pow(x3, term.p3);
        f1 += term.f1 * x;
        f2 += term.f2 * x;
        f3 += term.f3 * x;
    }
    const double along_r = f1 * sin_b_cos_p + f2 * cos_g;
    const double along_theta = f1 * sin_b_sin_p;
    const double along_z = -f1 * cos_b - f2 * sin_g - f3;
    return along_r * r + along_theta * theta + Vec3{0, 0, along_z};
}

}  // namespace

// The tilt b of the paper lies within a right angle: of a face that looks up it is that of the
// other side. From upright to 10 deg (0.17) up one goes over into the other.
Vec3 resistive_stress(Vec3 normal, Vec3 direction, double surface_friction) {
    if (dot(normal, direction) <= 0) return {};
    Vec3 r{direction.x, direction.y, 0};
    if (length(r) < 1e-9) r = {normal.x, normal.y, 0};
    r = length(r) < 1e-9 ? Vec3{1, 0, 0} : r * (1 / length(r));
    const double other = std::clamp(normal.z / 0.17, 0.0, 1.0);
    const Vec3 stress = (1 - other) * generic_stress(normal, direction, r) +
                        other * generic_stress(-1.0 * normal, direction, r);
    const double pressure = -dot(stress, normal);
    if (pressure <= 0) return {};  // out of the polynomials' range: soil does not pull
    const Vec3 shear = stress + pressure * normal;
    const double most = surface_friction * pressure;
    return -pressure * normal + std::min(1.0, most / std::max(length(shear), 1e-300)) * shear;
}

double passive_factor(double phi, double wall) {
    constexpr int kSlices = 100;
    const auto of = [&](double foot, double top) {
        const double radius =
            1 / (std::sin(foot) - std::exp((foot - top) * std::tan(phi)) * std::sin(top));
        if (!(radius > 0)) return 1e300;
        const double pole_x = -radius * std::cos(foot), pole_z = radius * std::sin(foot) - 1;
        // Slices from the wall on; on their left and right the spiral's depth. The weight is one.
        double moment = 0, x0 = 0, z0 = -1;
        for (int i = 1; i <= kSlices; ++i) {
            const double angle = foot + (top - foot) * i / kSlices;
            const double r = radius * std::exp((foot - angle) * std::tan(phi));
            const double x1 = pole_x + r * std::cos(angle), z1 = pole_z - r * std::sin(angle);
            moment += (x1 - x0) * (-(z0 + z1) / 2) * ((x0 + x1) / 2 - pole_x);
            x0 = x1;
            z0 = z1;
        }
        const double arm = (pole_z + 2.0 / 3) * std::cos(wall) + pole_x * std::sin(wall);
        return arm > 0 && moment > 0 ? 2 * moment / arm : 1e300;
    };
    double least = 1e300, foot = 1.2, top = 0.2, step = 0.4;
    while (step > 1e-4) {
        double best_foot = foot, best_top = top;
        for (int i = -2; i <= 2; ++i) {
            for (int j = -2; j <= 2; ++j) {
                if (const double k = of(foot + i * step, top + j * step);
                    top + j * step < foot + i * step && k < least) {
                    least = k;
                    best_foot = foot + i * step;
                    best_top = top + j * step;
                }
            }
        }
        if (best_foot == foot && best_top == top) step /= 2;
        foot = best_foot;
        top = best_top;
    }
    return least;
}

namespace {

/// Least of one and what a wall's wedge leaves of resistive force theory, by the side of the body
/// that it is on: +x, -x, +y, -y, +z, -z. The last is of what looks down by more than 45 degrees,
/// as if it were endless.
std::array<double, 7> wedge_shares(const std::vector<Facet>& surface, const Intruder& intruder,
                                   const Sand& sand, double xi) {
    std::array<double, 6> low, high, deep{};
    std::array<double, 7> shares;
    low.fill(1e300);
    high.fill(-1e300);
    for (const Facet& facet : surface) {
        const Vec3 arm = rotate(intruder.pose.rotation, facet.at);
        const double depth_m = -(intruder.pose.position.z + arm.z);
        if (depth_m <= 0) continue;
        const size_t side = side_of(facet.normal);
        const Vec3 out = rotate(intruder.pose.rotation, axis_of(side));
        const Vec3 level = cross({0, 0, 1}, out);
        if (-rotate(intruder.pose.rotation, facet.normal).z > std::sqrt(0.5)) continue;
        const double across = length(level) > 1e-9 ? dot(arm, level) / length(level) : arm.x;
        low[side] = std::min(low[side], across);
        high[side] = std::max(high[side], across);
        deep[side] = std::max(deep[side], depth_m);
    }
    const double phi = sand.friction_angle_rad, wall = std::atan(sand.surface_friction);
    const double kp = passive_factor(phi, wall), sine = std::sin(phi);
    const double resistive = -resistive_stress({1, 0, 0}, {1, 0, 0}, sand.surface_friction).x;
    const double endless = sand.density_kg_m3 * 9.81 * kp * std::cos(wall) / (xi * resistive);
    shares[6] = std::min(1.0, endless);
    const double apart = std::pow(kp - (1 - sine) / (1 + sine), 2.0 / 3);
    for (size_t side = 0; side < 6; ++side) {
        const double slim = deep[side] > 0 ? (high[side] - low[side]) / deep[side] : 0;
        const double wide = std::min(2.0, 1 + 1.6 * apart / (1 + 5 * slim));
        shares[side] = std::min(1.0, endless * wide);
    }
    return shares;
}

}  // namespace

Wrench resistive_force(const std::vector<Facet>& surface, const Intruder& intruder,
                       const Sand& sand) {
    const double m = std::tan(sand.friction_angle_rad);
    const double xi = sand.density_kg_m3 * 9.81 * (894 * m * m * m - 386 * m * m + 89 * m);
    std::array<double, 7> shares;
    shares.fill(1);
    if (sand.has_wedge) shares = wedge_shares(surface, intruder, sand, xi);
    Wrench sum;
    for (const Facet& facet : surface) {
        const Vec3 arm = rotate(intruder.pose.rotation, facet.at);
        const double depth_m = -(intruder.pose.position.z + arm.z);
        if (depth_m <= 0) continue;
        const double root_m = depth_m - rotate(intruder.pose.rotation, facet.root).z;
        const double bears_m = std::clamp(root_m, 0.0, depth_m);
        const Vec3 velocity = intruder.velocity_m_s + cross(intruder.angular_velocity_rad_s, arm);
        const double speed = length(velocity);
        if (!(speed > 0)) continue;
        const Vec3 normal = rotate(intruder.pose.rotation, facet.normal);
        const double down = std::max(0.0, -normal.z) * std::max(0.0, -normal.z);
        const double size =
            down + (1 - down) * shares[-normal.z > std::sqrt(0.5) ? 6 : side_of(facet.normal)];
        const double friction = facet.friction >= 0 ? facet.friction : sand.surface_friction;
        const Vec3 force = xi * bears_m * facet.share * facet.area_m2 * size *
                           resistive_stress(normal, velocity * (1 / speed), friction);
        sum.force_n += force;
        sum.moment_n_m += cross(arm, force);
    }
    return sum;
}

}  // namespace oracle
