// Snapshots of worlds: what is restored goes on bit for bit; what does not fit or is damaged is
// refused and changes nothing.
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>

#include "bsoil/bullet/soil_raycaster.h"
#include "bsoil/bullet/world_snapshot.h"
#include "bullet_scene.h"
#include "raycast_car.h"

namespace bsoil::bullet {
namespace {

constexpr btScalar kFrameS = btScalar(1) / 60;

uint64_t add(uint64_t hash, const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3ull;
    }
    return hash;
}
uint64_t add(uint64_t hash, const btVector3& v) {
    for (int i = 0; i < 3; ++i) hash = add(hash, &v[i], sizeof(btScalar));
    return hash;
}

/// A world that can be built any number of times, always alike.
struct TestWorld {
    BulletScene scene;
    std::vector<std::unique_ptr<btMotionState>> motion_states;
    std::vector<std::unique_ptr<btTypedConstraint>> constraints;
    std::unique_ptr<btMultiBody> multibody;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> multibody_constraints;
    std::unique_ptr<SoilAction> soil;
    std::unique_ptr<SoilRaycaster> caster;
    std::unique_ptr<Car> car;
    btRigidBody* driven = nullptr;
    std::function<void(TestWorld&)> command;  ///< before each frame
    int frame = 0;
    btScalar frame_s = kFrameS, substep_s = kFrameS / 2;

