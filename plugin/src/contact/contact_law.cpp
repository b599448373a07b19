#include "bsoil/contact/contact_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check_range.h"
#include "bsoil/contact/bekker_law.h"
#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/plain_law.h"
#include "bsoil/contact/work_law.h"
#include "contact/law_fields.h"

namespace bsoil {

Status ContactLawDef::validate(int material_count) const {
    Status status =
        check_range("contact_law.kind", static_cast<int>(kind), 0, static_cast<int>(Kind::work));
    for_each_constant(*this, [&](const char* name, double value, double low, double high) {
        if (status) status = check_range(std::string("contact_law.") + name, value, low, high);
    });
    if (status && wedge_length != 0) {
        status = check_range("contact_law.wedge_length", wedge_length, 0.5, 5);
    }
    if (status) {
        status = check_range("contact_law.mobilization_fall_widths", mobilization_fall_widths, 0,
                             0.99 * mobilization_widths);
    }
    if (!status) return status;
    if (kind != Kind::bekker) return Done{};
    if (bekker.size() != static_cast<size_t>(material_count)) {
        return Error{
            fmt::format("contact_law.bekker has {} entries for {} materials, needs one each",
                        bekker.size(), material_count)};
    }
    for (size_t i = 0; i < bekker.size(); ++i) {
        if (Status s = bekker[i].validate(); !s) {
            return Error{fmt::format("contact_law.bekker[{}].{}", i, s.error())};
        }
    }
    return Done{};
}

double ContactLawDef::wedge_length_of(double friction_angle_rad) const {
    return wedge_length > 0 ? wedge_length
                            : std::tan(std::numbers::pi / 4 + friction_angle_rad / 2);
}

double touching_share(const ContactVoxel& contact, double voxel_m, const ContactLawDef& law) {
    const double open_m = contact.gap_m - rebound_m(contact.bearing_depth_m, law);
    return std::clamp(1 - open_m / (law.open_gap_voxels * voxel_m), 0.0, 1.0);
}

double rebound_m(double depth_m, const ContactLawDef& law) {
    return depth_m / law.unloading_stiffness;
}

double unloaded_share(double depth_m, double retreat_m, const ContactLawDef& law) {
    if (!(retreat_m > 0)) return 1;
    return depth_m > 0 ? std::max(0.0, 1 - law.unloading_stiffness * retreat_m / depth_m) : 0;
}

std::unique_ptr<const ContactLaw> ContactLaw::make(std::shared_ptr<const ContactSoil> soil,
                                                   const SurfaceFriction& surface) {
    if (soil->law.kind == ContactLawDef::Kind::bekker) {
        return std::make_unique<BekkerLaw>(std::move(soil), surface);
    }
    if (soil->law.kind == ContactLawDef::Kind::plain) {
        return std::make_unique<PlainLaw>(std::move(soil), surface);
    }
    if (soil->law.kind == ContactLawDef::Kind::work) {
        return std::make_unique<WorkLaw>(std::move(soil), surface);
    }
    return std::make_unique<GranularLaw>(std::move(soil), surface);
}

}  // namespace bsoil
