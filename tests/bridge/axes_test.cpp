// Worlds with Y up and with Z up.
#include <vector>

#include "test_box.h"

namespace bsoil::bullet::axes_test {
namespace {

/// From a Y-up world to the Z-up world whose soil has the same grid: the grid's x is the world's z
/// with Y up, and its x with Z up.
btVector3 turned(const btVector3& v, bool z_up) {
    return z_up ? btVector3(v.z(), v.x(), v.y()) : v;
}

TEST(Axes, y_up_and_z_up_give_the_same_soil) {
    uint64_t checksums[2];
    std::vector<double> heights[2];
    double forces_n[2];
    for (const bool z_up : {false, true}) {
        BulletScene scene;
        scene.world->setGravity(turned(btVector3(0, btScalar(-kGravity_m_s2), 0), z_up));
        SoilDef def = small_bed();
        def.size_m = {1.6, 1, 2};
        // Of fixed density: contact forces, reckoned in the body's axes, do not act back on it.
        def.material.loose_density_kg_m3 = def.material.compacted_density_kg_m3 = 0;
        if (z_up) {
            def.up = UpAxis::z;
            def.size_m = {2, 1.6, 1};
        }
        const auto soil = sand_bed(*scene.world, def);
        btRigidBody& box =
            scene.add_box(kMassKg, turned(btVector3(0.2f, 0.15f, 0.1f), z_up),
                          turned(btVector3(-0.1f, btScalar(kBedTopM) + 0.17f, 0.05f), z_up));
        // Kinematic: what Bullet rounds in a solve depends on the order of the axes.
        box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        box.setActivationState(DISABLE_DEACTIVATION);
        for (int frame = 1; frame <= 60; ++frame) {
            const btScalar t = btScalar(frame) / 64;
            // No multiples of a voxel's parts, which fall to either side by the last bit.
            place(box, turned(btVector3(-0.1237f + 0.2413f * t,
                                        btScalar(kBedTopM) + 0.1711f - 0.2419f * t, 0.0613f),
                              z_up));
            scene.run(1.0 / 60);
        }
        checksums[z_up] = soil->soil().checksum();
        forces_n[z_up] = length(soil->body_report(box).force_n);
        const int* size = soil->soil().frame().size;
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x) {
                heights[z_up].push_back(soil->soil().surface_height_m(x, y));
            }
        }
    }
    EXPECT_EQ(heights[0], heights[1]);
    EXPECT_EQ(checksums[0], checksums[1]);
    EXPECT_GT(forces_n[0], 100);
    EXPECT_NEAR(forces_n[0], forces_n[1], 1e-3 * forces_n[0]);
}

TEST(Axes, a_dropped_box_comes_to_the_same_rest_with_y_up_and_with_z_up) {
    double heights[2], lifts_n[2];
    for (const bool z_up : {false, true}) {
        BulletScene scene;
        scene.world->setGravity(turned(btVector3(0, btScalar(-kGravity_m_s2), 0), z_up));
        SoilDef def = small_bed();
        def.size_m = z_up ? Vec3{2, 2, 1} : Vec3{2, 1, 2};
        def.up = z_up ? UpAxis::z : UpAxis::y;
        const auto soil = sand_bed(*scene.world, def);
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, turned(kAbove, z_up));
        scene.run(3);
        heights[z_up] = static_cast<double>(box.getWorldTransform().getOrigin()[z_up ? 2 : 1]);
        const Vec3 force_n = soil->body_report(box).force_n;
        lifts_n[z_up] = z_up ? force_n.z : force_n.y;
    }
    EXPECT_NEAR(heights[0], heights[1], 1e-4);
    EXPECT_NEAR(lifts_n[0], lifts_n[1], 0.01 * kWeightN);
}

}  // namespace
}  // namespace bsoil::bullet::axes_test
