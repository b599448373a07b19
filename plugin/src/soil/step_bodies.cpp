// The bodies of a step: which take part, and what the device is told of their shapes.
#include <algorithm>
#include <bit>
#include <cmath>

#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;

namespace {

int32_t to_q16(double value, double limit) {
    return static_cast<int32_t>(std::lround(std::clamp(value, -limit, limit) * 65536));
}

Pose interpolate(const Pose& a, const Pose& b, double t) {
    Quat q = b.rotation;
    if (a.rotation.x * q.x + a.rotation.y * q.y + a.rotation.z * q.z + a.rotation.w * q.w < 0) {
        q = {-q.x, -q.y, -q.z, -q.w};
    }
    // Sub-steps turn by little: the normalized chord follows the arc.
    Quat r{a.rotation.x + (q.x - a.rotation.x) * t, a.rotation.y + (q.y - a.rotation.y) * t,
           a.rotation.z + (q.z - a.rotation.z) * t, a.rotation.w + (q.w - a.rotation.w) * t};
    const double n = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
    return {a.position + (b.position - a.position) * t, {r.x / n, r.y / n, r.z / n, r.w / n}};
}

/// Which voxels the shape may cover. A distance counts up to 1/8 voxel beyond its sub-cell's
/// middle, which is 3/8 from the voxel's along each axis. What is sharp is further off its corner
/// than off its faces: there all voxels count.
void put_voxel_bounds(const ConvexShape& shape, const Aabb& box, int32_t* record) {
    using Kind = ConvexShape::Kind;
    constexpr double kReach = 1.5;
    constexpr int kFar = 1 << 20;
    const bool is_blunt = shape.kind == Kind::box || shape.kind == Kind::sphere ||
                          shape.kind == Kind::capsule || shape.kind == Kind::cylinder;
    const double low[3] = {box.min.x, box.min.y, box.min.z};
    const double high[3] = {box.max.x, box.max.y, box.max.z};
    for (int axis = 0; axis < 3; ++axis) {
        record[kShapeLow + axis] =
            is_blunt ? clamped_floor(low[axis] - kReach, -kFar, kFar) : -kFar;
        record[kShapeHigh + axis] =
            is_blunt ? clamped_floor(high[axis] + kReach, -kFar, kFar) : kFar;
    }
}

}  // namespace

