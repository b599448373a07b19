// The grid is no part of the physics: the same tool in the same bed feels the same newtons wherever
// the grid lies, however it is turned or mirrored, and however fine it is.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <span>

#include "bsoil/host/driven_body.h"

namespace bsoil::grid_invariance_test {
namespace {

/// Where the grid lies and how the world is looked at; the bed and the tool stay what they are.
struct View {
    double voxel_m = 0.04;
    Vec3 shift_voxels{};       ///< of the grid against bed and tool, along the floor
    double yaw_rad = 0;        ///< of the grid
    double turn_rad = 0;       ///< of bed and tool in the world, the grid with them not
    bool is_mirrored = false;  ///< bed and tool, left for right
    UpAxis up = UpAxis::z;
};

Quat about_z(double angle_rad) { return {0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)}; }

/// A tool that moves through dry sand, and the force on it, in the tool's own axes: x ahead, z up.
class DrivenTool {
  public:
    ConvexShape shape;
    double slant_rad = 0;  ///< of the shape, about up
    Vec3 start_m;          ///< of its centre above the bed's floor
    double bed_m = 0.32;
    Vec3 velocity_m_s;
    Vec3 angular_rad_s;
    double distance_m = 0.3;

    /// Mean over the last half of the way [N].
    Vec3 force_n(const View& view) const {
        SoilDef def;
        def.size_m = view.up == UpAxis::z ? Vec3{1.92, 1.92, 0.64} : Vec3{1.92, 0.64, 1.92};
        def.up = view.up;
        def.voxel_m = view.voxel_m;
        def.backend = Backend::cpu;
        const Frame frame(view);
        def.floor_center_m = frame.to_world(view.voxel_m * view.shift_voxels);
        def.yaw_rad = view.yaw_rad;
        // Its density does not change: what a step compacts decides the next one's force.
        def.material.loose_density_kg_m3 = def.material.compacted_density_kg_m3 = 0;
        auto soil = std::move(*Soil::create(def));
        // The bed fills the grid to a height: it has no sides but the grid's.
        const Vec3 high = frame.up * bed_m;
        EXPECT_TRUE(soil->fill(FunctionFill{[&](Vec3 p) { return dot(high - p, frame.up); }, ""}));
        DrivenBody forces(*soil);
        ConvexShape seen = shape;
        if (slant_rad != 0) {
            seen.local.rotation = about_z(view.is_mirrored ? -slant_rad : slant_rad);
        }
        const std::vector<ConvexShape> shapes{seen};
        SoilBody tool;
        tool.shapes = &shapes;
        const double step_s = def.step_s;
        const int steps = static_cast<int>(std::lround(distance_m / length(velocity_m_s) / step_s));
        Vec3 sum;
        for (int i = 0; i < steps; ++i) {
            const double t = (i + 1) * step_s;
            tool.pose.rotation = frame.rotation();
            tool.pose.position = frame.to_world(start_m + t * velocity_m_s);
            tool.center_of_mass_m = tool.pose.position;
            tool.linear_velocity_m_s = frame.to_world(velocity_m_s);
            tool.angular_velocity_rad_s = frame.turned(angular_rad_s);
            const StepReport report = soil->step({&tool, 1});
            const BodyContact contact = forces.advance(tool, report.contacts);
            if (i >= steps / 2) sum += frame.to_tool(contact.mobilized_force_n);
        }
        return sum * (1.0 / (steps - steps / 2));
    }

