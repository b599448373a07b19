/// What kernels are told of a soil's definition.
#pragma once

#include <cstdint>
#include <vector>

#include "soil/soil_core.h"

namespace bsoil {

/// What follows from the definition alone, once its grid has its place. The rest of SoilParams
/// passes and steps set.
void set_kernel_params(SoilCore& core);

/// Gravity of a step, Q16 voxels a step squared. Where the nearest whole one is off by more than a
/// hundredth, as of short steps in large voxels, steps have one more or one less: their mean is
/// right.
int32_t gravity_q16(const SoilDef& def, int64_t step_index);

/// Tables of all materials, each bonded and loose; what they say of banks, deposits and air is put
/// into the parameters.
std::vector<int32_t> make_material_tables(SoilCore& core);

}  // namespace bsoil
