/// What every function of the C interface starts with: exceptions kept in, handles looked up.
#pragma once

#include <exception>
#include <memory>
#include <new>
#include <string>
#include <string_view>

#include "bsoil/bullet/soil_action.h"
#include "c_structs.h"

struct bulletsoil_soil {
    std::unique_ptr<bsoil::bullet::SoilAction> action;
};

namespace bsoil::bullet {

/// Notes the text of this thread's last error. Returns `code`.
bulletsoil_result fail(bulletsoil_result code, std::string_view text);
/// Refuses what is no handle of a living soil.
void check_handle(const bulletsoil_soil* soil);

inline constexpr char kOutOfMemory[] =
    "out of memory on this machine; take a smaller size_m or larger voxels";
inline constexpr char kUnknownException[] =
    "an exception of unknown type; please report what was called";

template <typename Body>
bulletsoil_result guarded(const char* function, Body&& body) noexcept {
    try {
        try {
            body();
            return BULLETSOIL_OK;
        } catch (const Failure& failure) {
            return fail(failure.code, std::string(function) + ": " + failure.text);
        } catch (const std::bad_alloc&) {
            return fail(BULLETSOIL_OUT_OF_MEMORY, kOutOfMemory);
        } catch (const std::exception& error) {
            return fail(BULLETSOIL_INTERNAL_ERROR, std::string(function) + ": " + error.what());
        } catch (...) {
            return fail(BULLETSOIL_INTERNAL_ERROR, kUnknownException);
        }
    } catch (...) {  // no memory for the text
        return fail(BULLETSOIL_OUT_OF_MEMORY, kOutOfMemory);
    }
}

inline SoilAction& action_of(bulletsoil_soil* soil) {
    check_handle(soil);
    return *soil->action;
}
inline const SoilAction& action_of(const bulletsoil_soil* soil) {
    check_handle(soil);
    return *soil->action;
}

}  // namespace bsoil::bullet
