/// ShearMemory: how far a body's surface has slid along the soil beside it.
#pragma once

#include <span>
#include <vector>

#include "bsoil/body.h"
#include "contact_patches.h"

namespace bsoil::bullet {

/// Janosi and Hanamoto's shear displacement belongs to the soil: a voxel starts with none when it
/// meets the body and keeps adding to it until the body leaves, so that the soil under the front of
/// a track has sheared less than that under its end. A contact that moves on along its normal
/// (a blade, a sinking sole) takes its soil with it.
class ShearMemory {
  public:
    /// Adds the sliding of `duration_s`. Returns the displacement [m] per voxel, valid until the
    /// next call. Cost: O(n log n).
    std::span<const double> advance(std::span<const ContactVoxel> voxels, const BodyMotion& motion,
                                    double voxel_m, double duration_s);

  private:
    friend class CouplingSnapshot;
    struct Entry {
        Vec3 center_m;  ///< of the voxel
        Vec3 normal;
        Vec3 slid_m;
    };
    std::vector<Entry> entries_, previous_;  ///< sorted by center_m.x
    std::vector<double> displacement_m_;
};

}  // namespace bsoil::bullet
