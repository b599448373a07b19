/// Going through the fields of MaterialDef and SoilDef: BSOIL_MATERIAL_FIELDS and BSOIL_SOIL_FIELDS
/// as a visitor.
#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include "base/check_range.h"
#include "base/member_count.h"
#include "bsoil/soil_def.h"

namespace bsoil {

/// Whether a snapshot means something by a field, or only how a run is made depends on it; `live`:
/// a snapshot does, and Soil::change() takes another value of it. `pace`: change() alone does.
enum class FieldUse { state, live, run, pace };

/// One number of a definition. Of a Vec3 there are three.
struct FieldNumber {
    std::string name;  ///< "size_m.x"
    double value = 0;
    double least = 0, most = 0;  ///< alike: no range of its own
    FieldUse use = FieldUse::state;
};

namespace fields {

template <typename Value, typename Visit>
void visit_numbers(const FieldNumber& field, const Value& value, Visit& visit) {
    const auto number = [&](const char* axis, double axis_value) {
        visit(FieldNumber{field.name + axis, axis_value, field.least, field.most, field.use});
    };
    if constexpr (std::is_same_v<Value, Vec3>) {
        number(".x", value.x);
        number(".y", value.y);
        number(".z", value.z);
    } else {
        number("", static_cast<double>(value));
    }
}

#define BSOIL_COUNT(...) +1
static_assert(member_count<MaterialDef>() == 2 BSOIL_MATERIAL_FIELDS(BSOIL_COUNT),
              "a member of MaterialDef besides name and color has no row in BSOIL_MATERIAL_FIELDS");
static_assert(member_count<SoilDef>() == 3 BSOIL_SOIL_FIELDS(BSOIL_COUNT),
              "a member of SoilDef besides its materials and its law has no row in "
              "BSOIL_SOIL_FIELDS");
#undef BSOIL_COUNT

/// The last value of an enumeration that a definition has.
template <typename Enum>
constexpr Enum last_of = Enum{};
template <>
inline constexpr UpAxis last_of<UpAxis> = UpAxis::z;
template <>
inline constexpr Backend last_of<Backend> = Backend::gl;
template <>
inline constexpr OverflowHeuristic last_of<OverflowHeuristic> = OverflowHeuristic::up_spread;
template <>
inline constexpr SlideMotion last_of<SlideMotion> = SlideMotion::run_out;

/// Whether a row's range is all of the enumeration that its member is of.
template <typename Value>
constexpr bool is_all_of(double least, double most) {
    if constexpr (std::is_enum_v<Value>) {
        return least == 0 && most > 0 && most == static_cast<double>(last_of<Value>);
    } else {
        return true;
    }
}
#define BSOIL_CHECK(name, least, most, ...)                        \
    static_assert(is_all_of<decltype(SoilDef::name)>(least, most), \
                  "the range of " #name " is not that of its enumeration");
BSOIL_SOIL_FIELDS(BSOIL_CHECK)
#undef BSOIL_CHECK
static_assert(2 * kOpenSideLast - 1 == 63, "open_sides has a range of its own");

}  // namespace fields

/// Calls visit(FieldNumber) for each number of the definition, in the table's order.
template <typename Visit>
void for_each_number(const MaterialDef& def, Visit&& visit) {
#define BSOIL_VISIT(name, least, most, use, what, more) \
    fields::visit_numbers({#name, 0, least, most, FieldUse::use}, def.name, visit);
    BSOIL_MATERIAL_FIELDS(BSOIL_VISIT)
#undef BSOIL_VISIT
}
template <typename Visit>
void for_each_number(const SoilDef& def, Visit&& visit) {
#define BSOIL_VISIT(name, least, most, use, what, more) \
    fields::visit_numbers({#name, 0, least, most, FieldUse::use}, def.name, visit);
    BSOIL_SOIL_FIELDS(BSOIL_VISIT)
#undef BSOIL_VISIT
}

/// The first number that is out of its range; `where` comes before its name.
template <typename Def>
Status check_numbers(const Def& def, const std::string& where = {}) {
    Status status = Done{};
    for_each_number(def, [&](const FieldNumber& field) {
        if (status && field.least < field.most) {
            status = check_range(where + field.name, field.value, field.least, field.most);
        }
    });
    return status;
}

}  // namespace bsoil