  private:
    /// From the tool's axes to the world's.
    struct Frame {
        Vec3 ahead, aside, up;
        bool mirrored;
        explicit Frame(const View& view) : mirrored(view.is_mirrored) {
            const double c = std::cos(view.turn_rad), s = std::sin(view.turn_rad);
            ahead = {c, s, 0};
            aside = Vec3{-s, c, 0} * (view.is_mirrored ? -1.0 : 1.0);
            up = {0, 0, 1};
            if (view.up == UpAxis::y) {
                for (Vec3* v : {&ahead, &aside, &up}) *v = {v->x, v->z, -v->y};
            }
        }
        Vec3 to_world(Vec3 p) const { return p.x * ahead + p.y * aside + p.z * up; }
        Vec3 to_tool(Vec3 f) const { return {dot(f, ahead), dot(f, aside), dot(f, up)}; }
        /// A turn is mirrored the other way round.
        Vec3 turned(Vec3 w) const { return to_world(w) * (mirrored ? -1.0 : 1.0); }
        /// The shapes look the same in a mirror: their frame may stay right-handed.
        Quat rotation() const {
            const Vec3 y = cross(up, ahead);
            const double m[3][3] = {
                {ahead.x, y.x, up.x}, {ahead.y, y.y, up.y}, {ahead.z, y.z, up.z}};
            const double w = std::sqrt(std::max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2;
            if (w > 1e-6) {
                return {(m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w),
                        (m[1][0] - m[0][1]) / (4 * w), w};
            }
            return about_z(std::numbers::pi);
        }
    };
};

/// Pushes soil ahead and, being slanted, aside.
DrivenTool blade() {
    DrivenTool tool;
    tool.shape.kind = ConvexShape::Kind::box;
    tool.shape.half_extents_m = {0.06, 0.24, 0.12};
    tool.slant_rad = 0.35;
    tool.start_m = {-0.4, 0, 0.32};  // 0.12 m deep
    tool.velocity_m_s = {0.3, 0, 0};
    tool.distance_m = 0.4;
    return tool;
}
/// Is pressed into the bed by 0.06 m.
DrivenTool plate() {
    DrivenTool tool;
    tool.shape.kind = ConvexShape::Kind::box;
    tool.shape.half_extents_m = {0.24, 0.16, 0.08};
    tool.start_m = {0, 0, 0.32 + 0.08};
    tool.velocity_m_s = {0, 0, -0.1};
    tool.distance_m = 0.06;
    return tool;
}
/// Rolls 0.08 m deep, at a slip of 0.2.
DrivenTool wheel() {
    DrivenTool tool;
    tool.shape.kind = ConvexShape::Kind::cylinder;
    tool.shape.radius_m = 0.25;
    tool.shape.half_height_m = 0.2;
    tool.shape.local.rotation = {std::sin(std::numbers::pi / 4), 0, 0,
                                 std::cos(std::numbers::pi / 4)};  // axle along y
    tool.start_m = {-0.4, 0, 0.32 + 0.17};                         // 0.08 m deep
    tool.velocity_m_s = {0.4, 0, 0};
    tool.angular_rad_s = {0, 0.4 / 0.25 / 0.8, 0};
    tool.distance_m = 0.5;
    return tool;
}

struct NamedView {
    const char* name;
    View view;
};

/// Views in which every voxel has a counterpart. Kernels are integers; what is left is the order in
/// which slippage takes the directions of the grid, and that a sum of floats is rounded otherwise.
const NamedView kSameGrid[] = {
    {"shifted by whole voxels", {.shift_voxels = {1, 2, 0}}},
    {"turned by 90 deg", {.turn_rad = std::numbers::pi / 2}},
    {"turned by 180 deg", {.turn_rad = std::numbers::pi}},
    {"mirrored", {.is_mirrored = true}},
    {"turned with its grid", {.yaw_rad = 0.7, .turn_rad = 0.7}},
    {"Y up", {.up = UpAxis::y}},
};
/// Views in which faces lie elsewhere in their voxels.
const NamedView kOtherGrid[] = {
    {"shifted by half a voxel", {.shift_voxels = {0.5, 0.5, 0}}},
    {"shifted anyhow", {.shift_voxels = {0.325, 0.775, 0}}},
    {"grid turned by 23 deg", {.yaw_rad = 0.4}},
    {"grid turned by 45 deg", {.yaw_rad = std::numbers::pi / 4}},
};

/// In voxels of `voxel_m` by each view, and where it is given in finer ones.
void expect_same_newtons(const DrivenTool& tool, double voxel_m, std::span<const NamedView> views,
                         double tolerance, double finer_voxel_m = 0) {
    const Vec3 expected_n = tool.force_n({.voxel_m = voxel_m});
    const auto expect = [&](const char* name, const View& view) {
        const Vec3 found_n = tool.force_n(view);
        const double error = length(found_n - expected_n) / length(expected_n);
        EXPECT_LT(error, tolerance) << name << ": " << found_n.x << " " << found_n.y << " "
                                    << found_n.z << " N, in the grid as it is " << expected_n.x
                                    << " " << expected_n.y << " " << expected_n.z;
    };
    for (NamedView named : views) {
        named.view.voxel_m = voxel_m;
        expect(named.name, named.view);
    }
    if (finer_voxel_m > 0) expect("finer", {.voxel_m = finer_voxel_m});
}

// Measured: 1.0, 0.1 and 0.1 %. A blade's heap slides by a voxel earlier or later.
TEST(GridInvariance, blade_in_the_same_grid) {
    expect_same_newtons(blade(), 0.04, kSameGrid, 0.02);
}
TEST(GridInvariance, plate_in_the_same_grid) {
    expect_same_newtons(plate(), 0.04, kSameGrid, 0.01);
}
TEST(GridInvariance, wheel_in_the_same_grid) {
    expect_same_newtons(wheel(), 0.04, kSameGrid, 0.01);
}

// The README promises a twentieth. Measured: 4.1, 3.8 and 4.6 %.
// 5.5 % in a grid turned by 45 deg, 5 in the others: the ground before a wall is averaged over a
// rectangle along the grid's axes, which reaches further to the sides of a heap there.
TEST(GridInvariance, blade_in_another_grid) {
    expect_same_newtons(blade(), 0.04, kOtherGrid, 0.06, 0.02);
}
TEST(GridInvariance, plate_in_another_grid) {
    expect_same_newtons(plate(), 0.04, kOtherGrid, 0.05, 0.02);
}
// At a given depth a wheel of 6 voxels' radius, 2 voxels deep, is borne by a tenth less than in
// finer grids (6,410 N in voxels of 4 cm, 7,093 / 7,126 / 7,320 in 2 / 1.6 / 1 cm): so from 2 cm
// on.
TEST(SlowGridInvariance, wheel_in_another_grid) {
    expect_same_newtons(wheel(), 0.02, kOtherGrid, 0.05, 0.016);
}

}  // namespace
}  // namespace bsoil::grid_invariance_test
