#include "contact_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact_faces.h"

namespace bsoil::bullet {
namespace {

/// Which side of the centroid, along the two axes across the bin's own. `nothing_m`: what is no
/// further off lies in the middle, so that rounding does not decide.
int quadrant_of(Vec3 offset, int bin, double nothing_m) {
    const std::array<double, 3> c{offset.x, offset.y, offset.z};
    const int axis = bin / 2;
    return (c[(axis + 1) % 3] >= -nothing_m ? 1 : 0) + (c[(axis + 2) % 3] >= -nothing_m ? 2 : 0);
}

struct PatchSum {
    Vec3 limit_force_n;     ///< sum of limit times normal
    Vec3 weighted_point;    ///< sum of limit times position
    double limit_n = 0;     ///< sum of limits
    double friction_n = 0;  ///< sum of limit times friction
    double adhesion_n = 0;
    double area_m2 = 0;
};

}  // namespace

BodyContact group_contacts(std::span<const ContactVoxel> voxels, const BodyMotion& motion,
                           const BodyMotion& direction, Vec3 up, double voxel_m,
                           std::span<const SoilStrength> strengths,
                           std::span<const double> shear_displacement_m,
                           std::vector<ContactPatch>& patches) {
    patches.clear();
    const Quat to_body = conjugate(motion.pose.rotation);
    std::array<Vec3, kNormalBinCount> centroid{};
    std::array<double, kNormalBinCount> bin_area{};
    for (const ContactVoxel& v : voxels) {
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        centroid[bin] += v.area_m2 * v.position_m;
        bin_area[bin] += v.area_m2;
    }
    for (int bin = 0; bin < kNormalBinCount; ++bin)
        if (bin_area[bin] > 0) centroid[bin] = centroid[bin] * (1 / bin_area[bin]);

    ContactFaces faces;
    find_contact_faces(voxels, motion.pose.rotation, up, voxel_m, faces);

    BodyContact total;
    double mobilized_n = 0, limit_n_sum = 0;
    std::array<PatchSum, kPatchCapacity> sums{};
    for (size_t i = 0; i < voxels.size(); ++i) {
        const ContactVoxel& v = voxels[i];
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        const FaceExtent& face = faces.faces[faces.of_voxel[i]];
        const SoilStrength& strength = strengths[v.material];
        const double shear =
            shear_displacement_m.empty()
                ? 1
                : developed_shear(strength, shear_displacement_m[i], face.relative_density);
        const ElementYield yield = yield_of_element(v, direction.velocity_at(v.position_m),
                                                    dot(motion.velocity_at(v.position_m), v.normal),
                                                    up, strength, face, shear);
        const double area = v.area_m2 * v.fill;
        const int quadrant =
            quadrant_of(rotate(to_body, v.position_m - centroid[bin]), bin, 1e-6 * voxel_m);
        const double limit_n = yield.normal_limit_pa * area;
        PatchSum& sum = sums[bin * kQuadrantCount + quadrant];
        sum.limit_force_n += limit_n * v.normal;
        sum.weighted_point += limit_n * v.position_m;
        sum.limit_n += limit_n;
        sum.friction_n += limit_n * yield.friction;
        sum.adhesion_n += area * yield.adhesion_pa;
        sum.area_m2 += area;

        const Vec3 force = area * yield.mobilized_pa;
        total.mobilized_force_n += force;
        total.mobilized_torque_n_m += cross(v.position_m - motion.center_of_mass_m, force);
        const double normal_pa = std::max(0.0, -dot(yield.mobilized_pa, v.normal));
        mobilized_n += area * normal_pa;
        total.mobilized_pressure_pa += area * normal_pa * normal_pa;
        limit_n_sum += limit_n;
        total.width_m += limit_n * face.width_m;
        total.area_m2 += area;
        total.depth_m = std::max(total.depth_m, v.depth_m);
        total.compression_m = std::max(total.compression_m, v.compression_m);
    }
    total.mobilized_pressure_pa = mobilized_n > 0 ? total.mobilized_pressure_pa / mobilized_n : 0;
    total.width_m = limit_n_sum > 0 ? total.width_m / limit_n_sum : 0;

    for (int i = 0; i < kPatchCapacity; ++i) {
        const PatchSum& sum = sums[i];
        const double limit_n = length(sum.limit_force_n);
        if (!(limit_n > 0)) continue;
        patches.push_back({.bin = i / kQuadrantCount,
                           .point_m = sum.weighted_point * (1 / sum.limit_n),
                           .normal = sum.limit_force_n * (1 / limit_n),
                           .normal_limit_n = limit_n,
                           .friction = sum.friction_n / sum.limit_n,
                           .adhesion_n = sum.adhesion_n,
                           .area_m2 = sum.area_m2});
    }
    return total;
}

}  // namespace bsoil::bullet
