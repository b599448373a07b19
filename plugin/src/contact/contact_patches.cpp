#include "bsoil/contact/contact_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "bsoil/contact/mean_pressure.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/trapped_soil.h"

namespace bsoil {
namespace {

/// Voxels that one thread takes at least.
constexpr size_t kPatchRangeVoxels = 64;
/// Of fewer voxels one thread makes all sums. Ours, as a matter of cost: a tenth of a millisecond.
/// Larger: threads wait for the one that sums; smaller: sharing the work takes longer than the
/// work.
constexpr size_t kSharedVoxels = 2048;
/// A depth below this [voxels] counts as so much where limits grow with it. Ours: a twentieth of
/// the least that the grid resolves. Larger, and a body that has just touched sinks further until
/// the soil's next step; smaller, and rounding decides how much it is held by.
constexpr double kDepthLeastVoxels = 0.002;
/// Of soil that has sheared as far as it matters, and that nothing has drawn back from.
constexpr ContactHistory kAllDeveloped{std::numeric_limits<double>::infinity(), 0};

/// Of a voxel that does not touch soil.
constexpr int kNoPatch = -1;

/// Which side of the centroid, along the two axes across the bin's own. `nothing_m`: what is no
/// further off lies in the middle, so that rounding does not decide.
int quadrant_of(Vec3 offset, int bin, double nothing_m) {
    const std::array<double, 3> c{offset.x, offset.y, offset.z};
    const int axis = bin / 2;
    return (c[(axis + 1) % 3] >= -nothing_m ? 1 : 0) + (c[(axis + 2) % 3] >= -nothing_m ? 2 : 0);
}

/// On cache lines of its own: others are summed up at the same time.
struct alignas(64) PatchSum {
    Vec3 limit_force_n;     ///< sum of limit times normal, less the shear that comes with it
    Vec3 weighted_point;    ///< sum of limit times position
    double limit_n = 0;     ///< sum of limits
    double friction_n = 0;  ///< sum of limit times friction
    double adhesion_n = 0;
    double area_m2 = 0;
    double rebound_n_m = 0;          ///< sum of limit times rebound
    double shear_n = 0;              ///< sum of shear limits
    Vec3 slide_n;                    ///< sum of shear limit times direction of sliding
    Vec3 slide_n_m;                  ///< its torque about the centre of mass
    double slide_size_n = 0;         ///< sum of its magnitudes
    double square_n_m2 = 0;          ///< sum of limit times squared distance to the centre of mass
    std::array<Vec3, 3> normals_n;   ///< by axis: sum of limit times normal times its component
    std::array<Vec3, 3> twists_n_m;  ///< the same of the normal's torque
};

/// Force and torque about the centre of mass of a shear, spread over a patch.
struct Shear {
    Vec3 force_n, torque_n_m;
};

/// What the patch's voxels give along `tangent` where each takes it along its own surface.
Shear spread_shear(const PatchSum& sum, Vec3 arm_m, Vec3 tangent) {
    Shear out{sum.limit_n * tangent, sum.limit_n * cross(arm_m, tangent)};
    const std::array<double, 3> t{tangent.x, tangent.y, tangent.z};
    for (int k = 0; k < 3; ++k) {
        out.force_n += -t[k] * sum.normals_n[k];
        out.torque_n_m += -t[k] * sum.twists_n_m[k];
    }
    return out;
}

/// From `arm_m` to the line on which a force has the torque of `shear`.
Vec3 shift_to_line(const Shear& shear, Vec3 arm_m) {
    const double square = dot(shear.force_n, shear.force_n);
    if (!(square > 0)) return {};
    const Vec3 shift = cross(shear.force_n, shear.torque_n_m) * (1 / square) - arm_m;
    return shift - dot(shift, shear.force_n) / square * shear.force_n;
}

/// Puts the shear force where the voxels' shear forces have their sum and torque.
void place_shear(const PatchSum& sum, const BodyMotion& direction, double creep,
                 ContactPatch& patch) {
    patch.shear_point_m = patch.point_m;
    if (!(sum.shear_n > 0)) return;
    const Vec3 arm = patch.point_m - direction.center_of_mass_m;
    const double spread_m = std::sqrt(std::max(0.0, sum.square_n_m2 / sum.limit_n - dot(arm, arm)));
    const auto within = [spread_m](Vec3 shift) {
        const double size_m = length(shift);
        return size_m > spread_m ? shift * (spread_m / size_m) : shift;
    };
    const Vec3 along = sum.slide_n - dot(sum.slide_n, patch.normal) * patch.normal;
    const double one_way_n = length(along);
    const double slid = sum.slide_size_n / sum.shear_n;
    // Of what does not slide all of the shear adds up.
    patch.shear_share = 1 - slid + one_way_n / sum.shear_n;
    // Voxels that slide against each other have a sum too small to tell its place by.
    const double against = sum.slide_size_n > 0 ? 1 - one_way_n / sum.slide_size_n : 1;
    const double placed = slid * (1 - against * against);
    patch.shear_point_m += placed * within(shift_to_line({along, sum.slide_n_m}, arm));
    // A wheel that rolls without slip turns about its rim, not about a point inside of it.
    const Vec3 turn = cross(direction.angular_velocity_rad_s, arm);
    const Vec3 rolling = turn - dot(turn, patch.normal) * patch.normal;
    const double rolling_size = length(rolling);
    if (rolling_size > creep) {
        patch.shear_point_m +=
            (1 - placed) *
            within(shift_to_line(spread_shear(sum, arm, rolling * (1 / rolling_size)), arm));
    }
}

/// The voxels whose soil one carrier carries.
class CarrierPatches {
  public:
    CarrierPatches(const ContactMotion& motion, const ContactLaw& law, double element_m)
        : motion_(motion),
          to_body_(conjugate(motion.motion.pose.rotation)),
          no_distance_m_(1e-6 * element_m),
          depth_least_m_(kDepthLeastVoxels * law.voxel_m()),
          up_(law.up()),
          law_(law.def()) {}