    ~TestWorld() {
        soil.reset();
        for (const auto& c : constraints) scene.world->removeConstraint(c.get());
        for (const auto& c : multibody_constraints) scene.world->removeMultiBodyConstraint(c.get());
        for (const auto& c : colliders) scene.world->removeCollisionObject(c.get());
        if (multibody) scene.world->removeMultiBody(multibody.get());
    }
    btDiscreteDynamicsWorld& world() { return *scene.world; }
    void step() {
        ++frame;
        if (driven) {
            btTransform pose = btTransform::getIdentity();
            const btScalar t = frame_s * btScalar(frame);
            pose.setOrigin(btVector3(btScalar(-0.9) + btScalar(0.3) * t, btScalar(0.42), 0));
            driven->getMotionState()->setWorldTransform(pose);
        }
        if (command) command(*this);
        scene.world->stepSimulation(frame_s, 8, substep_s);
    }
    void run(int frames) {
        for (int i = 0; i < frames; ++i) step();
    }
    std::vector<SoilAction*> soils() {
        return soil ? std::vector<SoilAction*>{soil.get()} : std::vector<SoilAction*>{};
    }
    Status save(const std::string& path) { return save_world(world(), soils(), path); }
    Status load(const std::string& path) { return load_world(world(), soils(), path); }
    /// Of every pose and velocity and of the soil.
    uint64_t checksum() const {
        uint64_t hash = soil ? soil->soil().checksum() : 1;
        const btCollisionObjectArray& objects = scene.world->getCollisionObjectArray();
        for (int i = 0; i < objects.size(); ++i) {
            const btTransform& pose = objects[i]->getWorldTransform();
            hash = add(hash, pose.getOrigin());
            for (int row = 0; row < 3; ++row) hash = add(hash, pose.getBasis()[row]);
            const int state = objects[i]->getActivationState();
            hash = add(hash, &state, sizeof(state));
            if (const btRigidBody* body = btRigidBody::upcast(objects[i])) {
                hash = add(add(hash, body->getLinearVelocity()), body->getAngularVelocity());
            }
        }
        if (multibody) {
            for (int i = 0; i < multibody->getNumDofs() + 6; ++i) {
                hash = add(hash, multibody->getVelocityVector() + i, sizeof(btScalar));
            }
        }
        for (int i = 0; car && i < car->vehicle->getNumWheels(); ++i) {
            const btWheelInfo& wheel = car->vehicle->getWheelInfo(i);
            const btScalar of_vehicle[] = {
                wheel.m_rotation, wheel.m_steering, wheel.m_brake,
                wheel.m_raycastInfo.m_isInContact ? wheel.m_raycastInfo.m_suspensionLength : 0,
                car->vehicle->getCurrentSpeedKmHour()};
            hash = add(hash, of_vehicle, sizeof(of_vehicle));
            const SoilWheelReport report = caster->wheel_report(i);
            const double of_soil[] = {report.normal_force_n, report.traction_n, report.side_force_n,
                                      report.sinkage_m,      report.spin_rad_s, report.slip};
            hash = add(hash, of_soil, sizeof(of_soil));
        }
        return hash;
    }
};
using Build = std::function<std::unique_ptr<TestWorld>()>;

void add_soil(TestWorld& w, const SoilActionDef& options = {}) {
    SoilDef def;
    def.material.shear_displacement_m = 0.02;
    def.size_m = {3.2, 0.9, 2.4};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    auto soil = SoilAction::create(w.world(), def, options);
    ASSERT_TRUE(soil) << soil.error();
    w.soil = std::move(*soil);
    ASSERT_TRUE(w.soil->fill(BoxFill{{{-2, 0, -2}, {2, 0.4, 2}}, "dry_sand"}));
}

/// Soil, a wheel with a motor, a plate, a scoop of several boxes full of soil, a blade that is
/// driven, and a stone that comes in later.
std::unique_ptr<TestWorld> build_machine() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    BulletScene& s = w->scene;
    btRigidBody& frame = s.add_box(40, {0.3f, 0.1f, 0.2f}, {0.5f, 0.9f, 0});
    btRigidBody& wheel =
        s.add(30, s.shape<btCylinderShapeZ>(btVector3(0.25f, 0.25f, 0.15f)), {0.5f, 0.66f, 0});
    auto hinge = std::make_unique<btHingeConstraint>(frame, wheel, btVector3(0, -0.24f, 0),
                                                     btVector3(0, 0, 0), btVector3(0, 0, 1),
                                                     btVector3(0, 0, 1));
    hinge->enableAngularMotor(true, -3, 2);
    s.world->addConstraint(hinge.get(), true);
    w->constraints.push_back(std::move(hinge));
    btRigidBody& plate = s.add_box(60, {0.2f, 0.05f, 0.2f}, {-0.1f, 0.5f, 0.7f});
    EXPECT_TRUE(w->soil->set_options(plate, {.surface = {0.1, 0}}));
    auto& scoop = static_cast<btCompoundShape&>(s.shape<btCompoundShape>());
    btTransform at = btTransform::getIdentity();
    const auto wall = [&](const btVector3& half, const btVector3& place) {
        at.setOrigin(place);
        scoop.addChildShape(at, &s.shape<btBoxShape>(half));
    };
    wall({0.3f, 0.1f, 0.3f}, {0, -0.2f, 0});
    for (const float side : {-1.0f, 1.0f}) {
        wall({0.1f, 0.25f, 0.3f}, {0.4f * side, 0.05f, 0});
        wall({0.5f, 0.25f, 0.1f}, {0, 0.05f, 0.4f * side});
    }
    // Apart from the driven box: contacts of compounds with other bodies are found anew.
    s.add(80, scoop, {-0.9f, 0.75f, -0.8f});
    // Sand falls into the scoop.
    EXPECT_TRUE(w->soil->fill(BoxFill{{{-1.1, 0.75, -1.0}, {-0.7, 0.88, -0.6}}, "dry_sand"}));
    w->motion_states.push_back(std::make_unique<btDefaultMotionState>(
        btTransform(btQuaternion::getIdentity(), btVector3(-0.9f, 0.42f, 0))));
    s.bodies.push_back(std::make_unique<btRigidBody>(
        0, w->motion_states.back().get(), &s.shape<btBoxShape>(btVector3(0.1f, 0.2f, 0.2f))));
    w->driven = s.bodies.back().get();
    w->driven->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    w->driven->setActivationState(DISABLE_DEACTIVATION);
    s.world->addRigidBody(w->driven);
    s.add(25, s.shape<btSphereShape>(btScalar(0.15)), {1.1f, 2.5f, 0.6f});
    return w;
}

/// Bodies that the soil does not carry lie on its surface while a heap of it slumps: their contacts
/// go whenever the surface has moved by a hundredth of a voxel since they met it.
std::unique_ptr<TestWorld> build_bodies_on_ground() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    EXPECT_TRUE(w->soil->fill(CylinderFill{{0, 0.4, 0}, 0.3, 0.4, "dry_sand"}));
    for (int i = 0; i < 4; ++i) {
        const float x = 0.45f * static_cast<float>(i) - 0.7f;
        btRigidBody& body =
            i % 2 == 0
                ? w->scene.add_box(5, {0.1f, 0.05f, 0.1f}, {x, 0.9f, 0.1f})
                : w->scene.add(5, w->scene.shape<btSphereShape>(btScalar(0.1)), {x, 0.9f, 0.1f});
        EXPECT_TRUE(w->soil->set_options(body, {.ignored = true}));
    }
    return w;
}

