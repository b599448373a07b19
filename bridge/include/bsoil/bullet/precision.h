/// Bullet's precision, here and in the BulletSoil library that is linked.
///
/// The public names of bsoil::bullet lie in an inline namespace named by the precision, chosen
/// where the header is compiled. So a program that was compiled for the other one does not link.
#pragma once

#include <LinearMath/btScalar.h>

#include "bsoil/cxx20.h"

#ifdef BT_USE_DOUBLE_PRECISION
/// Name of the inline namespace: float32 or float64.
#define BSOIL_BULLET_PRECISION float64
#else
/// Name of the inline namespace: float32 or float64.
#define BSOIL_BULLET_PRECISION float32
#endif

// BULLETSOIL_SCALAR_BITS comes with the library, from CMake or pkg-config.
#if defined(BULLETSOIL_SCALAR_BITS) && defined(BT_USE_DOUBLE_PRECISION) && \
    BULLETSOIL_SCALAR_BITS != 64
#error \
    "BulletSoil's float library is linked, and Bullet is included in double precision: link \
BulletSoil::bullet_double (pkg-config bulletsoil-bullet-float64), or undefine BT_USE_DOUBLE_PRECISION"
#endif
#if defined(BULLETSOIL_SCALAR_BITS) && !defined(BT_USE_DOUBLE_PRECISION) && \
    BULLETSOIL_SCALAR_BITS != 32
#error \
    "BulletSoil's double library is linked, and Bullet is included in float precision: link \
BulletSoil::bullet (pkg-config bulletsoil-bullet), or define BT_USE_DOUBLE_PRECISION"
#endif
