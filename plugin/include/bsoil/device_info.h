/// What there is to compute on.
#pragma once

#include <string>
#include <vector>

#include "bsoil/cxx20.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// The CPU or one EGL device.
struct DeviceInfo {
    std::string name;    ///< the CPU's model, or as the GL driver calls it
    std::string detail;  ///< threads, or version and limits, or why it cannot be used
    bool usable = false;
    bool hardware = false;  ///< no software renderer
};
/// All of them, the CPU first. Opens each: takes some milliseconds.
std::vector<DeviceInfo> list_devices();

}  // namespace bsoil
#pragma GCC visibility pop