/// No soil: a heap of all kinds of shapes that falls apart and goes to sleep piece by piece.
std::unique_ptr<TestWorld> build_heap() {
    auto w = std::make_unique<TestWorld>();
    BulletScene& s = w->scene;
    s.add(0, s.shape<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), {0, 0, 0});
    std::mt19937 random(7);
    const auto uniform = [&](float low, float high) {
        return low + (high - low) * static_cast<float>(random() % 10000) / 10000;
    };
    for (int i = 0; i < 40; ++i) {
        const btVector3 place(uniform(-0.6f, 0.6f), 0.3f + 0.15f * static_cast<float>(i),
                              uniform(-0.6f, 0.6f));
        if (i % 4 == 0) {
            s.add_box(3, {0.15f, 0.1f, 0.2f}, place);
        } else if (i % 4 == 1) {
            s.add(2, s.shape<btSphereShape>(btScalar(0.12)), place);
        } else if (i % 4 == 2) {
            s.add(2, s.shape<btCylinderShape>(btVector3(0.1f, 0.1f, 0.1f)), place);
        } else {
            s.add(4, s.shape<btCapsuleShape>(btScalar(0.08), btScalar(0.2)), place);
        }
        if (i % 5 == 0) {
            s.bodies.back()->setCcdMotionThreshold(btScalar(0.05)),
                s.bodies.back()->setCcdSweptSphereRadius(btScalar(0.05));
        }
    }
    // Steps that do not divide the frame: a part of each is left over.
    w->frame_s = btScalar(1) / 70;
    w->substep_s = btScalar(1) / 120;
    return w;
}

/// The same with compounds and a triangle mesh.
std::unique_ptr<TestWorld> build_compounds() {
    auto w = build_heap();
    BulletScene& s = w->scene;
    static const std::unique_ptr<btTriangleMesh> mesh = [] {
        auto made = std::make_unique<btTriangleMesh>();
        for (int i = -4; i < 4; ++i) {
            for (int k = -4; k < 4; ++k) {
                const auto point = [](int x, int z) {
                    return btVector3(btScalar(x) * 0.5f, 0.1f * btScalar((x + z) & 1),
                                     btScalar(z) * 0.5f);
                };
                made->addTriangle(point(i, k), point(i, k + 1), point(i + 1, k));
                made->addTriangle(point(i + 1, k), point(i, k + 1), point(i + 1, k + 1));
            }
        }
        return made;
    }();
    s.add(0, s.shape<btBvhTriangleMeshShape>(mesh.get(), true), {0, 0.05f, 0});
    for (int i = 0; i < 6; ++i) {
        auto& shape = static_cast<btCompoundShape&>(s.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        for (const float side : {-1.0f, 1.0f}) {
            at.setOrigin(btVector3(0.2f * side, 0, 0));
            shape.addChildShape(at, &s.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f)));
        }
        s.add(5, shape, {0.2f * static_cast<float>(i - 3), 1.5f + 0.4f * static_cast<float>(i), 0});
    }
    return w;
}

/// A multibody of three links that scratches the soil with a motor.
std::unique_ptr<TestWorld> build_multibody() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    BulletScene& s = w->scene;
    const int links = 3;
    w->multibody =
        std::make_unique<btMultiBody>(links, btScalar(20), btVector3(1, 1, 1), false, true);
    btMultiBody& m = *w->multibody;
    m.setBasePos(btVector3(0, 0.65f, 0));
    for (int i = 0; i < links; ++i) {
        m.setupRevolute(i, 4, btVector3(0.1f, 0.1f, 0.1f), i - 1, btQuaternion::getIdentity(),
                        btVector3(0, 0, 1), btVector3(i == 0 ? 0.25f : 0.2f, 0, 0),
                        btVector3(0.2f, 0, 0), true);
    }
    m.finalizeMultiDof();
    s.world->addMultiBody(&m);
    for (int i = -1; i < links; ++i) {
        auto collider = std::make_unique<btMultiBodyLinkCollider>(&m, i);
        collider->setCollisionShape(&s.shape<btBoxShape>(i < 0 ? btVector3(0.25f, 0.15f, 0.3f)
                                                               : btVector3(0.17f, 0.1f, 0.15f)));
        s.world->addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter,
                                    btBroadphaseProxy::AllFilter);
        (i < 0 ? m.setBaseCollider(collider.get())
               : static_cast<void>(m.getLink(i).m_collider = collider.get()));
        w->colliders.push_back(std::move(collider));
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    m.forwardKinematics(rotations, origins);
    m.updateCollisionObjectWorldTransforms(rotations, origins);
    auto motor = std::make_unique<btMultiBodyJointMotor>(&m, 1, btScalar(-0.8), btScalar(2));
    s.world->addMultiBodyConstraint(motor.get());
    motor->finalizeMultiDof();
    w->multibody_constraints.push_back(std::move(motor));
    s.add_box(30, {0.2f, 0.15f, 0.2f}, {-0.8f, 0.6f, 0.5f});
    return w;
}

