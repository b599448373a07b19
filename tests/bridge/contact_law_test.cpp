// The law that a host has chosen is the one that bears its bodies.
#include "sand_bed.h"

namespace bsoil::bullet::contact_law_test {
namespace {

/// A soil that bears 300 kPa per metre of sinkage, whatever its density.
SoilDef spring_bed() {
    SoilDef def = small_bed();
    def.contact_law.kind = ContactLawDef::Kind::bekker;
    BekkerSoil soil;
    soil.kphi_pa_m_n = 300e3;
    soil.n = 1;
    soil.friction_angle_rad = 0.5;
    def.contact_law.bekker = {soil};
    return def;
}

TEST(ContactLaw, plate_driven_into_bekkers_soil_meets_its_modulus) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, spring_bed());
    btRigidBody& plate = scene.add(0, scene.shape<btBoxShape>(btVector3(0.25f, 0.1f, 0.25f)),
                                   btVector3(0, btScalar(kBedTopM + 0.1), 0));
    plate.setCollisionFlags(plate.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    plate.setActivationState(DISABLE_DEACTIVATION);
    constexpr double kSpeedMS = 0.05;
    for (int frame = 1; frame <= 96; ++frame) {
        const double depth_m = kSpeedMS * frame / 60;
        btTransform pose = plate.getWorldTransform();
        pose.setOrigin(btVector3(0, btScalar(kBedTopM + 0.1 - depth_m), 0));
        plate.setInterpolationWorldTransform(plate.getWorldTransform());
        plate.setWorldTransform(pose);
        plate.setLinearVelocity(btVector3(0, btScalar(-kSpeedMS), 0));
        scene.world->stepSimulation(btScalar(1) / 60, 0);
        if (frame % 24 != 0) continue;
        // Its own rim raises the level around it.
        EXPECT_NEAR(soil->body_report(plate).force_n.y / (300e3 * 0.25 * depth_m), 1, 0.15)
            << depth_m;
    }
}

TEST(ContactLaw, law_without_its_parameters_is_refused_by_name) {
    BulletScene scene;
    SoilDef def = spring_bed();
    def.contact_law.bekker.clear();
    const auto refused = SoilAction::create(*scene.world, def);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("contact_law.bekker has 0 entries for 1 materials"),
              std::string::npos)
        << refused.error();
}

}  // namespace
}  // namespace bsoil::bullet::contact_law_test
