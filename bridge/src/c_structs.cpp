#include "c_structs.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "bsoil/limits.h"
#include "bsoil/version.h"

namespace bsoil::bullet {

// Numbers of the C interface say the same as the enums that from_c() makes of them.
template <typename Enum>
constexpr bool same(int number, Enum value) {
    return number == static_cast<int>(value);
}
static_assert(same(BULLETSOIL_UP_Y, UpAxis::y));
static_assert(same(BULLETSOIL_UP_Z, UpAxis::z));
static_assert(same(BULLETSOIL_BACKEND_AUTOMATIC, Backend::automatic));
static_assert(same(BULLETSOIL_BACKEND_CPU, Backend::cpu));
static_assert(same(BULLETSOIL_BACKEND_GL, Backend::gl));
static_assert(same(BULLETSOIL_OVERFLOW_EVEN, OverflowHeuristic::even));
static_assert(same(BULLETSOIL_OVERFLOW_UP, OverflowHeuristic::up));
static_assert(same(BULLETSOIL_OVERFLOW_UP_SPREAD, OverflowHeuristic::up_spread));
static_assert(same(BULLETSOIL_SLIDES_SETTLE, SlideMotion::settle));
static_assert(same(BULLETSOIL_SLIDES_RUN_OUT, SlideMotion::run_out));
static_assert(same(BULLETSOIL_CONTACT_GRANULAR, ContactLawDef::Kind::granular));
static_assert(same(BULLETSOIL_CONTACT_BEKKER, ContactLawDef::Kind::bekker));
static_assert(same(BULLETSOIL_OPEN_LOW_X, kOpenLowX));
static_assert(same(BULLETSOIL_OPEN_HIGH_X, kOpenHighX));
static_assert(same(BULLETSOIL_OPEN_LOW_Y, kOpenLowY));
static_assert(same(BULLETSOIL_OPEN_HIGH_Y, kOpenHighY));
static_assert(same(BULLETSOIL_OPEN_LOW_Z, kOpenLowZ));
static_assert(same(BULLETSOIL_OPEN_HIGH_Z, kOpenHighZ));
static_assert(same(BULLETSOIL_CONTACT_PLAIN, ContactLawDef::Kind::plain));
static_assert(same(BULLETSOIL_CONTACT_WORK, ContactLawDef::Kind::work));
static_assert(same(BULLETSOIL_SOURCE_DISC, SourceDef::Shape::disc));
static_assert(same(BULLETSOIL_SOURCE_RECTANGLE, SourceDef::Shape::rectangle));
static_assert(same(BULLETSOIL_SINK_BOX, ConvexShape::Kind::box));
static_assert(same(BULLETSOIL_SINK_SPHERE, ConvexShape::Kind::sphere));
static_assert(same(BULLETSOIL_SINK_CAPSULE, ConvexShape::Kind::capsule));
static_assert(same(BULLETSOIL_SINK_CYLINDER, ConvexShape::Kind::cylinder));
static_assert(same(BULLETSOIL_SINK_CONE, ConvexShape::Kind::cone));

namespace {

// A field of a definition and its namesake in the C struct, either way.
void assign(double from, double& to) { to = from; }
void assign(int from, int32_t& to) { to = from; }
void assign(bool from, int32_t& to) { to = from ? 1 : 0; }
void assign(int32_t from, bool& to) { to = from != 0; }
template <typename Enum>
requires std::is_enum_v<Enum>
void assign(Enum from, int32_t& to) { to = static_cast<int32_t>(from); }
template <typename Enum>
requires std::is_enum_v<Enum>
void assign(int32_t from, Enum& to) { to = static_cast<Enum>(from); }
void assign(Vec3 from, double (&to)[3]) { copy(from, to); }
void assign(const double (&from)[3], Vec3& to) { to = {from[0], from[1], from[2]}; }

}  // namespace

void check_size(const char* name, size_t struct_size, size_t least, size_t most) {
    if (struct_size < least) {
        refuse(std::string(name) + ".struct_size is " + std::to_string(struct_size) +
               ", must be at least " + std::to_string(least) + ": was the struct initialized?");
    }
    if (struct_size > most) {
        refuse(std::string(name) + ".struct_size is " + std::to_string(struct_size) +
               ", this library (" + version() + ") knows " + std::to_string(most) +
               " bytes: the program was compiled for a newer one; link that");
    }
}

bulletsoil_material to_c(const MaterialDef& def) {
    bulletsoil_material out{};
    out.struct_size = sizeof out;
    out.name = def.name.c_str();
#define BSOIL_ASSIGN(field, ...) assign(def.field, out.field);
    BSOIL_MATERIAL_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    std::copy(def.color.begin(), def.color.end(), out.color);
    return out;
}

namespace {

MaterialDef from_c(const bulletsoil_material& material) {
    MaterialDef out;
    out.name = &required(material.name, "material.name");
#define BSOIL_ASSIGN(field, ...) assign(material.field, out.field);
    BSOIL_MATERIAL_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    std::copy(std::begin(material.color), std::end(material.color), out.color.begin());
    return out;
}

/// The materials of a definition. Their distance in memory is what the caller takes for their size.
std::vector<MaterialDef> materials_of(const bulletsoil_soil_def& def) {
    std::vector<MaterialDef> out;
    if (def.materials == nullptr) {
        if (def.material_count != 0) {
            refuse("def.material_count is " + std::to_string(def.material_count) +
                   ", and def.materials is null; let it point to them");
        }
        return out;
    }
    if (def.material_count < 1 || def.material_count > limits::kMaterialCapacity) {
        refuse("def.material_count is " + std::to_string(def.material_count) + ", must be 1.." +
               std::to_string(limits::kMaterialCapacity));
    }
    const size_t stride = def.materials->struct_size;
    check_size("def.materials[0]", stride, kMaterialBytesMin, sizeof(bulletsoil_material));
    if (stride % alignof(bulletsoil_material) != 0) {
        refuse("def.materials[0].struct_size is " + std::to_string(stride) +
               ", must be a multiple of " + std::to_string(alignof(bulletsoil_material)));
    }
    for (size_t i = 0; i < def.material_count; ++i) {
        const auto* bytes = reinterpret_cast<const char*>(def.materials) + i * stride;
        const auto& material = *reinterpret_cast<const bulletsoil_material*>(bytes);
        if (material.struct_size != stride) {
            refuse("def.materials[" + std::to_string(i) + "].struct_size is " +
                   std::to_string(material.struct_size) + ", must be that of the first, " +
                   std::to_string(stride));
        }
        if (material.reserved != 0) {
            refuse("def.materials[" + std::to_string(i) + "].reserved is " +
                   std::to_string(material.reserved) + ", must be 0");
        }
        out.push_back(from_c(widened(material, to_c(materials::all().front()))));
    }
    return out;
}

ContactLawDef constants_of(const bulletsoil_contact_constants& given) {
    check_size("def.contact_constants", given.struct_size, kContactConstantsBytesMin,
               sizeof(bulletsoil_contact_constants));
    const bulletsoil_contact_constants constants = widened(given, default_contact_constants());
    ContactLawDef out;
#define BSOIL_ASSIGN(field, ...) assign(constants.field, out.field);
    BSOIL_CONTACT_LAW_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    return out;
}

/// Their number and their values are left for ContactLawDef::validate to name.
std::vector<BekkerSoil> bekker_of(const bulletsoil_soil_def& def) {
    std::vector<BekkerSoil> out;
    if (def.bekker_count == 0) return out;
    required(def.bekker, "def.bekker");
    if (def.bekker_count > limits::kMaterialCapacity) {
        refuse("def.bekker_count is " + std::to_string(def.bekker_count) + ", must be 0.." +
               std::to_string(limits::kMaterialCapacity));
    }
    for (size_t i = 0; i < def.bekker_count; ++i) {
        const bulletsoil_bekker& soil = def.bekker[i];
        out.push_back({.kphi_pa_m_n = soil.kphi_pa_m_n,
                       .kc_pa_m_n1 = soil.kc_pa_m_n1,
                       .n = soil.n,
                       .cohesion_pa = soil.cohesion_pa,
                       .friction_angle_rad = soil.friction_angle_rad,
                       .shear_displacement_m = soil.shear_displacement_m,
                       .density_kg_m3 = {}});
    }
    return out;
}

}  // namespace

bulletsoil_contact_constants default_contact_constants() {
    const ContactLawDef from;
    bulletsoil_contact_constants out{};
    out.struct_size = sizeof out;
#define BSOIL_ASSIGN(field, ...) assign(from.field, out.field);
    BSOIL_CONTACT_LAW_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    return out;
}

bulletsoil_soil_def default_def() {
    const SoilDef from;
    bulletsoil_soil_def out{};
    out.struct_size = sizeof out;
#define BSOIL_ASSIGN(field, ...) assign(from.field, out.field);
    BSOIL_SOIL_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    assign(from.contact_law.kind, out.contact_law);
    return out;
}

SoilDef from_c(const bulletsoil_soil_def& def) {
    SoilDef out;
    out.materials = materials_of(def);
#define BSOIL_ASSIGN(field, ...) assign(def.field, out.field);
    BSOIL_SOIL_FIELDS(BSOIL_ASSIGN)
#undef BSOIL_ASSIGN
    if (def.contact_constants != nullptr) out.contact_law = constants_of(*def.contact_constants);
    assign(def.contact_law, out.contact_law.kind);
    out.contact_law.bekker = bekker_of(def);
    if (def.reserved != 0) {
        refuse("def.reserved is " + std::to_string(def.reserved) + ", must be 0");
    }
    if (def.reserved_2 != 0) {
        refuse("def.reserved_2 is " + std::to_string(def.reserved_2) + ", must be 0");
    }
    return out;
}

}  // namespace bsoil::bullet
