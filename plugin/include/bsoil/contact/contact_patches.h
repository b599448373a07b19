/// Contact patches: a body's contact voxels summed up into at most 24 places, for each body that
/// carries the soil, where a constraint can act.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/contact/contact_faces.h"
#include "bsoil/contact/contact_law.h"
#include "bsoil/contact/contact_motion.h"
#include "bsoil/contact/patch_elements.h"
#include "bsoil/work_threads.h"

#pragma GCC visibility push(default)
namespace bsoil {

inline constexpr int kNormalBinCount = 6;  ///< +x, -x, +y, -y, +z, -z of the body's frame
inline constexpr int kQuadrantCount =
    4;  ///< of a bin, about its centroid: a patch each, so torque gets through
inline constexpr int kPatchCapacity = kNormalBinCount * kQuadrantCount;  ///< for each carrier

/// Part of a body's contact with the soil. World axes.
struct ContactPatch {
    int bin = 0;       ///< 0..5: dominant axis of the normals in the body's frame
    int carrier = -1;  ///< ContactVoxel::carrier of its voxels: the body that its reaction acts on
    Vec3 point_m;      ///< where its force acts: mean of the voxels, weighted by their limits
    Vec3 normal;       ///< unit, out of the body; of the sum of the voxels' limit forces
    double normal_limit_n = 0;  ///< length of that sum: the push at which the soil yields
    double found_limit_n = 0;   ///< the same as the soil's step has found it, see limit_shares()
    double friction = 0;        ///< mean, weighted by the limits
    double adhesion_n = 0;      ///< shear force that it takes without any normal force
    double area_m2 = 0;         ///< of its voxels (area times fill)
    double rebound_m = 0;       ///< how far its soil follows a body that lifts; mean by the limits
    /// Where its shear force acts. A wheel's patch slides along an arc and a ring's in a circle:
    /// the force that all voxels' shear together has its line outside of the voxels' mean.
    Vec3 shear_point_m;
    double shear_share =
        1;  ///< of the voxels' shear that adds up: they slide in directions of their own
};

/// What is to be found of a contact.
struct ContactAsk {
    double apart_m = 0;  ///< how far elements are apart, where that is more than a voxel
    /// The mobilized parts of BodyContact; else they stay zero. A body whose motion is solved for
    /// has no use for them.
    bool mobilized = true;
    /// ContactPatches::patch_elements(), of a body whose limits follow it between the soil's steps.
    bool elements = false;
};

/// All of a body's contact with the soil. World axes.
struct BodyContact {
    Vec3 mobilized_force_n;     ///< of the soil on the body, from the motion as it is
    Vec3 mobilized_torque_n_m;  ///< about the centre of mass
    double area_m2 = 0;         ///< in contact with soil (area times fill)
    double depth_m = 0;  ///< of the deepest element that looks down, or of any where none does
    double deepest_height_m = 0;       ///< along up, where that is
    double compression_m = 0;          ///< largest
    double mobilized_pressure_pa = 0;  ///< mean normal stress of the mobilized force, by force
    double width_m = 0;                ///< mean width of the faces, by their limits
};

/// Sums the contact voxels of one body into patches: by what carries the soil, by the dominant axis
/// of the normal in the body's frame, then by quadrant of the tangent plane about the bin's
/// centroid. Sums of limit forces over patches equal those over voxels, so a closed surface under
/// uniform pressure gives no force. It keeps its room to work in from call to call.
class ContactPatches {
  public:
    /// law: against the body's surface. motions: one for each carrier among the voxels, in the
    /// order the patches come in. history: per voxel, empty where all shear stress is developed and
    /// nothing has drawn back. threads: to share the work, or null. The same as find_faces() and
    /// find_on_faces().
    BodyContact find(std::span<const ContactVoxel> voxels, std::span<const ContactMotion> motions,
                     const ContactLaw& law, std::span<const ContactHistory> history,
                     const WorkThreads* threads = nullptr, const ContactAsk& ask = {});
    /// In two parts, where soles of several bodies are one: join_soles() comes between them.
    void find_faces(std::span<const ContactVoxel> voxels, Quat body_to_world, const ContactLaw& law,
                    const WorkThreads* threads = nullptr, const ContactAsk& ask = {});
    /// The second: what the elements give on the faces that were found.
    BodyContact find_on_faces(std::span<const ContactVoxel> voxels,
                              std::span<const ContactMotion> motions, const ContactLaw& law,
                              std::span<const ContactHistory> history,
                              const WorkThreads* threads = nullptr, const ContactAsk& ask = {});
    /// Of the last find_faces() or find().
    ContactFaces& faces() { return faces_; }
    /// Of the last find().
    std::span<const ContactPatch> patches() const { return patches_; }
    /// What they are made of, where that was asked for.
    std::span<const PatchElement> patch_elements() const { return patch_elements_; }

  private:
    /// What an element gives, and on which part of its area.
    struct Element {
        ElementYield yield;
        double area_m2 = 0;
    };
    /// What BodyContact takes of an element. Few words, which one thread adds up.
    struct Part {
        double limit_n = 0, width_n_m = 0;  ///< width: of its face, times the limit
        double area_m2 = 0, depth_m = 0, compression_m = 0;
        int carrier = -1;
        int8_t bin = 0;  ///< dominant_axis_bin() of its normal in its body's frame
        bool is_on_sole = false;
    };
    class Total;
    void find_elements(std::span<const ContactVoxel> voxels, std::span<const ContactMotion> motions,
                       const ContactLaw& law, std::span<const ContactHistory> history,
                       const WorkThreads* threads, const ContactAsk& ask);
    void sort_by_bin(int carrier);
    std::span<const uint32_t> of_bin(size_t bin) const {
        return std::span(by_bin_).subspan(bin_starts_[bin],
                                          bin_starts_[bin + 1] - bin_starts_[bin]);
    }
    ContactFaces faces_;
    std::vector<Element> elements_;  ///< per voxel
    std::vector<Part> parts_;        ///< per voxel
    /// Of one carrier, by bin: the voxels, and the patch of each.
    std::vector<uint32_t> by_bin_;
    std::vector<int8_t> patch_of_;
    std::array<size_t, kNormalBinCount + 1> bin_starts_{};
    std::vector<ContactPatch> patches_;
    std::vector<PatchElement> patch_elements_;
};

/// The same of a body on the ground alone, once. `patches` is overwritten.
BodyContact group_contacts(std::span<const ContactVoxel> voxels, const BodyMotion& motion,
                           const BodyMotion& direction, const ContactLaw& law,
                           std::span<const ContactHistory> history,
                           std::vector<ContactPatch>& patches);

}  // namespace bsoil
#pragma GCC visibility pop
