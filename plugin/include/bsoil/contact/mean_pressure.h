/// MeanPressure: of a contact, each part of it weighted by the force that it bears.
#pragma once

#include "bsoil/cxx20.h"

namespace bsoil {

/// Adds up the parts of a contact. The sum of squared stresses over the sum of stresses: a part
/// without force has no say, whatever its area.
class MeanPressure {
  public:
    /// A part of `area_m2` under a stress.
    void add_stress(double stress_pa, double area_m2) {
        force_n_ += area_m2 * stress_pa;
        squares_ += area_m2 * stress_pa * stress_pa;
    }
    /// A part of `area_m2` (> 0) that bears a force.
    void add_force(double force_n, double area_m2) {
        force_n_ += force_n;
        squares_ += force_n * force_n / area_m2;
    }
    /// The mean; 0 without any force.
    double pa() const { return force_n_ > 0 ? squares_ / force_n_ : 0; }

  private:
    double force_n_ = 0, squares_ = 0;
};

}  // namespace bsoil