/// A car that spins its wheels, is steered over a block that lifts it, coasts, is braked and goes
/// to sleep; each command is given once. substeps: of 1/60 s, as is the soil's step.
std::unique_ptr<TestWorld> build_car(int substeps, const SoilWheelDef& wheel = {.width_m = 0.24}) {
    auto w = std::make_unique<TestWorld>();
    w->substep_s = kFrameS / btScalar(substeps);
    SoilDef def;
    def.material.shear_displacement_m = 0.02;
    def.size_m = {6, 1.2, 2.4};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    w->soil = std::move(*SoilAction::create(w->world(), def));
    EXPECT_TRUE(w->soil->fill(BoxFill{{{-9, -1, -9}, {9, 0.5, 9}}, "dry_sand"}));
    w->scene.add_box(0, {0.3f, 0.4f, 0.25f}, {0.3f, 0.4f, 0.6f});
    w->caster = std::make_unique<SoilRaycaster>(*w->soil);
    w->car = std::make_unique<Car>(w->scene, *w->caster, 800, btVector3(-1.4f, 1.5f, 0));
    w->car->chassis.setActivationState(ACTIVE_TAG);
    w->command = [](TestWorld& t) {
        if (t.frame == 20) t.car->drive(5000);
        if (t.frame == 70) {
            for (int i = 0; i < 2; ++i) t.car->vehicle->setSteeringValue(0.2f, i);
        }
        if (t.frame == 64) t.car->drive(0);
        if (t.frame == 80) t.car->brake(15);
        if (t.frame == 150) t.car->chassis.forceActivationState(WANTS_DEACTIVATION);
    };
    EXPECT_TRUE(w->caster->attach(*w->car->vehicle, wheel));
    return w;
}

