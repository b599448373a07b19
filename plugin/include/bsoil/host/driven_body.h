/// DrivenBody: the force of the soil on a body that a host moves, for hosts without Bullet.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/contact_patches.h"
#include "bsoil/soil.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// One for each body, as long as it is there. It keeps what the soil beside the body has been
/// through, and tells the soil the width and pressure of the contact (Soil::known_contacts).
class DrivenBody {
  public:
    /// soil: must outlive this. body: SoilBody::id.
    explicit DrivenBody(Soil& soil, int body = 0, const SurfaceFriction& surface = {});

    /// After Soil::step with this body, whose id is that of this: the force that its motion meets.
    /// contacts: of the step's report, of any bodies. Soil that other bodies carry counts as if it
    /// lay on the ground. Cost: O(n log n) in the body's contacts.
    BodyContact advance(const SoilBody& body, std::span<const ContactVoxel> contacts);
    /// Of the last advance().
    std::span<const ContactPatch> patches() const { return found_.patches(); }
    const ContactLaw& law() const { return *law_; }  ///< against the body's surface

  private:
    Soil& soil_;
    int body_;
    SurfaceFriction surface_;
    uint64_t def_revision_;  ///< of the soil that law_ is of
    std::unique_ptr<const ContactLaw> law_;
    ContactMotion motion_;
    ContactMemory memory_;
    ContactPatches found_;
    std::vector<ContactVoxel> own_;
};

}  // namespace bsoil
#pragma GCC visibility pop
