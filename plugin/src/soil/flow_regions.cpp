// Where sources, sinks and open sides lie in the grid.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/check_range.h"
#include "bsoil/limits.h"
#include "soil/flows.h"
#include "soil/shape_bounds.h"

namespace bsoil {

using namespace layout;

namespace {

// Voxels around a region whose centres are looked at: a second.
constexpr double kRegionVoxelsMost = 1 << 26;
constexpr size_t kRegionTilesMost = 1 << 16;

// A source lies so far on [voxels]: of two layers as near one is nearer.
constexpr double kAside = 1e-4;

/// Collects the voxels of a region.
class RegionBuilder {
  public:
    RegionBuilder(int tiles_x, FlowRegion& region) : tiles_x_(tiles_x), region_(region) {}

    /// The voxels low .. high - 1 of a column, tile by tile.
    void add(int x, int y, int low, int high) {
        if (low >= high) return;
        const int tile = y / kTileSide * tiles_x_ + x / kTileSide;
        if (region_.parts.empty() || region_.parts.back().tile != tile) {
            region_.parts.push_back({tile, low, high, {}, {}, 0});
        }
        FlowPart& part = region_.parts.back();
        part.low = std::min(part.low, low);
        part.high = std::max(part.high, high);
        const int column = y % kTileSide * kTileSide + x % kTileSide;
        part.columns[column] = low | high << 16;
        part.first[column] = static_cast<int32_t>(region_.voxel_count);
        region_.voxel_count += high - low;
    }

