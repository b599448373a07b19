/// SoilAction: deformable soil in a Bullet world. See docs/contact_law.md for how a collision shape
/// becomes an impulse.
#pragma once

#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/bullet/soil_action_types.h"
#include "bsoil/soil.h"

namespace bsoil::bullet {
class SoilVehicles;
}

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

class SoilRaycaster;

/// Deformable soil as an action of a btDiscreteDynamicsWorld, or of a btMultiBodyDynamicsWorld,
/// which is one.
///
/// It adds itself to the world, together with one invisible collision object (the anchor) whose box
/// is asked for at the start of every substep; that is when the soil's constraint rows enter the
/// world. They leave it in updateAction, so between two calls of stepSimulation the world holds
/// none of them.
///
/// Lifetime: bodies may be removed and deleted without telling the soil, between steps and in the
/// world's actions. The world may be destroyed before the SoilAction, with the anchor in it. A host
/// that empties a world by hand, taking out every collision object it finds, may delete the anchor
/// with the others; one that takes it out and keeps it must destroy the SoilAction before the
/// world. Not thread-safe.
class SoilAction final : public btActionInterface {
  public:
    /// Creates the soil and couples it with the world. The error names the field, its value and its
    /// range. SoilDef::up and gravity_m_s2 have to be the world's gravity, to a twentieth, unless
    /// the world has none yet; a world whose gravity is changed later sets
    /// StatusBit::gravity_differs while it is another.
    static Result<std::unique_ptr<SoilAction>> create(btDiscreteDynamicsWorld& world,
                                                      const SoilDef& def,
                                                      const SoilActionDef& options = {});
    ~SoilAction() override;
    SoilAction(const SoilAction&) = delete;
    SoilAction& operator=(const SoilAction&) = delete;

    /// The soil itself: sample it, weigh it, mesh it, save it. Its step() is the SoilAction's to
    /// call.
    /// @{
    Soil& soil();
    const Soil& soil() const;
    /// @}
    /// Puts soil in, see Soil::fill.
    template <typename Fill>
    Status fill(const Fill& fill) {
        return soil().fill(fill);
    }

    /// Behind a loading screen, with all soil and bodies in place and between calls of
    /// stepSimulation: Soil::settle with the world's bodies, which stand still and feel nothing. No
    /// time passes in the world. The steps count in step_count(). Error: as Soil::settle, or the
    /// soil is switched off, or its world is gone.
    Result<SettleReport> settle(int steps_max = 0);

    /// From the next soil step on. Options may be given before the object enters the world and end
    /// when it leaves it: one that is taken out and put back starts with the defaults. Nothing
    /// tells that an object is deleted without ever having been in the world: a new one at its
    /// address gets the options that waited for it, unless set_options(object, {}) forgot them
    /// before. Error: as BodyOptions::validate; then nothing changes.
    Status set_options(const btCollisionObject& object, const BodyOptions& options);
    /// The defaults for an object that none were set for.
    BodyOptions options(const btCollisionObject& object) const;

    /// Off: the soil is frozen, takes no time and carries nothing; bodies that slept on it wake and
    /// fall. What rests on ground(), ignored or refused, stays; so does what comes meanwhile and is
    /// refused. On again: it goes on with the bodies where they are then, as with new ones (peaks
    /// and contacts start anew, nothing was swept). Switching back before a substep has passed
    /// changes nothing. On at first.
    void set_enabled(bool enabled);
    bool is_enabled() const;  ///< as set_enabled() has it

    /// Report of the last soil step; its contacts are valid until the next one. They are gone
    /// before where the soil itself was asked to finish a step in progress
    /// (SoilDef::step_budget_ms). Where it was given another state (Soil::load), all of the report
    /// is.
    const StepReport& last_report() const;
    /// Soil steps made so far.
    long long step_count() const;
    /// What the soil has run into since Soil::clear_status(), by which object, where and when;
    /// oldest first. To be told of new ones look at StepReport::condition_new_count of
    /// last_report(), which allocates nothing.
    std::vector<ObjectCondition> conditions() const;
    /// Objects that touch the grid and take no part, as of the last soil step; of the last substep
    /// while the soil is switched off.
    const std::vector<RefusedBody>& refused() const;
    /// All zero for an object that does not touch the soil.
    BodyReport body_report(const btCollisionObject& object) const;
    /// The object's SoilBody::id, as in last_report().contacts; -1 for one the soil has not met.
    int body_id(const btCollisionObject& object) const;

    /// Snapshot of the soil and of all that the coupling remembers of its bodies (ids, poses, shear
    /// displacements, averaged directions, row limits, drift, carried loads, time not stepped yet).
    /// Bodies are named by their place in the world's list; wheels of attached raycast vehicles are
    /// in it, what the vehicle itself holds is Bullet's. Between calls of stepSimulation. Bullet's
    /// own state is not in it: save_world() of world_snapshot.h has both. Error: the file cannot be
    /// written, or a pose or velocity is not finite.
    Status save(const std::string& path) const;
    /// Replaces the state of the soil and the coupling. The world must hold the same objects in the
    /// same order; their poses are the host's to put back. Options of bodies are not
    /// touched. last_report() has no contacts until the next soil step.
    /// Error: the file is damaged or of another soil or world; it names what differs and changes
    /// nothing.
    Status load(const std::string& path);

    /// The topmost resting soil or terrain on the vertical line through a point of the world, as
    /// the ground's triangles have it. Empty outside the grid's box and where there is neither.
    /// Cost: columns are read once per tile of 8 x 8 and change; needs no SoilActionDef::ground.
    std::optional<SurfacePoint> surface_at(Vec3 world_m) const;
    /// The static body that rays hit and that uncoupled bodies (ignored or refused ones) rest on;
    /// null without SoilActionDef::ground or once the host has deleted it. Coupled bodies and soft
    /// bodies have no contact with it. The host may set its friction (1: a pair's is the other
    /// body's), rolling and spinning friction (0.03 m, and at most 0.3 of a body's radius; it is
    /// set anew for each pair, until the host does), restitution and user data, have it ignore
    /// objects (setIgnoreCollisionCheck), or take it out of the world.
    btRigidBody* ground() const;

    /// Called by Bullet at the end of each substep: takes the impulses of this substep's rows and
    /// steps the soil as often as SoilDef::step_s has passed.
    void updateAction(btCollisionWorld* world, btScalar substep_s) override;
    /// Called by Bullet when it draws its world. The drawer's mode says what: DBG_DrawAabb the
    /// grid's box, DBG_DrawWireframe the height spans of columns in tiles that bodies touch,
    /// DBG_DrawNormals the contact voxels with their normals and the forces on bodies as arrows,
    /// the largest ten voxels long.
    void debugDraw(btIDebugDraw* drawer) override;

    struct Impl;

  private:
    friend class SnapshotAccess;
    friend class SoilRaycaster;
    SoilAction(std::unique_ptr<Impl> impl, const SoilActionDef& options);
    std::shared_ptr<SoilVehicles> vehicles();
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
#pragma GCC visibility pop
