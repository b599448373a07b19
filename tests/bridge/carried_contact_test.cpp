// Bodies on soil that other bodies carry: what holds them up is the carrier, through the soil.
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodySliderConstraint.h>

#include <cstring>
#include <filesystem>

#include "bsoil/bullet/world_snapshot.h"
#include "sand_bed.h"
#include "temporary_file.h"

namespace bsoil::bullet::carried_contact_test {
namespace {

constexpr double kFloorM = 0.6;  ///< height of the bed's floor
constexpr double kSoilM = 0.15;  ///< of the soil on it
constexpr btScalar kRockKg = 40;
constexpr double kRockWeightN = 40 * kGravity_m_s2;
const btVector3 kRockHalf(btScalar(0.1), btScalar(0.1), btScalar(0.1));

/// What a bed is to Bullet.
enum class Bed { rigid, link, kinematic };

std::string name_of(const testing::TestParamInfo<Bed>& info) {
    return info.param == Bed::rigid ? "rigid" : info.param == Bed::link ? "link" : "kinematic";
}

/// A box of 1 x 1 m without a lid, of walls of 10 cm, that stands on a spring of the test's own or
/// is moved by hand; sand lies in it.
class TruckBed {
  public:
    static constexpr btScalar kMassKg = 200;
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    btRigidBody* rigid = nullptr;
    std::unique_ptr<btMultiBody> multibody;
    std::unique_ptr<btMultiBodyLinkCollider> collider;

    explicit TruckBed(Bed kind, bool rests_on_blocks = true) {
        auto& shape = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
        const auto wall = [&](btVector3 half, btVector3 at) {
            btTransform pose = btTransform::getIdentity();
            pose.setOrigin(at);
            shape.addChildShape(pose, &scene.shape<btBoxShape>(half));
        };
        const auto half = btScalar(0.6), thin = btScalar(0.05), high = btScalar(0.2);
        wall({half, thin, half}, {0, -thin, 0});
        for (const btScalar side : {btScalar(-1), btScalar(1)}) {
            wall({thin, high, half}, {side * (half - thin), high, 0});
            wall({half, high, thin}, {0, high, side * (half - thin)});
        }
        const btVector3 at(0, btScalar(kFloorM), 0);
        if (kind == Bed::link) {
            add_slider(shape, at);
        } else {
            rigid = &scene.add(kind == Bed::rigid ? kMassKg : 0, shape, at);
            if (kind == Bed::rigid) {
                rigid->setLinearFactor(btVector3(0, 1, 0));
                rigid->setAngularFactor(btVector3(0, 0, 0));
            } else {
                rigid->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
                rigid->setActivationState(DISABLE_DEACTIVATION);
            }
        }
        SoilDef def = small_bed();
        def.size_m = {2, 1.5, 2};
        auto made = SoilAction::create(*scene.world, def);
        EXPECT_TRUE(made) << made.error();
        soil = std::move(*made);
        EXPECT_TRUE(soil->fill(
            BoxFill{{{-0.5, kFloorM, -0.5}, {0.5, kFloorM + kSoilM, 0.5}}, def.material.name}));
        if (rests_on_blocks && kind != Bed::kinematic) {
            for (const btScalar x : {btScalar(-0.5), btScalar(0.5)}) {
                for (const btScalar z : {btScalar(-0.5), btScalar(0.5)}) {
                    blocks_.push_back(
                        &scene.add_box(0, {btScalar(0.05), btScalar(0.2), btScalar(0.05)},
                                       {x, btScalar(kFloorM - 0.1 - 0.2), z}));
                }
            }
        }
    }
    ~TruckBed() {
        if (!multibody) return;
        scene.world->removeCollisionObject(collider.get());
        scene.world->removeMultiBody(multibody.get());
    }

