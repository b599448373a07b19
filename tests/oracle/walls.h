/// Soil caught in walls: not in the thesis. A voxel that bodies cover by half or more holds soil
/// that their surface has run over; it may leave on the side it came from only.
///
/// That side is told by the gradient of the bodies' coverage as it was before their last move: the
/// gradient of now, as far on as the body has moved, interpolated between the voxel and the nearest
/// of its 26 neighbours in that direction (or in what is left of it when rock bars an axis). Rock
/// and the grid's ends count as covered no less than what is on this side of them.
#pragma once

#include <span>

#include "oracle/field.h"

namespace oracle {

/// The way out of the wall for the soil of one voxel.
struct WayOut {
    Vec3 direction;  ///< of any length; 0 where there is no way to prefer
    bool overrun =
        false;  ///< the far side is nearer now: all of the soil has to go, not its excess
};

bool is_caught(const Model& model, const Voxel& voxel);

/// Of any voxel that bodies cover.
WayOut find_way_out(const Model& model, const Field& field, std::span<const Body> bodies, int x,
                    int y, int z);

/// Excess of a voxel that needs no push because its soil, which the body there carries, moves out
/// of the body's way by itself: up to its way in this step, where what is ahead of it is open and
/// carried by the same body.
double carried_off(const Model& model, const Field& field, const WayOut& out, int x, int y, int z);

/// Whether the voxel (x, y, z) is closed by a wall that recedes: within 60 degrees of the way its
/// coverage rises, and no faster than model.follow_most.
bool recedes(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
             int z);

/// What the voxel (x, y, z), closed by a wall that recedes, still takes of soil `from` that the
/// wall's body carries.
double room_at_face(const Model& model, const Field& field, std::span<const Body> bodies,
                    const Voxel& from, int x, int y, int z);

/// Whether soil of the voxel (x, y, z), whose way out is `out` if it is caught, may not go to the
/// neighbour at (dx, dy, dz). Caught soil may go into caught voxels that are covered no more, or
/// any when it was overrun, but never inwards. Nothing else enters a wall.
bool is_barred(const Model& model, const Field& field, const WayOut& out, int x, int y, int z,
               int dx, int dy, int dz);

}  // namespace oracle