// Body and shape records for the bodies at share t of the step.
void Soil::Impl::upload_bodies(std::span<const StepBody> step_bodies, double t) {
    const int body_count = static_cast<int>(body_ids.size());
    params.body_count = body_count;
    params.shape_offset = body_count * kBodyWords;
    shape_words.assign(static_cast<size_t>(params.shape_offset), 0);
    body_width_voxels.assign(static_cast<size_t>(body_count), 0);
    const double per_step = def.step_s / frame.voxel_m;
    for (const StepBody& body : step_bodies) {
        const SoilBody& in = *body.input;
        int32_t* record = &shape_words[static_cast<size_t>(body.track->index) * kBodyWords];
        if (!in.is_static) {
            const Vec3 linear = rotate(world_to_grid.rotation, in.linear_velocity_m_s) * per_step;
            const Vec3 angular =
                rotate(world_to_grid.rotation, in.angular_velocity_rad_s) * def.step_s;
            const Vec3 center = to_grid(in.center_of_mass_m) * 2;
            const double components[9] = {linear.x,  linear.y, linear.z, angular.x, angular.y,
                                          angular.z, center.x, center.y, center.z};
            for (int i = 0; i < 6; ++i) {
                record[kBodyLinear + i] = to_q16(components[i], i < 3 ? 64 : 2);
            }
            for (int i = 6; i < 9; ++i) {
                record[kBodyLinear + i] =
                    static_cast<int32_t>(std::lround(std::clamp(components[i], -1e6, 1e6)));
            }
            record[kBodyMoving] = 1;
            record[kBodyPacking] = static_cast<int32_t>(
                std::lround(relative_density_under(in.contact_pressure_pa) * kVoxelFull));
        }
        body_width_voxels[static_cast<size_t>(body.track->index)] =
            std::max(0.0, in.contact_width_m) / frame.voxel_m;
        record[kBodyReach] = static_cast<int32_t>(std::lround(
            std::clamp(in.contact_width_m / 2 / frame.voxel_m, 1.0, 1.0 * kBodyReachMost)));
        record[kBodyFriction] = static_cast<int32_t>(
            std::lround((in.surface.friction >= 0 ? std::min(in.surface.friction, 2.0)
                                                  : materials[0].tool_friction) *
                        def.gravity_m_s2 * def.step_s * per_step * kVelocityOne));
    }
    const auto put_float = [&](size_t at, double value) {
        shape_words[at] = std::bit_cast<int32_t>(static_cast<float>(value));
    };
    shape_boxes.clear();
    const double inverse_voxel = 1 / frame.voxel_m;
    std::vector<std::pair<size_t, const ConvexShape*>>& hulls = hull_scratch;
    hulls.clear();
    lattice_scratch.clear();
    for (const StepBody& body : step_bodies) {
        const Pose pose = interpolate(body.from, body.to, t);
        for (const ConvexShape& shape : body.shapes()) {
            const size_t record = shape_words.size();
            shape_words.resize(record + kShapeWords, 0);
            shape_words[record + kShapeKind] = static_cast<int32_t>(shape.kind);
            shape_words[record + kShapeBody] = body.track->index;
            const Pose to_grid_m = pose * shape.local;
            const Pose from_grid = inverse(to_grid_m);
            const Vec3 columns[3] = {rotate(from_grid.rotation, {1, 0, 0}),
                                     rotate(from_grid.rotation, {0, 1, 0}),
                                     rotate(from_grid.rotation, {0, 0, 1})};
            Vec3 offset = from_grid.position * inverse_voxel;
            double per_voxel = 1;
            if (shape.kind == ConvexShape::Kind::lattice) {
                // The rows of a lattice lead to its nodes.
                per_voxel = frame.voxel_m / shape.lattice->spacing_m();
                offset = (from_grid.position - shape.lattice->origin()) *
                         (1 / shape.lattice->spacing_m());
            }
            const double rows[12] = {columns[0].x * per_voxel, columns[1].x * per_voxel,
                                     columns[2].x * per_voxel, offset.x,
                                     columns[0].y * per_voxel, columns[1].y * per_voxel,
                                     columns[2].y * per_voxel, offset.y,
                                     columns[0].z * per_voxel, columns[1].z * per_voxel,
                                     columns[2].z * per_voxel, offset.z};
            for (size_t i = 0; i < 12; ++i) {
                put_float(record + kShapeRows + i, rows[i]);
            }
            const double r = shape.radius_m * inverse_voxel,
                         h = shape.half_height_m * inverse_voxel;
            const size_t size = record + kShapeSize;
            if (shape.kind == ConvexShape::Kind::box) {
                put_float(size, shape.half_extents_m.x * inverse_voxel);
                put_float(size + 1, shape.half_extents_m.y * inverse_voxel);
                put_float(size + 2, shape.half_extents_m.z * inverse_voxel);
            } else if (shape.kind == ConvexShape::Kind::lattice) {
                put_float(size, shape.lattice->quantum_m() * inverse_voxel);
                lattice_scratch.push_back({record, &shape});
            } else {
                put_float(size, r);
                put_float(size + 1, h);
                const double slant = std::sqrt(r * r + 4 * h * h);
                if (slant > 0) {
                    put_float(size + 2, 2 * h / slant);
                    put_float(size + 3, r / slant);
                }
            }
            put_float(record + kShapeRounding, shape.rounding_m * inverse_voxel);
            if (shape.kind == ConvexShape::Kind::hull) {
                hulls.push_back({record, &shape});
            }
            shape_boxes.push_back({shape_bounds(shape, pose, frame.voxel_m)});
            put_voxel_bounds(shape, shape_boxes.back(), &shape_words[record]);
        }
    }
    for (const auto& [record, shape] : hulls) {
        shape_words[record + kShapePlanes] = static_cast<int32_t>(shape_words.size());
        shape_words[record + kShapePlanes + 1] = static_cast<int32_t>(shape->planes.size());
        for (const Plane& plane : shape->planes) {
            const size_t at = shape_words.size();
            shape_words.resize(at + kFaceWords);
            put_float(at, plane.normal.x);
            put_float(at + 1, plane.normal.y);
            put_float(at + 2, plane.normal.z);
            put_float(at + 3, plane.offset * inverse_voxel);
        }
    }
    upload_shapes();
}

const Soil::Impl::LatticePlace* Soil::Impl::place_of(const ConvexShape& shape) const {
    const auto found =
        std::find_if(lattices.begin(), lattices.end(),
                     [&](const LatticePlace& place) { return place.lattice == shape.lattice; });
    return found == lattices.end() ? nullptr : &*found;
}