class WorldSnapshot : public testing::Test {
  protected:
    std::string path(const std::string& name) const {
        return (std::filesystem::temp_directory_path() /
                ("bsoil_world_" + std::to_string(getpid()) + "_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name() + "_" + name))
            .string();
    }
    void TearDown() override {
        for (const char* name : {"a", "b"}) std::filesystem::remove(path(name));
    }
    static std::vector<char> bytes_of(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write_bytes(const std::string& file, const std::vector<char>& bytes) {
        std::ofstream(file, std::ios::binary)
            .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    /// Runs a world, saves it, goes on; restores another and compares every step after.
    void expect_goes_on(const Build& build, int before, int after, bool saving_shows = false) {
        const std::unique_ptr<TestWorld> alone = build(), saved = build(), restored = build();
        alone->run(before);
        saved->run(before);
        Status done = saved->save(path("a"));
        ASSERT_TRUE(done) << done.error();
        ASSERT_EQ(saved->checksum(), alone->checksum());
        restored->run(3);  // another history
        restored->frame = saved->frame;
        done = restored->load(path("a"));
        ASSERT_TRUE(done) << done.error();
        ASSERT_EQ(restored->checksum(), saved->checksum());
        if (!saving_shows) {  // nothing that is saved got lost
            done = restored->save(path("b"));
            ASSERT_TRUE(done) << done.error();
            ASSERT_EQ(bytes_of(path("b")), bytes_of(path("a")));
        }
        for (int i = 1; i <= after; ++i) {
            saved->step();
            restored->step();
            alone->step();
            ASSERT_EQ(restored->checksum(), saved->checksum())
                << "saved after " << before << " frames, frame " << i << " after";
            if (!saving_shows) {
                ASSERT_EQ(alone->checksum(), saved->checksum())
                    << "not saved at all, frame " << i << " after " << before;
            }
        }
    }
};

TEST_F(WorldSnapshot, machine_on_soil_goes_on_bit_for_bit) {
    for (const int before : {0, 1, 40}) expect_goes_on(build_machine, before, 40);
}

TEST_F(WorldSnapshot, bodies_on_the_ground_go_on_bit_for_bit_while_it_slumps) {
    // The ground is a mesh to Bullet: its contacts are found anew when the world is saved.
    for (const int before : {20, 30, 40, 50, 60}) {
        expect_goes_on(build_bodies_on_ground, before, 60, true);
    }
}

TEST_F(WorldSnapshot, a_ball_goes_on_bit_for_bit_from_anywhere_in_its_impact) {
    const auto dropped = [] {
        auto world = std::make_unique<TestWorld>();
        SoilDef def;
        def.size_m = {2, 1, 2};
        def.backend = Backend::cpu;
        auto soil = SoilAction::create(world->world(), def);
        EXPECT_TRUE(soil) << soil.error();
        world->soil = std::move(*soil);
        EXPECT_TRUE(world->soil->fill(BoxFill{{{-1, 0, -1}, {1, 0.4, 1}}, "dry_sand"}));
        world->scene.add(200, world->scene.shape<btSphereShape>(btScalar(0.3)),
                         {0, btScalar(1.4), 0});
        return world;
    };
    for (const int before : {21, 22, 23, 24, 26, 40}) expect_goes_on(dropped, before, 30);
}

TEST_F(WorldSnapshot, heap_goes_on_bit_for_bit_while_it_falls_and_sleeps) {
    for (const int before : {0, 25, 90, 300}) expect_goes_on(build_heap, before, 120);
}

TEST_F(WorldSnapshot, compounds_and_meshes_go_on_as_the_run_that_saved) {
    for (const int before : {30, 120}) expect_goes_on(build_compounds, before, 120, true);
}

TEST_F(WorldSnapshot, multibody_on_soil_goes_on_bit_for_bit) {
    for (const int before : {1, 45}) expect_goes_on(build_multibody, before, 45);
}

TEST_F(WorldSnapshot, raycast_vehicle_goes_on_bit_for_bit) {
    const auto alone = build_car(1), saved = build_car(1);
    const auto report = [&](int i) { return saved->caster->wheel_report(i); };
    const auto in_contact = [&](int i) {
        return saved->car->vehicle->getWheelInfo(i).m_raycastInfo.m_isInContact;
    };
    const auto standing = [&] { return report(0).is_on_soil && report(3).is_on_soil; };
    const auto spinning = [&] { return report(0).slip > 0.3; };
    const auto steered = [&] {
        return saved->car->vehicle->getSteeringValue(0) > 0 && report(0).side_force_n != 0;
    };
    const auto some_in_the_air = [&] {
        int count = 0;
        for (int i = 0; i < 4; ++i) count += in_contact(i) ? 0 : 1;
        return count > 0;
    };
    const auto braked = [&] {
        return saved->car->vehicle->getWheelInfo(0).m_brake > 0 && std::abs(report(0).slip) > 0;
    };
    const auto asleep = [&] { return !saved->car->chassis.isActive(); };
    const std::pair<const char*, std::function<bool()>> moments[] = {
        {"at the start", [&] { return saved->frame == 0; }},
        {"after a step", [&] { return saved->frame == 1; }},
        {"one in the air", some_in_the_air},
        {"standing", standing},
        {"spinning", spinning},
        {"steered", steered},
        {"braked", braked},
        {"asleep", asleep}};
    constexpr int kFrames = 300, kAfter = 60;
    std::vector<uint64_t> expected{alone->checksum()};
    for (int i = 0; i < kFrames + kAfter; ++i) {
        alone->step();
        expected.push_back(alone->checksum());
    }
    std::set<std::string> tried;
    for (; saved->frame <= kFrames; saved->step()) {
        const int frame = saved->frame;
        ASSERT_EQ(saved->checksum(), expected[static_cast<size_t>(frame)]);
        const auto moment =
            std::find_if(std::begin(moments), std::end(moments),
                         [&](const auto& m) { return !tried.contains(m.first) && m.second(); });
        if (moment == std::end(moments)) continue;
        tried.insert(moment->first);
        SCOPED_TRACE(testing::Message() << moment->first << ", frame " << frame);
        Status done = saved->save(path("a"));
        ASSERT_TRUE(done) << done.error();
        const auto restored = build_car(1);
        restored->run(3);  // another history
        restored->frame = frame;
        done = restored->load(path("a"));
        ASSERT_TRUE(done) << done.error();
        ASSERT_TRUE(restored->save(path("b")));
        ASSERT_EQ(bytes_of(path("b")), bytes_of(path("a")));
        for (int i = frame; i <= frame + kAfter; ++i) {
            ASSERT_EQ(restored->checksum(), expected[static_cast<size_t>(i)]) << i;
            restored->step();
        }
    }
    for (const auto& moment : moments) EXPECT_TRUE(tried.contains(moment.first)) << moment.first;
}

TEST_F(WorldSnapshot, raycast_vehicle_goes_on_in_the_middle_of_a_soil_step) {
    expect_goes_on([] { return build_car(3); }, 60, 20);
    const auto slow = [] {
        auto w = build_car(1);
        w->substep_s = w->frame_s = kFrameS / 3;
        return w;
    };
    for (const int before : {79, 80, 81}) expect_goes_on(slow, before, 20);
}

TEST_F(WorldSnapshot, other_raycast_vehicles_are_refused_by_name) {
    const auto saved = build_car(1);
    saved->run(10);
    ASSERT_TRUE(saved->save(path("a")));
    const auto expect = [&](TestWorld& w, const std::string& words) {
        w.run(5);
        const uint64_t before = w.checksum();
        for (const Status& status : {w.load(path("a")), w.soil->load(path("a"))}) {
            ASSERT_FALSE(status) << words;
            EXPECT_NE(status.error().find(words), std::string::npos) << status.error();
        }
        EXPECT_EQ(w.checksum(), before);
    };
    expect(*build_car(1, {.width_m = 0.25}), "wheel 0 of vehicle 0 has here width_m 0.25");
    expect(*build_car(1, {.width_m = 0.24, .surface = {.friction = 0.3}}), "friction 0.3");
    const auto larger = build_car(1);
    larger->car->vehicle->getWheelInfo(2).m_wheelsRadius = 0.5f;
    ASSERT_TRUE(larger->caster->attach(*larger->car->vehicle, SoilWheelDef{.width_m = 0.24}));
    expect(*larger, "wheel 2 of vehicle 0 has here m_wheelsRadius 0.5");
    const auto six = build_car(1);
    for (const btScalar z : {-0.6f, 0.6f}) {
        six->car->vehicle->addWheel({0, -0.2f, z}, {0, -1, 0}, {0, 0, 1}, Car::kRestM,
                                    Car::kRadiusM, six->car->tuning, false);
    }
    ASSERT_TRUE(six->caster->attach(*six->car->vehicle, SoilWheelDef{.width_m = 0.24}));
    expect(*six, "4 wheels of vehicle 0 in the snapshot, 6 here");
    const auto detached = build_car(1);
    detached->caster->detach();
    expect(*detached, "1 vehicles attached to a SoilRaycaster in the snapshot, 0 here");
    // Bullet's part alone: a vehicle that is no action of the world.
    const auto without = build_car(1);
    without->world().removeVehicle(without->car->vehicle.get());
    const uint64_t before = without->checksum();
    const Status missing = without->load(path("a"));
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().find("1 vehicles in the snapshot, 0 here"), std::string::npos)
        << missing.error();
    EXPECT_EQ(without->checksum(), before);
}

TEST_F(WorldSnapshot, soil_and_coupling_alone_go_on_where_the_host_puts_the_bodies) {
    // Kinematic bodies only: their poses are the host's.
    const auto build = [] {
        auto w = std::make_unique<TestWorld>();
        add_soil(*w);
        w->motion_states.push_back(std::make_unique<btDefaultMotionState>(
            btTransform(btQuaternion::getIdentity(), btVector3(-0.9f, 0.42f, 0))));
        BulletScene& s = w->scene;
        s.bodies.push_back(std::make_unique<btRigidBody>(
            0, w->motion_states.back().get(), &s.shape<btBoxShape>(btVector3(0.1f, 0.2f, 0.2f))));
        w->driven = s.bodies.back().get();
        w->driven->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        w->driven->setActivationState(DISABLE_DEACTIVATION);
        s.world->addRigidBody(w->driven);
        return w;
    };
    const auto saved = build(), restored = build();
    saved->run(30);
    ASSERT_TRUE(saved->soil->save(path("a")));
    restored->frame = 29;
    restored->step();  // brings the body there
    const Status loaded = restored->soil->load(path("a"));
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(restored->soil->step_count(), saved->soil->step_count());
    const BodyReport report = saved->soil->body_report(*saved->driven);
    EXPECT_GT(length(report.force_n), 0);
    EXPECT_EQ(restored->soil->body_report(*restored->driven).force_n.x, report.force_n.x);
    EXPECT_EQ(restored->soil->body_report(*restored->driven).peak_force_n, report.peak_force_n);
    for (int i = 0; i < 30; ++i) {
        saved->step();
        restored->step();
        ASSERT_EQ(restored->soil->soil().checksum(), saved->soil->soil().checksum()) << i;
        ASSERT_EQ(restored->soil->body_report(*restored->driven).force_n.x,
                  saved->soil->body_report(*saved->driven).force_n.x);
    }
}

TEST_F(WorldSnapshot, a_soil_that_is_off_stays_off) {
    const auto saved = build_machine(), restored = build_machine();
    saved->run(20);
    saved->soil->set_enabled(false);
    saved->run(2);
    ASSERT_TRUE(saved->save(path("a")));
    restored->frame = saved->frame;
    ASSERT_TRUE(restored->load(path("a")));
    EXPECT_FALSE(restored->soil->is_enabled());
    for (int i = 0; i < 20; ++i) {
        if (i == 5) {
            for (TestWorld* w : {saved.get(), restored.get()}) w->soil->set_enabled(true);
        }
        saved->step();
        restored->step();
        ASSERT_EQ(restored->checksum(), saved->checksum()) << i;
    }
}

TEST_F(WorldSnapshot, a_world_that_has_blown_up_can_be_put_back) {
    const auto w = build_heap();
    w->run(20);
    ASSERT_TRUE(w->save(path("a")));
    const uint64_t good = w->checksum();
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    w->scene.bodies[5]->setLinearVelocity(btVector3(nan, 0, 0));
    const Status refused = w->save(path("b"));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("finite"), std::string::npos) << refused.error();
    const Status loaded = w->load(path("a"));
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(w->checksum(), good);
}

TEST_F(WorldSnapshot, damaged_files_are_refused_and_change_nothing) {
    const auto w = build_machine(), twin = build_machine();
    w->run(8);
    twin->run(8);
    ASSERT_TRUE(w->save(path("a")));
    const std::vector<char> good = bytes_of(path("a"));
    w->run(2);
    twin->run(2);
    const uint64_t checksum = w->checksum();
    const auto expect_refused = [&](const std::vector<char>& bytes, const std::string& what) {
        write_bytes(path("b"), bytes);
        for (const Status& status : {w->load(path("b")), w->soil->load(path("b"))}) {
            ASSERT_FALSE(status) << what;
            ASSERT_NE(status.error().find(path("b")), std::string::npos) << status.error();
        }
        ASSERT_EQ(w->checksum(), checksum) << what;
    };
    std::mt19937 random(3);
    for (size_t i = 0; i < 400; ++i) {
        std::vector<char> flipped = good;
        const size_t at = i < 200 ? i : random() % good.size();
        flipped[at] = static_cast<char>(flipped[at] ^ (1 << random() % 8));
        expect_refused(flipped, "bit flipped in byte " + std::to_string(at));
    }
    for (const size_t size : {size_t{0}, size_t{7}, size_t{16}, size_t{60}, size_t{200},
                              good.size() / 2, good.size() - 1}) {
        expect_refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)},
                       "cut to " + std::to_string(size));
    }
    std::vector<char> longer = good;
    longer.push_back('x');
    expect_refused(longer, "a byte too many");
    expect_refused({}, "empty");
    w->run(10);
    twin->run(10);
    EXPECT_EQ(w->checksum(), twin->checksum());
}

