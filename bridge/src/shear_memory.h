/// ShearMemory: how far a body's surface has slid along the soil beside it.
#pragma once

#include <span>
#include <vector>

#include "bsoil/body.h"
#include "contact_patches.h"

namespace bsoil::bullet {

/// A voxel of soil beside a body, and how far the body has slid along it.
struct ShearedSoil {
    Vec3 center_m;  ///< of the voxel
    Vec3 normal;    ///< out of the body
    Vec3 slid_m;
};

/// Janosi and Hanamoto's shear displacement belongs to the soil: a voxel starts with none when it
/// meets the first body and keeps adding to it until the last one leaves, so that the soil under
/// the front of a track has sheared less than that under its end, whether the track is one body or
/// many links. A contact that moves on along its normal (a blade, a sinking sole) takes its soil
/// with it.
class ShearMemory {
  public:
    /// The soil that may lie beside these voxels, in the same order. `soil` is sorted by
    /// center_m.x.
    static void near(std::span<const ShearedSoil> soil, std::span<const ContactVoxel> voxels,
                     double voxel_m, std::vector<ShearedSoil>& out);

    /// Adds the sliding of `duration_s`. around: what other bodies knew at the last call, sorted by
    /// center_m.x; soil that one of them has sheared further comes to this one so. Returns the
    /// displacement [m] per voxel, valid until the next call. Cost: O(n log n).
    std::span<const double> advance(std::span<const ContactVoxel> voxels, const BodyMotion& motion,
                                    double voxel_m, double duration_s,
                                    std::span<const ShearedSoil> around = {});
    /// Sorted by center_m.x.
    std::span<const ShearedSoil> soil() const { return entries_; }

  private:
    friend class CouplingSnapshot;
    std::vector<ShearedSoil> entries_, previous_;  ///< sorted by center_m.x
    std::vector<double> displacement_m_;
};

/// The order of ShearMemory's lists.
inline bool lies_before(const ShearedSoil& a, const ShearedSoil& b) {
    return a.center_m.x < b.center_m.x;
}

}  // namespace bsoil::bullet
