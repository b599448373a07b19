/// PatchHeirs: which of a contact's new patches goes on with the force of which old one.
#pragma once

#include <span>
#include <vector>

#include "bsoil/contact/contact_patches.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A patch at a distance from its body's centre of mass.
struct PlacedPatch {
    ContactPatch patch;
    Vec3 offset_m;  ///< from the centre of mass, as it was when the patch was found
};

/// What a new patch takes over.
struct PatchHeir {
    int old = -1;  ///< its place in the list of old patches; -1: the body has just come in
    double force_share = 0;  ///< of the old one's force: several heirs share it
    double limit_share = 0;  ///< its limit over the old one's, at most 1
};

/// A new patch starts with the force that the nearest old one had, as a share of its limit. Nearest
/// by place, because patches are numbered in the body's frame, and on a spinning wheel a number
/// moves. Several new patches with the same nearest old one share its force. If each took all of
/// it, the sum would throw the body up.
class PatchHeirs {
  public:
    /// One for each new patch, valid until the next call. Cost: new times old ones, at most 24 each
    /// for a carrier.
    std::span<const PatchHeir> find(std::span<const PlacedPatch> old,
                                    std::span<const PlacedPatch> now);

  private:
    std::vector<PatchHeir> heirs_;
    std::vector<double> limits_n_;  ///< sum of the limits of the new patches nearest to an old one
};

}  // namespace bsoil
#pragma GCC visibility pop
