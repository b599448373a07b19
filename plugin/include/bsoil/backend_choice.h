/// Where a soil would run.
#pragma once

#include <string>

#include "bsoil/result.h"
#include "bsoil/soil_def.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// The backend, device and number of threads that a soil would get.
struct BackendChoice {
    std::string backend_name;  ///< "cpu" or "gl"
    std::string device_name;   ///< of the processor, or as the GL driver calls it
    int thread_count = 1;      ///< of the CPU backend
    std::string reason;        ///< why this one, in a sentence
};
/// What Soil::create takes for SoilDef::backend and SoilDef::thread_count. The error says what the
/// backend lacks, or which number is out of range. Compiles the kernels where the choice is OpenGL.
Result<BackendChoice> choose_backend(Backend backend, int thread_count);

}  // namespace bsoil
#pragma GCC visibility pop
