#include "bsoil/contact/known_contacts.h"

#include <cmath>

#include "bsoil/limits.h"

namespace bsoil {
namespace {

double not_negative(double value) { return std::isfinite(value) && value > 0 ? value : 0; }

bool is_id(int body) { return body >= 0 && body <= limits::kBodyIdMost; }

}  // namespace

KnownContact KnownContacts::of(int body) const {
    const auto found = entries_.find(body);
    return found == entries_.end() ? KnownContact{} : found->second.contact;
}

void KnownContacts::set_width(int body, double width_m) {
    if (!is_id(body)) return;
    entries_[body].contact.width_m = not_negative(width_m);
}

void KnownContacts::set_pressure(int body, double pressure_pa) {
    if (!is_id(body)) return;
    entries_[body].contact.pressure_pa = not_negative(pressure_pa);
}

void KnownContacts::keep_only(std::span<const SoilBody> bodies) {
    for (auto& [body, entry] : entries_) entry.is_kept = false;
    for (const SoilBody& body : bodies) {
        const auto found = entries_.find(body.id);
        if (found != entries_.end()) found->second.is_kept = true;
    }
    std::erase_if(entries_, [](const auto& entry) { return !entry.second.is_kept; });
}

}  // namespace bsoil
