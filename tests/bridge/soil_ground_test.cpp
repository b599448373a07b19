// The soil's surface as rays, sweeps and uncoupled bodies meet it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "bsoil/bullet/soil_action.h"
#include "bullet_scene.h"
#include "bullet_types.h"

namespace bsoil::bullet::soil_ground_test {
namespace {

constexpr double kVoxelM = 0.05;

SoilDef small_def(UpAxis up = UpAxis::y) {
    SoilDef def;
    def.up = up;
    def.size_m = up == UpAxis::y ? Vec3{2, 1, 2} : Vec3{2, 2, 1};
    def.voxel_m = kVoxelM;
    def.backend = Backend::cpu;
    return def;
}

std::unique_ptr<SoilAction> make_soil(BulletScene& scene, const SoilDef& def,
                                      const SoilActionDef& options = {}) {
    const auto g = btScalar(-def.gravity_m_s2);
    scene.world->setGravity(def.up == UpAxis::y ? btVector3(0, g, 0) : btVector3(0, 0, g));
    auto soil = SoilAction::create(*scene.world, def, options);
    EXPECT_TRUE(soil) << soil.error();
    return soil ? std::move(*soil) : nullptr;
}

/// Soil up to y = 0.4 m.
std::unique_ptr<SoilAction> make_bed(BulletScene& scene, const SoilActionDef& options = {}) {
    auto soil = make_soil(scene, small_def(), options);
    EXPECT_TRUE(soil->fill(BoxFill{{{-2, -1, -2}, {2, 0.4, 2}}, "dry_sand"}));
    return soil;
}

btCollisionWorld::ClosestRayResultCallback cast(const btCollisionWorld& world,
                                                const btVector3& from, const btVector3& to) {
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    world.rayTest(from, to, hit);
    return hit;
}

/// Takes out the soil of a box, by a body that is there for one step and pushes it away.
void push_soil_away(BulletScene& scene, const btVector3& half_extents, btVector3 at, double time_s,
                    const btVector3& velocity) {
    btRigidBody& tool = scene.add_box(0, half_extents, at);
    tool.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    tool.setActivationState(DISABLE_DEACTIVATION);
    for (int frame = 0; frame < static_cast<int>(time_s * 60); ++frame) {
        at += velocity / 60;
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(at);
        tool.setWorldTransform(pose);
        scene.world->stepSimulation(btScalar(1) / 60, 1);
    }
    scene.remove(tool);
}

TEST(SoilGround, rays_hit_level_soil_from_above_below_and_aslant) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    const auto down = cast(*scene.world, {0.3f, 2, -0.2f}, {0.3f, -1, -0.2f});
    ASSERT_EQ(down.m_collisionObject, soil->ground());
    EXPECT_NEAR(down.m_hitPointWorld.y(), 0.4, 1e-5);
    EXPECT_NEAR(down.m_hitNormalWorld.y(), 1, 1e-5);
    const auto up = cast(*scene.world, {0.3f, 0, -0.2f}, {0.3f, 1, -0.2f});
    ASSERT_TRUE(up.hasHit());
    EXPECT_NEAR(up.m_hitPointWorld.y(), 0.4, 1e-5);
    // Falls 0.5 m over 2 m: meets 0.4 m where it has come from 0.6, 0.8 m along.
    const auto aslant = cast(*scene.world, {-0.9f, 0.6f, -0.9f}, {0.7f, 0.2f, 0.3f});
    ASSERT_TRUE(aslant.hasHit());
    EXPECT_NEAR(aslant.m_hitPointWorld.x(), -0.1, 1e-4);
    EXPECT_NEAR(aslant.m_hitPointWorld.z(), -0.3, 1e-4);
    // To the rim of the box, and no further.
    EXPECT_TRUE(cast(*scene.world, {0.999f, 1, 0.999f}, {0.999f, 0, 0.999f}).hasHit());
    EXPECT_FALSE(cast(*scene.world, {1.01f, 1, 0}, {1.01f, 0, 0}).hasHit());
    EXPECT_FALSE(cast(*scene.world, {-0.9f, 0.45f, 0}, {0.9f, 0.45f, 0.3f}).hasHit());
}

TEST(SoilGround, rays_that_are_not_finite_hit_nothing) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    constexpr btScalar kNan = std::numeric_limits<btScalar>::quiet_NaN();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(cast(*scene.world, {kNan, 2, 0}, {0, -1, 0}).hasHit());
    EXPECT_FALSE(soil->surface_at({nan, 0, 0}));
    EXPECT_FALSE(soil->surface_at({0, 0, std::numeric_limits<double>::infinity()}));
}

