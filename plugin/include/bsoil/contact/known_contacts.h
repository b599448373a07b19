/// KnownContacts: what a soil keeps of its contacts with bodies from one step to the next.
#pragma once

#include <map>
#include <span>

#include "bsoil/body.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What a step has to know of a body's contact before it finds that contact anew.
struct KnownContact {
    /// Mean width of its faces (BodyContact::width_m): how far around the soil's surface and
    /// density count.
    double width_m = 0;
    /// Mean normal pressure (MeanPressure): soil under the body is compacted to the density of it.
    double pressure_pa = 0;
};

/// One entry for each body that somebody has found a contact of, by SoilBody::id. It stays until it
/// is found anew or a step comes without the body. The soil owns it (Soil::known_contacts) and
/// saves it with its state. Whoever finds forces writes it: DrivenBody, or the coupling with
/// Bullet.
class KnownContacts {
  public:
    /// All zero for a body without an entry.
    KnownContact of(int body) const;
    /// What is not finite or below 0 counts as 0. An id out of the range of SoilBody::id is
    /// ignored.
    /// @{
    void set_width(int body, double width_m);
    void set_pressure(int body, double pressure_pa);
    /// @}
    void clear() { entries_.clear(); }  ///< nothing is known of any body
    /// Forgets all bodies that are not in this list.
    void keep_only(std::span<const SoilBody> bodies);
    /// Calls visit(body, contact) for each entry, by rising id.
    template <typename Visit>
    void for_each(Visit visit) const {
        for (const auto& [body, entry] : entries_) visit(body, entry.contact);
    }

  private:
    struct Entry {
        KnownContact contact;
        bool is_kept = true;
    };
    std::map<int, Entry> entries_;
};

}  // namespace bsoil
#pragma GCC visibility pop
