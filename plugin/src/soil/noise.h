/// Coherent value noise for procedural ground (thesis section 2.2.2).
#pragma once

namespace bsoil {

/// Sum of octaves of smooth value noise, each half as long and `persistence` as high; about -1..1.
double fractal_noise(double x, double y, int octaves, double persistence, unsigned seed);

}  // namespace bsoil
