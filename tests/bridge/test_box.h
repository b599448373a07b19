// The box that most tests of bodies and worlds put on a bed of sand.
#pragma once

#include "sand_bed.h"

namespace bsoil::bullet {

constexpr btScalar kHalf = btScalar(0.2);  ///< half its edge [m]
inline const btVector3 kHalfBox(kHalf, kHalf, kHalf);
constexpr btScalar kMassKg = 50;
constexpr double kWeightN = 50 * kGravity_m_s2;
/// Above the bed, clear of it by 1 cm.
inline const btVector3 kAbove(0, btScalar(kBedTopM) + kHalf + btScalar(0.01), 0);

/// Lets a box come to rest on the soil and sleep.
inline btRigidBody& sleeping_box(BulletScene& scene) {
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(5);
    EXPECT_FALSE(box.isActive());
    return box;
}

/// The mean vertical force of the soil on a body, less the soil that it carries: over a time that
/// rocking averages out in.
inline double mean_lift_n(BulletScene& scene, const SoilAction& soil,
                          const btCollisionObject& body) {
    double sum = 0;
    constexpr int kFrames = 60;
    for (int i = 0; i < kFrames; ++i) {
        scene.run(1.0 / 60);
        const BodyReport report = soil.body_report(body);
        sum += (report.force_n.y - report.load_kg * kGravity_m_s2) / kFrames;
    }
    return sum;
}

}  // namespace bsoil::bullet
