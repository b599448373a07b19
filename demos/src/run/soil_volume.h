/// The soil, or a field of it, as a volume to look into.
#pragma once

#include <vector>

#include "bsoil/render/renderer.h"
#include "soil_field.h"

namespace bsoil::scene {

/// What a volume shows.
struct SoilVolumeDef {
    /// Field::none: the soil itself, in its colours, which hides as much as there is of it. Another
    /// field hides the more, the nearer it is to the upper end of its colour bar.
    Field field = Field::none;
    double low = 0, high = 0;  ///< of the colour bar; both 0: the field's own range
    /// In what hides most 1/e of the light is left after this [m]; 0: as wide as the field needs.
    double sight_m = 0;
    friend bool operator==(const SoilVolumeDef&, const SoilVolumeDef&) = default;
};

/// Keeps the voxels of a soil as a renderer takes them. Only tiles that have changed are read
/// again.
class SoilVolume {
  public:
    /// The soil must outlive it.
    SoilVolume(const Soil& soil, const SoilVolumeDef& def);
    /// True when a voxel has changed since the last call, as it has before the first.
    bool update();
    const render::VolumeData& data() const { return data_; }
    /// Where it lies and how far one sees into it. Its `volume` is the caller's to set.
    render::Volume placed() const;
    /// Whether it shows the soil itself: what is too thin for it is left to grains.
    bool is_soil() const { return def_.field == Field::none; }
    ColorBar bar() const { return field_.bar(); }

  private:
    bool read_tile(int tx, int ty);
    std::array<uint8_t, 4> texel(int x, int y, int z) const;

    const Soil& soil_;
    SoilVolumeDef def_;
    SoilField field_;
    render::VolumeData data_;
    std::vector<uint64_t> revisions_;
    bool is_new_ = true;
};

}  // namespace bsoil::scene