    btRigidBody& add_rock() {
        btRigidBody& rock = scene.add_box(
            kRockKg, kRockHalf, btVector3(0, btScalar(kFloorM + kSoilM) + btScalar(0.11), 0));
        return rock;
    }
    btCollisionObject& object() {
        return rigid ? static_cast<btCollisionObject&>(*rigid) : *collider;
    }
    double velocity_m_s() const {
        return static_cast<double>(rigid ? rigid->getLinearVelocity().y()
                                         : multibody->getJointVel(0));
    }
    double load_kg() const {
        return soil->body_report(rigid ? static_cast<const btCollisionObject&>(*rigid) : *collider)
            .load_kg;
    }
    /// What Bullet's own contacts push the bed up with, mean over a time.
    double mean_stand_n(double seconds) {
        double sum = 0;
        const int frames = static_cast<int>(seconds * 60 + 0.5);
        for (int i = 0; i < frames; ++i) {
            scene.run(1.0 / 60);
            for (int k = 0; k < scene.dispatcher.getNumManifolds(); ++k) {
                const btPersistentManifold& m = *scene.dispatcher.getManifoldByIndexInternal(k);
                const bool is_a = m.getBody0() == &object();
                if (!is_a && m.getBody1() != &object()) continue;
                for (int p = 0; p < m.getNumContacts(); ++p) {
                    const btManifoldPoint& point = m.getContactPoint(p);
                    sum += (is_a ? 1 : -1) * static_cast<double>(point.m_appliedImpulse) * 60 *
                           static_cast<double>(point.m_normalWorldOnB.y());
                }
            }
        }
        return sum / frames;
    }

