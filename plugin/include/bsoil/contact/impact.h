/// Impact: how soil stops a body that comes down on a plane of it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsoil/contact/contact_patches.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What soil resists a fall with.
struct Resistance {
    double force_n = 0;    ///< against the motion, at rest
    double drag_kg_m = 0;  ///< what speed adds, per square of speed
};

/// How a body is stopped within a time.
struct Stopping {
    double way_m = 0, speed_m_s = 0;  ///< how far it has gone, and its speed then
};

/// A body of `mass_kg` on its way down, driven by gravity and other forces.
struct Fall {
    double mass_kg = 1;                           ///< behind the point that meets the soil
    double speed_m_s = 0, acceleration_m_s2 = 0;  ///< along the plane's normal, into the soil
};

/// A body before its impact.
struct ImpactBody {
    BodyMotion motion;         ///< as it is now
    BodyMotion direction;      ///< as the law sees it: as_share()
    double most_m = 0;         ///< how far it may go down along the normal
    double apart_m = 0;        ///< between its elements
    double density_kg_m3 = 0;  ///< of the soil, with its water
    Vec3 normal{0, 0, 1};      ///< of the soil's surface, unit, upward
};

/// What soil resists a body with, by how far the body has gone down. It is known at some depths and
/// interpolated in between. Keeps its room to work in from call to call.
class Impact {
  public:
    /// elements: of the body's lower side once it has gone down by most_m (sample_underside()), at
    /// least one; they must outlive the calls below. law: likewise.
    void start(const ContactLaw& law, std::span<const ContactVoxel> elements,
               const ImpactBody& body);
    /// Where the body's weight of contact lies now [m, world]: the mean of its elements by area and
    /// depth.
    static Vec3 center_m(std::span<const ContactVoxel> elements, double most_m, Vec3 normal);
    /// Resistance where the body has gone down by way_m; patches() are those of it. Cost: a search
    /// for patches.
    Resistance at(double way_m);
    std::span<const ContactPatch> patches() const {
        return found_.patches();
    }  ///< of the last at()
    /// How it is stopped within `duration_s`; resistance does not push back. Cost: 128 evaluations
    /// of the table.
    Stopping stop(const Fall& fall, double duration_s) const;
    /// The least way at which the table tells one depth from the next.
    double first_way_m() const;
    double resting_force_n() const { return here_n_; }  ///< where the body is now

  private:
    /// Depths between the body's pose and the one it would fall to at which resistance is known.
    /// Ours. More: as many searches for patches each; fewer: a ball's resistance, which grows with
    /// the square of its depth, is taken too large in between.
    static constexpr int kDepthCount = 4;
    Resistance between(double way_m) const;

    const ContactLaw* law_ = nullptr;
    std::span<const ContactVoxel> elements_;
    ImpactBody body_;
    BodyMotion still_;
    double rise_ = 1;   ///< of the normal along up
    double met_m_ = 0;  ///< way at which the first element meets the soil
    double here_n_ = 0;
    std::array<Resistance, kDepthCount + 1> known_{};
    std::vector<ContactVoxel> lifted_;
    ContactPatches found_;
};

}  // namespace bsoil
#pragma GCC visibility pop
