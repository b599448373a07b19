/// The constants of ContactLawDef by name and range: BSOIL_CONTACT_LAW_FIELDS as a visitor.
#pragma once

#include "base/member_count.h"
#include "bsoil/contact/contact_law_def.h"

namespace bsoil {

#define BSOIL_COUNT(...) +1
static_assert(member_count<ContactLawDef>() == 2 BSOIL_CONTACT_LAW_FIELDS(BSOIL_COUNT),
              "a member of ContactLawDef besides kind and bekker has no row in "
              "BSOIL_CONTACT_LAW_FIELDS");
#undef BSOIL_COUNT

/// Calls visit(name, value, least, most) for each constant.
template <typename Visit>
void for_each_constant(const ContactLawDef& law, Visit&& visit) {
#define BSOIL_VISIT(name, least, most, ...) \
    visit(#name, static_cast<double>(law.name), least, most);
    BSOIL_CONTACT_LAW_FIELDS(BSOIL_VISIT)
#undef BSOIL_VISIT
}

}  // namespace bsoil
