/// What several conversions ask of a shape, and how they say what is wrong with it.
#pragma once

#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/result.h"
#include "bullet_types.h"

namespace bsoil::bullet {

using Shapes = std::vector<ConvexShape>;

inline ConvexShape of_kind(ConvexShape::Kind kind) {
    ConvexShape out;
    out.kind = kind;
    return out;
}

inline std::string shape_name(const btCollisionShape& shape) {
    return std::string("shape '") + shape.getName() + "'";
}

inline Status check_extent(const btCollisionShape& shape, const char* field, double metres,
                           double smallest_m = std::numeric_limits<double>::min()) {
    if (std::isfinite(metres) && metres >= smallest_m) return Done{};
    return Error{shape_name(shape) + ": " + field + " is " + std::to_string(metres) +
                 " m, must be finite and above 0"};
}

inline Status check_margin(const btCollisionShape& shape, double metres) {
    if (std::isfinite(metres) && metres >= 0) return Done{};
    return Error{shape_name(shape) + ": margin is " + std::to_string(metres) +
                 " m, must be finite and not negative"};
}

/// An error says which shape it is of.
inline Result<Shapes> named(const btCollisionShape& shape, Result<Shapes> converted) {
    if (!converted) return Error{shape_name(shape) + ": " + converted.error()};
    return converted;
}

inline bool is_gimpact_compound(const btCollisionShape& shape) {
    return shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE &&
           static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() ==
               CONST_GIMPACT_COMPOUND_SHAPE;
}

inline Pose child_pose(const btGImpactCompoundShape& shape, int child) {
    return shape.childrenHasTransform() ? from_bullet(shape.getChildTransform(child)) : Pose{};
}

}  // namespace bsoil::bullet
