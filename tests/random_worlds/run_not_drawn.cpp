// Of a build without the renderer.
#include "run_drawn.h"

namespace bsoil::random_worlds {

bool can_draw() { return false; }
void run_drawn(const WorldPlan&, Failures&) {}

}  // namespace bsoil::random_worlds
