/// The tables of a scene that become a SoilDef and its materials. Names, ranges and meanings come
/// from BSOIL_SOIL_FIELDS, BSOIL_CONTACT_LAW_FIELDS and BSOIL_MATERIAL_FIELDS.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "schema_table.h"

namespace bsoil::scene {
namespace {

/// What a scene allows where that is less than SoilDef does.
struct NarrowerRange {
    std::string_view field;
    Range range;  ///< in the key's unit
};
constexpr NarrowerRange kNarrower[] = {
    {"size_m", {1e-4, 1e4}},
    {"floor_center_m", {-1e4, 1e4}},  // float positions keep a millimetre within it
    {"yaw_rad", {-360, 360}},
    {"tile_capacity", {0, 1e6}},
};
/// What the command or [world] gives to every soil.
constexpr std::string_view kGivenElsewhere[] = {"up", "gravity_m_s2", "backend", "thread_count"};
/// Keys that are no number.
constexpr std::string_view kWrittenApart[] = {"open_sides", "faces_by_shape"};

/// A field of a definition as a key: angles are written in degrees, their limits as whole ones.
struct FieldKey {
    std::string name, doc;
    Range range;
    double scale = 1;

    FieldKey(std::string_view field, Range of_def, std::string_view what, std::string_view more)
        : name(field), doc(what), range(of_def) {
        if (!more.empty()) doc += "; " + std::string(more);
        if (field.ends_with("_rad")) {
            name.replace(name.size() - 4, 4, "_deg");
            scale = kDegree;
            range = {std::ceil(of_def.min / kDegree), std::floor(of_def.max / kDegree)};
        }
        for (const NarrowerRange& narrower : kNarrower) {
            if (narrower.field == field) range = narrower.range;
        }
    }
};

bool is_written_apart(std::string_view field) {
    return std::ranges::find(kWrittenApart, field) != std::end(kWrittenApart);
}

template <typename Place>
void add_field(TableOf<SoilItem>& table, const FieldKey& key, Place place) {
    using Value = std::remove_reference_t<std::invoke_result_t<Place, SoilItem&>>;
    for (const std::string_view other : kGivenElsewhere) {
        if (key.name == other) return;
    }
    if (is_written_apart(key.name)) return;
    if constexpr (std::is_same_v<Value, double>) {
        table.number(key.name, place, key.range, key.doc, key.scale);
    } else if constexpr (std::is_same_v<Value, int>) {
        table.integer(key.name, place, key.range, key.doc);
    } else if constexpr (std::is_same_v<Value, Vec3>) {
        table.vector(key.name, place, key.range, key.doc);
    } else if constexpr (std::is_same_v<Value, OverflowHeuristic>) {
        table.choice(
            key.name, {"even", "up", "up_spread"}, "up", key.doc, [place](SoilItem& s, size_t i) {
                constexpr OverflowHeuristic kOrder[] = {
                    OverflowHeuristic::even, OverflowHeuristic::up, OverflowHeuristic::up_spread};
                place(s) = kOrder[i];
            });
    } else if constexpr (std::is_same_v<Value, SlideMotion>) {
        table.choice(
            key.name, {"settle", "run_out"}, "settle", key.doc, [place](SoilItem& s, size_t i) {
                constexpr SlideMotion kOrder[] = {SlideMotion::settle, SlideMotion::run_out};
                place(s) = kOrder[i];
            });
    } else {
        static_assert(std::is_same_v<Value, UpAxis> || std::is_same_v<Value, Backend>,
                      "a field of a new type needs a key of its own kind");
    }
    if (key.name == "size_m") table.required();
}

std::string read_sides(const toml::node& value, int& sides) {
    constexpr std::pair<std::string_view, OpenSide> kSides[] = {
        {"-x", kOpenLowX},  {"+x", kOpenHighX}, {"-y", kOpenLowY},
        {"+y", kOpenHighY}, {"-z", kOpenLowZ},  {"+z", kOpenHighZ}};
    const toml::array* array = value.as_array();
    if (!array) return "expected a list of texts, not " + kind_text(value);
    for (const toml::node& entry : *array) {
        if (!entry.is_string()) return "expected texts in the list, not " + kind_text(entry);
        const std::string& given = entry.as_string()->get();
        const auto found =
            std::ranges::find(kSides, given, [](const auto& side) { return side.first; });
        if (found == std::end(kSides)) {
            return '"' + given + "\" is not one of -x, +x, -y, +y, -z, +z";
        }
        sides |= found->second;
    }
    return {};
}

/// What is a number in [soil.contact_constants].
TableOf<ContactLawDef> contact_constants_table() {
    TableOf<ContactLawDef> table(
        "soil.contact_constants", false,
        "Constants of the contact law. Where each value is from, and what changes with it: "
        "plugin/include/bsoil/contact/contact_law_def.h.");
    const auto add = [&table](const FieldKey& key, auto place) {
        using Value =
            std::remove_reference_t<std::invoke_result_t<decltype(place), ContactLawDef&>>;
        if constexpr (std::is_same_v<Value, double>) {
            table.number(key.name, place, key.range, key.doc);
        } else if constexpr (std::is_same_v<Value, int>) {
            table.integer(key.name, place, key.range, key.doc);
        }
    };
#define BSOIL_KEY(field, least, most, what, more)    \
    add(                                             \
        FieldKey(#field, {least, most}, what, more), \
        [](ContactLawDef & law) -> auto& { return law.field; });
    BSOIL_CONTACT_LAW_FIELDS(BSOIL_KEY)
#undef BSOIL_KEY
    return table;
}

/// What is on or off: in [soil].
void add_contact_flags(TableOf<SoilItem>& table) {
    const auto add = [&table](const FieldKey& key, auto place) {
        using Value = std::remove_reference_t<std::invoke_result_t<decltype(place), SoilItem&>>;
        if constexpr (std::is_same_v<Value, bool>) {
            if (!is_written_apart(key.name)) table.flag(key.name, place, key.doc);
        }
    };
#define BSOIL_KEY(field, least, most, what, more)    \
    add(                                             \
        FieldKey(#field, {least, most}, what, more), \
        [](SoilItem & s) -> auto& { return s.def.contact_law.field; });
    BSOIL_CONTACT_LAW_FIELDS(BSOIL_KEY)
#undef BSOIL_KEY
}

TableOf<BekkerItem> bekker_table() {
    using B = BekkerItem;
    return TableOf<B>("material.bekker", false,
                      "Bekker's pressure under a plate of radius b, p = (kc / b + kphi) z^n: the "
                      "densities of the material are chosen so that its own bearing comes nearest. "
                      "Stands beside `cohesion_pa`, `friction_angle_deg` and, where it is known, "
                      "`density_kg_m3`; see docs/bekker_import.md.")
        .number("kphi", &B::kphi, {0, 1e9}, "frictional modulus [N/m^(n+2)]")
        .required()
        .number("kc", &B::kc, {-1e8, 1e8}, "cohesive modulus [N/m^(n+1)]")
        .number("n", &B::n, {0, 2.5}, "exponent of sinkage")
        .required()
        .number("gravity_m_s2", &B::gravity_m_s2, {0.1, 30}, "where they were measured");
}

}  // namespace

TableOf<SoilItem> soil_table() {
    using S = SoilItem;
    TableOf<S> table("soil", false,
                     "The soil's grid and its step; without this table there is no soil. `--steps` "
                     "and `steps` of the summary count steps of the soil.");
#define BSOIL_KEY(field, least, most, use, what, more)      \
    add_field(                                              \
        table, FieldKey(#field, {least, most}, what, more), \
        [](S & s) -> auto& { return s.def.field; });
    BSOIL_SOIL_FIELDS(BSOIL_KEY)
#undef BSOIL_KEY
    table
        .choice(
            "contact_law", {"granular", "bekker", "plain", "work"}, "granular",
            "what soil does to bodies: by the stress at each element of their surface, by "
            "Bekker's and Janosi's parameters (each material then needs `[material.bekker]`), "
            "by resistive force theory alone, or by the work of moving what a face displaces to "
            "the free surface",
            [](S& s, size_t i) {
                constexpr ContactLawDef::Kind kOrder[] = {
                    ContactLawDef::Kind::granular, ContactLawDef::Kind::bekker,
                    ContactLawDef::Kind::plain, ContactLawDef::Kind::work};
                s.def.contact_law.kind = kOrder[i];
            })
        .choice("contact_faces", {"coverage", "shape"}, "shape",
                "where the area of a body's surface in a voxel comes from: the coverage field, or "
                "the body's shapes with their edges and thin parts",
                [](S& s, size_t i) { s.def.contact_law.faces_by_shape = i == 1; });
    add_contact_flags(table);
    return table
        .child<ContactLawDef>("contact_constants", contact_constants_table(),
                              [](S& s) { return &s.def.contact_law; })
        .value("open_sides", "[text, ...]",
               "sides of the box, before it is turned, over whose edge soil falls out of it: "
               "\"-x\", \"+x\" and so on along the world's axes; the others are walls",
               [](S& s, const toml::node& value) { return read_sides(value, s.def.open_sides); })
        .text("material", &S::material,
              "name of a built-in or of a [[material]]; dry_sand where neither key is given")
        .texts("materials", &S::materials, "several of them, up to 8, instead of `material`");
}

TableOf<MaterialItem> material_table() {
    using M = MaterialItem;
    TableOf<M> table(
        "material", true,
        "A material: a built-in with some values replaced. A density given without the loose and "
        "the compacted one is that of loose soil, and the compacted one is 1 / 0.8 of it.");
    table.text("name", &M::name, "unique; a built-in's name replaces that built-in")
        .required()
        .text("base", &M::base,
              "the built-in it starts from: dry_sand, moist_sand, sandy_loam, loam, clay, gravel, "
              "fine_sand (which takes water)");
    const auto add = [&table](const FieldKey& key, std::optional<double> M::*place) {
        table.number(key.name, place, key.range, key.doc, key.scale);
    };
#define BSOIL_KEY(field, least, most, use, what, more) \
    add(FieldKey(#field, {least, most}, what, more), &M::field);
    BSOIL_MATERIAL_FIELDS(BSOIL_KEY)
#undef BSOIL_KEY
    return table
        .child<BekkerItem>("bekker", bekker_table(), [](M& m) { return &m.bekker.emplace(); })
        .vector("color", &M::color, kFraction, "linear red, green, blue for pictures");
}

}  // namespace bsoil::scene