/// The surface over the column centres, as Bullet's own mesh.
struct ReferenceMesh {
    btTriangleMesh mesh;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
    btCollisionObject object;
    explicit ReferenceMesh(const Soil& soil) {
        const GridFrame& frame = soil.frame();
        const auto vertex = [&](int x, int y) {
            const Vec3 p =
                frame.to_world({x + 0.5, y + 0.5, soil.surface_height_m(x, y) / frame.voxel_m});
            return btVector3(static_cast<btScalar>(p.x), static_cast<btScalar>(p.y),
                             static_cast<btScalar>(p.z));
        };
        for (int y = 0; y + 1 < frame.size[1]; ++y) {
            for (int x = 0; x + 1 < frame.size[0]; ++x) {
                mesh.addTriangle(vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1));
                mesh.addTriangle(vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1));
            }
        }
        shape = std::make_unique<btBvhTriangleMeshShape>(&mesh, true);
        object.setCollisionShape(shape.get());
        object.setWorldTransform(btTransform::getIdentity());
    }
};

class SoilGroundAxis : public testing::TestWithParam<UpAxis> {};
INSTANTIATE_TEST_SUITE_P(Up, SoilGroundAxis, testing::Values(UpAxis::y, UpAxis::z),
                         [](const auto& axis) { return axis.param == UpAxis::y ? "y" : "z"; });

TEST_P(SoilGroundAxis, rays_hit_hills_where_they_hit_a_mesh_of_the_columns) {
    BulletScene scene;
    SoilDef def = small_def(GetParam());
    def.yaw_rad = 0.4;
    const auto soil = make_soil(scene, def);
    NoiseFill hills;
    hills.amplitude_m = 0.3;
    hills.wavelength_m = 0.7;
    hills.material = "dry_sand";
    ASSERT_TRUE(soil->fill(hills));
    const ReferenceMesh reference(soil->soil());
    const int up_axis = def.up == UpAxis::y ? 1 : 2;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> place(-0.9f, 0.9f), height(0, 1);
    const GridFrame& frame = soil->soil().frame();
    int hit_count = 0, same_normal_count = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto point = [&]() {
            const float a = place(random), b = place(random), h = height(random);
            return def.up == UpAxis::y ? btVector3(a, h, b) : btVector3(a, b, h);
        };
        const btVector3 from = point();
        btVector3 to = point();
        if (i % 4 == 0) {  // straight down
            to = from;
            to[up_axis] = -1;
        }
        btTransform a = btTransform::getIdentity(), b = a;
        a.setOrigin(from);
        b.setOrigin(to);
        btCollisionWorld::ClosestRayResultCallback expected(from, to);
        scene.world->rayTestSingle(a, b, const_cast<btCollisionObject*>(&reference.object),
                                   reference.shape.get(), btTransform::getIdentity(), expected);
        const auto found = cast(*scene.world, from, to);
        // The mesh ends half a voxel before the rim.
        const auto is_at_rim = [&](const btVector3& at) {
            const Vec3 p = frame.to_grid(from_bullet(at));
            return std::min({p.x, p.y, frame.size[0] - p.x, frame.size[1] - p.y}) < 0.51;
        };
        if (found.hasHit() && is_at_rim(found.m_hitPointWorld)) continue;
        ASSERT_EQ(found.hasHit(), expected.hasHit()) << i;
        if (!expected.hasHit()) continue;
        ++hit_count;
        // The same triangles in single precision, once in the world's and once in the grid's frame.
        EXPECT_NEAR((found.m_hitPointWorld - expected.m_hitPointWorld).length(), 0, 2e-4) << i;
        same_normal_count += found.m_hitNormalWorld.dot(expected.m_hitNormalWorld) > 0.999f;
        const auto at =
            soil->surface_at({expected.m_hitPointWorld.x(), expected.m_hitPointWorld.y(),
                              expected.m_hitPointWorld.z()});
        ASSERT_TRUE(at);
        const double level = def.up == UpAxis::y ? at->position_m.y : at->position_m.z;
        EXPECT_NEAR(level, static_cast<double>(expected.m_hitPointWorld[up_axis]), 1e-3);
    }
    EXPECT_GT(hit_count, 500);
    EXPECT_GT(same_normal_count, 0.99 * hit_count);  // on an edge either triangle may be hit
}