    /// Of a bin's voxels, in their order.
    void find_centroid(int bin, std::span<const uint32_t> of_bin,
                       std::span<const ContactVoxel> voxels) {
        double area_m2 = 0;
        for (const uint32_t i : of_bin) {
            centroid_[bin] += voxels[i].area_m2 * voxels[i].position_m;
            area_m2 += voxels[i].area_m2;
        }
        if (area_m2 > 0) centroid_[bin] = centroid_[bin] * (1 / area_m2);
    }
    /// The patch that a voxel belongs to, once the centroids are known.
    int patch_of(const ContactVoxel& v, int bin) const {
        const Vec3 off = rotate(to_body_, v.position_m - centroid_[bin]);
        return bin * kQuadrantCount + quadrant_of(off, bin, no_distance_m_);
    }
    /// area_m2: of the voxel's that touches soil. Patches are summed by themselves.
    void add(const ContactVoxel& v, int patch, const ElementYield& yield, double area_m2) {
        const double limit_n =
            std::max(yield.normal_limit_pa, kDrawnBackShare * yield.pushed_pa) * area_m2;
        PatchSum& sum = sums_[patch];
        sum.limit_force_n += limit_n * v.normal - area_m2 * yield.drag_pa;
        sum.weighted_point += limit_n * v.position_m;
        sum.limit_n += limit_n;
        sum.friction_n += limit_n * yield.friction;
        sum.adhesion_n += area_m2 * yield.adhesion_pa;
        sum.area_m2 += area_m2;
        sum.rebound_n_m += limit_n * rebound_m(bearing_depth_of(v, up_), law_);
        const double shear_n = limit_n * yield.friction + area_m2 * yield.adhesion_pa;
        const Vec3 arm = v.position_m - motion_.motion.center_of_mass_m;
        sum.shear_n += shear_n;
        sum.slide_n += shear_n * yield.slide;
        sum.slide_n_m += cross(arm, shear_n * yield.slide);
        sum.slide_size_n += shear_n * length(yield.slide);
        sum.square_n_m2 += limit_n * dot(arm, arm);
        const std::array<double, 3> n{v.normal.x, v.normal.y, v.normal.z};
        const Vec3 twist = cross(arm, v.normal);
        for (int k = 0; k < 3; ++k) {
            sum.normals_n[k] += limit_n * n[k] * v.normal;
            sum.twists_n_m[k] += limit_n * n[k] * twist;
        }
    }
    void append_to(std::vector<ContactPatch>& patches) {
        for (int i = 0; i < kPatchCapacity; ++i) {
            const PatchSum& sum = sums_[i];
            const double limit_n = length(sum.limit_force_n);
            places_[i] = limit_n > 0 ? static_cast<int>(patches.size()) : kNoPatch;
            if (!(limit_n > 0)) continue;
            patches.push_back({.bin = i / kQuadrantCount,
                               .carrier = motion_.carrier,
                               .point_m = sum.weighted_point * (1 / sum.limit_n),
                               .normal = sum.limit_force_n * (1 / limit_n),
                               .normal_limit_n = limit_n,
                               .found_limit_n = limit_n,
                               .friction = sum.friction_n / sum.limit_n,
                               .adhesion_n = sum.adhesion_n,
                               .area_m2 = sum.area_m2,
                               .rebound_m = std::max(0.0, sum.rebound_n_m / sum.limit_n),
                               .shear_point_m = {}});
            place_shear(sum, motion_.direction, law_.creep, patches.back());
        }
    }