// Makes room for the words of this sub-step and for its lattices behind them; those of former steps
// that it does not need are dropped. False where the device has no memory for them.
bool Soil::Impl::place_lattices() {
    std::vector<LatticePlace> wanted;
    size_t capacity = shapes_capacity;
    if (shape_words.size() > capacity) {
        capacity = std::max(shape_words.size(), 2 * capacity);
    }
    size_t end = capacity;
    for (const auto& entry : lattice_scratch) {
        const auto& lattice = entry.second->lattice;
        const bool is_new = std::none_of(wanted.begin(), wanted.end(), [&](const auto& place) {
            return place.lattice == lattice;
        });
        if (is_new) {
            wanted.push_back({lattice, end});
            end += lattice->words().size();
        }
    }
    lattices.clear();
    shapes_capacity = 0;
    if (end > INT32_MAX || !device->allocate(Buffer::shapes, static_cast<int64_t>(end))) {
        return false;
    }
    shapes_capacity = capacity;
    lattices = std::move(wanted);
    for (const LatticePlace& place : lattices) {
        device->write(Buffer::shapes, static_cast<int64_t>(place.offset), place.lattice->words());
    }
    return true;
}

void Soil::Impl::upload_shapes() {
    const bool all_placed =
        std::all_of(lattice_scratch.begin(), lattice_scratch.end(),
                    [&](const auto& entry) { return place_of(*entry.second) != nullptr; });
    bool has_lattices = true;
    if (!all_placed || (shape_words.size() > shapes_capacity && !lattices.empty())) {
        has_lattices = place_lattices();
    }
    if (!has_lattices) {
        // All of them are one that holds nothing.
        for (const auto& [record, shape] : lattice_scratch) {
            conditions.note(StatusBit::shape_refused,
                            body_ids[static_cast<size_t>(shape_words[record + kShapeBody])]);
            shape_words[record + kShapeLattice] = static_cast<int32_t>(shape_words.size());
        }
        shape_words.resize(shape_words.size() + kLatticeIndex, 0);
    } else {
        for (const auto& [record, shape] : lattice_scratch) {
            shape_words[record + kShapeLattice] = static_cast<int32_t>(place_of(*shape)->offset);
        }
    }
    ensure_capacity(Buffer::shapes, shapes_capacity, shape_words.size());
    device->write(Buffer::shapes, 0, shape_words);
}

void Soil::Impl::ensure_capacity(device::BufferIndex buffer, size_t& capacity, size_t words) {
    if (words > capacity) {
        capacity = std::max(words, 2 * capacity);
        // Growing a small buffer can only fail when the host is out of memory; then the next step
        // finds it empty.
        if (!device->allocate(buffer, static_cast<int64_t>(capacity))) {
            conditions.note(StatusBit::tile_table_full);
            capacity = 0;
        }
    }
}

bool Soil::Impl::accept_body(const SoilBody& body) {
    if (!is_finite(body.pose) || !is_finite(body.linear_velocity_m_s) ||
        !is_finite(body.angular_velocity_rad_s) || !is_finite(body.center_of_mass_m) ||
        !std::isfinite(body.contact_pressure_pa) || !std::isfinite(body.contact_width_m)) {
        conditions.note(
            StatusBit::pose_not_finite, body.id,
            is_finite(body.center_of_mass_m) ? std::optional(body.center_of_mass_m) : std::nullopt);
        return false;
    }
    if (!body.shapes || body.shapes->empty() || body.id < 0 || body.id > 65534 ||
        !std::all_of(body.shapes->begin(), body.shapes->end(), is_valid_shape)) {
        conditions.note(StatusBit::shape_refused, std::max(-1, body.id), body.center_of_mass_m);
        return false;
    }
    return true;
}

int Soil::Impl::take_body_index(int id) {
    const auto free = std::find(body_ids.begin(), body_ids.end(), -1);
    if (free != body_ids.end()) {
        *free = id;
        return static_cast<int>(free - body_ids.begin());
    }
    body_ids.push_back(id);
    return static_cast<int>(body_ids.size()) - 1;
}

// Steps that a body's motion needs: no point of it may cross more than a voxel at once.
double Soil::Impl::body_reach_voxels(const StepBody& body) const {
    double reach = 0;
    for (const ConvexShape& shape : body.shapes()) {
        const Aabb a = shape_bounds(shape, body.from, frame.voxel_m);
        const Aabb b = shape_bounds(shape, body.to, frame.voxel_m);
        const double shifts[6] = {a.min.x - b.min.x, a.min.y - b.min.y, a.min.z - b.min.z,
                                  a.max.x - b.max.x, a.max.y - b.max.y, a.max.z - b.max.z};
        for (double shift : shifts) {
            reach = std::max(reach, std::abs(shift));
        }
    }
    return reach;
}

}  // namespace bsoil
