/// Where the measured data lie that tests of forces compare with.
#pragma once

#include <cstdlib>
#include <string>

namespace bsoil {

/// A table of terramechanics: under $BULLETSOIL_DATA, else in the folder that CMake was told.
inline std::string measured_data(const std::string& file) {
    const char* set = std::getenv("BULLETSOIL_DATA");
    return (set ? std::string(set) : BULLETSOIL_DATA_DIR) + "/terramechanics/" + file;
}

}  // namespace bsoil
