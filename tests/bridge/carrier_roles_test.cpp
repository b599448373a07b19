// Soil on a body that its host turns kinematic and back, with a stand-in for the soil.
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bullet_scene.h"
#include "bullet_types.h"
#include "flat_soil.h"

namespace bsoil::bullet::carrier_roles_test {
namespace {

constexpr double kStepS = 1.0 / 60;
constexpr double kGravity_m_s2 = 9.81;
constexpr btScalar kLinkKg = 40;
/// From the middle of the bed, which so touches nothing but soil.
constexpr double kSurfaceM = 0.5;

/// Level soil that a bed carries, and that goes up and down with it.
class SoilOnBed final : public btActionInterface {
  public:
    SoilOnBed(btDiscreteDynamicsWorld& world, const btRigidBody& bed)
        : world_(world),
          bed_(bed),
          collector_({{-2, -2, -2}, {2, 2, 2}}),
          coupling_(world, {{0, 1, 0}, kGravity_m_s2, 0.1, {MaterialDef{}}, {}}, known_,
                    SoilActionDef{}, threads_),
          anchor_(
              world, btVector3(0, 0, 0), [this] { coupling_.open_substep(); }, [] {}) {
        world.addAction(this);
    }
    ~SoilOnBed() override { world_.removeAction(this); }

    void updateAction(btCollisionWorld*, btScalar substep_s) override {
        coupling_.close_substep(substep_s);
        collector_.collect(world_, kStepS);
        const int carrier = collector_.body_id(bed_);
        const double level_m = from_bullet(bed_.getWorldTransform().getOrigin()).y + kSurfaceM;
        contacts_.clear();
        for (const SoilBody& body : collector_.soil_bodies(0)) {
            if (body.id == carrier) continue;
            for (ContactVoxel v : surface_points(body.shapes->front(), 6)) {
                v.center_m = v.position_m = transform(body.pose, v.position_m);
                v.normal = rotate(body.pose.rotation, v.normal);
                v.body = body.id;
                v.carrier = carrier;
                v.depth_m = v.bearing_depth_m = level_m - v.position_m.y;
                if (v.depth_m > 0) contacts_.push_back(v);
            }
        }
        coupling_.set_contacts(collector_.bodies(), contacts_, kStepS);
    }
    void debugDraw(btIDebugDraw*) override { coupling_.take_rows_out(); }

  private:
    btDiscreteDynamicsWorld& world_;
    const btRigidBody& bed_;
    std::vector<ContactVoxel> contacts_;
    BodyCollector collector_;
    WorkThreads threads_{1};
    KnownContacts known_;
    ContactCoupling coupling_;
    WorldAnchor anchor_;
};

/// A box of a multibody that slides along y.
struct Slider {
    BulletScene& scene;
    btMultiBody multibody{1, 0, btVector3(0, 0, 0), true, false};
    btBoxShape box{btVector3(0.2f, 0.2f, 0.2f)};
    btMultiBodyLinkCollider collider{&multibody, 0};

    explicit Slider(BulletScene& in, const btVector3& at) : scene(in) {
        btVector3 inertia;
        box.calculateLocalInertia(kLinkKg, inertia);
        multibody.setBasePos(at);
        multibody.setupPrismatic(0, kLinkKg, inertia, -1, btQuaternion::getIdentity(),
                                 btVector3(0, 1, 0), btVector3(0, 0, 0), btVector3(0, 0, 0), true);
        multibody.finalizeMultiDof();
        multibody.setLinearDamping(0);
        multibody.setAngularDamping(0);
        scene.world->addMultiBody(&multibody);
        collider.setCollisionShape(&box);
        collider.setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        multibody.getLink(0).m_collider = &collider;
        scene.world->addCollisionObject(&collider);
    }
    ~Slider() {
        scene.world->removeCollisionObject(&collider);
        scene.world->removeMultiBody(&multibody);
    }
    double speed_m_s() const { return static_cast<double>(multibody.getJointVel(0)); }
};

// The link's rows went on against the fixed body: it hung in the air, and its bed felt none of it.
TEST(CarrierRoles, link_weighs_on_a_kinematic_bed_that_is_turned_dynamic) {
    BulletScene scene;
    btRigidBody& bed =
        scene.add_box(kLinkKg, btVector3(0.5f, 0.1f, 0.5f), btVector3(0, btScalar(-kSurfaceM), 0));
    bed.setActivationState(DISABLE_DEACTIVATION);
    bed.setLinearFactor(btVector3(0, 1, 0));
    bed.setAngularFactor(btVector3(0, 0, 0));
    bed.setGravity(btVector3(0, 0, 0));
    bed.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    Slider link(scene, btVector3(0, 0.21f, 0));
    SoilOnBed soil(*scene.world, bed);
    scene.run(0.5);
    ASSERT_NEAR(link.speed_m_s(), 0, 0.01) << "the soil holds it";
    bed.setCollisionFlags(btCollisionObject::CF_DYNAMIC_OBJECT);
    bed.setLinearVelocity(btVector3(0, 0, 0));
    constexpr int kFrames = 12;
    // In the first one the soil's rows are still those of a kinematic bed.
    scene.run(kFrames * kStepS);
    const double bed_m_s = static_cast<double>(bed.getLinearVelocity().y());
    const double momentum_n_s = static_cast<double>(kLinkKg) * (bed_m_s + link.speed_m_s());
    const double weight_n_s = static_cast<double>(kLinkKg) * kGravity_m_s2 * (kFrames - 1) * kStepS;
    EXPECT_NEAR(momentum_n_s, -weight_n_s, 0.02 * weight_n_s);
    EXPECT_NEAR(bed_m_s, link.speed_m_s(), 0.05 * std::abs(bed_m_s)) << "they fall together";
}

}  // namespace
}  // namespace bsoil::bullet::carrier_roles_test
