// Another definition while the soil runs.
#include <fmt/format.h>

#include <algorithm>

#include "soil/def_fields.h"
#include "soil/kernel_params.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

template <typename Def>
std::vector<FieldNumber> numbers_of(const Def& def) {
    std::vector<FieldNumber> numbers;
    for_each_number(def, [&](const FieldNumber& field) { numbers.push_back(field); });
    return numbers;
}

/// Whether soil is as it was.
template <typename Def>
bool is_same(const Def& a, const Def& b) {
    const std::vector<FieldNumber> from = numbers_of(a), to = numbers_of(b);
    for (size_t i = 0; i < from.size(); ++i) {
        if (from[i].use != FieldUse::pace && from[i].value != to[i].value) return false;
    }
    return true;
}

/// Whether what differs may; `of` comes behind the name of what may not.
template <typename Def>
Status check_change(const Def& from, const Def& to, const std::string& of = {}) {
    const std::vector<FieldNumber> now = numbers_of(from), wanted = numbers_of(to);
    for (size_t i = 0; i < now.size(); ++i) {
        const bool may_differ = now[i].use == FieldUse::live || now[i].use == FieldUse::pace;
        if (may_differ || now[i].value == wanted[i].value) continue;
        return Error{
            fmt::format("{}{} is {:.9g}, this soil has {:.9g}, which cannot change while it runs; "
                        "create another soil",
                        wanted[i].name, of, wanted[i].value, now[i].value)};
    }
    return Done{};
}

Status check_change(const SoilCore& s, const SoilDef& to) {
    if (Status status = to.validate(); !status) return status;
    if (Status status = check_change(s.def, to); !status) return status;
    if (!(to.contact_law == s.def.contact_law)) {
        return Error{
            "contact_law differs from this soil's, which cannot change while it runs; create "
            "another "
            "soil"};
    }
    const std::vector<MaterialDef> materials = to.material_list();
    if (!std::ranges::equal(materials, s.materials, {}, &MaterialDef::name, &MaterialDef::name)) {
        return Error{"the materials' names must be this soil's, in their order"};
    }
    for (size_t i = 0; i < materials.size(); ++i) {
        const std::string of = fmt::format(" of material '{}'", materials[i].name);
        if (Status status = check_change(s.materials[i], materials[i], of); !status) return status;
    }
    return Done{};
}

}  // namespace

// What stood may fall, what lay still may drain, and what is known of contacts is no longer true:
// as after a fill, everything is looked at anew. That nothing moves is then found out by the step.
Status Soil::change(const SoilDef& def) {
    Impl& s = *impl_;
    s.finish();
    if (Status status = check_change(s, def); !status) return status;
    const std::vector<MaterialDef> materials = def.material_list();
    const bool other_colors =
        !std::ranges::equal(materials, s.materials, {}, &MaterialDef::color, &MaterialDef::color);
    const bool other_numbers =
        !is_same(s.def, def) || !std::ranges::equal(materials, s.materials, is_same<MaterialDef>);
    const bool other_pace =
        def.step_budget_ms != s.def.step_budget_ms || def.step_spread_max != s.def.step_spread_max;
    if (!other_colors && !other_numbers && !other_pace) return Done{};
    s.def = def;
    s.materials = materials;
    ++s.def_revision;
    if (other_colors) s.tiles.note_all_revised();
    if (!other_numbers) return Done{};
    set_kernel_params(s);
    s.sampler.forget();  // where roofs hold, surfaces are others
    std::vector<int32_t> tables = make_material_tables(s);
    s.device->write(Buffer::tables, 0, tables);
    s.flows.change_materials(std::move(tables));
    s.contacts.start();
    s.tiles.look_anew_at_all();
    return Done{};
}

}  // namespace bsoil