TEST(SoilGround, empty_columns_have_no_surface_and_terrain_has_one) {
    BulletScene scene;
    const auto soil = make_soil(scene, small_def());
    ASSERT_TRUE(soil->fill(BoxFill{{{-1, 0, -1}, {-0.5, 0.3, 1}}, "dry_sand"}));
    ASSERT_TRUE(
        soil->soil().add_terrain([](Vec3 p) { return p.x > 0.5 && p.y < 0.2 ? 1.0 : -1.0; }));
    EXPECT_TRUE(cast(*scene.world, {-0.7f, 1, 0}, {-0.7f, -1, 0}).hasHit());
    EXPECT_FALSE(cast(*scene.world, {0, 1, 0}, {0, -1, 0}).hasHit());
    EXPECT_FALSE(soil->surface_at({0, 0, 0}));
    const auto terrain = cast(*scene.world, {0.8f, 1, 0}, {0.8f, -1, 0});
    ASSERT_TRUE(terrain.hasHit());
    EXPECT_NEAR(terrain.m_hitPointWorld.y(), 0.2, 0.5 * kVoxelM);
}

TEST(SoilGround, soil_in_flight_does_not_count_until_it_has_landed) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    ASSERT_TRUE(soil->fill(BoxFill{{{-0.5, 0.8, -0.5}, {0.5, 0.9, 0.5}}, "dry_sand"}));
    EXPECT_NEAR(soil->surface_at({0, 0, 0})->position_m.y, 0.4, 1e-5);
    scene.run(1);
    EXPECT_NEAR(soil->surface_at({0, 0, 0})->position_m.y, 0.5, 0.04);
}

TEST(SoilGround, sphere_sweep_stops_on_the_surface) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btSphereShape ball(btScalar(0.1));
    btTransform from = btTransform::getIdentity(), to = from;
    from.setOrigin({0.02f, 0.9f, 0.03f});
    to.setOrigin({0.02f, 0.1f, 0.03f});
    btCollisionWorld::ClosestConvexResultCallback hit(from.getOrigin(), to.getOrigin());
    scene.world->convexSweepTest(&ball, from, to, hit);
    ASSERT_TRUE(hit.hasHit());
    EXPECT_EQ(hit.m_hitCollisionObject, soil->ground());
    EXPECT_NEAR(hit.m_hitPointWorld.y(), 0.4, 1e-3);
    // 0.9 to 0.5 of 0.8 m; Bullet stops short by its allowed penetration.
    EXPECT_NEAR(hit.m_closestHitFraction, 0.5, 2e-3);
}

/// How many of 25 boxes dropped on level ground, the soil's or a mesh of its columns, are awake 10
/// s later.
int awake_debris(bool on_mesh) {
    BulletScene scene;
    SoilActionDef options;
    options.ground = !on_mesh;
    const auto soil = make_bed(scene, options);
    ReferenceMesh reference(soil->soil());
    if (on_mesh) scene.world->addCollisionObject(&reference.object);
    EXPECT_TRUE(soil->set_options(reference.object, {.ignored = true}));
    btCollisionShape& shape = scene.shape<btBoxShape>(btVector3(0.05f, 0.05f, 0.05f));
    for (int i = 0; i < 25; ++i) {
        btRigidBody& body = scene.add(
            1, shape,
            {btScalar(0.3 * (i % 5) - 0.6), btScalar(0.6), btScalar(0.3 * (i / 5) - 0.6)});
        EXPECT_TRUE(soil->set_options(body, {.ignored = true}));
    }
    const uint64_t before = soil->soil().checksum();
    scene.run(10);
    int awake = 0;
    for (const auto& body : scene.bodies) {
        awake += body->isActive();
        // 1 cm: Bullet's contact slop and margins.
        EXPECT_NEAR(body->getWorldTransform().getOrigin().y(), 0.45, 0.01);
    }
    EXPECT_EQ(soil->soil().checksum(), before);
    if (on_mesh) scene.world->removeCollisionObject(&reference.object);
    return awake;
}

