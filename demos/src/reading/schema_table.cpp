#define TOML_IMPLEMENTATION
#include "schema_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scene/spelling.h"

namespace bsoil::scene {
namespace {

/// A unit's suffix, the suffix scenes use for that quantity, and the factor between them.
struct UnitSuffix {
    const char* suffix;
    const char* accepted;
    double factor;
};
constexpr std::array kForeignUnits{
    UnitSuffix{"mm", "m", 1e-3},        UnitSuffix{"cm", "m", 1e-2},
    UnitSuffix{"km", "m", 1e3},         UnitSuffix{"rad", "deg", 180 / std::numbers::pi},
    UnitSuffix{"g", "kg", 1e-3},        UnitSuffix{"t", "kg", 1e3},
    UnitSuffix{"ms", "s", 1e-3},        UnitSuffix{"min", "s", 60},
    UnitSuffix{"kpa", "pa", 1e3},       UnitSuffix{"mpa", "pa", 1e6},
    UnitSuffix{"kn", "n", 1e3},         UnitSuffix{"kn_m", "n_m", 1e3},
    UnitSuffix{"g_cm3", "kg_m3", 1e3},  UnitSuffix{"t_m3", "kg_m3", 1e3},
    UnitSuffix{"km_h", "m_s", 1 / 3.6}, UnitSuffix{"rad_s", "deg_s", 180 / std::numbers::pi},
    UnitSuffix{"rpm", "deg_s", 6},
};
/// The suffixes scenes use, longest first.
constexpr std::array kUnits{"_n_s_m", "_kg_m3", "_deg_s", "_mm_s", "_m_s2", "_n_m", "_m_s",
                            "_deg",   "_kg",    "_pa",    "_m",    "_s",    "_n"};

std::string without_unit(const std::string& name) {
    for (const char* unit : kUnits) {
        if (name.ends_with(unit)) return name.substr(0, name.size() - std::string(unit).size());
    }
    return name;
}

bool exists_for(const KeySpec& key, const std::string& selected) {
    return key.only.empty() ||
           std::find(key.only.begin(), key.only.end(), selected) != key.only.end();
}

/// The word that decides which keys a table may have: what it says, or the default.
std::string selected_in(const toml::table& table, const TableSpec& spec) {
    for (const KeySpec& key : spec.keys) {
        if (key.name != spec.selector) continue;
        const size_t quoted = key.fallback.size();
        return table[key.name].value_or(quoted > 2 ? key.fallback.substr(1, quoted - 2) : "");
    }
    return {};
}

/// A value as text, the same however its numbers are written.
std::string value_text(const toml::node& value) {
    if (value.is_integer() || value.is_floating_point()) return fmt::format("{}", number_of(value));
    if (value.is_boolean()) return value.as_boolean()->get() ? "true" : "false";
    if (value.is_string()) return '"' + value.as_string()->get() + '"';
    std::string text;
    if (const toml::array* array = value.as_array()) {
        for (const toml::node& entry : *array) {
            text += (text.empty() ? "" : ", ") + value_text(entry);
        }
    }
    return '[' + text + ']';
}

/// Why `name` is no key of the table, with the key that was probably meant.
std::string unknown_key_text(const std::string& name, const toml::node& value,
                             const TableSpec& spec, const std::string& selected) {
    const std::string where = spec.path.empty() ? spec.file : '[' + spec.path + ']';
    for (const UnitSuffix& unit : kForeignUnits) {
        const std::string suffix = std::string("_") + unit.suffix;
        if (!name.ends_with(suffix)) continue;
        const std::string meant = name.substr(0, name.size() - suffix.size()) + '_' + unit.accepted;
        for (const KeySpec& key : spec.keys) {
            if (key.name != meant) continue;
            std::string here;
            if (const auto number = value.value<double>()) {
                here = fmt::format(": {} = {}", meant, number_text(*number * unit.factor));
            }
            return fmt::format("wrong unit in `{}`: the key is `{}`{}", name, meant, here);
        }
    }
    for (const KeySpec& key : spec.keys) {
        if (key.name != name && exists_for(key, selected) &&
            without_unit(key.name) == without_unit(name)) {
            return fmt::format("wrong unit in `{}`: the key is `{}`", name, key.name);
        }
    }
    std::vector<std::string> names;
    for (const KeySpec& key : spec.keys) {
        if (exists_for(key, selected)) names.push_back(key.name);
    }
    if (const std::string meant = nearest_word(name, names); !meant.empty()) {
        return fmt::format("unknown key `{}` in {}; did you mean `{}`?", name, where, meant);
    }
    std::string known;
    for (const KeySpec& key : spec.keys) {
        if (exists_for(key, selected)) known += (known.empty() ? "" : ", ") + key.name;
    }
    return fmt::format("unknown key `{}` in {}; the keys are {}", name, where, known);
}

void read_child(const toml::node& value, const KeySpec& key, void* item,
                std::vector<SchemaError>& errors) {
    if (!key.table->array) {
        if (const toml::table* table = value.as_table()) {
            read_table(*table, *key.table, key.child(item), errors);
        } else {
            errors.push_back({position_of(value), fmt::format("`{}`: expected a table, not {}",
                                                              key.name, kind_text(value))});
        }
        return;
    }
    const toml::array* array = value.as_array();
    if (!array) {
        errors.push_back(
            {position_of(value), fmt::format("`{0}` is written once for each: [[{1}]], not [{1}]",
                                             key.name, key.table->path)});
        return;
    }
    for (const toml::node& entry : *array) {
        if (const toml::table* table = entry.as_table()) {
            read_table(*table, *key.table, key.child(item), errors);
        } else {
            errors.push_back({position_of(entry), fmt::format("`{}`: expected a table, not {}",
                                                              key.name, kind_text(entry))});
        }
    }
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

}  // namespace

SourcePosition position_of(const toml::node& node) {
    const toml::source_position begin = node.source().begin;
    return {static_cast<int>(begin.line), static_cast<int>(begin.column)};
}

std::string number_text(double value) {
    const double rounded = std::round(value * 1e6) / 1e6;  // hides what radians add to degrees
    return fmt::format("{}", rounded == 0 && value != 0 ? value : rounded);
}

std::string range_text(Range range) {
    return number_text(range.min) + " .. " + number_text(range.max);
}

std::string kind_text(const toml::node& value) {
    switch (value.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "a list";
        case toml::node_type::string:
            return "the text \"" + value.as_string()->get() + '"';
        case toml::node_type::integer:
            return "the integer " + std::to_string(value.as_integer()->get());
        case toml::node_type::floating_point:
            return "the number " + number_text(value.as_floating_point()->get());
        case toml::node_type::boolean:
            return value.as_boolean()->get() ? "true" : "false";
        default:
            return "a date or time";
    }
}

double number_of(const toml::node& value) {
    // value<double>() gives nothing for integers that a double does not hold exactly.
    if (const auto* integer = value.as_integer()) return static_cast<double>(integer->get());
    return value.as_floating_point()->get();
}

std::string read_number(const toml::node& value, Range range, double& out) {
    if (!value.is_number()) return "expected a number, not " + kind_text(value);
    out = number_of(value);
    if (!(out >= range.min && out <= range.max)) {
        return fmt::format("{} is out of range {}", out, range_text(range));
    }
    return {};
}

std::string read_numbers(const toml::node& value, Range range, size_t min_count, size_t max_count,
                         std::vector<double>& out) {
    const toml::array* array = value.as_array();
    if (!array) return "expected a list of numbers, not " + kind_text(value);
    if (array->size() < min_count || array->size() > max_count) {
        return fmt::format("expected {} numbers, not {}", min_count, array->size());
    }
    for (const toml::node& entry : *array) {
        double number = 0;
        const std::string error = read_number(entry, range, number);
        if (!error.empty()) return error;
        out.push_back(number);
    }
    return {};
}

void read_table(const toml::table& table, const TableSpec& spec, void* item,
                std::vector<SchemaError>& errors) {
    SceneItem* scene_item = spec.item(item);
    const SourcePosition at = position_of(table);
    if (scene_item) scene_item->at = at;
    const std::string selected = selected_in(table, spec);
    for (const auto& [toml_key, value] : table) {
        const std::string name(toml_key.str());
        const toml::source_position begin = toml_key.source().begin;
        const SourcePosition key_at{static_cast<int>(begin.line), static_cast<int>(begin.column)};
        const auto key = std::find_if(spec.keys.begin(), spec.keys.end(),
                                      [&](const KeySpec& k) { return k.name == name; });
        if (key == spec.keys.end()) {
            errors.push_back({key_at, unknown_key_text(name, value, spec, selected)});
            continue;
        }
        if (!selected.empty() && !exists_for(*key, selected)) {
            errors.push_back(
                {key_at, fmt::format("`{}` has no meaning with {} = \"{}\"; leave it out", name,
                                     spec.selector, selected)});
            continue;
        }
        if (scene_item) scene_item->keys[name] = position_of(value);
        if (key->table) {
            read_child(value, *key, item, errors);
            continue;
        }
        if (scene_item) scene_item->said[name] = value_text(value);
        const std::string error = key->read(item, value);
        if (!error.empty()) {
            errors.push_back({position_of(value), fmt::format("`{}`: {}", name, error)});
        }
    }
    if (table.contains("rotation_deg") && table.contains("axis_angle_deg")) {
        errors.push_back({at, "give `rotation_deg` or `axis_angle_deg`, not both"});
    }
    for (const KeySpec& key : spec.keys) {
        if (key.required && !table.contains(key.name) && exists_for(key, selected)) {
            errors.push_back(
                {at, spec.path.empty()
                         ? fmt::format("{} needs {}: {}", spec.file,
                                       key.table ? '[' + key.name + ']' : '`' + key.name + '`',
                                       key.table ? key.table->doc : key.doc)
                         : fmt::format("[{}] needs `{}`: {}", spec.path, key.name, key.doc)});
        }
    }
}

std::map<std::string, std::string> values_in(const SceneItem& item, const TableSpec& spec) {
    std::map<std::string, std::string> values = item.said;
    const auto selector = values.find(spec.selector);
    const std::string selected = selector == values.end() || selector->second.size() < 2
                                     ? std::string()
                                     : selector->second.substr(1, selector->second.size() - 2);
    for (const KeySpec& key : spec.keys) {
        if (key.table || !exists_for(key, selected)) continue;
        values.emplace(key.name, key.fallback.empty() ? "none" : key.fallback);
    }
    return values;
}

std::string table_markdown(const TableSpec& spec) {
    std::string out;
    if (!spec.path.empty()) {
        out += fmt::format("\n## {}\n\n{}\n",
                           spec.array ? "[[" + spec.path + "]]" : '[' + spec.path + ']', spec.doc);
    }
    out += "\n| key | value | range | default | meaning |\n|---|---|---|---|---|\n";
    for (const KeySpec& key : spec.keys) {
        if (key.table) continue;
        const std::string initial = key.required           ? "required"
                                    : key.fallback.empty() ? "-"
                                                           : '`' + key.fallback + '`';
        const std::string only =
            key.only.empty() ? "" : fmt::format(" ({}: {})", spec.selector, joined(key.only));
        out += fmt::format("| `{}` | {} | {} | {} | {}{} |\n", key.name, key.type, key.range,
                           initial, key.doc, only);
    }
    for (const KeySpec& key : spec.keys) {
        if (key.table) out += table_markdown(*key.table);
    }
    return out;
}

}  // namespace bsoil::scene
