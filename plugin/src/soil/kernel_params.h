/// What kernels are told of a soil's definition.
#pragma once

#include <cstdint>
#include <vector>

#include "soil/soil_core.h"

namespace bsoil {

/// What follows from the definition alone, once its grid has its place. The rest of SoilParams
/// passes and steps set.
void set_kernel_params(SoilCore& core);

/// Tables of all materials, each bonded and loose; what they say of banks, deposits and air is put
/// into the parameters.
std::vector<int32_t> make_material_tables(SoilCore& core);

}  // namespace bsoil
