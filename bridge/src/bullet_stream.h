/// StateStream for Bullet's own types.
#pragma once

#include <LinearMath/btTransform.h>

#include "bsoil/snapshot_file.h"

namespace bsoil::bullet {

inline void list(StateStream& stream, btVector3& v) {
    stream(v.m_floats[0], v.m_floats[1], v.m_floats[2]);
}
inline void list(StateStream& stream, btQuaternion& q) {
    for (int i = 0; i < 4; ++i) stream(q[i]);
}
inline void list(StateStream& stream, btMatrix3x3& m) {
    for (int row = 0; row < 3; ++row) list(stream, m[row]);
}
inline void list(StateStream& stream, btTransform& t) {
    list(stream, t.getBasis());
    list(stream, t.getOrigin());
}

}  // namespace bsoil::bullet
