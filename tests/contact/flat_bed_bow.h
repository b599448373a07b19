/// Soil that goes with the front of a body: the rules of docs/decisions/bow.md.
#pragma once

#include <span>

#include "bsoil/contact/contact_law.h"

namespace bsoil::flat_bed {

/// What stands for a bow of soil before a body; see the page.
enum class Bow { none, turned, turned_by_share, held, block };

/// The bow of one body in a level bed whose up is z.
class BodyBow {
  public:
    /// velocity_m_s: of the body; voxels: its part in the soil.
    BodyBow(Bow rule, const MaterialDef& material, Vec3 velocity_m_s,
            std::span<const ContactVoxel> voxels);
    /// Stress [Pa] on an element that moves into the soil, in place of `stress_pa`.
    Vec3 stress_pa(Vec3 stress_pa, const ContactVoxel& element, Vec3 velocity) const;

  private:
    Vec3 turned(Vec3 stress_pa, const ContactVoxel& element, Vec3 velocity) const;
    Vec3 of_block(const ContactVoxel& element) const;

    Bow rule_;
    bool travels_ = false;
    Vec3 travel_;  ///< level, unit
    double tan_phi_;
    double foot_m_ = 0;        ///< depth of the body's lowest point
    double wedge_pa_m_ = 0;    ///< level stress of the passive wedge over depth
    double upright_pa_m_ = 0;  ///< of resistive force theory for an upright wall of soil
    Vec3 base_pa_m_;           ///< of a level face of soil that goes along
};

}  // namespace bsoil::flat_bed
