/// Conditions: what a soil runs into while it steps, by which body, where and when.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Sticky conditions: once set they stay until Soil::clear_status(). The text of each names the
/// cure.
enum class StatusBit : uint32_t {
    tile_table_full = 1u << 0,    ///< more tiles needed awake than tile_capacity or memory holds
    speed_clamped = 1u << 1,      ///< soil or a body moved faster than substeps_max voxels a step
    body_teleported = 1u << 2,    ///< a body jumped so far that it was placed, not swept
    body_outside_grid = 1u << 3,  ///< a moving body left the grid's box
    pose_not_finite =
        1u << 4,  ///< a body was ignored: NaN or infinite pose or velocity, or no rotation
    contact_list_full = 1u << 5,  ///< more contact voxels than kContactCapacity: none counted
    amount_headroom = 1u << 6,    ///< a voxel holds so much soil, or momentum, that it saturates
    shape_refused = 1u << 7,      ///< a shape without size, a bad id, or a body too many: ignored
    span_list_full = 1u << 8,     ///< a column has more height spans than kSpanCapacity
    gravity_differs = 1u << 9,    ///< the bodies' world has another gravity than the soil
    rate_lowered = 1u << 10,      ///< a step did not begin when it was due, to keep step_budget_ms
    budget_exceeded =
        1u << 11,            ///< a step spread over step_spread_max calls was finished at a stretch
    device_lost = 1u << 12,  ///< the GPU failed, or memory did: nothing moves any more, and all
                             ///< that is read is 0
};

/// A status bit with what is known of it. There is one for each bit and body.
struct Condition {
    StatusBit bit{};
    int body = -1;  ///< SoilBody::id; -1: no single body's doing
    /// Where it was met, the first time that this was known, world axes: a body's centre of mass,
    /// or the centre of a voxel (its height to within 2, 4 ... voxels in grids of more than 2^31
    /// voxels). Empty: at no single place.
    std::optional<Vec3> position_m{};
    int64_t first_step = 0;   ///< soil step in which it was first met; the first step of all is 1
    double first_time_s = 0;  ///< the end of that step
    int64_t last_step = 0;    ///< in which it was last met
    int64_t step_count = 0;   ///< steps in which it was met
};

/// "tile_table_full".
std::string name_of(StatusBit bit);
/// What happened and what to do: "body_teleported: a body jumped; ...".
const char* text_of(StatusBit bit);
/// The text of each set bit.
std::vector<std::string> status_texts(uint32_t status_bits);
/// "body_teleported: a body jumped; ... [body 3, at (0.50, 0.20, 1.00) m, step 12, 0.200 s; in 4
/// steps, the last 20]". body_name stands in for "body 3".
std::string condition_text(const Condition& condition, const std::string& body_name = {});

}  // namespace bsoil
#pragma GCC visibility pop
