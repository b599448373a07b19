/// What holds back a column of soil that a body lifts.
#pragma once

#include "bsoil/contact/contact_law.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Of ContactVoxel::is_load_side, whatever the law: soil shears on soil up the column's side, as
/// wide as the edge. Beside it soil is at rest, K0 = 1 - sin phi (Jaky 1944), so that a metre of
/// edge at depth z holds
///
///     K0 tan phi gamma z^2 / 2 + c z
///
/// against what rises: White, Cheuk and Bolton (2008) without dilation; cohesion as Meyerhof and
/// Adams (1968) have it. Friction acts along the slip: of what goes sideways too it has the part
/// that rises. Nothing holds what goes down, or level.
ElementYield load_side_yield(const ContactSoil& soil, const ContactVoxel& contact,
                             const ElementMotion& motion);

}  // namespace bsoil
#pragma GCC visibility pop