// A hash keeps accidents out, not someone who computes it anew: whatever stands in a section, the
// world is whole after, and as it was where an error is returned.
TEST_F(WorldSnapshot, forged_sections_are_refused_or_harmless) {
    for (const Build& build : {Build(build_machine), Build([] { return build_car(1); })}) {
        const auto w = build();
        w->run(8);
        ASSERT_TRUE(w->save(path("a")));
        const auto sections = read_snapshot_file(path("a"));
        ASSERT_TRUE(sections);
        std::mt19937 random(4);
        int refused = 0;
        for (int i = 0; i < 300; ++i) {
            std::vector<SnapshotSection> forged = *sections;
            std::vector<uint8_t>& bytes = forged[random() % forged.size()].bytes;
            const size_t at = random() % bytes.size();
            if (i % 4 == 0) {
                bytes.resize(at);
            } else if (i % 4 == 1) {
                std::fill(
                    bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at + 8, bytes.size())),
                    static_cast<uint8_t>(0xff));
            } else {
                bytes[at] = static_cast<uint8_t>(random());
            }
            ASSERT_TRUE(write_snapshot_file(path("b"), forged));
            const uint64_t before = w->checksum();
            if (w->load(path("b"))) {
                const Status back = w->load(path("a"));
                ASSERT_TRUE(back) << back.error() << i;
            } else {
                ++refused;
                ASSERT_EQ(w->checksum(), before) << i;
            }
            if (i % 40 == 0) w->step();
        }
        EXPECT_GT(refused, 150);
        w->run(20);
    }
}

