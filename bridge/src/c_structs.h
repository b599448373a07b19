/// The structs of the C interface and the definitions they stand for.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>

#include "bsoil/c/bulletsoil.h"
#include "bsoil/soil_def.h"
#include "bsoil/soil_flow.h"

namespace bsoil::bullet {

/// Ends a function with a text: thrown by the checks below, caught by guarded().
struct Failure {
    bulletsoil_result code;
    std::string text;
};

[[noreturn]] inline void refuse(std::string text) {
    throw Failure{BULLETSOIL_INVALID_ARGUMENT, std::move(text)};
}

template <typename T>
T& required(T* pointer, const char* name) {
    if (pointer == nullptr) refuse(std::string(name) + " is null, must be given");
    return *pointer;
}

/// What a caller of the first version knows of each struct: up to its last member then. No padding
/// follows it, where a later member would read what that caller never wrote.
#define BSOIL_BYTES_UP_TO(Struct, member) (offsetof(Struct, member) + sizeof(Struct::member))
constexpr size_t kMaterialBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_material, reserved);
constexpr size_t kSoilDefBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_soil_def, propagation_iterations);
constexpr size_t kContactConstantsBytesMin =
    BSOIL_BYTES_UP_TO(bulletsoil_contact_constants, looks_down_cosine);
constexpr size_t kBodyReportBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_body_report, is_in_contact);
constexpr size_t kSettleReportBytesMin =
    BSOIL_BYTES_UP_TO(bulletsoil_settle_report, tile_awake_count);
constexpr size_t kStepRateBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_step_rate, call_most_ms);
static_assert(kStepRateBytesMin == sizeof(bulletsoil_step_rate));
static_assert(kSettleReportBytesMin == sizeof(bulletsoil_settle_report));
constexpr size_t kConditionBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_condition, step_count);
static_assert(kMaterialBytesMin % alignof(bulletsoil_material) == 0);
static_assert(kSoilDefBytesMin % alignof(bulletsoil_soil_def) == 0);
static_assert(kBodyReportBytesMin == offsetof(bulletsoil_body_report, load_n));
static_assert(kContactConstantsBytesMin % alignof(bulletsoil_contact_constants) == 0);

constexpr size_t kSourceBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_source, reserved);
constexpr size_t kSinkBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_sink, reserved);
constexpr size_t kFlowStateBytesMin = BSOIL_BYTES_UP_TO(bulletsoil_flow_state, missed_kg);
static_assert(kFlowStateBytesMin == sizeof(bulletsoil_flow_state));
static_assert(kSourceBytesMin == sizeof(bulletsoil_source));
static_assert(kSinkBytesMin % alignof(bulletsoil_sink) == 0);

void check_size(const char* name, size_t struct_size, size_t least, size_t most);

/// A struct of the caller's as the library knows it: what the caller does not know keeps `known`.
template <typename Struct>
Struct widened(const Struct& from, Struct known) {
    std::memcpy(&known, &from, from.struct_size);
    return known;
}
/// As much of `from` as the caller knows.
template <typename Struct>
void narrow_into(Struct& to, Struct from, size_t struct_size) {
    from.struct_size = struct_size;
    std::memcpy(&to, &from, struct_size);
}

inline void check(const Status& status, bulletsoil_result code = BULLETSOIL_INVALID_ARGUMENT) {
    if (!status) throw Failure{code, status.error()};
}

inline Vec3 point(const double* xyz, const char* name) {
    required(xyz, name);
    return {xyz[0], xyz[1], xyz[2]};
}
inline void copy(Vec3 from, double (&to)[3]) {
    to[0] = from.x;
    to[1] = from.y;
    to[2] = from.z;
}

/// Empty for null: the soil's first material.
inline std::string text_of(const char* text) { return text == nullptr ? std::string() : text; }

bulletsoil_material to_c(const MaterialDef& def);
bulletsoil_soil_def default_def();
bulletsoil_contact_constants default_contact_constants();
/// Values out of range, those of the enumerations among them, are left for SoilDef::validate to
/// name.
SoilDef from_c(const bulletsoil_soil_def& def);
bulletsoil_source default_source();
bulletsoil_sink default_sink();
SourceDef from_c(const bulletsoil_source& source);
SinkDef from_c(const bulletsoil_sink& sink);

}  // namespace bsoil::bullet
