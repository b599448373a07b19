/// The weight of soil on a body: what a bucket or a bed carries rests on it and on nothing else.
#pragma once

#include <span>

#include "body_state.h"
#include "bsoil/body.h"

namespace bsoil::bullet {

/// Gives each dynamic body or link the impulse of its load's weight over `duration_s`, at the
/// load's centre of mass. Sleeping bodies are left alone: what they carry already rests. Call from
/// an action: Bullet keeps impulses then.
void apply_carried_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                         Vec3 up, double gravity_m_s2, double duration_s);

}  // namespace bsoil::bullet
