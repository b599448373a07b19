/// One body of a scene in its world: a rigid body, or a link of a multibody.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <btBulletDynamicsCommon.h>

#include <string>

#include "scene/scene.h"

namespace bsoil::scene {

struct SceneBody {
    std::string name;
    const BodyItem* item = nullptr;
    Pose frame_to_center;  ///< Bullet's frame (centre of mass, principal axes) in the body's frame
    btCollisionObject* object = nullptr;  ///< what the soil and other bodies meet
    btRigidBody* body = nullptr;          ///< the same object; null for a link
    const btMultiBody* multibody = nullptr;
    int link = -1;  ///< of the multibody; -1: its base

    /// World pose of the body's frame.
    Pose pose() const;
    Vec3 linear_velocity_m_s() const;  ///< of the centre of mass
    Vec3 angular_velocity_rad_s() const;
    bool is_awake() const;
    /// Kinetic energy and potential energy above the world's origin [J]; 0 for what cannot move.
    double mechanical_energy_j(const btVector3& gravity_m_s2) const;
};

}  // namespace bsoil::scene
