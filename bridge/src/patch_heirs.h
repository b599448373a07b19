/// PatchHeirs: from a body's old patches to its new ones.
#pragma once

#include <span>
#include <vector>

#include "coupled_body.h"

namespace bsoil::bullet {

/// A new patch starts with the force that the nearest old one had, as a share of its limit. Nearest
/// by place, because patches are numbered in the body's frame, and on a spinning wheel a number
/// moves. Several new patches with the same nearest old one share its force. If each took all of
/// it, the sum would throw the body up.
class PatchHeirs {
  public:
    /// Puts new patches in place of those that the body has.
    void replace(CoupledBody& coupled, std::span<const ContactPatch> patches);

  private:
    std::vector<CoupledPatch> previous_;
    std::vector<double> heirs_;  ///< sum of the limits of the new patches nearest to an old one
    std::vector<int> nearest_;   ///< old patch of each new one, or -1
};

}  // namespace bsoil::bullet
