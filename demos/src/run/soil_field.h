/// Fields of the soil in numbers and colours.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/soil.h"

namespace bsoil::scene {

enum class Field {
    none,
    density,
    velocity,
    force,
    coverage,
    disturbed,
    activity,
    material,
    moisture,
    compaction
};
inline constexpr int kFieldCount = 10;
const char* field_name(Field field);
/// Moisture: a material of the soil takes water; compaction: the density of one changes. All other
/// fields every soil has.
bool has_field(const std::vector<MaterialDef>& materials, Field field);

/// Linear colour of a fraction 0..1: dark blue over green to yellow, as bright as it is much.
std::array<float, 3> ramp_color(double fraction);

/// The two ends of a colour bar.
struct ColorBar {
    std::string title, unit;
    double low = 0, high = 1;
};

class SoilField {
  public:
    /// low, high: of the colour bar; both 0: the field's own range. The soil must outlive it.
    SoilField(const Soil& soil, Field field, double low = 0, double high = 0);
    const ColorBar& bar() const { return bar_; }
    /// None where there is no soil to have one.
    std::optional<double> value(const VoxelSample& sample) const;
    /// Where a value lies between the ends of the colour bar, 0..1.
    double fraction(double value) const;
    /// Linear RGB.
    std::array<float, 3> color(double value, const VoxelSample& sample) const;

  private:
    const Soil& soil_;
    Field field_;
    ColorBar bar_;
};

}  // namespace bsoil::scene