TEST_F(WorldSnapshot, sizes_in_the_head_are_not_believed) {
    const SnapshotSection section{"soil", std::vector<uint8_t>(1000, 7)};
    ASSERT_TRUE(write_snapshot_file(path("a"), {&section, 1}));
    const std::vector<char> good = bytes_of(path("a"));
    for (const size_t at : {size_t{12}, size_t{32}, size_t{40}}) {  // sections, content, frame
        std::vector<char> huge = good;
        for (size_t i = 0; i < 4; ++i) huge[at + i] = static_cast<char>(0x7f);
        if (at > 12) huge[at + 7] = static_cast<char>(0x7f);
        // The head's own hash would catch it: make it fit.
        const size_t head = 16 + 40;
        uint64_t hash = 0xcbf29ce484222325ull;
        hash = add(hash, huge.data(), head);
        std::memcpy(huge.data() + head, &hash, sizeof(hash));
        write_bytes(path("b"), huge);
        const auto read = read_snapshot_file(path("b"));
        ASSERT_FALSE(read) << at;
        EXPECT_NE(read.error().find("damaged"), std::string::npos) << read.error();
    }
    std::vector<char> other = good;
    other[8] = 2;
    write_bytes(path("b"), other);
    const auto read = read_snapshot_file(path("b"));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().find("version 2"), std::string::npos) << read.error();
}

