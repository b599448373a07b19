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

}  // namespace bsoil