  private:
    void add_slider(btCollisionShape& shape, const btVector3& at) {
        btVector3 inertia;
        shape.calculateLocalInertia(kMassKg, inertia);
        multibody = std::make_unique<btMultiBody>(1, 0, btVector3(0, 0, 0), true, true);
        multibody->setupPrismatic(0, kMassKg, inertia, -1, btQuaternion::getIdentity(),
                                  btVector3(0, 1, 0), at, btVector3(0, 0, 0), true);
        multibody->finalizeMultiDof();
        multibody->setLinearDamping(0);
        multibody->setAngularDamping(0);
        scene.world->addMultiBody(multibody.get());
        collider = std::make_unique<btMultiBodyLinkCollider>(multibody.get(), 0);
        collider->setCollisionShape(&shape);
        collider->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        multibody->getLink(0).m_collider = collider.get();
        scene.world->addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter,
                                        btBroadphaseProxy::AllFilter);
    }
    std::vector<btRigidBody*> blocks_;
};

class RockOnBed : public testing::TestWithParam<Bed> {};
/// A kinematic bed feels nothing and never sleeps.
class RockOnDynamicBed : public RockOnBed {};

TEST_P(RockOnBed, is_held_up_at_the_soils_surface) {
    TruckBed bed(GetParam());
    bed.scene.run(1);
    btRigidBody& rock = bed.add_rock();
    bed.scene.run(4);
    const double bottom_m = height_of(rock) - static_cast<double>(kRockHalf.y());
    // 40 kg on 20 x 20 cm are 10 kPa, which loose sand bears at some centimetres.
    EXPECT_GT(bottom_m, kFloorM + kSoilM - 0.07);
    EXPECT_LT(bottom_m, kFloorM + kSoilM + 0.01);
    EXPECT_NEAR(bed.soil->body_report(rock).force_n.y, kRockWeightN, 0.02 * kRockWeightN);
    EXPECT_GT(bed.soil->body_report(rock).sinkage_m, 0);
    // To the last bit, while it is awake and when it sleeps.
    for (int frame = 0; frame < 180; ++frame) {
        const BodyReport of_rock = bed.soil->body_report(rock);
        const BodyReport of_bed = bed.soil->body_report(bed.object());
        ASSERT_EQ(of_bed.through_load_n, -of_rock.force_n);
        ASSERT_EQ(of_rock.through_load_n, Vec3{});
        bed.scene.run(1.0 / 60);
    }
}

TEST_P(RockOnDynamicBed, weighs_on_the_bed_as_much_as_it_weighs) {
    TruckBed bed(GetParam());
    bed.scene.run(2);
    const double before_n = bed.mean_stand_n(1);
    const double load_kg = bed.load_kg();
    // The bed and all of its sand.
    const double sand_kg = bed.soil->soil().totals().mass_kg.front();
    EXPECT_NEAR(load_kg, sand_kg, 0.01 * sand_kg);
    EXPECT_NEAR(before_n, (200 + load_kg) * kGravity_m_s2, 0.01 * before_n);
    bed.add_rock();
    bed.scene.run(3);
    EXPECT_NEAR(bed.mean_stand_n(1) - before_n - (bed.load_kg() - load_kg) * kGravity_m_s2,
                kRockWeightN, 0.02 * kRockWeightN);
}

// The bed falls, or is thrown, with all that is in it: no force from outside but gravity.
TEST_P(RockOnDynamicBed, and_bed_keep_their_momentum_in_free_fall) {
    TruckBed bed(GetParam(), false);
    bed.scene.world->setGravity(btVector3(0, 0, 0));
    btRigidBody& rock = bed.add_rock();
    rock.setGravity(btVector3(0, 0, 0));
    if (bed.rigid) bed.rigid->setGravity(btVector3(0, 0, 0));
    rock.setLinearVelocity(btVector3(0, btScalar(-1.5), 0));
    double impulse_n_s = 0;
    for (int i = 0; i < 20; ++i) {
        const double before = static_cast<double>(rock.getLinearVelocity().y());
        const double bed_before = bed.velocity_m_s();
        const double load_kg = bed.load_kg();
        bed.scene.run(1.0 / 60);
        const double given = static_cast<double>(kRockKg) *
                             (static_cast<double>(rock.getLinearVelocity().y()) - before);
        // The soil's own gravity, and what its slower fall leaves of the bed's momentum.
        const double taken = (200 + load_kg) * (bed.velocity_m_s() - bed_before) -
                             bed.soil->body_report(bed.object()).load_n.y / 60;
        impulse_n_s += given;
        EXPECT_NEAR(given + taken, 0, 0.02 * static_cast<double>(kRockKg) * 1.5) << "frame " << i;
    }
    EXPECT_GT(impulse_n_s, 0.5 * 40 * 1.5);
}

TEST_P(RockOnDynamicBed, falls_asleep_with_it) {
    TruckBed bed(GetParam());
    btRigidBody& rock = bed.add_rock();
    bed.scene.run(8);
    EXPECT_FALSE(rock.isActive());
    EXPECT_FALSE(bed.object().isActive());
    const double height_m = height_of(rock);
    bed.scene.run(4);
    EXPECT_FALSE(rock.isActive());
    EXPECT_EQ(height_of(rock), height_m);
}

INSTANTIATE_TEST_SUITE_P(Beds, RockOnBed, testing::Values(Bed::rigid, Bed::link, Bed::kinematic),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Beds, RockOnDynamicBed, testing::Values(Bed::rigid, Bed::link), name_of);

TEST(RockOnLift, goes_up_and_along_with_it) {
    TruckBed bed(Bed::kinematic);
    btRigidBody& rock = bed.add_rock();
    bed.scene.run(2);
    const btVector3 start = rock.getWorldTransform().getOrigin();
    constexpr double kSpeed = 0.1;
    for (int i = 0; i < 90; ++i) {
        btTransform pose = bed.rigid->getWorldTransform();
        pose.setOrigin(pose.getOrigin() +
                       btVector3(btScalar(kSpeed / 60), btScalar(kSpeed / 60), 0));
        bed.rigid->setWorldTransform(pose);
        bed.rigid->setInterpolationWorldTransform(pose);
        bed.rigid->setInterpolationLinearVelocity(btVector3(btScalar(kSpeed), btScalar(kSpeed), 0));
        bed.scene.run(1.0 / 60);
    }
    const btVector3 moved = rock.getWorldTransform().getOrigin() - start;
    EXPECT_NEAR(moved.x(), 0.15, 0.02);  // it lags by what its friction takes to develop
    EXPECT_NEAR(moved.y(), 0.15, 0.03);  // the soil gives way a little more while it rises
    EXPECT_NEAR(rock.getLinearVelocity().x(), kSpeed, 0.02);
}

TEST(RockOnBedSnapshot, goes_on_bit_for_bit) {
    const TemporaryFile file("rock_on_bed.snapshot");
    const auto state = [](TruckBed& bed) {
        std::vector<btScalar> out;
        for (const auto& body : bed.scene.bodies) {
            for (int i = 0; i < 3; ++i) {
                out.push_back(body->getWorldTransform().getOrigin()[i]);
                out.push_back(body->getLinearVelocity()[i]);
                out.push_back(body->getAngularVelocity()[i]);
            }
        }
        return out;
    };
    TruckBed one(Bed::rigid), two(Bed::rigid);
    one.add_rock();
    two.add_rock();
    one.scene.run(0.5);
    SoilAction* soils[] = {one.soil.get()};
    ASSERT_TRUE(save_world(*one.scene.world, soils, file.path()));
    SoilAction* other[] = {two.soil.get()};
    const Status loaded = load_world(*two.scene.world, other, file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    const Vec3 pressed_n = one.soil->body_report(one.object()).through_load_n;
    EXPECT_LT(pressed_n.y, -0.5 * kRockWeightN);
    EXPECT_EQ(two.soil->body_report(two.object()).through_load_n, pressed_n);
    for (int i = 0; i < 30; ++i) {
        one.scene.run(1.0 / 60);
        two.scene.run(1.0 / 60);
        ASSERT_EQ(state(one), state(two)) << "frame " << i;
        ASSERT_EQ(one.soil->soil().checksum(), two.soil->soil().checksum()) << "frame " << i;
    }
}

// A loose block under the sand, and a wheel's load over it.
TEST(BuriedBlock, takes_the_load_of_what_stands_over_it) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& block =
        scene.add_box(20, btVector3(btScalar(0.15), btScalar(0.05), btScalar(0.15)),
                      btVector3(0, btScalar(kBedTopM - 0.1), 0));
    scene.run(2);
    btRigidBody& box = scene.add_box(60, btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1)),
                                     btVector3(0, btScalar(kBedTopM + 0.11), 0));
    scene.run(4);
    const double bottom_m = height_of(box) - 0.1;
    const double block_top_m = height_of(block) + 0.05;
    EXPECT_GE(bottom_m, block_top_m - 0.005);
    EXPECT_NEAR(soil->body_report(box).force_n.y, 60 * kGravity_m_s2, 0.1 * 60 * kGravity_m_s2);
    EXPECT_LT(std::abs(static_cast<double>(box.getLinearVelocity().y())), 0.01);
}