TEST_F(WorldSnapshot, another_world_or_soil_is_refused_by_name) {
    const auto saved = build_machine();
    saved->run(5);
    ASSERT_TRUE(saved->save(path("a")));
    const auto expect = [&](TestWorld& w, const std::string& words) {
        const uint64_t before = w.checksum();
        const Status status = w.load(path("a"));
        ASSERT_FALSE(status) << words;
        EXPECT_NE(status.error().find(words), std::string::npos) << status.error();
        EXPECT_EQ(w.checksum(), before);
    };
    const auto more = build_machine();
    more->scene.add_box(1, {0.1f, 0.1f, 0.1f}, {0, 3, 0});
    expect(*more, "collision objects");
    const auto heavy = build_machine();
    heavy->scene.bodies[0]->setMassProps(41, btVector3(1, 1, 1));
    expect(*heavy, "mass_kg 41");
    const auto indexed = build_machine();
    indexed->scene.bodies[1]->setUserIndex(3);
    expect(*indexed, "user index 3");
    const auto loose = build_machine();
    loose->world().removeConstraint(loose->constraints[0].get());
    expect(*loose, "constraints");
    loose->constraints.clear();
    const auto bare = build_heap();
    expect(*bare, "another world");
    const auto finer = build_machine();
    finer->soil.reset();
    SoilDef def;
    def.material.shear_displacement_m = 0.03;  // the only difference
    def.size_m = {3.2, 0.9, 2.4};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    // The soil's anchor goes to the end of the list; a world of that order is another one.
    finer->soil = std::move(*SoilAction::create(finer->world(), def));
    expect(*finer, "another world");
    const Status soil = finer->soil->soil().load(path("a"));
    ASSERT_FALSE(soil);
    EXPECT_NE(soil.error().find("shear_displacement_m of material 'dry_sand' 0.02"),
              std::string::npos)
        << soil.error();
    EXPECT_FALSE(save_world(saved->world(), {}, path("b")));  // has a soil that is not given
    btSimpleBroadphase simple;
    btDiscreteDynamicsWorld other(&saved->scene.dispatcher, &simple, &saved->scene.solver,
                                  &saved->scene.configuration);
    const Status broadphase = save_world(other, {}, path("b"));
    ASSERT_FALSE(broadphase);
    EXPECT_NE(broadphase.error().find("btDbvtBroadphase"), std::string::npos);
}

}  // namespace
}  // namespace bsoil::bullet
