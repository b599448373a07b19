#include "snapshot_worlds.h"

#include <random>

namespace bsoil::bullet {

TestWorld::~TestWorld() {
    soil.reset();
    for (const auto& c : constraints) scene.world->removeConstraint(c.get());
    for (const auto& c : multibody_constraints) scene.world->removeMultiBodyConstraint(c.get());
    for (const auto& c : colliders) scene.world->removeCollisionObject(c.get());
    if (multibody) scene.world->removeMultiBody(multibody.get());
}

void TestWorld::step() {
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

uint64_t TestWorld::checksum() const {
    uint64_t hash = soil ? soil->soil().checksum() : 1;
    hash = add_objects(hash, *scene.world);
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
        const double of_soil[] = {
            report.normal_force_n, report.traction_n, report.side_force_n, report.torque_n_m,
            report.sinkage_m,      report.spin_rad_s, report.slip};
        hash = add(hash, of_soil, sizeof(of_soil));
    }
    return hash;
}

void add_soil(TestWorld& w, const SoilActionDef& options) {
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

void add_driven_blade(TestWorld& w) {
    BulletScene& s = w.scene;
    w.motion_states.push_back(std::make_unique<btDefaultMotionState>(
        btTransform(btQuaternion::getIdentity(), btVector3(-0.9f, 0.42f, 0))));
    s.bodies.push_back(std::make_unique<btRigidBody>(
        0, w.motion_states.back().get(), &s.shape<btBoxShape>(btVector3(0.1f, 0.2f, 0.2f))));
    w.driven = s.bodies.back().get();
    w.driven->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    w.driven->setActivationState(DISABLE_DEACTIVATION);
    s.world->addRigidBody(w.driven);
}

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
    add_driven_blade(*w);
    s.add(25, s.shape<btSphereShape>(btScalar(0.15)), {1.1f, 2.5f, 0.6f});
    return w;
}

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

std::unique_ptr<TestWorld> build_car(int substeps, const SoilWheelDef& wheel) {
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

void WorldSnapshot::expect_goes_on(const Build& build, int before, int after, bool saving_shows) {
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

}  // namespace bsoil::bullet
