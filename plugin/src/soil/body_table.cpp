#include "soil/body_table.h"

#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"
#include "soil/shape_bounds.h"

namespace bsoil {

namespace {

// A body counts as still until it has moved this far since its coverage was last made [voxels]: a
// machine that rocks by micrometres on its tracks is not voxelized anew in every step. Well below
// what the contact forces resolve.
constexpr double kStillVoxels = 1.0 / 512;

// A body is cut into samples as in a grid with so many voxels at least along its shortest side, or
// its longest where that is more. Ours: two samples along the shortest, so that it stands on faces
// and not on points, and four along the longest. Larger: as many more contacts; smaller: a body
// balances on the middles of its faces.
constexpr double kCutVoxelsLeast = 2, kCutVoxelsMost = 4;

/// Of the box round all shapes.
struct Sizes {
    double smallest_m = 0, largest_m = 0;
    double cut_voxel_m() const {
        if (!(largest_m > 0)) return HUGE_VAL;
        return std::max(smallest_m / kCutVoxelsLeast, largest_m / kCutVoxelsMost);
    }
};

Sizes sizes_of(const std::vector<ConvexShape>& shapes) {
    Aabb box = shape_bounds(shapes.front(), Pose{}, 1);
    for (const ConvexShape& shape : shapes) box = merge(box, shape_bounds(shape, Pose{}, 1));
    const Vec3 sides = box.max - box.min;
    return {std::min({sides.x, sides.y, sides.z}), std::max({sides.x, sides.y, sides.z})};
}

}  // namespace

bool GivenBody::operator==(const GivenBody& o) const {
    const auto same = [](Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
    const Quat &a = pose.rotation, &b = o.pose.rotation;
    return same(pose.position, o.pose.position) && a.x == b.x && a.y == b.y && a.z == b.z &&
           a.w == b.w && same(linear_velocity_m_s, o.linear_velocity_m_s) &&
           same(angular_velocity_rad_s, o.angular_velocity_rad_s) &&
           same(center_of_mass_m, o.center_of_mass_m) && contact_width_m == o.contact_width_m;
}

std::optional<SmallBodyPlace> small_body_place(const SoilCore& core, const StepBody& body) {
    using namespace layout;
    if (!body.track->is_small || body.input->is_static) return {};
    const Vec3 at = core.to_grid(body.input->center_of_mass_m);
    const auto& size = core.frame.size;
    const bool is_inside =
        at.x >= 0 && at.x < size[0] && at.y >= 0 && at.y < size[1] && at.z >= 0 && at.z < size[2];
    if (!is_inside) return {};
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y), z = static_cast<int>(at.z);
    const int column = y % kTileSide * kTileSide + x % kTileSide;
    return SmallBodyPlace{core.tile_index(x / kTileSide, y / kTileSide),
                          1 + z * kTileColumns + column};
}

void BodyTable::meet(std::span<const SoilBody> input) {
    in_step_.clear();
    reach_voxels_ = 0;
    fastest_ = nullptr;
    are_same_ = true;
    known_contacts.keep_only(input);
    for (const SoilBody& body : input) {
        if (!accept(body)) continue;
        if (static_cast<int>(in_step_.size()) >= limits::kBodyCapacity) {
            core_.conditions.note(StatusBit::shape_refused, body.id, body.center_of_mass_m);
            break;
        }
        BodyTrack& track = tracks_[body.id];
        if (track.last_step == core_.step_index) {
            continue;  // the same id twice in one step: the first counts
        }
        const Pose to = core_.world_to_grid * body.pose;
        StepBody entry{&body, &track, to, to, true, true};
        make_shapes(track, body);
        if (track.index < 0) {
            track.index = take_index(body.id);
        } else if (track.shape_revision == body.shape_revision) {
            entry.from = track.pose;
            const double move = reach_of(entry);
            entry.moved = move > kStillVoxels;
            entry.placed = move > core_.def.substeps_max;
            if (!entry.moved) {
                entry.to = entry.from;
            } else if (move > core_.def.substeps_max) {
                core_.conditions.note(StatusBit::body_teleported, body.id, body.center_of_mass_m);
                entry.from = to;
            } else {
                fastest_ = move > reach_voxels_ ? &body : fastest_;
                reach_voxels_ = std::max(reach_voxels_, move);
            }
        }
        entry.contact = contact_of(body);
        const GivenBody given{body.pose, body.linear_velocity_m_s, body.angular_velocity_rad_s,
                              body.center_of_mass_m, entry.contact.width_m};
        are_same_ = are_same_ && !entry.moved && given == track.given;
        track.given = given;
        entry.turned_static = track.is_static != body.is_static;
        track.pose = entry.to;
        track.shape_revision = body.shape_revision;
        track.is_static = body.is_static;
        track.last_step = core_.step_index;
        if (!body.is_static && !body.may_leave && !core_.frame.is_above(body.center_of_mass_m)) {
            core_.conditions.note(StatusBit::body_outside_grid, body.id, body.center_of_mass_m);
        }
        in_step_.push_back(entry);
    }
}

void BodyTable::keep_given() {
    kept_.clear();
    kept_.reserve(in_step_.size());
    fastest_ = nullptr;
    for (StepBody& body : in_step_) {
        BodyTrack& track = *body.track;
        SoilBody& kept = kept_.emplace_back(*body.input);
        if (track.kept_shapes.empty() || track.kept_revision != kept.shape_revision) {
            track.kept_shapes = *kept.shapes;
            track.kept_revision = kept.shape_revision;
        }
        kept.shapes = &track.kept_shapes;
        body.input = &kept;
    }
}

// What the caller says, else what is known.
KnownContact BodyTable::contact_of(const SoilBody& body) const {
    KnownContact out = known_contacts.of(body.id);
    if (body.contact_width_m >= 0) out.width_m = body.contact_width_m;
    if (body.contact_pressure_pa >= 0) out.pressure_pa = body.contact_pressure_pa;
    return out;
}

bool BodyTable::any_moved() const {
    return std::ranges::any_of(in_step_, [](const StepBody& body) { return body.moved; });
}

BodyTrack& BodyTable::add(const SoilBody& body) {
    BodyTrack& track = tracks_[body.id];
    make_shapes(track, body);
    track.index = take_index(body.id);
    track.pose = core_.world_to_grid * body.pose;
    track.shape_revision = body.shape_revision;
    track.is_static = body.is_static;
    track.last_step = core_.step_index;
    return track;
}

// Of a body that is new, or whose shapes are.
void BodyTable::make_shapes(BodyTrack& track, const SoilBody& body) const {
    if (track.index < 0 || track.shape_revision != body.shape_revision ||
        track.walls.growth.size() != body.shapes->size()) {
        track.walls.make(*body.shapes, core_.frame.voxel_m);
        track.surface = {};
        track.is_small = make_small_surface(*body.shapes, track.surface);
    }
    if (core_.def.contact_law.faces_by_shape && !body.is_static && !track.surface.is_made) {
        track.surface.make(*body.shapes, track.walls.growth, core_.frame.voxel_m,
                           core_.def.contact_law.kind != ContactLawDef::Kind::bekker &&
                               core_.def.contact_law.trapped_soil,
                           sizes_of(*body.shapes).cut_voxel_m());
    }
}

// A small body's samples lie closer than the grid's: it has to stand on its faces, not on their
// middles. Walls grow for the soil's sake, which hardly sees a small body.
bool BodyTable::make_small_surface(const std::vector<ConvexShape>& shapes,
                                   SurfaceSamples& surface) const {
    const Sizes sizes = sizes_of(shapes);
    if (!(sizes.largest_m <= core_.frame.voxel_m)) return false;
    surface.make(shapes, std::vector<SheetGrowth>(shapes.size()), sizes.cut_voxel_m());
    if (!surface.is_whole) surface = {};
    return surface.is_whole;
}

bool BodyTable::accept(const SoilBody& body) {
    // A condition names a body that there can be.
    const int id = body.id >= 0 && body.id <= limits::kBodyIdMost ? body.id : -1;
    if (!is_rigid(body.pose) || !is_finite(body.linear_velocity_m_s) ||
        !is_finite(body.angular_velocity_rad_s) || !is_finite(body.center_of_mass_m) ||
        !std::isfinite(body.contact_pressure_pa) || !std::isfinite(body.contact_width_m)) {
        core_.conditions.note(
            StatusBit::pose_not_finite, id,
            is_finite(body.center_of_mass_m) ? std::optional(body.center_of_mass_m) : std::nullopt);
        return false;
    }
    if (!body.shapes || body.shapes->empty() || body.id < 0 || body.id > limits::kBodyIdMost ||
        !std::all_of(body.shapes->begin(), body.shapes->end(), is_valid_shape)) {
        core_.conditions.note(StatusBit::shape_refused, id, body.center_of_mass_m);
        return false;
    }
    return true;
}

int BodyTable::take_index(int id) {
    const auto free = std::find(ids_.begin(), ids_.end(), -1);
    if (free != ids_.end()) {
        *free = id;
        return static_cast<int>(free - ids_.begin());
    }
    if (ids_.size() >= limits::kBodyCapacity) return -1;
    ids_.push_back(id);
    return static_cast<int>(ids_.size()) - 1;
}

// Steps that a body's motion needs: no point of it may cross more than a voxel at once.
double BodyTable::reach_of(const StepBody& body) const {
    double reach = 0;
    for (const ConvexShape& shape : body.shapes()) {
        const Aabb a = shape_bounds(shape, body.from, core_.frame.voxel_m);
        const Aabb b = shape_bounds(shape, body.to, core_.frame.voxel_m);
        const double shifts[6] = {a.min.x - b.min.x, a.min.y - b.min.y, a.min.z - b.min.z,
                                  a.max.x - b.max.x, a.max.y - b.max.y, a.max.z - b.max.z};
        for (double shift : shifts) reach = std::max(reach, std::abs(shift));
    }
    return reach;
}

void BodyTable::restart(std::unordered_map<int, BodyTrack> tracks, std::vector<int> ids) {
    tracks_ = std::move(tracks);
    ids_ = std::move(ids);
}

}  // namespace bsoil