// With Bullet in double precision a few boxes creep, fewer than on its own mesh.
TEST(SoilGround, uncoupled_debris_rests_on_it_and_sleeps) {
    const int awake = awake_debris(false);
    EXPECT_LE(awake, awake_debris(true));
    EXPECT_LE(awake, 5);
}

TEST(SoilGround, uncoupled_debris_comes_to_rest_on_bumps) {
    BulletScene scene;
    const auto soil = make_soil(scene, small_def());
    NoiseFill hills;
    hills.base_m = 0.4;
    hills.wavelength_m = 1;
    hills.material = "dry_sand";
    ASSERT_TRUE(soil->fill(hills));
    btCollisionShape& shape = scene.shape<btBoxShape>(btVector3(0.05f, 0.05f, 0.05f));
    for (int i = 0; i < 25; ++i) {
        ASSERT_TRUE(soil->set_options(scene.add(1, shape,
                                                {btScalar(0.3 * (i % 5) - 0.6), btScalar(0.75),
                                                 btScalar(0.3 * (i / 5) - 0.6)}),
                                      {.ignored = true}));
    }
    scene.run(10);
    for (const auto& body : scene.bodies) {
        EXPECT_FALSE(body->isActive());
        const Vec3 at = from_bullet(body->getWorldTransform().getOrigin());
        const auto surface = soil->surface_at(at);
        ASSERT_TRUE(surface);
        // On a face, an edge or a corner, over a bump.
        EXPECT_GT(at.y, surface->position_m.y + 0.03);
        EXPECT_LT(at.y, surface->position_m.y + 0.12);
    }
}

TEST(SoilGround, sleeping_debris_falls_when_the_soil_under_it_is_dug_away) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btRigidBody& debris = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {0, 0.5f, 0});
    btRigidBody& far_off = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {-0.8f, 0.5f, -0.8f});
    ASSERT_TRUE(soil->set_options(debris, {.ignored = true}));
    ASSERT_TRUE(soil->set_options(far_off, {.ignored = true}));
    scene.run(4);
    ASSERT_FALSE(debris.isActive());
    // A blade 0.2 m deep; it may not meet the debris, nor its heap what is far off.
    push_soil_away(scene, {0.05f, 0.09f, 0.25f}, {-0.5f, 0.3f, 0}, 1.5, {0.6f, 0, 0});
    scene.run(3);
    const Vec3 at{debris.getWorldTransform().getOrigin().x(), 0,
                  debris.getWorldTransform().getOrigin().z()};
    const double surface_m = soil->surface_at(at)->position_m.y;
    EXPECT_LT(surface_m, 0.37);  // it was 0.4: so much is dug away
    // On a slope it may stand on an edge: half its diagonal high.
    EXPECT_GT(debris.getWorldTransform().getOrigin().y(), surface_m + 0.05);
    EXPECT_LT(debris.getWorldTransform().getOrigin().y(), surface_m + 0.08 * 1.42);
    EXPECT_FALSE(far_off.isActive());
    EXPECT_NEAR(far_off.getWorldTransform().getOrigin().y(), 0.48, 0.01);
    EXPECT_NEAR(soil->surface_at({-0.725, 0, -0.725})->position_m.y, 0.4, 1e-6) << "not far off";
}

