/// The voxels that a displaced voxel overlaps, thesis (13) to (15).
#pragma once

#include <vector>

#include "oracle/field.h"

namespace oracle {

struct Overlap {
    int dx, dy, dz;  ///< of the overlapped voxel
    double share;    ///< lambda of (15)
};

/// All voxels but the one itself that a voxel displaced by `way` (components within -1..1)
/// overlaps.
inline std::vector<Overlap> overlaps(Vec3 way) {
    const auto omega = [](double x1, double x2) {
        return 1 - std::min(1.0, std::abs(x1 - x2));
    };  // (13)
    std::vector<Overlap> parts;
    for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const double share =
                    omega(way.x, dx) * omega(way.y, dy) * omega(way.z, dz);  // (15)
                if (share > 0 && (dx != 0 || dy != 0 || dz != 0)) {
                    parts.push_back({dx, dy, dz, share});
                }
            }
        }
    }
    return parts;
}

}  // namespace oracle
