/// The elements that patches are made of, and what they bear once their body has moved on.
#pragma once

#include <span>

#include "bsoil/contact/contact_law_def.h"
#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Share of its full limit that an element or a patch counts with at least where it has drawn back.
/// Ours: as good as none, so that a patch whose elements all have drawn back has a place and a
/// direction for when they come back. Larger: soil pushes on bodies that have left it; smaller:
/// rounding is in what comes back.
inline constexpr double kDrawnBackShare = 1e-6;

/// An element of a patch as the soil's step has found it. World axes.
struct PatchElement {
    int patch = 0;         ///< index into ContactPatches::patches()
    Vec3 normal;           ///< unit, out of the body
    double pushed_n = 0;   ///< its limit if it had not drawn back
    double depth_m = 0;    ///< by which it bears, > 0
    double retreat_m = 0;  ///< ContactHistory::retreat_m
};

/// What has become of the patches' limits after their body has moved by shift_m, as shares of what
/// they were: one for each patch, at least kDrawnBackShare. up: unit.
///
/// Elements go along with the body. So what it moves level brings each of them to soil that is as
/// deep and as much drawn back as what it had: a wheel rolls on as it did. As the body sinks or
/// rises an element's limit follows its depth, and what it has drawn back
/// (ContactLawDef::unloading_stiffness). An element that goes into the soil all the same, as a
/// wheel's front does while the wheel rises, does not draw back.
void limit_shares(std::span<const PatchElement> elements, Vec3 shift_m, Vec3 up,
                  const ContactLawDef& law, std::span<double> shares);

}  // namespace bsoil
#pragma GCC visibility pop
