// Bodies of a few voxels on the soil's ground, as Bullet's own contacts have them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/host/ground_surface.h"
#include "bullet_scene.h"
#include "bullet_types.h"
#include "ground_shape.h"

namespace bsoil::bullet::small_debris_test {
namespace {

constexpr double kVoxelM = 0.008;

/// A bed of 0.4 m up to y = 0.04 m, and a post of 2 x 2 columns in its middle, up to 0.056 m.
struct Bed {
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    explicit Bed(bool has_lump) {
        SoilDef def;
        def.size_m = {0.4, 0.16, 0.4};
        def.voxel_m = kVoxelM;
        def.backend = Backend::cpu;
        auto made = SoilAction::create(*scene.world, def);
        EXPECT_TRUE(made) << made.error();
        soil = std::move(*made);
        if (has_lump) {
            EXPECT_TRUE(soil->soil().add_terrain([](Vec3 p) {
                return 0.008 - std::max({std::abs(p.x), std::abs(p.z), p.y - 0.048});
            }));
        }
        EXPECT_TRUE(soil->fill(BoxFill{{{-1, 0, -1}, {1, 0.04, 1}}, "dry_sand"}));
    }
    btRigidBody& add(btCollisionShape& shape, const btTransform& pose) {
        btRigidBody& body = scene.add(0.2f, shape, pose.getOrigin());
        EXPECT_TRUE(soil->set_options(body, {.ignored = true}));
        body.setWorldTransform(pose);
        body.setInterpolationWorldTransform(pose);
        return body;
    }
};

/// Four corners of a cube: sharp edges, and an edge that is as long as the body.
btConvexHullShape& tetrahedron(BulletScene& scene, btScalar half_m, btScalar margin_m) {
    auto& shape = static_cast<btConvexHullShape&>(scene.shape<btConvexHullShape>());
    shape.setMargin(margin_m);
    for (const btVector3& p :
         {btVector3(-1, -1, 1), btVector3(1, -1, -1), btVector3(-1, 1, -1), btVector3(1, 1, 1)}) {
        shape.addPoint(half_m * p);
    }
    return shape;
}

// An arm of 3 cm, times a friction of 0.5, holds a cube of 5 cm that leans by 25 degrees: Bullet
// let it stand, and creep about on its edge.
TEST(SmallDebris, does_not_stand_on_its_edges) {
    Bed bed(false);
    // Its middle is 12.1 mm beside the edge: 35.4 mm times the cosine of 70 degrees. The arm is
    // half of 0.3 of 43.3 mm: 6.5 mm.
    btTransform pose(btQuaternion(btVector3(0, 0, 1), btScalar(25 * std::numbers::pi / 180)),
                     btVector3(0.053f, 0.0733f, 0.013f));
    btRigidBody& cube =
        bed.add(bed.scene.shape<btBoxShape>(btVector3(0.025f, 0.025f, 0.025f)), pose);
    bed.scene.run(0.5, 4);
    EXPECT_NEAR(cube.getWorldTransform().getOrigin().y(), 0.065, 1e-3);
    EXPECT_NEAR(std::abs(cube.getWorldTransform().getBasis()[1].y()), 1, 1e-3);
    bed.soil->ground()->setRollingFriction(0.5f);
    bed.scene.run(0.1);
    EXPECT_EQ(bed.soil->ground()->getRollingFriction(), 0.5f) << "what the host sets stays";
}

// With a post below its box it lay on a pick of small triangles, another one in each step, and was
// pushed into the soil by some: one of these was awake after 10 s.
TEST(SmallDebris, comes_to_rest_beside_a_post) {
    for (int i = 0; i < 12; ++i) {
        Bed bed(true);
        const btQuaternion turn(btVector3(1, btScalar(0.3 * i), 0.5f).normalized(), btScalar(i));
        const btVector3 place(btScalar(0.04 * std::cos(i)), 0.08f, btScalar(0.04 * std::sin(i)));
        const btRigidBody& body =
            bed.add(tetrahedron(bed.scene, 0.0230748f, 0.00084f), btTransform(turn, place));
        bed.scene.run(7.5, 2);
        EXPECT_FALSE(body.isActive()) << i;
    }
}

struct Count final : btTriangleCallback {
    int triangles = 0;
    double area_m2 = 0;  ///< as seen from above
    void processTriangle(btVector3* p, int, int) override {
        ++triangles;
        area_m2 += 0.5 * static_cast<double>((p[1] - p[0]).cross(p[2] - p[0]).z());
    }
};

// 16 x 16 cells, and the lump in a corner of them: halves of what is left are plane, down to some
// 4 x 4 cells. All cells took 512.
TEST(SmallDebris, meets_plane_parts_of_the_ground_as_a_whole) {
    Bed bed(true);
    GroundSurface surface(bed.soil->soil());
    const GroundShape ground(surface, 0.16);
    Count count;
    // The grid's axes: x and y level. 15 voxels and a bit, from the post on.
    const float middle = 0.2f, side = 15.2f * 0.008f;
    ground.processAllTriangles(&count, {middle - side, middle - side, 0},
                               {middle + 0.001f, middle + 0.001f, 0.16f});
    EXPECT_NEAR(count.area_m2, 0.128 * 0.128, 1e-6);
    EXPECT_LT(count.triangles, 80);
}

// A triangle that a sharp edge has gone through is out of the body soonest by its other face: that
// pushed the body on into the soil.
TEST(SmallDebris, is_pushed_out_of_the_soil_only) {
    Bed bed(true);
    btConvexHullShape& shape = tetrahedron(bed.scene, 0.023f, 0.001f);
    std::mt19937 random(3);
    std::uniform_real_distribution<btScalar> uniform(-1, 1);
    int contacts = 0, below = 0;
    btRigidBody& body = bed.add(shape, btTransform::getIdentity());
    for (int i = 0; i < 300; ++i) {
        const btVector3 axis =
            btVector3(uniform(random), uniform(random), uniform(random)).normalized();
        btTransform pose(btQuaternion(axis, 3 * uniform(random)), btVector3(0, 0, 0));
        btScalar low = 0;
        for (int k = 0; k < shape.getNumPoints(); ++k) {
            low = std::min(low, (pose * shape.getScaledPoint(k)).y());
        }
        // 2 mm in the soil, and the post below its box.
        pose.setOrigin(
            {0.03f + 0.01f * uniform(random), 0.038f - low, 0.03f + 0.01f * uniform(random)});
        body.setWorldTransform(pose);
        bed.scene.world->performDiscreteCollisionDetection();
        for (int m = 0; m < bed.scene.dispatcher.getNumManifolds(); ++m) {
            btPersistentManifold& manifold = *bed.scene.dispatcher.getManifoldByIndexInternal(m);
            if (manifold.getBody0() != bed.soil->ground() &&
                manifold.getBody1() != bed.soil->ground()) {
                continue;
            }
            const btScalar side = manifold.getBody0() == &body ? 1 : -1;
            contacts += manifold.getNumContacts();
            for (int k = 0; k < manifold.getNumContacts(); ++k) {
                below += side * manifold.getContactPoint(k).m_normalWorldOnB.y() < 0;
            }
            manifold.clearManifold();
        }
    }
    EXPECT_GT(contacts, 400);
    EXPECT_EQ(below, 0);
}

}  // namespace
}  // namespace bsoil::bullet::small_debris_test
