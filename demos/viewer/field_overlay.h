/// Fields of the soil in colours: on its surface or on a slice through it.
#pragma once

#include <optional>
#include <string>

#include "bsoil/soil.h"
#include "bsoil/surface_mesh.h"
#include "world_picture.h"

namespace bsoil::viewer {

enum class Field { none, density, velocity, force, coverage, disturbed, activity, material };
inline constexpr int kFieldCount = 8;
const char* field_name(Field field);

/// Linear colour of a fraction 0..1: dark blue over green to yellow, as bright as it is much.
std::array<float, 3> ramp_color(double fraction);

/// What is shown of a field.
struct OverlayDef {
    Field field = Field::none;
    bool on_surface = true;
    bool slice = false;
    int slice_axis = 0;        ///< of the grid: 0 x, 1 y, 2 z
    double slice_at = 0.5;     ///< along that axis, fraction of the grid
    double low = 0, high = 0;  ///< of the colour bar; both 0: the field's own range
    friend bool operator==(const OverlayDef&, const OverlayDef&) = default;
};

class FieldOverlay {
  public:
    FieldOverlay(const Soil& soil, const OverlayDef& def);
    ColorBar bar() const { return bar_; }
    /// Colours of the soil's surface by the field just below it.
    void color(Mesh& mesh) const;
    /// The soil's cut through the grid, coloured; bare voxels are left out.
    Mesh slice() const;
    Plane slice_plane() const;

  private:
    int slice_layer() const;
    std::optional<double> value(const VoxelSample& sample) const;
    std::array<float, 3> color_of(double value, const VoxelSample& sample) const;

    const Soil& soil_;
    OverlayDef def_;
    ColorBar bar_;
};

}  // namespace bsoil::viewer