    /// Once they are appended: adds an element of the patch's, if there is one.
    void add_element(const ContactVoxel& v, int patch, double pushed_n, double retreat_m,
                     std::vector<PatchElement>& elements) const {
        if (places_[patch] == kNoPatch || !(pushed_n > 0)) return;
        const double depth_m = std::max(bearing_depth_of(v, up_), depth_least_m_);
        elements.push_back({places_[patch], v.normal, pushed_n, depth_m, retreat_m});
    }

  private:
    const ContactMotion& motion_;
    Quat to_body_;
    double no_distance_m_;
    double depth_least_m_;
    Vec3 up_;
    const ContactLawDef& law_;
    std::array<Vec3, kNormalBinCount> centroid_{};
    std::array<PatchSum, kPatchCapacity> sums_{};
    std::array<int, kPatchCapacity> places_{};  ///< among the patches, or kNoPatch
};

}  // namespace

/// All of a body's voxels, whatever carries their soil.
class ContactPatches::Total {
  public:
    void add(const Part& part, size_t voxel) {
        limit_n_ += part.limit_n;
        total_.width_m += part.width_n_m;
        total_.area_m2 += part.area_m2;
        // A wall's level has the rim in it that came out from under the sole.
        const bool is_deepest =
            part.is_on_sole == has_sole_ ? part.depth_m > total_.depth_m : part.is_on_sole;
        if (part.depth_m > 0 && is_deepest) {
            has_sole_ = part.is_on_sole;
            total_.depth_m = part.depth_m;
            deepest_ = voxel;
        }
        total_.compression_m = std::max(total_.compression_m, part.compression_m);
    }
    /// Where the mobilized parts are asked for.
    void add_mobilized(const ContactVoxel& v, const Element& element, Vec3 center_m) {
        const Vec3 force = element.area_m2 * element.yield.mobilized_pa;
        total_.mobilized_force_n += force;
        total_.mobilized_torque_n_m += cross(v.position_m - center_m, force);
        pressure_.add_stress(std::max(0.0, -dot(element.yield.mobilized_pa, v.normal)),
                             element.area_m2);
    }
    BodyContact contact(std::span<const ContactVoxel> voxels, Vec3 up) const {
        BodyContact out = total_;
        if (total_.depth_m > 0) out.deepest_height_m = dot(voxels[deepest_].position_m, up);
        out.mobilized_pressure_pa = pressure_.pa();
        out.width_m = limit_n_ > 0 ? total_.width_m / limit_n_ : 0;
        return out;
    }

