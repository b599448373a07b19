// What the soil draws of itself in Bullet's debug drawing.
#include <LinearMath/btIDebugDraw.h>

#include "sand_bed.h"

namespace bsoil::bullet::debug_draw_test {
namespace {

struct Lines final : btIDebugDraw {
    struct Line {
        Vec3 from, to, color;
    };
    std::vector<Line> lines;
    int mode = 0;

    static Vec3 at(const btVector3& v) {
        return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
    }
    void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override {
        lines.push_back({at(from), at(to), at(color)});
    }
    void drawContactPoint(const btVector3&, const btVector3&, btScalar, int,
                          const btVector3&) override {}
    void reportErrorWarning(const char*) override {}
    void draw3dText(const btVector3&, const char*) override {}
    void setDebugMode(int m) override { mode = m; }
    int getDebugMode() const override { return mode; }
};

/// A box that rests on sand, over the corner where four tiles of 8 x 8 columns meet: those of the
/// grid's middle are from -0.2 to 0.2 m.
struct Bed {
    BulletScene scene;
    std::unique_ptr<SoilAction> soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f),
                                     btVector3(0.2f, btScalar(kBedTopM + 0.2), 0.2f));
    Bed() {
        for (int i = 0; i < 60; ++i) scene.world->stepSimulation(btScalar(1.0 / 60), 0);
    }
    std::vector<Lines::Line> drawn(int mode) {
        Lines drawer;
        drawer.mode = mode;
        soil->debugDraw(&drawer);
        return drawer.lines;
    }
};

TEST(DebugDraw, the_grid_is_a_box) {
    Bed bed;
    const auto lines = bed.drawn(btIDebugDraw::DBG_DrawAabb);
    ASSERT_EQ(lines.size(), 12u);
    for (const auto& line : lines) {
        for (const Vec3 end : {line.from, line.to}) {
            EXPECT_NEAR(std::abs(end.x), 1, 1e-6);
            EXPECT_NEAR(std::abs(end.z), 1, 1e-6);
            EXPECT_TRUE(std::abs(end.y) < 1e-6 || std::abs(end.y - 1.2) < 1e-6) << end.y;
        }
    }
}

TEST(DebugDraw, spans_of_columns_beside_a_body_end_at_the_surface) {
    Bed bed;
    const auto lines = bed.drawn(btIDebugDraw::DBG_DrawWireframe);
    // Those that it stands in; none far away are drawn.
    EXPECT_GE(lines.size(), 4 * 64u);
    EXPECT_LE(lines.size(), 9 * 64u);
    int at_surface = 0;
    for (const auto& line : lines) {
        EXPECT_NEAR(line.from.x, line.to.x, 1e-6);
        EXPECT_NEAR(line.from.z, line.to.z, 1e-6);
        at_surface += std::abs(line.to.y - kBedTopM) < 0.05;
    }
    EXPECT_GT(at_surface, 2 * 64);
}

TEST(DebugDraw, forces_add_up_to_the_weight_that_the_soil_bears) {
    Bed bed;
    const auto lines = bed.drawn(btIDebugDraw::DBG_DrawNormals);
    const size_t contacts = bed.soil->last_report().contacts.size();
    ASSERT_GT(contacts, 0u);
    ASSERT_GT(lines.size(), contacts);
    // Behind the contacts' normals: arrows of three lines, the longest ten voxels long.
    double longest_m = 0;
    Vec3 sum;
    for (size_t i = contacts; i < lines.size(); i += 3) {
        longest_m = std::max(longest_m, length(lines[i].to - lines[i].from));
        sum += lines[i].to - lines[i].from;
    }
    EXPECT_NEAR(longest_m, 10 * 0.05, 1e-6);
    EXPECT_GT(sum.y, 0.95 * length(sum));  // up
}

TEST(DebugDraw, a_driven_body_has_one_arrow_for_the_soils_whole_force) {
    Bed bed;
    bed.box.setCollisionFlags(bed.box.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    btTransform deeper = bed.box.getWorldTransform();
    for (int i = 0; i < 10; ++i) {
        deeper.getOrigin().setY(deeper.getOrigin().y() - btScalar(0.002));
        bed.box.setWorldTransform(deeper);
        bed.scene.world->stepSimulation(btScalar(1.0 / 60), 0);
    }
    const auto lines = bed.drawn(btIDebugDraw::DBG_DrawNormals);
    const size_t contacts = bed.soil->last_report().contacts.size();
    ASSERT_EQ(lines.size(), contacts + 3);
    const Vec3 way = lines[contacts].to - lines[contacts].from;
    const Vec3 force_n = bed.soil->body_report(bed.box).force_n;
    ASSERT_GT(force_n.y, 0);
    EXPECT_NEAR(length(way), 10 * 0.05, 1e-6);
    EXPECT_NEAR(dot(way, force_n), length(way) * length(force_n), 1e-4 * length(force_n));
    // It begins below the box, near its middle.
    EXPECT_LT(length(lines[contacts].from - Lines::at(deeper.getOrigin())), 0.1);
}

TEST(DebugDraw, nothing_is_drawn_without_a_mode_and_drawing_changes_nothing) {
    Bed bed, plain;
    EXPECT_TRUE(bed.drawn(0).empty());
    for (int i = 0; i < 30; ++i) {
        bed.drawn(btIDebugDraw::DBG_DrawAabb | btIDebugDraw::DBG_DrawWireframe |
                  btIDebugDraw::DBG_DrawNormals);
        bed.scene.world->stepSimulation(btScalar(1.0 / 60), 0);
        plain.scene.world->stepSimulation(btScalar(1.0 / 60), 0);
    }
    EXPECT_EQ(bed.soil->soil().checksum(), plain.soil->soil().checksum());
    EXPECT_EQ(height_of(bed.box), height_of(plain.box));
    bed.soil->debugDraw(nullptr);
}

}  // namespace
}  // namespace bsoil::bullet::debug_draw_test
