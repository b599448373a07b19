/// What a SoilAction takes and tells: options, reports, conditions.
#pragma once

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>

#include <string>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/bullet/precision.h"
#include "bsoil/result.h"
#include "bsoil/soil.h"

class btCollisionObject;

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

/// How a soil is coupled to its world.
struct SoilActionDef {
    /// Objects the soil does not see, none of them null: as BodyOptions::ignored. Of those that are
    /// not in the world yet see SoilAction::set_options.
    std::vector<const btCollisionObject*> ignored;
    /// A sleeping body is woken when the limits of its contact with the soil have changed by more
    /// than this fraction of their sum (plus wake_weight_fraction of its weight). 0..10
    double wake_limit_fraction = 0.1;
    /// Fraction of the body's weight, 0..10. It is woken as well when the force of the soil that it
    /// carries has changed by more than this fraction of its weight and that force together.
    double wake_weight_fraction = 0.05;
    /// Whether the soil's surface is an object of the world (SoilAction::ground) that rays, sweeps
    /// and bodies which are not coupled meet. Costs nothing but where they do.
    bool ground = true;
    int ground_group = btBroadphaseProxy::StaticFilter;  ///< its collision filter group
    /// and mask
    int ground_mask = btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// How one object takes part in the coupling.
struct BodyOptions {
    bool ignored = false;  ///< the soil does not see it, and it does not feel the soil
    /// The soil gives way to it, and it feels nothing: as a kinematic body, with the report of one.
    /// A ghost (btGhostObject) takes part with this alone.
    bool coverage_only = false;
    SurfaceFriction surface{};  ///< friction and adhesion between it and the soil
    /// All fields are equal.
    bool operator==(const BodyOptions&) const = default;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// What the soil does to one body. Force and torque are those of Bullet's last substep (for a
/// sleeping body: of the last one it was awake in); the rest is of the last soil step. World axes.
struct BodyReport {
    Vec3 force_n;             ///< of the soil on the body
    Vec3 torque_n_m;          ///< about the body's centre of mass
    double peak_force_n = 0;  ///< largest length of force_n since the body met the soil
    double contact_area_m2 = 0;
    /// How far its lowest point lies below the soil's surface beside it (a mesh: the deepest
    /// contact).
    double sinkage_m = 0;
    double compression_m = 0;  ///< largest elastic push-in of a contact
    double load_kg = 0;        ///< soil it carries
    /// Force of that soil and of soil that falls on it, in Bullet's last substep, besides force_n:
    /// weight, less what walls of others bear of it and with what the body bears as such a wall,
    /// and the push of soil whose velocity the body has changed. What accelerates load_kg with a
    /// dynamic body is not in it: Bullet's solver has that mass with the body. For a driven body,
    /// which feels nothing, it is of the last soil step, and all is in it.
    Vec3 load_n;
    /// Force of bodies that stand on the soil it carries, which press on it through that soil,
    /// besides force_n and load_n: the opposite of what that soil does to them. Driven bodies and
    /// wheels of a btRaycastVehicle press on no other body.
    Vec3 through_load_n;
    int patch_count = 0;  ///< contact patches, each one normal and two tangential constraint rows
};

using bsoil::SurfacePoint;

/// A condition that the soil ran into, with the object it is of.
struct ObjectCondition {
    Condition condition;
    /// Compare only: the object may be gone. Null: no single object's doing, or one that was gone
    /// before a snapshot was written.
    const btCollisionObject* object = nullptr;
};

/// An object that touches the grid and takes no part, and why.
struct RefusedBody {
    const btCollisionObject* object = nullptr;  ///< compare only: the object may be gone
    std::string reason;                         ///< names the body, its shape and what is wrong
};

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
#pragma GCC visibility pop