  private:
    int tiles_x_;
    FlowRegion& region_;
};

/// Along the world's axes.
Vec3 up_of(const SoilDef& def) { return def.up == UpAxis::y ? Vec3{0, 1, 0} : Vec3{0, 0, 1}; }

/// A source's frame: where its soil goes, its length and its width.
struct SourceFrame {
    Vec3 along, length, width;
};
SourceFrame frame_of(const SourceDef& source, Vec3 up) {
    SourceFrame frame;
    const double size = bsoil::length(source.direction);
    frame.along = size > 0 ? source.direction * (1 / size) : -up;
    Vec3 level = Vec3{1, 0, 0} - frame.along.x * frame.along;
    if (bsoil::length(level) < 1e-6) level = up - dot(up, frame.along) * frame.along;
    level = level * (1 / bsoil::length(level));
    const Vec3 across = cross(frame.along, level);
    const double c = std::cos(source.turn_rad), s = std::sin(source.turn_rad);
    frame.length = c * level + s * across;
    frame.width = cross(frame.along, frame.length);
    return frame;
}

/// A rotation that turns the axes x, y, z into a frame's.
Quat rotation_of(Vec3 x, Vec3 y, Vec3 z) {
    const double t = x.x + y.y + z.z;
    if (t > 0) {
        const double s = 2 * std::sqrt(1 + t);
        return {(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, s / 4};
    }
    if (x.x > y.y && x.x > z.z) {
        const double s = 2 * std::sqrt(1 + x.x - y.y - z.z);
        return {s / 4, (y.x + x.y) / s, (z.x + x.z) / s, (y.z - z.y) / s};
    }
    if (y.y > z.z) {
        const double s = 2 * std::sqrt(1 + y.y - x.x - z.z);
        return {(y.x + x.y) / s, s / 4, (z.y + y.z) / s, (z.x - x.z) / s};
    }
    const double s = 2 * std::sqrt(1 + z.z - x.x - y.y);
    return {(z.x + x.z) / s, (z.y + y.z) / s, s / 4, (x.y - y.x) / s};
}

/// How far a source's soil moves in a step [m].
double way_of(const SourceDef& source, const SoilDef& def) { return source.speed_m_s * def.step_s; }

}  // namespace

Status SourceDef::validate() const {
    for (const auto& [name, v] :
         {std::pair{"source.center_m", center_m}, std::pair{"source.direction", direction}}) {
        for (const double number : {v.x, v.y, v.z}) {
            if (Status status =
                    check_range(name, number, -limits::kPlaceMostM, limits::kPlaceMostM);
                !status) {
                return status;
            }
        }
    }
    if (shape != Shape::disc && shape != Shape::rectangle) {
        return check_range("source.shape", static_cast<int>(shape), 0, 1);
    }
    const bool is_disc = shape == Shape::disc;
    for (const Status& status :
         {is_disc ? check_range("source.radius_m", radius_m, 1e-4, 1e4) : Status{Done{}},
          is_disc ? Status{Done{}} : check_range("source.length_m", length_m, 1e-4, 1e4),
          is_disc ? Status{Done{}} : check_range("source.width_m", width_m, 1e-4, 1e4),
          check_range("source.turn_rad", turn_rad, -7, 7),
          check_range("source.speed_m_s", speed_m_s, 0, 100),
          check_range("source.spread_rad", spread_rad, 0, 1),
          check_range("source.rate_kg_s", rate_kg_s, 0, 1e9),
          check_range("source.rate_m3_s", rate_m3_s, 0, 1e6),
          check_range("source.start_s", start_s, 0, kFlowForever),
          check_range("source.end_s", end_s, start_s, kFlowForever)}) {
        if (!status) return status;
    }
    if ((rate_kg_s > 0) == (rate_m3_s > 0)) {
        return Error{fmt::format(
            "source.rate_kg_s is {} and source.rate_m3_s is {}: one of them must be above 0",
            rate_kg_s, rate_m3_s)};
    }
    return Done{};
}

Status SinkDef::validate() const {
    using Kind = ConvexShape::Kind;
    if (region.kind < Kind::box || region.kind > Kind::cone || !is_valid_shape(region)) {
        return Error{
            "sink.region must be a box, sphere, capsule, cylinder or cone with finite sizes above "
            "zero"};
    }
    if (!is_rigid(pose) || bsoil::length(pose.position) > limits::kPlaceMostM) {
        return Error{fmt::format("sink.pose must be finite, within {:g} m, and a rotation",
                                 limits::kPlaceMostM)};
    }
    if (rate_kg_s > 0 && water_kg_s != 0) {
        return Error{fmt::format(
            "sink.rate_kg_s is {} and sink.water_kg_s is {}: a sink takes soil or moves water; "
            "one of them must be 0",
            rate_kg_s, water_kg_s)};
    }
    for (const Status& status : {check_range("sink.rate_kg_s", rate_kg_s, 0, 1e9),
                                 check_range("sink.water_kg_s", water_kg_s, -1e9, 1e9),
                                 check_range("sink.start_s", start_s, 0, kFlowForever),
                                 check_range("sink.end_s", end_s, start_s, kFlowForever)}) {
        if (!status) return status;
    }
    return Done{};
}

// Voxels whose centres a convex shape holds, tile by tile.
Result<FlowRegion> Flows::find_region(const ConvexShape& shape, const Pose& pose) const {
    FlowRegion region;
    const Pose to_shape = inverse(core_.world_to_grid * pose * shape.local);
    const Aabb box = shape_bounds(shape, core_.world_to_grid * pose, core_.frame.voxel_m);
    if (box.max.x < 0 || box.max.y < 0 || box.max.z < 0 || box.min.x > core_.frame.size[0] ||
        box.min.y > core_.frame.size[1] || box.min.z > core_.frame.size[2]) {
        return region;
    }
    const int x0 = clamped_floor(box.min.x, 0, core_.frame.size[0] - 1),
              x1 = clamped_floor(box.max.x, 0, core_.frame.size[0] - 1),
              y0 = clamped_floor(box.min.y, 0, core_.frame.size[1] - 1),
              y1 = clamped_floor(box.max.y, 0, core_.frame.size[1] - 1),
              z0 = clamped_floor(box.min.z, 0, core_.height - 1),
              z1 = clamped_floor(box.max.z, 0, core_.height - 1);
    const double voxels = (x1 - x0 + 1.0) * (y1 - y0 + 1.0) * (z1 - z0 + 1.0);
    if (voxels > kRegionVoxelsMost) {
        return Error{fmt::format("its region's box has {:.3g} voxels, at most {:.3g} are possible",
                                 voxels, kRegionVoxelsMost)};
    }
    RegionBuilder builder(core_.tiles_x, region);
    for (int ty = y0 / kTileSide; ty <= y1 / kTileSide; ++ty) {
        for (int tx = x0 / kTileSide; tx <= x1 / kTileSide; ++tx) {
            for (int c = 0; c < kTileColumns; ++c) {
                const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
                if (x < x0 || x > x1 || y < y0 || y > y1) continue;
                const auto is_inside = [&](int z) {
                    return contains(shape, transform(to_shape, Vec3{x + 0.5, y + 0.5, z + 0.5} *
                                                                   core_.frame.voxel_m));
                };
                int low = z0, high = z1 + 1;
                while (low < high && !is_inside(low)) ++low;
                while (low < high && !is_inside(high - 1)) --high;
                builder.add(x, y, low, high);
            }
            if (region.parts.size() > kRegionTilesMost) {
                return Error{
                    fmt::format("its region lies in more than {} tiles of 8 x 8 columns; make "
                                "several of it",
                                kRegionTilesMost)};
            }
        }
    }
    return region;
}

// The voxels that a source's soil crosses in a step, at least one thick.
Result<FlowRegion> Flows::find_source_region(const SourceDef& source) const {
    const SourceFrame axes = frame_of(source, up_of(core_.def));
    const double voxel_m = core_.frame.voxel_m;
    const double way_m = way_of(source, core_.def), thick_m = std::max(way_m, voxel_m);
    ConvexShape slab;
    if (source.shape == SourceDef::Shape::disc) {
        slab.kind = ConvexShape::Kind::cylinder;
        slab.radius_m = source.radius_m;
        slab.half_height_m = thick_m / 2;
    } else {
        slab.half_extents_m = {source.length_m / 2, source.width_m / 2, thick_m / 2};
    }
    const double on_m = std::max(0.0, way_m - voxel_m) / 2 + kAside * voxel_m;
    const Vec3 middle = source.center_m + on_m * axes.along;
    const Quat rotation = rotation_of(axes.length, axes.width, axes.along);
    Result<FlowRegion> region = find_region(slab, {middle, rotation});
    if (!region || region->voxel_count > 0) return region;
    // Thinner than a voxel: the one that it lies in.
    const Vec3 at = core_.to_grid(source.center_m);
    const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y)),
              z = static_cast<int>(std::floor(at.z));
    if (x >= 0 && y >= 0 && z >= 0 && x < core_.frame.size[0] && y < core_.frame.size[1] &&
        z < core_.height) {
        RegionBuilder(core_.tiles_x, *region).add(x, y, z, z + 1);
    }
    return region;
}

