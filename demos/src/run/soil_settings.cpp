#include "soil_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <type_traits>

#include "bsoil/snapshot_file.h"

namespace bsoil::scene {
namespace {

/// Whole numbers of a definition are far below; beyond it a conversion is undefined.
constexpr double kWholeMost = 1e9;

/// Calls visit(name, number) for each double of a value; whole numbers come as one and go back.
template <typename Value, typename Visit>
void visit_number(const std::string& name, Value& value, const Visit& visit) {
    if constexpr (std::is_same_v<Value, Vec3>) {
        visit(name + ".x", value.x);
        visit(name + ".y", value.y);
        visit(name + ".z", value.z);
    } else if constexpr (std::is_same_v<Value, double>) {
        visit(name, value);
    } else if constexpr (std::is_same_v<Value, float>) {
        double number = static_cast<double>(value);
        visit(name, number);
        value = static_cast<float>(number);
    } else {
        double number = static_cast<double>(value);
        visit(name, number);
        value = static_cast<Value>(static_cast<int>(std::clamp(number, -kWholeMost, kWholeMost)));
    }
}

/// The fields of these uses alone: `live` ones.
#define BSOIL_SETTING_state(name)
#define BSOIL_SETTING_run(name)
#define BSOIL_SETTING_pace(name)
#define BSOIL_SETTING_live(name) visit_number(where + #name, of.name, visit);
#define BSOIL_SETTING(name, least, most, use, ...) BSOIL_SETTING_##use(name)

template <typename Visit>
void visit_settings(SoilDef& def, const Visit& visit) {
    {
        const std::string where;
        SoilDef& of = def;
        BSOIL_SOIL_FIELDS(BSOIL_SETTING)
    }
    for (size_t m = 0; m < def.materials.size(); ++m) {
        const std::string where = fmt::format("{}.", m);
        MaterialDef& of = def.materials[m];
        BSOIL_MATERIAL_FIELDS(BSOIL_SETTING)
        for (size_t c = 0; c < of.color.size(); ++c) {
            visit_number(fmt::format("{}color.{}", where, c), of.color[c], visit);
        }
    }
}

#undef BSOIL_SETTING
#undef BSOIL_SETTING_live
#undef BSOIL_SETTING_pace
#undef BSOIL_SETTING_run
#undef BSOIL_SETTING_state

void list(StateStream& stream, std::vector<NamedNumber>& numbers) {
    stream.list(numbers, 16, [&](NamedNumber& n) { stream(n.name, n.value); });
}

}  // namespace

std::vector<NamedNumber> soil_numbers(const SoilDef& def) {
    SoilDef copy = def;
    std::vector<NamedNumber> numbers;
    visit_settings(copy, [&numbers](const std::string& name, double& value) {
        numbers.push_back({name, value});
    });
    return numbers;
}

std::vector<uint8_t> soil_settings(const SoilDef& def) {
    std::vector<NamedNumber> numbers = soil_numbers(def);
    StateStream stream;
    list(stream, numbers);
    return stream.bytes();
}

Status set_soil_settings(std::span<const uint8_t> settings, SoilDef& def) {
    std::vector<NamedNumber> numbers;
    StateStream stream(settings);
    list(stream, numbers);
    if (!stream.at_end()) return Error{"is damaged; take another copy of it"};
    visit_settings(def, [&numbers](const std::string& name, double& value) {
        const auto saved = std::ranges::find(numbers, name, &NamedNumber::name);
        if (saved != numbers.end()) value = saved->value;
    });
    return Done{};
}

}  // namespace bsoil::scene
