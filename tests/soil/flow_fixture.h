/// Sources and sinks for tests, in a grid of 48 x 48 columns.
#pragma once

#include <numeric>

#include "soil_fixture.h"

namespace bsoil {

constexpr double kVoxel = 0.05;

inline int64_t sum(const std::vector<int64_t>& units) {
    return std::accumulate(units.begin(), units.end(), int64_t{0});
}

/// Units in the grid = start + in - out, for each material.
inline void expect_balance(const Soil& soil, const SoilTotals& start) {
    const SoilTotals now = soil.totals();
    for (size_t m = 0; m < now.units.size(); ++m) {
        EXPECT_EQ(now.units[m], start.units[m] + now.units_in[m] - now.units_out[m]) << m;
    }
}

/// A disc of 0.2 m in the middle of a grid of 48 x 48 columns, 1.2 m up.
inline SourceDef pipe(double rate_kg_s) {
    SourceDef source;
    source.center_m = {1.2, 1.2, 1.2};
    source.radius_m = 0.2;
    source.rate_kg_s = rate_kg_s;
    return source;
}

inline SinkDef box_sink(Vec3 low, Vec3 high) {
    SinkDef sink;
    sink.region.half_extents_m = 0.5 * (high - low);
    sink.pose.position = 0.5 * (low + high);
    return sink;
}

inline SoilDef flow_def(double step_s = 1.0 / 60) {
    SoilDef def = grid_def(48, 48, 32, kVoxel);
    def.step_s = step_s;
    return def;
}

}  // namespace bsoil
