#include "bsoil/contact/patch_heirs.h"

#include <algorithm>
#include <limits>

namespace bsoil {
namespace {

/// Patches whose normals are further apart than this cosine are not the same contact, and take over
/// no force. Ours: 60 deg, where faces of a box are 90 deg apart. Larger, and a rolling wheel
/// starts every patch from nothing; smaller, and a face passes its force on to the one round the
/// edge.
constexpr double kSamePatchCosine = 0.5;

/// The old patch nearest to a new one by place and direction, or -1. extent_m: how far the new
/// patches reach from the centre of mass.
int nearest_of(std::span<const PlacedPatch> old, const PlacedPatch& next, double extent_m) {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < old.size(); ++i) {
        const double cosine = dot(old[i].patch.normal, next.patch.normal);
        const Vec3 apart = old[i].offset_m - next.offset_m;
        const double distance = dot(apart, apart) + (1 - cosine) * extent_m * extent_m;
        if (cosine < kSamePatchCosine || distance >= least ||
            old[i].patch.carrier != next.patch.carrier) {
            continue;
        }
        least = distance;
        nearest = static_cast<int>(i);
    }
    return nearest;
}

}  // namespace

std::span<const PatchHeir> PatchHeirs::find(std::span<const PlacedPatch> old,
                                            std::span<const PlacedPatch> now) {
    double extent_m = 0;
    for (const PlacedPatch& next : now) extent_m = std::max(extent_m, length(next.offset_m));
    limits_n_.assign(old.size(), 0);
    heirs_.assign(now.size(), {});
    for (size_t i = 0; i < now.size(); ++i) {
        heirs_[i].old = nearest_of(old, now[i], extent_m);
        if (heirs_[i].old >= 0) {
            limits_n_[static_cast<size_t>(heirs_[i].old)] += now[i].patch.normal_limit_n;
        }
    }
    for (size_t i = 0; i < now.size(); ++i) {
        if (heirs_[i].old < 0) continue;
        const auto from = static_cast<size_t>(heirs_[i].old);
        const double limit_n = now[i].patch.normal_limit_n;
        heirs_[i].force_share = limit_n / limits_n_[from];
        heirs_[i].limit_share = std::min(1.0, limit_n / old[from].patch.normal_limit_n);
    }
    return heirs_;
}

}  // namespace bsoil
