#include "soil/shape_upload.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "soil/shape_bounds.h"
#include "soil/slip_table.h"

namespace bsoil {

using namespace layout;

namespace {

// Words of Buffer::shapes that a soil starts with; it grows by doubling.
constexpr size_t kShapeWordsAtStart = 4096;

// What a body record takes: voxels and radians a base step, half voxels, a coefficient. Faster and
// farther bodies count as these; rougher ones than 2 do not exist.
constexpr double kLinearMost = 64;
constexpr double kAngularMost = 2;
constexpr double kCenterMost = 1e6;
constexpr double kFrictionMost = 2;

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

void ShapeUpload::start() { core_.ensure_capacity(Buffer::shapes, capacity_, kShapeWordsAtStart); }

void ShapeUpload::upload(std::span<const StepBody> bodies, std::span<const int> ids, double t) {
    core_.params.body_count = static_cast<int>(ids.size());
    core_.params.shape_offset = core_.params.body_count * kBodyWords;
    words_.assign(static_cast<size_t>(core_.params.shape_offset), 0);
    boxes_.clear();
    hulls_.clear();
    lattice_shapes_.clear();
    for (const StepBody& body : bodies) add_body(body);
    for (const StepBody& body : bodies) {
        const Pose pose = interpolate(body.from, body.to, t);
        for (const ConvexShape& shape : body.shapes()) add_shape(shape, pose, body.track->index);
    }
    for (const auto& [record, shape] : hulls_) add_planes(*shape, record);
    write_words(ids);
}

void ShapeUpload::add_body(const StepBody& body) {
    const SoilBody& in = *body.input;
    const SoilDef& def = core_.def;
    // What a body carries goes as far in this step as the body has gone since the last one.
    const double voxel_m = core_.frame.voxel_m, step_s = def.step_s * core_.due_count,
                 per_step = step_s / voxel_m;
    int32_t* record = &words_[static_cast<size_t>(body.track->index) * kBodyWords];
    if (!in.is_static) {
        const Quat& turn = core_.world_to_grid.rotation;
        const Vec3 linear = rotate(turn, in.linear_velocity_m_s) * per_step;
        const Vec3 angular = rotate(turn, in.angular_velocity_rad_s) * step_s;
        const Vec3 center = core_.to_grid(in.center_of_mass_m) * 2;
        const double linears[3] = {linear.x, linear.y, linear.z},
                     angulars[3] = {angular.x, angular.y, angular.z},
                     centers[3] = {center.x, center.y, center.z};
        for (int axis = 0; axis < 3; ++axis) {
            record[kBodyLinear + axis] = to_q16(linears[axis], kLinearMost);
            record[kBodyAngular + axis] = to_q16(angulars[axis], kAngularMost);
            record[kBodyCenter + axis] = static_cast<int32_t>(
                std::lround(std::clamp(centers[axis], -kCenterMost, kCenterMost)));
        }
        record[kBodyMoving] = 1;
        record[kBodyPacking] = static_cast<int32_t>(
            std::lround(relative_density_under(body.contact.pressure_pa) * kVoxelFull));
    }
    record[kBodyReach] = static_cast<int32_t>(
        std::lround(std::clamp(body.contact.width_m / 2 / voxel_m, 1.0, 1.0 * kBodyReachMost)));
    if (const auto place = small_body_place(core_, body)) record[kBodyPlace] = place->word;
    record[kBodyFriction] = in.surface.friction >= 0
                                ? friction_speed(std::min(in.surface.friction, kFrictionMost), def)
                                : kFrictionOfSoil;
}

void ShapeUpload::put_float(size_t at, double value) {
    words_[at] = std::bit_cast<int32_t>(static_cast<float>(value));
}

void ShapeUpload::add_shape(const ConvexShape& shape, const Pose& pose, int body_index) {
    const double voxel_m = core_.frame.voxel_m, inverse_voxel = 1 / voxel_m;
    const size_t record = words_.size();
    words_.resize(record + kShapeWords, 0);
    words_[record + kShapeKind] = static_cast<int32_t>(shape.kind);
    words_[record + kShapeBody] = body_index;
    const Pose from_grid = inverse(pose * shape.local);
    const Vec3 columns[3] = {rotate(from_grid.rotation, {1, 0, 0}),
                             rotate(from_grid.rotation, {0, 1, 0}),
                             rotate(from_grid.rotation, {0, 0, 1})};
    Vec3 offset = from_grid.position * inverse_voxel;
    double per_voxel = 1;
    if (shape.kind == ConvexShape::Kind::lattice) {
        // The rows of a lattice lead to its nodes.
        per_voxel = voxel_m / shape.lattice->spacing_m();
        offset = (from_grid.position - shape.lattice->origin()) * (1 / shape.lattice->spacing_m());
    }
    const double rows[12] = {
        columns[0].x * per_voxel, columns[1].x * per_voxel, columns[2].x * per_voxel, offset.x,
        columns[0].y * per_voxel, columns[1].y * per_voxel, columns[2].y * per_voxel, offset.y,
        columns[0].z * per_voxel, columns[1].z * per_voxel, columns[2].z * per_voxel, offset.z};
    for (size_t i = 0; i < 12; ++i) put_float(record + kShapeRows + i, rows[i]);
    add_size(shape, record);
    put_float(record + kShapeRounding, shape.rounding_m * inverse_voxel);
    if (shape.kind == ConvexShape::Kind::hull) {
        hulls_.push_back({record, &shape});
    } else if (shape.kind == ConvexShape::Kind::lattice) {
        lattice_shapes_.push_back({record, &shape});
    }
    boxes_.push_back(shape_bounds(shape, pose, voxel_m));
    put_voxel_bounds(shape, boxes_.back(), &words_[record]);
}

// Words kShapeHalfExtents to kShapeSizeEnd, by kind.
void ShapeUpload::add_size(const ConvexShape& shape, size_t record) {
    const double inverse_voxel = 1 / core_.frame.voxel_m;
    if (shape.kind == ConvexShape::Kind::box) {
        const Vec3 half_extents = shape.half_extents_m * inverse_voxel;
        put_float(record + kShapeHalfExtents, half_extents.x);
        put_float(record + kShapeHalfExtents + 1, half_extents.y);
        put_float(record + kShapeHalfExtents + 2, half_extents.z);
    } else if (shape.kind == ConvexShape::Kind::lattice) {
        put_float(record + kShapeLatticeUnit, shape.lattice->quantum_m() * inverse_voxel);
    } else {
        const double r = shape.radius_m * inverse_voxel, h = shape.half_height_m * inverse_voxel;
        put_float(record + kShapeRadius, r);
        put_float(record + kShapeHalfHeight, h);
        const double slant = std::sqrt(r * r + 4 * h * h);
        if (slant > 0) {
            put_float(record + kShapeSlantCosine, 2 * h / slant);
            put_float(record + kShapeSlantSine, r / slant);
        }
    }
}

void ShapeUpload::add_planes(const ConvexShape& shape, size_t record) {
    words_[record + kShapeFaces] = static_cast<int32_t>(words_.size());
    words_[record + kShapeFaceCount] = static_cast<int32_t>(shape.planes.size());
    for (const Plane& plane : shape.planes) {
        const size_t at = words_.size();
        words_.resize(at + kFaceWords);
        put_float(at + kFaceNormal, plane.normal.x);
        put_float(at + kFaceNormal + 1, plane.normal.y);
        put_float(at + kFaceNormal + 2, plane.normal.z);
        put_float(at + kFaceOffset, plane.offset * (1 / core_.frame.voxel_m));
    }
}

const ShapeUpload::LatticePlace* ShapeUpload::place_of(const ConvexShape& shape) const {
    const auto found =
        std::find_if(lattices_.begin(), lattices_.end(),
                     [&](const LatticePlace& place) { return place.lattice == shape.lattice; });
    return found == lattices_.end() ? nullptr : &*found;
}

// A shape stands in a box of its own frame, and a hull behind its faces; a lattice is not asked.
bool ShapeUpload::may_cover(size_t shape, const Vec3& block_middle) const {
    constexpr double kReach = 1;  // of a distance beyond a shape's surface: 0.775 in the kernel
    const int32_t* record =
        &words_[static_cast<size_t>(core_.params.shape_offset) + shape * kShapeWords];
    const auto kind = static_cast<ConvexShape::Kind>(record[kShapeKind]);
    const auto number = [&](int at) { return double{std::bit_cast<float>(record[at])}; };
    const double reach = number(kShapeRounding) + kReach;
    using Kind = ConvexShape::Kind;
    if (kind == Kind::lattice) return true;
    double middle[3];
    double half[3];  // the block's half extents along the shape's axes
    for (int i = 0; i < 3; ++i) {
        const int row = kShapeRows + kShapeRowWords * i;
        const Vec3 axis{number(row), number(row + 1), number(row + 2)};
        middle[i] = dot(axis, block_middle) + number(row + 3);
        half[i] = kTileSide / 2.0 * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
    }
    if (kind == Kind::hull) {
        // The block's corners along a face's normal, in the shape's frame.
        const auto column = [&](int axis) {
            const int at = kShapeRows + axis;
            return Vec3{number(at), number(at + kShapeRowWords), number(at + 2 * kShapeRowWords)};
        };
        const Vec3 columns[3] = {column(0), column(1), column(2)};
        for (int i = 0; i < record[kShapeFaceCount]; ++i) {
            const int32_t* face =
                &words_[static_cast<size_t>(record[kShapeFaces] + kFaceWords * i)];
            const auto word = [&](int at) { return double{std::bit_cast<float>(face[at])}; };
            const Vec3 normal{word(kFaceNormal), word(kFaceNormal + 1), word(kFaceNormal + 2)};
            const double side =
                dot(normal, Vec3{middle[0], middle[1], middle[2]}) - word(kFaceOffset);
            const double width = std::abs(dot(normal, columns[0])) +
                                 std::abs(dot(normal, columns[1])) +
                                 std::abs(dot(normal, columns[2]));
            if (side - kTileSide / 2.0 * width > reach) return false;
        }
        return true;
    }
    const double radius = number(kShapeRadius), half_height = number(kShapeHalfHeight);
    std::array<double, 3> extents{radius, radius, half_height};
    if (kind == Kind::box) {
        extents = {number(kShapeHalfExtents), number(kShapeHalfExtents + 1),
                   number(kShapeHalfExtents + 2)};
    } else if (kind == Kind::sphere) {
        extents[2] = radius;
    } else if (kind == Kind::capsule) {
        extents[2] = radius + half_height;
    }
    for (size_t i = 0; i < 3; ++i) {
        if (std::abs(middle[i]) - half[i] - extents[i] > reach) return false;
    }
    return true;
}

// Makes room for the words of this sub-step and for its lattices behind them; those of former steps
// that it does not need are dropped. False where the device has no memory for them.
bool ShapeUpload::place_lattices() {
    std::vector<LatticePlace> wanted;
    size_t capacity = capacity_;
    if (words_.size() > capacity) capacity = std::max(words_.size(), 2 * capacity);
    size_t end = capacity;
    for (const auto& entry : lattice_shapes_) {
        const auto& lattice = entry.second->lattice;
        const bool is_new = std::none_of(wanted.begin(), wanted.end(), [&](const auto& place) {
            return place.lattice == lattice;
        });
        if (is_new) {
            wanted.push_back({lattice, end});
            end += lattice->words().size();
        }
    }
    lattices_.clear();
    capacity_ = 0;
    if (end > INT32_MAX || !core_.device->allocate(Buffer::shapes, static_cast<int64_t>(end))) {
        return false;
    }
    capacity_ = capacity;
    lattices_ = std::move(wanted);
    for (const LatticePlace& place : lattices_) {
        core_.device->write(Buffer::shapes, static_cast<int64_t>(place.offset),
                            place.lattice->words());
    }
    return true;
}

void ShapeUpload::write_words(std::span<const int> ids) {
    const bool all_placed =
        std::all_of(lattice_shapes_.begin(), lattice_shapes_.end(),
                    [&](const auto& entry) { return place_of(*entry.second) != nullptr; });
    bool has_lattices = true;
    if (!all_placed || (words_.size() > capacity_ && !lattices_.empty())) {
        has_lattices = place_lattices();
    }
    if (!has_lattices) {
        // All of them are one that holds nothing.
        for (const auto& [record, shape] : lattice_shapes_) {
            core_.conditions.note(StatusBit::shape_refused,
                                  ids[static_cast<size_t>(words_[record + kShapeBody])]);
            words_[record + kShapeLattice] = static_cast<int32_t>(words_.size());
        }
        words_.resize(words_.size() + kLatticeIndex, 0);
    } else {
        for (const auto& [record, shape] : lattice_shapes_) {
            words_[record + kShapeLattice] = static_cast<int32_t>(place_of(*shape)->offset);
        }
    }
    core_.ensure_capacity(Buffer::shapes, capacity_, words_.size());
    core_.device->write(Buffer::shapes, 0, words_);
}

}  // namespace bsoil
