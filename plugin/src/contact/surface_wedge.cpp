#include "contact/surface_wedge.h"

namespace bsoil {

SurfaceWedge::SurfaceWedge(double tan_phi, double tan_wall)
    : tan_phi_(tan_phi), tan_wall_(std::min(tan_wall, tan_phi)) {
    level_push_ = push(0);
    level_factor_ = kNone;
    for (const double run : kRuns) {
        level_factor_ = std::min(level_factor_, run * push(1 / run));
    }
}

// Weight, the wall's force inclined by its friction, and the plane's reaction at phi to its normal
// balance.
double SurfaceWedge::push(double slope) const {
    const double apart = 1 - slope * tan_phi_;
    const double inclined = (slope + tan_phi_) / apart;  // tan(plane + phi)
    const double held = 1 - inclined * tan_wall_;
    return apart > 0 && held > 0 ? inclined / held : kNone;
}

}  // namespace bsoil
