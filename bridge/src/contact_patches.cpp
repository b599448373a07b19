#include "contact_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bsoil::bullet {
namespace {

int dominant_axis_bin(Vec3 n) {
    const std::array<double, 3> c{n.x, n.y, n.z};
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(c[k]) > std::abs(c[axis])) axis = k;
    return 2 * axis + (c[axis] < 0 ? 1 : 0);
}

/// Which side of the centroid, along the two axes across the bin's own.
int quadrant_of(Vec3 offset, int bin) {
    const std::array<double, 3> c{offset.x, offset.y, offset.z};
    const int axis = bin / 2;
    return (c[(axis + 1) % 3] >= 0 ? 1 : 0) + (c[(axis + 2) % 3] >= 0 ? 2 : 0);
}

/// Size of the contact in each bin: its extents along the body's two axes across the bin's, of
/// which a sole counts the shorter and a wall the more level one.
std::array<FaceExtent, kNormalBinCount> face_extents(std::span<const ContactVoxel> voxels,
                                                     Quat to_body, Vec3 up) {
    struct Range {
        std::array<double, 3> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
        double depth_m = 0, down = 0, area_m2 = 0;
    };
    std::array<Range, kNormalBinCount> ranges{};
    for (const ContactVoxel& v : voxels) {
        Range& range = ranges[dominant_axis_bin(rotate(to_body, v.normal))];
        const Vec3 p = rotate(to_body, v.position_m);
        const std::array<double, 3> c{p.x, p.y, p.z};
        for (int k = 0; k < 3; ++k) {
            range.low[k] = std::min(range.low[k], c[k]);
            range.high[k] = std::max(range.high[k], c[k]);
        }
        range.depth_m = std::max(range.depth_m, v.depth_m + v.compression_m);
        range.down -= dot(v.normal, up) * v.area_m2;
        range.area_m2 += v.area_m2;
    }
    const Vec3 body_up = rotate(to_body, up);
    const std::array<double, 3> upness{std::abs(body_up.x), std::abs(body_up.y),
                                       std::abs(body_up.z)};
    std::array<FaceExtent, kNormalBinCount> faces{};
    for (int bin = 0; bin < kNormalBinCount; ++bin) {
        const Range& range = ranges[bin];
        if (!(range.area_m2 > 0)) continue;
        const int a = (bin / 2 + 1) % 3, b = (bin / 2 + 2) % 3;
        const double side_a = range.high[a] - range.low[a], side_b = range.high[b] - range.low[b];
        const bool is_sole = range.down > 0.7 * range.area_m2;
        faces[bin] = {is_sole                 ? std::min(side_a, side_b)
                      : upness[a] < upness[b] ? side_a
                                              : side_b,
                      range.depth_m};
    }
    return faces;
}

struct PatchSum {
    Vec3 limit_force_n;     ///< sum of limit times normal
    Vec3 weighted_point;    ///< sum of limit times position
    double limit_n = 0;     ///< sum of limits
    double friction_n = 0;  ///< sum of limit times friction
};

}  // namespace

BodyContact group_contacts(std::span<const ContactVoxel> voxels, const BodyMotion& motion, Vec3 up,
                           std::span<const SoilStrength> strengths,
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

    const std::array<FaceExtent, kNormalBinCount> faces = face_extents(voxels, to_body, up);

    BodyContact total;
    std::array<PatchSum, kPatchCapacity> sums{};
    for (const ContactVoxel& v : voxels) {
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        const ElementYield yield = yield_of_element(v, motion.velocity_at(v.position_m), up,
                                                    strengths[v.material], faces[bin]);
        const double area = v.area_m2 * v.fill;
        const int quadrant = quadrant_of(rotate(to_body, v.position_m - centroid[bin]), bin);
        const double limit_n = yield.normal_limit_pa * area;
        PatchSum& sum = sums[bin * kQuadrantCount + quadrant];
        sum.limit_force_n += limit_n * v.normal;
        sum.weighted_point += limit_n * v.position_m;
        sum.limit_n += limit_n;
        sum.friction_n += limit_n * yield.friction;

        const Vec3 force = area * yield.mobilized_pa;
        total.mobilized_force_n += force;
        total.mobilized_torque_n_m += cross(v.position_m - motion.center_of_mass_m, force);
        total.area_m2 += area;
        total.depth_m = std::max(total.depth_m, v.depth_m);
        total.compression_m = std::max(total.compression_m, v.compression_m);
    }

    for (int i = 0; i < kPatchCapacity; ++i) {
        const PatchSum& sum = sums[i];
        const double limit_n = length(sum.limit_force_n);
        if (!(limit_n > 0)) continue;
        patches.push_back({.bin = i / kQuadrantCount,
                           .point_m = sum.weighted_point * (1 / sum.limit_n),
                           .normal = sum.limit_force_n * (1 / limit_n),
                           .normal_limit_n = limit_n,
                           .friction = sum.friction_n / sum.limit_n});
    }
    return total;
}

}  // namespace bsoil::bullet