TEST(SoilGround, ball_rolls_down_a_slope_as_on_a_mesh_of_the_columns) {
    const double slope = 15 * std::numbers::pi / 180;
    const auto roll = [slope](bool on_mesh, int start) {
        BulletScene scene;
        SoilActionDef options;
        options.ground = !on_mesh;
        const auto soil = make_soil(scene, small_def(), options);
        const auto surface = [slope](Vec3 p) { return 0.5 - std::tan(slope) * p.x - p.y; };
        EXPECT_TRUE(soil->fill(FunctionFill{surface, "dry_sand"}));
        ReferenceMesh reference(soil->soil());
        reference.object.setFriction(1);
        reference.object.setRollingFriction(0.03f);
        reference.object.setSpinningFriction(0.03f);
        if (on_mesh) scene.world->addCollisionObject(&reference.object);
        EXPECT_TRUE(soil->set_options(reference.object, {.ignored = true}));
        btRigidBody& ball =
            scene.add(1, scene.shape<btSphereShape>(btScalar(0.15)),
                      {btScalar(-0.6 + 0.007 * start), 0.85f, btScalar(0.01 + 0.003 * start)});
        EXPECT_TRUE(soil->set_options(ball, {.ignored = true}));
        scene.run(0.3);  // lands
        const btScalar landed_m_s = ball.getLinearVelocity().length();
        scene.run(0.6);
        if (on_mesh) scene.world->removeCollisionObject(&reference.object);
        return static_cast<double>(ball.getLinearVelocity().length() - landed_m_s) / 0.6;
    };
    // Which of the steps of the columns it lands on makes a difference of a tenth.
    constexpr int kStarts = 6;
    double acceleration = 0, on_mesh = 0;
    for (int start = 0; start < kStarts; ++start) {
        acceleration += roll(false, start) / kStarts;
        on_mesh += roll(true, start) / kStarts;
    }
    EXPECT_NEAR(acceleration, on_mesh, 0.1 * on_mesh);
    // A solid ball that does not slide, with a rolling resistance of 0.5 x 0.03 m on its radius of
    // 0.15 m; the steps of the columns take some more of it.
    const double expected = 5.0 / 7 * 9.81 * (std::sin(slope) - 0.1 * std::cos(slope));
    EXPECT_NEAR(acceleration, expected, 0.3 * expected);
}

TEST(SoilGround, coupled_bodies_move_as_if_it_were_not_there) {
    const auto run = [](bool with_ground) {
        BulletScene scene;
        SoilActionDef options;
        options.ground = with_ground;
        const auto soil = make_bed(scene, options);
        EXPECT_EQ(soil->ground() != nullptr, with_ground);
        btRigidBody& box = scene.add_box(60, {0.2f, 0.1f, 0.2f}, {0, 0.6f, 0});
        btRigidBody& ball =
            scene.add(5, scene.shape<btSphereShape>(btScalar(0.1)), {0.03f, 0.9f, 0});
        scene.run(2);
        return std::tuple(box.getWorldTransform().getOrigin().y(),
                          ball.getWorldTransform().getOrigin().x(),
                          ball.getWorldTransform().getOrigin().y(), soil->soil().checksum());
    };
    EXPECT_EQ(run(true), run(false));
}

TEST(SoilGround, body_the_soil_refuses_rests_on_it) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btRigidBody& body = scene.add_flat_hull({0, 0.5f, 0});
    scene.run(3);
    EXPECT_FALSE(soil->refused().empty());
    EXPECT_NEAR(body.getWorldTransform().getOrigin().y(), 0.4, 0.06);
}

TEST(SoilGround, body_the_soil_refuses_rests_on_it_while_the_soil_is_off) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btRigidBody& body = scene.add_flat_hull({0, 0.45f, 0});
    scene.run(0.2);
    ASSERT_FALSE(soil->refused().empty());
    soil->set_enabled(false);
    scene.run(0.1);
    // Lifted, it has none of its old contacts.
    btTransform pose = btTransform::getIdentity();
    pose.setOrigin({0, 0.55f, 0});
    body.setWorldTransform(pose);
    body.setLinearVelocity({0, 0, 0});
    body.setAngularVelocity({0, 0, 0});
    body.activate();
    scene.run(2);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().y(), 0.4, 0.06);
}