// Everything of a flow that follows from its definition and the grid.
Status Flows::place(Flow& flow) const {
    const bool is_source = flow.kind == FlowKind::source;
    if (Status status = is_source ? flow.source.validate() : flow.sink.validate(); !status) {
        return status;
    }
    const bool is_well = flow.kind == FlowKind::well;
    if (!is_source && is_well != (flow.sink.water_kg_s != 0)) {
        return Error{"a well moves water, another sink none; remove it and add the other kind"};
    }
    if (is_well && core_.params.water_count == 0) {
        return Error{fmt::format(
            "sink.water_kg_s is {}, but pore_water_fraction is 0 in all materials of this soil; "
            "give one of them some",
            flow.sink.water_kg_s)};
    }
    const char* what = is_source ? "source" : "sink";
    auto region =
        is_source ? find_source_region(flow.source) : find_region(flow.sink.region, flow.sink.pose);
    if (!region) return Error{fmt::format("{}: {}", what, region.error())};
    if (region->voxel_count == 0) {
        return Error{
            fmt::format("{}: no voxel of the grid has its centre in the region; move it, "
                        "or make it larger",
                        what)};
    }
    flow.region = std::move(*region);
    std::ranges::fill(flow.words, 0);
    if (!is_source) {
        const double water_kg_s = flow.sink.water_kg_s;
        flow.units_per_s = (is_well ? std::abs(water_kg_s) * kWaterParts : flow.sink.rate_kg_s) /
                           core_.kg_per_unit;
        flow.words[kFlowWell] = !is_well ? 0 : water_kg_s > 0 ? -1 : 1;
        return Done{};
    }
    const SourceDef& source = flow.source;
    const auto named = std::ranges::find_if(
        core_.materials, [&](const MaterialDef& m) { return m.name == source.material; });
    if (named == core_.materials.end() && !source.material.empty()) {
        return Error{fmt::format("source.material '{}' is not in this soil; name one of its own",
                                 source.material)};
    }
    flow.material = source.material.empty() ? 0 : static_cast<int>(named - core_.materials.begin());
    const MaterialDef& soil = core_.materials[static_cast<size_t>(flow.material)];
    const double density = soil.has_density_range() ? soil.loose_density_kg_m3 : soil.density_kg_m3;
    flow.units_per_s =
        (source.rate_kg_s > 0 ? source.rate_kg_s : source.rate_m3_s * density) / core_.kg_per_unit;
    if (flow.region.voxel_count > kFlowVoxelsMost) {
        return Error{
            fmt::format("source: its region has {} voxels, at most {} are possible: make "
                        "several of it",
                        flow.region.voxel_count, kFlowVoxelsMost)};
    }
    const double way_voxels = way_of(source, core_.def) / core_.frame.voxel_m;
    if (way_voxels > kFlowSpeedMost / kVelocityOne) {
        return Error{fmt::format(
            "source.speed_m_s is {}, must be at most {:g} ({} voxels a step)", source.speed_m_s,
            kFlowSpeedMost / kVelocityOne * core_.frame.voxel_m / core_.def.step_s,
            kFlowSpeedMost / kVelocityOne)};
    }
    const double room_kg =
        static_cast<double>(flow.region.voxel_count) * std::pow(core_.frame.voxel_m, 3) * density;
    if (flow.units_per_s * core_.kg_per_unit * core_.def.step_s > room_kg) {
        return Error{fmt::format(
            "source: its rate of {:g} kg/s is more than {:g} kg/s, which fill its region in every "
            "step; enlarge it, or pour faster",
            flow.units_per_s * core_.kg_per_unit, room_kg / core_.def.step_s)};
    }
    const auto count = static_cast<int>(flow.region.voxel_count);
    int stride = std::max(1, static_cast<int>(count * (std::numbers::phi - 1)));
    while (std::gcd(stride, count) != 1) ++stride;
    flow.words[kFlowPlane] = kPlaneMaterial + flow.material;
    flow.words[kFlowCount] = count;
    flow.words[kFlowStride] = stride;
    flow.words[kFlowVolume] =
        static_cast<int32_t>(std::lround(kReferenceDensity / density * kVoxelFull));
    flow.words[kFlowWater] = static_cast<int32_t>(
        std::lround(soil.placed_saturation * soil.pore_water_fraction * kWaterParts * kVoxelFull));
    const SourceFrame axes = frame_of(source, up_of(core_.def));
    const double aside = way_voxels * std::tan(source.spread_rad);
    const std::pair<Vec3, double> velocities[] = {
        {axes.along, way_voxels}, {axes.length, aside}, {axes.width, aside}};
    for (size_t i = 0; i < 3; ++i) {
        const Vec3 v = rotate(core_.world_to_grid.rotation, velocities[i].first) *
                       velocities[i].second * kVelocityOne;
        const double axis[] = {v.x, v.y, v.z};
        for (size_t a = 0; a < 3; ++a) {
            flow.words[kFlowVelocity + 3 * i + a] = static_cast<int32_t>(std::lround(axis[a]));
        }
    }
    return Done{};
}

// The outermost columns along each open side.
void Flows::open_sides() {
    const bool y_up = core_.def.up == UpAxis::y;
    for (int bit = 1; bit <= kOpenSideLast; bit <<= 1) {
        if ((core_.def.open_sides & bit) == 0) continue;
        const int world_axis = std::countr_zero(static_cast<unsigned>(bit)) / 2;
        // Grid x, y, z are world Z, X, Y when Y is up.
        const int axis = y_up ? (world_axis + 1) % 3 : world_axis;
        const bool is_high = std::countr_zero(static_cast<unsigned>(bit)) % 2 == 1;
        Flow& flow = all_.emplace_back();
        flow.id = bit;
        flow.kind = FlowKind::open_side;
        RegionBuilder builder(core_.tiles_x, flow.region);
        const int at = is_high ? core_.frame.size[axis] - 1 : 0;
        for (int i = 0; i < core_.frame.size[1 - axis]; ++i) {
            builder.add(axis == 0 ? at : i, axis == 0 ? i : at, 0, core_.height);
        }
    }
}

}  // namespace bsoil
