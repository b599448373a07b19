/// Fields of the soil in colours: on its surface or on a slice through it.
#pragma once

#include <optional>
#include <string>

#include "bsoil/soil.h"
#include "bsoil/surface_mesh.h"
#include "run/soil_field.h"
#include "world_picture.h"

namespace bsoil::viewer {

using scene::ColorBar;
using scene::Field;
using scene::field_name;
using scene::kFieldCount;
using scene::ramp_color;

/// What is shown of a field.
struct OverlayDef {
    Field field = Field::none;
    bool on_surface = true;
    bool slice = false;
    bool volume = false;       ///< in place of the soil's surface: see SoilVolume
    int slice_axis = 0;        ///< of the grid: 0 x, 1 y, 2 z
    double slice_at = 0.5;     ///< along that axis, fraction of the grid
    double low = 0, high = 0;  ///< of the colour bar; both 0: the field's own range
    friend bool operator==(const OverlayDef&, const OverlayDef&) = default;
};

class FieldOverlay {
  public:
    FieldOverlay(const Soil& soil, const OverlayDef& def);
    const ColorBar& bar() const { return field_.bar(); }
    /// Colours of the soil's surface by the field just below it. Of speeds it shows the faster of
    /// the voxel's and that of what slides on top.
    void color(Mesh& mesh) const;
    /// The soil's cut through the grid, coloured; bare voxels are left out.
    Mesh slice() const;
    Plane slice_plane() const;

  private:
    std::optional<double> value_at(const int voxel[3], VoxelSample& sample) const;
    std::optional<double> value_around(Vec3 grid, VoxelSample& sample) const;
    int slice_layer() const;

    const Soil& soil_;
    OverlayDef def_;
    scene::SoilField field_;
};

}  // namespace bsoil::viewer