  private:
    BodyContact total_;  ///< width_m: times the limits
    MeanPressure pressure_;
    double limit_n_ = 0;
    size_t deepest_ = 0;
    bool has_sole_ = false;
};

BodyContact ContactPatches::find(std::span<const ContactVoxel> voxels,
                                 std::span<const ContactMotion> motions, const ContactLaw& law,
                                 std::span<const ContactHistory> history,
                                 const WorkThreads* threads, const ContactAsk& ask) {
    find_faces(voxels, motions.front().motion.pose.rotation, law, threads, ask);
    return find_on_faces(voxels, motions, law, history, threads, ask);
}

// A face is one whatever carries the soil beside its parts.
void ContactPatches::find_faces(std::span<const ContactVoxel> voxels, Quat body_to_world,
                                const ContactLaw& law, const WorkThreads* threads,
                                const ContactAsk& ask) {
    faces_.find(voxels, body_to_world, law, std::max(law.voxel_m(), ask.apart_m), threads);
}

void ContactPatches::find_elements(std::span<const ContactVoxel> voxels,
                                   std::span<const ContactMotion> motions, const ContactLaw& law,
                                   std::span<const ContactHistory> history,
                                   const WorkThreads* threads, const ContactAsk& ask) {
    elements_.resize(voxels.size());
    parts_.resize(voxels.size());
    const auto find = [&](size_t i) {
        const ContactVoxel& v = voxels[i];
        const ContactMotion& relative = motion_for(motions, v.carrier);
        const Quat to_body = conjugate(relative.motion.pose.rotation);
        Element& element = elements_[i];
        element = {{}, v.is_between_walls ? 0 : v.area_m2 * v.touching};
        if (element.area_m2 > 0) {  // a stress on no area is no force
            element.yield =
                law.yield({v, faces_.of_voxel(i)},
                          {relative.direction.velocity_at(v.position_m),
                           dot(relative.motion.velocity_at(v.position_m), v.normal), ask.mobilized},
                          history.empty() ? kAllDeveloped : history[i]);
            element.area_m2 *= element.yield.area_share;
        }
        const double limit_n = element.yield.normal_limit_pa * element.area_m2;
        parts_[i] = {limit_n,
                     limit_n * faces_.of_voxel(i).width_m,
                     element.area_m2,
                     v.depth_m,
                     v.compression_m,
                     v.carrier,
                     static_cast<int8_t>(dominant_axis_bin(rotate(to_body, v.normal))),
                     is_sole(looks_down(v.normal, law.up()))};
    };
    for_ranges(threads, voxels.size(), kPatchRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) find(i);
    });
}

