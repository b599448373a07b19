/// SnapshotAccess: a SoilAction's part of a snapshot.
#pragma once

#include <functional>
#include <span>

#include "bsoil/bullet/precision.h"
#include "bsoil/snapshot_file.h"

namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

class SoilAction;

/// `index` counts the soils of a world.
class SnapshotAccess {
  public:
    /// Takes what the soil has in the world for a substep out of it.
    static void close_substep(SoilAction& action);
    /// The sections of one soil and its coupling. Error: something in it is not finite.
    static Result<std::vector<SnapshotSection>> sections(const SoilAction& action, size_t index);
    /// Checks them against this soil and its world; the function put out replaces the state.
    static Result<std::function<void()>> prepare(SoilAction& action,
                                                 std::span<const SnapshotSection> sections,
                                                 size_t index);
};

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