TEST(SoilGround, body_that_comes_while_the_soil_is_off_and_is_refused_rests_on_it) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    soil->set_enabled(false);
    scene.run(0.1);
    btRigidBody& body = scene.add_flat_hull({0, 0.5f, 0});
    btRigidBody& falls = scene.add_box(5, {0.1f, 0.1f, 0.1f}, {0.8f, 0.6f, 0});
    scene.run(1.5);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().y(), 0.4, 0.06);
    EXPECT_LT(falls.getWorldTransform().getOrigin().y(), 0);
    ASSERT_EQ(soil->refused().size(), 1u);
    EXPECT_EQ(soil->refused()[0].object, &body);
    soil->set_enabled(true);
    scene.run(0.2);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().y(), 0.4, 0.06);
}

TEST(SoilGround, filter_mask_keeps_groups_apart) {
    BulletScene scene;
    SoilActionDef options;
    options.ground_group = 64;
    options.ground_mask = btBroadphaseProxy::SensorTrigger;
    const auto soil = make_bed(scene, options);
    btRigidBody& debris = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {0, 0.6f, 0});
    ASSERT_TRUE(soil->set_options(debris, {.ignored = true}));
    scene.run(0.6);
    EXPECT_LT(debris.getWorldTransform().getOrigin().y(), 0);
}

TEST(SoilGround, host_may_have_it_ignore_an_object) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btRigidBody& through = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {0.5f, 0.6f, 0});
    btRigidBody& held = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {-0.5f, 0.6f, 0});
    ASSERT_TRUE(soil->set_options(through, {.ignored = true}));
    ASSERT_TRUE(soil->set_options(held, {.ignored = true}));
    soil->ground()->setIgnoreCollisionCheck(&through, true);
    scene.run(0.6);
    EXPECT_LT(through.getWorldTransform().getOrigin().y(), 0);
    EXPECT_NEAR(held.getWorldTransform().getOrigin().y(), 0.48, 0.02);
}

// With its list of ignored objects empty again Bullet asked it about no pair, and it held bodies
// that the soil holds.
TEST(SoilGround, coupled_bodies_move_as_before_once_it_ignores_no_object_any_more) {
    enum class Host { does_nothing, lets_collide, takes_out_joint };
    const auto run = [](Host host) {
        BulletScene scene;
        const auto soil = make_bed(scene);
        btRigidBody& box = scene.add_box(300, {0.2f, 0.1f, 0.2f}, {0, 0.5f, 0});
        btRigidBody& other = scene.add_box(1, {0.08f, 0.08f, 0.08f}, {0.7f, 2, 0});
        if (host == Host::lets_collide) {
            soil->ground()->setIgnoreCollisionCheck(&other, true);
            soil->ground()->setIgnoreCollisionCheck(&other, false);
        } else if (host == Host::takes_out_joint) {
            btPoint2PointConstraint joint(other, *soil->ground(), {0, 0, 0}, {0.7f, 2, 0});
            scene.world->addConstraint(&joint, true);
            scene.world->removeConstraint(&joint);
        }
        scene.run(0.2);
        return std::tuple(box.getWorldTransform().getOrigin().y(), soil->soil().checksum());
    };
    const auto untouched = run(Host::does_nothing);
    EXPECT_EQ(run(Host::lets_collide), untouched);
    EXPECT_EQ(run(Host::takes_out_joint), untouched);
}

TEST(SoilGround, host_may_delete_it) {
    BulletScene scene;
    const auto soil = make_bed(scene);
    btRigidBody* ground = soil->ground();
    scene.world->removeRigidBody(ground);
    scene.run(0.1);
    EXPECT_FALSE(cast(*scene.world, {0, 2, 0}, {0, -1, 0}).hasHit());
    delete ground;
    EXPECT_EQ(soil->ground(), nullptr);
    scene.run(0.1);
    EXPECT_TRUE(soil->surface_at({0, 0, 0}));
}

}  // namespace
}  // namespace bsoil::bullet::soil_ground_test