BodyContact ContactPatches::find_on_faces(std::span<const ContactVoxel> voxels,
                                          std::span<const ContactMotion> motions,
                                          const ContactLaw& law,
                                          std::span<const ContactHistory> history,
                                          const WorkThreads* threads, const ContactAsk& ask) {
    patches_.clear();
    patch_elements_.clear();
    const double element_m = std::max(law.voxel_m(), ask.apart_m);
    find_elements(voxels, motions, law, history, threads, ask);

    Total total;
    const WorkThreads* sharers = voxels.size() < kSharedVoxels ? nullptr : threads;
    for (const ContactMotion& relative : motions) {
        CarrierPatches sums(relative, law, element_m);
        sort_by_bin(relative.carrier);
        for_ranges(sharers, kNormalBinCount, 1, [&](size_t first, size_t last) {
            for (size_t bin = first; bin < last; ++bin) {
                sums.find_centroid(static_cast<int>(bin), of_bin(bin), voxels);
            }
        });
        for_ranges(sharers, by_bin_.size(), kPatchRangeVoxels, [&](size_t first, size_t last) {
            for (size_t k = first; k < last; ++k) {
                const size_t i = by_bin_[k];
                patch_of_[k] = static_cast<int8_t>(
                    parts_[i].area_m2 > 0 ? sums.patch_of(voxels[i], parts_[i].bin) : kNoPatch);
            }
        });
        const auto sum_all = [&] {
            for (size_t i = 0; i < voxels.size(); ++i) {
                if (parts_[i].carrier != relative.carrier) continue;
                total.add(parts_[i], i);
                if (!ask.mobilized) continue;
                total.add_mobilized(voxels[i], elements_[i], relative.motion.center_of_mass_m);
            }
        };
        const auto sum_patch = [&](int patch) {
            const size_t bin = static_cast<size_t>(patch / kQuadrantCount);
            for (size_t k = bin_starts_[bin]; k < bin_starts_[bin + 1]; ++k) {
                if (patch_of_[k] != patch) continue;
                const Element& element = elements_[by_bin_[k]];
                sums.add(voxels[by_bin_[k]], patch, element.yield, element.area_m2);
            }
        };
        // Each sum in the order of the voxels, on whichever thread.
        for_ranges(sharers, 1 + kPatchCapacity, 1, [&](size_t first, size_t last) {
            for (size_t job = first; job < last; ++job) {
                if (job == 0) {
                    sum_all();
                } else {
                    sum_patch(static_cast<int>(job) - 1);
                }
            }
        });
        sums.append_to(patches_);
        for (size_t k = 0; ask.elements && k < by_bin_.size(); ++k) {
            if (patch_of_[k] == kNoPatch) continue;
            const uint32_t i = by_bin_[k];
            const Element& element = elements_[i];
            sums.add_element(voxels[i], patch_of_[k], element.yield.pushed_pa * element.area_m2,
                             history.empty() ? 0 : history[i].retreat_m, patch_elements_);
        }
    }
    const BodyContact contact = total.contact(voxels, law.up());
    // The flux of momentum into faces above the surface holds nothing in the air: before any face
    // has reached the soil a body falls as if there were none.
    if (!(contact.depth_m > 0)) {
        patches_.clear();
        patch_elements_.clear();
    }
    return contact;
}

// Stable: each bin's voxels keep their order.
void ContactPatches::sort_by_bin(int carrier) {
    bin_starts_.fill(0);
    for (const Part& part : parts_) {
        if (part.carrier == carrier) ++bin_starts_[static_cast<size_t>(part.bin) + 1];
    }
    std::partial_sum(bin_starts_.begin(), bin_starts_.end(), bin_starts_.begin());
    by_bin_.resize(bin_starts_.back());
    patch_of_.resize(bin_starts_.back());
    std::array<size_t, kNormalBinCount> next;
    std::copy_n(bin_starts_.begin(), kNormalBinCount, next.begin());
    for (size_t i = 0; i < parts_.size(); ++i) {
        if (parts_[i].carrier != carrier) continue;
        by_bin_[next[static_cast<size_t>(parts_[i].bin)]++] = static_cast<uint32_t>(i);
    }
}

BodyContact group_contacts(std::span<const ContactVoxel> voxels, const BodyMotion& motion,
                           const BodyMotion& direction, const ContactLaw& law,
                           std::span<const ContactHistory> history,
                           std::vector<ContactPatch>& patches) {
    const ContactMotion on_ground{-1, motion, direction, {}, {}};
    ContactPatches found;
    const BodyContact total = found.find(voxels, {&on_ground, 1}, law, history);
    patches.assign(found.patches().begin(), found.patches().end());
    return total;
}

}  // namespace bsoil
