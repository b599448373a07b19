/// BekkerLaw: the law that users of other terrain models know, with a soil's own parameters.
#pragma once

#include "bsoil/contact/contact_law.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Bekker's pressure p = (kc / b + kphi) z^n on what looks down, along its normal (Bekker 1969;
/// Wong and Reece 1967 for the curved rim of a wheel), and Mohr, Coulomb and Janosi's shear (c + p
/// tan phi) (1 - exp(-j / K)). b is w l / (w + l) of the face, twice its area over its rim: half
/// the side of a square, the width of a long strip, 0.87 of the radius of a disc. A face within 12
/// deg of upright bears less, an upright one nothing: this law knows no wall, and so no blade.
/// Density, adhesion and momentum do not enter. It is here for comparison and for soils whose
/// parameters are all that is known.
class BekkerLaw final : public ContactLaw {
  public:
    /// soil->law.bekker: one for each material.
    BekkerLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface);
    /// See ContactLaw::yield().
    ElementYield yield(const ContactElement& element, const ElementMotion& motion,
                       const ContactHistory& memory) const override;

  private:
    SurfaceFriction surface_;
};

}  // namespace bsoil
#pragma GCC visibility pop
