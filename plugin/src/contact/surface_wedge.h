/// SurfaceWedge: what a wall meets where the ground before it is not level.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace bsoil {

/// Soil slides up along a plane from the wall's foot to the surface. Of all planes the one that
/// asks for the least force counts (Coulomb 1776), whatever the surface is like. No plane descends:
/// what lies beyond a heap is level ground.
class SurfaceWedge {
  public:
    /// tan_wall: friction of wall and soil, no more than tan_phi.
    SurfaceWedge(double tan_phi, double tan_wall);

    /// The easiest plane.
    struct Found {
        double level_depth = 0;  ///< of level ground that would push back as hard
        /// Of what lies before this place of the wall, the share that comes in as new soil when the
        /// wall moves ahead. The wedge goes along with it, and soil enters through the plane.
        double inflow_share = 1;
    };
    /// Planes that are tried. Ours: as many as kRuns needs from its first to its last. Larger:
    /// kRuns goes further; smaller: not as far.
    static constexpr size_t kRunCount = 17;
    /// A number for each plane that is tried.
    using Runs = std::array<double, kRunCount>;

    /// depth: of the wall's foot below the ground at the wall, > 0. heights(x): of the ground above
    /// the foot, at distances x before the wall. All in one unit. Exact for level and for evenly
    /// sloping ground. Cost: kRunCount heights and planes; the compiler makes vectors of both.
    template <class Heights>
    Found find(double depth, Heights&& heights) const {
        Runs x, slope, push_at;
        for (size_t k = 0; k < kRunCount; ++k) x[k] = kRuns[k] * depth;
        const Runs here = heights(x);
        for (size_t k = 0; k < kRunCount; ++k) {
            slope[k] = here[k] / x[k];
            push_at[k] = push(slope[k]);
        }
        double least = kNone, inflow = 1, lowest = kNone, area = 0, before_x = 0, before = depth;
        for (size_t k = 0; k < kRunCount; ++k) {
            if (!(here[k] > 0)) {  // the plane is level and ends where the ground meets it
                const double last = (x[k] - before_x) * before / (before - here[k]);
                const double its_push = (area + before * last / 2) * level_push_;
                if (its_push < least) {
                    least = its_push;
                    inflow = 0;
                }
                break;
            }
            area += (before + here[k]) / 2 * (x[k] - before_x);
            // Any other plane would come out before it gets there.
            if (slope[k] <= lowest) {
                lowest = slope[k];
                const double its_push = (area - here[k] * x[k] / 2) * push_at[k];
                if (its_push < least) {
                    least = its_push;
                    // A foot further down by dz has a plane that enters so much more of new soil.
                    const double falls = std::max(0.0, (before - here[k]) / (x[k] - before_x));
                    inflow = slope[k] / (slope[k] + falls);
                }
            }
            before_x = x[k];
            before = here[k];
        }
        if (!(least < kNone)) return {depth, 1};
        return {2 * least / (depth * level_factor_), inflow};
    }

  private:
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    /// How far planes are tried, over the wall's depth. Ours: from 63 deg down to 7 deg, each a
    /// fifth further than the one before; the least is flat, so that it is found within a
    /// hundredth. Further: heaps longer than eight times their height count, and none is.
    static constexpr Runs kRuns = [] {
        Runs out{};
        // Ours: the fourth root of 2. Larger: the least is missed by more than a hundredth;
        // smaller: more heights are read for nothing.
        constexpr double kStep = 1.189207115002721;
        double run = 0.5;
        for (double& each : out) {
            each = run;
            run *= kStep;
        }
        return out;
    }();

    /// Level push on the wall over the wedge's weight, for a plane that rises so steeply. Weight,
    /// the wall's force inclined by its friction, and the plane's reaction at phi to its normal
    /// balance.
    double push(double slope) const {
        const double apart = 1 - slope * tan_phi_;
        const double inclined = (slope + tan_phi_) / apart;  // tan(plane + phi)
        const double held = 1 - inclined * tan_wall_;
        // Both quotients without a branch before them.
        const double out = inclined / held;
        return std::min(apart, held) > 0 ? out : kNone;
    }

    double tan_phi_, tan_wall_;
    double level_push_ = 0;    ///< push(0)
    double level_factor_ = 0;  ///< of level ground: least push over half the depth's square
};

}  // namespace bsoil
