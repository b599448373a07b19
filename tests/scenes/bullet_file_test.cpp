// Worlds from .bullet files: what comes through, what is said to be missing, what is refused.
#include "robots/bullet_file.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "files/data_files.h"
#include "reading/scene_load.h"
#include "run/scene_run.h"

namespace bsoil::scene::bullet_file_test {
namespace {

struct World {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string saved(const btDefaultSerializer& serializer) {
    return {reinterpret_cast<const char*>(serializer.getBufferPointer()),
            static_cast<size_t>(serializer.getCurrentBufferSize())};
}

/// Two boxes joined by a hinge, a sphere and, on demand, a heightfield under them; z is up.
void write_world(const std::string& path, bool with_heightfield) {
    World w;
    btBoxShape box(btVector3(0.3f, 0.2f, 0.1f));
    btSphereShape sphere(btScalar(0.2));
    btRigidBody a(10, nullptr, &box, btVector3(1, 1, 1)), b(10, nullptr, &box, btVector3(1, 1, 1));
    btRigidBody c(5, nullptr, &sphere, btVector3(0.1f, 0.1f, 0.1f));
    const auto place = [&](btRigidBody& body, const btVector3& at) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(at);
        body.setWorldTransform(pose);
        body.setInterpolationWorldTransform(pose);
        w.world.addRigidBody(&body);
    };
    place(a, {0, 0, 1});
    place(b, {0.8f, 0, 1});
    place(c, {0, 1, 1.2f});
    btHingeConstraint hinge(a, b, btVector3(0.4f, 0, 0), btVector3(-0.4f, 0, 0), btVector3(0, 1, 0),
                            btVector3(0, 1, 0));
    w.world.addConstraint(&hinge, true);
    std::vector<float> heights(16, 0.0f);
    btHeightfieldTerrainShape terrain(4, 4, heights.data(), 1, btScalar(-1), btScalar(1), 2,
                                      PHY_FLOAT, false);
    btRigidBody ground(0, nullptr, &terrain);
    if (with_heightfield) place(ground, {0, 0, 0});
    btDefaultSerializer serializer;
    serializer.registerNameForPointer(&c, "ball");
    w.world.serialize(&serializer);
    std::ofstream(path, std::ios::binary) << saved(serializer);
    w.world.removeConstraint(&hinge);
    for (btRigidBody* body : {&a, &b, &c}) w.world.removeRigidBody(body);
    if (with_heightfield) w.world.removeRigidBody(&ground);
}

/// A multibody: a base at (0, 1, 1.2) and, 0.5 m further in x, a box that slides along z.
std::string slider_bytes() {
    World w;
    btBoxShape box(btVector3(0.3f, 0.2f, 0.1f));
    btMultiBody slider(1, 1, btVector3(1, 1, 1), false, false);
    slider.setBasePos({0, 1, btScalar(1.2)});
    slider.setupPrismatic(0, 10, btVector3(1, 1, 1), -1, btQuaternion::getIdentity(),
                          btVector3(0, 0, 1), btVector3(btScalar(0.5), 0, 0), btVector3(0, 0, 0),
                          true);
    slider.finalizeMultiDof();
    w.world.addMultiBody(&slider);
    btMultiBodyLinkCollider link(&slider, 0);
    link.setCollisionShape(&box);
    w.world.addCollisionObject(&link);
    slider.getLink(0).m_collider = &link;
    btDefaultSerializer serializer;
    w.world.serialize(&serializer);
    w.world.removeCollisionObject(&link);
    w.world.removeMultiBody(&slider);
    return saved(serializer);
}

/// Bullet 3.24 in single precision makes no colliders for links.
constexpr bool kMakesLinkColliders = sizeof(btScalar) == sizeof(double);

class BulletFileTest : public testing::Test {
  protected:
    std::string path =
        (std::filesystem::temp_directory_path() / ("bsoil_" + std::to_string(getpid()) + ".bullet"))
            .string();
    void TearDown() override { std::filesystem::remove(path); }
    void write(const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
    void expect_reason(const std::string& bytes, const char* reason) {
        write(bytes);
        World other;
        const auto file = BulletFile::load(path, other.world, btTransform::getIdentity());
        ASSERT_FALSE(file);
        EXPECT_NE(file.error().find(reason), std::string::npos) << file.error();
    }
};

// For demo.world_from_file.
TEST(BulletFile, writes_the_example) {
    write_world(BSOIL_EXAMPLE_BULLET_FILE, false);
    const auto content = check_bullet_file(BSOIL_EXAMPLE_BULLET_FILE);
    ASSERT_TRUE(content) << content.error();
    EXPECT_EQ(content->rigid_body_count, 3);
}

TEST_F(BulletFileTest, bodies_and_constraints_come_through_and_go_again) {
    write_world(path, false);
    World w;
    w.world.setGravity({0, 0, -3});
    {
        const auto file = BulletFile::load(path, w.world);
        ASSERT_TRUE(file) << file.error();
        EXPECT_TRUE((*file)->missing().empty());
        ASSERT_EQ((*file)->bodies().size(), 3u);
        EXPECT_EQ(w.world.getNumConstraints(), 1);
        EXPECT_EQ(w.world.getGravity().z(), -3);  // not the file's
        const auto ball = std::find_if((*file)->bodies().begin(), (*file)->bodies().end(),
                                       [](const auto& b) { return b.name == "ball"; });
        ASSERT_NE(ball, (*file)->bodies().end());
        EXPECT_EQ(ball->body->getWorldTransform().getOrigin(), btVector3(0, 1, 1.2f));
        EXPECT_NEAR(1 / ball->body->getInvMass(), 5, 1e-5);
        EXPECT_EQ(ball->body->getCollisionShape()->getShapeType(), SPHERE_SHAPE_PROXYTYPE);
        w.world.stepSimulation(btScalar(1) / 60);
    }
    EXPECT_EQ(w.world.getNumCollisionObjects(), 0);
    EXPECT_EQ(w.world.getNumConstraints(), 0);
}

TEST_F(BulletFileTest, a_scene_takes_one_with_its_bodies_by_name) {
    write_world(path, false);
    const auto scene = parse_scene(
        "[world]\nduration_s = 1\n"
        "[soil]\nsize_m = [3, 3, 1.5]\nvoxel_m = 0.1\n"
        "[[fill]]\nkind = \"box\"\nmin_m = [-1.5, -1.5, 0]\nmax_m = [1.5, 1.5, 0.4]\n"
        "[[bullet_file]]\nname = \"yard\"\nfile = \"" +
            path +
            "\"\nposition_m = [0.1, 0, -0.3]\n"
            "[[check]]\nkind = \"body_at_rest\"\nbody = \"yard/ball\"\nby_s = 0.9\n",
        "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->bodies.size(), 3u);
    const BodyItem* ball = scene->find_body("yard/ball");
    ASSERT_TRUE(ball);
    EXPECT_NEAR(ball->mass_kg, 5, 1e-6);
    EXPECT_NEAR(length(ball->pose.position - Vec3{0.1, 1, 0.9}), 0, 1e-6);
    double reach_m = 0;  // of the picture's surface
    for (const Vec3 p : ball->shape.mesh->vertices) reach_m = std::max(reach_m, length(p));
    EXPECT_NEAR(reach_m, 0.2, 0.02);

    auto run = SceneRun::create(*scene, {.backend = Backend::cpu});
    ASSERT_TRUE(run) << run.error();
    const SceneBody* body = (*run)->bullet().find_body("yard/ball");
    ASSERT_TRUE(body && body->body);
    EXPECT_NEAR(length(body->pose().position - ball->pose.position), 0, 1e-6);
    while (!(*run)->finished()) (*run)->step();
    // It fell onto the sand, a few centimetres into it, and not through it onto the plane.
    EXPECT_LT(body->pose().position.z, 0.62);
    EXPECT_GT(body->pose().position.z, 0.45);
}

TEST_F(BulletFileTest, multibodies_come_through_and_go_again) {
    write(slider_bytes());
    World w;
    btMultiBody own(0, 1, btVector3(1, 1, 1), false, false);
    own.finalizeMultiDof();
    w.world.addMultiBody(&own);
    {
        const auto file = BulletFile::load(path, w.world);
        ASSERT_TRUE(file) << file.error();
        ASSERT_EQ(w.world.getNumMultibodies(), 2);
        EXPECT_EQ(w.world.getMultiBody(1)->getLinkMass(0), 10);
        EXPECT_EQ(w.world.getNumCollisionObjects(), kMakesLinkColliders ? 1 : 0);
        EXPECT_EQ((*file)->missing().size(), kMakesLinkColliders ? 0u : 1u);
        w.world.stepSimulation(btScalar(1) / 60);
    }
    EXPECT_EQ(w.world.getNumCollisionObjects(), 0);
    ASSERT_EQ(w.world.getNumMultibodies(), 1);
    EXPECT_EQ(w.world.getMultiBody(0), &own);
    w.world.removeMultiBody(&own);
}

TEST_F(BulletFileTest, a_file_can_be_placed) {
    write_world(path, false);
    World w;
    const btTransform pose(btQuaternion(btVector3(0, 0, 1), btScalar(1.5707963)),
                           btVector3(5, 0, 0));
    const auto file = BulletFile::load(path, w.world, pose);
    ASSERT_TRUE(file) << file.error();
    const auto ball = std::find_if((*file)->bodies().begin(), (*file)->bodies().end(),
                                   [](const auto& b) { return b.name == "ball"; });
    ASSERT_NE(ball, (*file)->bodies().end());
    const btVector3 at = ball->body->getWorldTransform().getOrigin();
    EXPECT_LT((at - btVector3(4, 0, 1.2f)).length(), 1e-5);
}

TEST_F(BulletFileTest, multibodies_are_placed_with_their_links_and_colliders) {
    write(slider_bytes());
    World w;
    // A quarter turn takes x to y and y to -x.
    const btTransform pose(btQuaternion(btVector3(0, 0, 1), SIMD_HALF_PI), btVector3(5, 0, 0));
    const auto file = BulletFile::load(path, w.world, pose);
    ASSERT_TRUE(file) << file.error();
    ASSERT_EQ(w.world.getNumMultibodies(), 1);
    btMultiBody& slider = *w.world.getMultiBody(0);
    EXPECT_LT((slider.getBasePos() - btVector3(4, 0, 1.2f)).length(), 1e-5);
    const btTransform& link = slider.getLink(0).m_cachedWorldTransform;
    EXPECT_LT((link.getOrigin() - btVector3(4, 0.5f, 1.2f)).length(), 1e-5);
    EXPECT_LT((link.getBasis().getColumn(0) - btVector3(0, 1, 0)).length(), 1e-5);
    // From above through the end of the box, which reaches 0.3 m along its own x, 0.2 m along y.
    const btVector3 from(4, 0.75f, 3), to(4, 0.75f, 0);
    btCollisionWorld::ClosestRayResultCallback ray(from, to);
    w.world.rayTest(from, to, ray);
    EXPECT_EQ(ray.hasHit(), kMakesLinkColliders);
    if (ray.hasHit()) {
        EXPECT_NEAR(ray.m_hitPointWorld.z(), 1.3, 1e-5);  // its upper side
    }
}

TEST_F(BulletFileTest, a_dropped_heightfield_is_said_to_be_missing) {
    write_world(path, true);
    World w;
    const auto file = BulletFile::load(path, w.world);
    ASSERT_TRUE(file) << file.error();
    EXPECT_EQ((*file)->bodies().size(), 3u);
    ASSERT_EQ((*file)->missing().size(), 1u);
    EXPECT_NE((*file)->missing()[0].find("1 of its 4 rigid bodies"), std::string::npos)
        << (*file)->missing()[0];
}

TEST_F(BulletFileTest, cut_and_damaged_files_are_refused) {
    write_world(path, false);
    const std::string good = bytes_of(path);
    World w;
    const auto expect_refused = [&](const std::string& bytes, const std::string& what) {
        write(bytes);
        const auto file = BulletFile::load(path, w.world);
        ASSERT_FALSE(file) << what;
        EXPECT_NE(file.error().find(path), std::string::npos) << file.error();
        EXPECT_EQ(w.world.getNumCollisionObjects(), 0) << what;
    };
    for (size_t size = 0; size < good.size(); size += 1 + good.size() / 200) {
        expect_refused(good.substr(0, size), "cut to " + std::to_string(size));
    }
    expect_refused(std::string(5000, 'x'), "no magic");
    expect_refused("BULLETf-v324" + std::string(5000, '\x7f'), "garbage after the magic");
    // Size, structure and count of the first blocks; the description of the structures.
    for (const size_t at : {size_t{16}, size_t{28}, size_t{32}}) {
        for (const char byte : {'\x7f', '\xff'}) {
            std::string bad = good;
            for (size_t i = 0; i < 4; ++i) bad[at + i] = byte;
            expect_refused(bad, "block head " + std::to_string(at));
        }
    }
    const size_t dna = good.rfind("SDNA");
    for (const size_t at :
         {dna, dna + 4, dna + 9, good.rfind("TYPE") + 6, good.rfind("STRC") + 6}) {
        std::string bad = good;
        bad[at] = '\x7f';
        expect_refused(bad, "description " + std::to_string(at));
    }
    // What Bullet would read with other sizes than its names say: no size of a pointer, one of
    // three sizes of an array, a pointer by its second letter.
    for (const auto& [name, other] : {std::pair<std::string, std::string>{"ListBase", "ListCase"},
                                      {"m_padding[4]", "pad[2][2][1]"},
                                      {"m_padding[4]", "m*padding[4]"}}) {
        const size_t at = good.find(name, dna);
        ASSERT_NE(at, std::string::npos) << name;
        std::string bad = good;
        bad.replace(at, name.size(), other);
        expect_refused(bad, other);
    }
    // Bullet would take the later one.
    for (const std::string tag : {"DNA1", "SDNANAME"}) expect_refused(good + tag, "two " + tag);
    World other;
    EXPECT_FALSE(BulletFile::load(path + ".absent", other.world));
}

TEST_F(BulletFileTest, a_mesh_without_triangles_is_refused) {
    World w;
    btTriangleMesh triangles;
    triangles.addTriangle({-2, 0, -2}, {2, 0, -2}, {0, 0, 2});
    btBvhTriangleMeshShape shape(&triangles, true);
    btRigidBody ground(0, nullptr, &shape);
    w.world.addRigidBody(&ground);
    triangles.getIndexedMeshArray()[0].m_numTriangles = 0;
    btDefaultSerializer serializer;
    w.world.serialize(&serializer);
    w.world.removeRigidBody(&ground);
    expect_reason(saved(serializer), "mesh without triangles");
}

TEST_F(BulletFileTest, iterations_that_no_host_asks_for_are_refused) {
    World w;
    btSphereShape sphere(btScalar(0.2));
    btRigidBody ball(5, nullptr, &sphere, btVector3(1, 1, 1));
    w.world.addRigidBody(&ball);
    btPoint2PointConstraint point(ball, {0, 0, 1});
    point.setOverrideNumSolverIterations(2'000'000'000);
    w.world.addConstraint(&point);
    btDefaultSerializer serializer;
    w.world.serialize(&serializer);
    w.world.removeConstraint(&point);
    w.world.removeRigidBody(&ball);
    expect_reason(saved(serializer), "iterations");
}

TEST_F(BulletFileTest, the_example_of_bullet_loads_and_says_what_is_missing) {
    const std::string example = find_file("data:bullet3/multibody.bullet", BSOIL_SCENES_DIR "/x");
    if (example.empty()) {
        GTEST_SKIP() << "bullet3/multibody.bullet is not there";
    }
    World w;
    const auto file = BulletFile::load(example, w.world);
    ASSERT_TRUE(file) << file.error();
    EXPECT_EQ((*file)->bodies().size(), 1u);
    EXPECT_EQ(w.world.getNumMultibodies(), 1);
    // Bullet 3.24 makes no colliders for the links of this file.
    ASSERT_EQ((*file)->missing().size(), 1u);
    EXPECT_NE((*file)->missing()[0].find("3 of its 3 colliders of multibodies"), std::string::npos)
        << (*file)->missing()[0];
}

}  // namespace
}  // namespace bsoil::scene::bullet_file_test
