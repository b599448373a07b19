/// PlainLaw: three-dimensional resistive force theory and nothing else.
#pragma once

#include <vector>

#include "bsoil/contact/contact_law.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Each element meets xi D t(n, v): D its depth, t the stress of resistive_stress() for its normal
/// and the direction of its motion, xi = rho g (894 m^3 - 386 m^2 + 89 m) with m = tan phi
/// (Agarwal, Goldman, Kamrin 2023). A material enters by its density and its angle of friction, a
/// surface by its friction. Nothing is fitted, and nothing has a size: a large face bears what its
/// small parts bear. Cohesion, density as state, the speed and Janosi's K do not enter, so it is a
/// law of dry sand that moves slowly. Rules come on one by one: ContactLawDef::passive_wedge
/// and trapped_soil.
/// It is here to be held against: what the grid makes of it is
/// verified against exact integrals (docs/verification.md), and each rule of another law has to do
/// better.
///
/// Its polynomials pull at an element that looks up and is lifted; soil does not, and it meets
/// nothing. What resistive force theory leaves open is what an element at rest can hold. That is
/// the stress of a push along its normal and all friction; a creep of ContactLawDef::creep blends
/// the two. An element that has drawn back is let go as ContactLawDef::unloading_stiffness says.
class PlainLaw final : public ContactLaw {
  public:
    /// soil: not null.
    PlainLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface);
    /// See ContactLaw::yield().
    ElementYield yield(const ContactElement& element, const ElementMotion& motion,
                       const ContactHistory& memory) const override;

  private:
    struct Strength {
        double stiffness_pa_m = 0;  ///< xi
        double friction = 0;        ///< min(tool friction, tan phi)
        double friction_angle_rad = 0, tan_phi = 0;
        double passive_factor = 0;  ///< Kp of a wall with this friction
        /// Normal stress on an endless upright wall by its wedge over that by resistive force
        /// theory: both grow with depth alone.
        double wedge_share = 0;
    };
    /// What the size of its face leaves of an element's stress: 0..1.
    double size_factor(const Strength& soil, const FaceExtent& face, Vec3 normal) const;

    std::vector<Strength> strengths_;  ///< indexed by ContactVoxel::material
};

}  // namespace bsoil
#pragma GCC visibility pop