/// How far a plate of 0.4 m under 0.25 m of sand rises in a second, drawn up with its own weight
/// and `share` times that of the soil on it.
double rises_m(double share) {
    BulletScene scene;
    constexpr btScalar kPlateKg = 20;
    btRigidBody& plate =
        scene.add_box(kPlateKg, btVector3(0.2f, 0.05f, 0.2f), btVector3(0, 0.1f, 0));
    const auto soil = sand_bed(*scene.world);
    scene.run(1);
    const double before_m = height_of(plate);
    const double load_kg = soil->body_report(plate).load_kg;
    plate.setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < 60; ++i) {
        plate.applyCentralForce(
            btVector3(0, btScalar((kPlateKg + share * load_kg) * kGravity_m_s2), 0));
        scene.run(1.0 / 60);
    }
    return height_of(plate) - before_m;
}

// The column's sides hold it, whoever pulls: by hand 1 + 2 K0 tan phi 0.25 / 0.4 = 1.37. Found:
// still at 1.3, out at 1.4.
TEST(CarriedColumn, in_its_bed_is_held_by_the_sides_of_its_column) {
    EXPECT_LT(rises_m(1.25), 1e-3);
    EXPECT_GT(rises_m(1.5), 0.1);
}

}  // namespace
}  // namespace bsoil::bullet::carried_contact_test
