/// ContactMemory: how far a body's surface has slid along the soil beside it, and drawn back from
/// it.
#pragma once

#include <span>
#include <vector>

#include "bsoil/body.h"
#include "contact_patches.h"

namespace bsoil::bullet {

/// Janosi and Hanamoto's shear displacement belongs to the soil: a voxel starts with none when it
/// meets the body and keeps adding to it until the body leaves, so that the soil under the front of
/// a track has sheared less than that under its end. So does what the surface has drawn back since
/// it pressed on the soil most. A contact that moves on along its normal (a blade, a sinking sole)
/// takes its soil with it.
class ContactMemory {
  public:
    /// Adds the motion of `duration_s`. Returns what there is per voxel, valid until the next call.
    /// Cost: O(n log n).
    std::span<const ContactHistory> advance(std::span<const ContactVoxel> voxels,
                                            const BodyMotion& motion, double voxel_m,
                                            double duration_s);

  private:
    friend class CouplingSnapshot;
    struct Entry {
        Vec3 center_m;  ///< of the voxel
        Vec3 normal;
        Vec3 slid_m;
        double retreat_m = 0;
    };
    std::vector<Entry> entries_, previous_;  ///< sorted by center_m.x
    std::vector<ContactHistory> history_;
};

}  // namespace bsoil::bullet
