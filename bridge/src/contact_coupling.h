/// ContactCoupling: gives the contact of every coupled body to Bullet's solver and takes the
/// impulses back.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "body_state.h"
#include "bsoil/bullet/soil_action.h"
#include "link_patch_constraint.h"
#include "rigid_patch_constraint.h"

class btMultiBodyDynamicsWorld;

namespace bsoil::bullet {

/// Contacts come in once a soil step (set_contacts); rows are in the world from open_substep to
/// close_substep. No pointer to a body is followed before the world's own list has been seen to
/// hold it.
class ContactCoupling {
  public:
    /// up: unit. `strengths` is indexed by ContactVoxel::material.
    ContactCoupling(btDiscreteDynamicsWorld& world, Vec3 up, std::vector<SoilStrength> strengths,
                    const SoilActionDef& options);
    ~ContactCoupling();

    /// Bodies with their contacts of this soil step, in any order. Bodies that are not among them
    /// are let go.
    void set_contacts(std::span<const BodyState> bodies, std::span<const ContactVoxel> contacts);
    /// Start of a substep: puts the rows of all bodies that are still there into the world.
    void open_substep();
    /// End of a substep: reads the impulses and takes the rows out.
    void close_substep(btScalar substep_s);
    /// Takes the rows out without reading them.
    void take_rows_out();

    /// All zero for an id without contact.
    BodyReport report(int body_id) const;

  private:
    struct CoupledPatch {
        ContactPatch patch;
        Vec3 offset_m;  ///< from the centre of mass: the point follows it, the directions stay
        double friction_normal_n = 0;  ///< normal force the friction is reckoned from
        Vec3 applied_force_n;          ///< by the last solve
        Vec3 preload_n;                ///< of it, what was given as a force before the solve
        Vec3 drift_m;                  ///< see PatchRow
    };
    struct Coupled {
        BodyState body;
        std::vector<CoupledPatch> patches;
        std::vector<std::unique_ptr<RigidPatchConstraint>>
            rigid_rows;  ///< a pool; the first patches.size() in use
        std::unique_ptr<LinkPatchConstraint> link_rows;
        Pose pose_at_open;  ///< at the start of the substep
        bool was_asleep = false;
        std::array<double, kNormalBinCount> limits_at_sleep_n{};
        BodyReport report;
        bool seen = false;
    };

    void set_body_contacts(Coupled& coupled, std::span<const ContactVoxel> voxels);
    void wake_if_changed(Coupled& coupled);
    PatchRow row_of(const Coupled& coupled, const CoupledPatch& patch) const;
    void preload(Coupled& coupled);
    bool is_in_world(const BodyState& body) const;
    bool read_forces(Coupled& coupled, btScalar substep_s, Vec3& torque_n_m);
    void add_drift(Coupled& coupled);
    void open(Coupled& coupled);
    void close(Coupled& coupled);

    btDiscreteDynamicsWorld& world_;
    btMultiBodyDynamicsWorld* multibody_world_;  ///< world_, if it is one
    Vec3 up_;
    std::vector<SoilStrength> strengths_;
    double wake_limit_fraction_, wake_weight_fraction_;
    std::map<int, Coupled>
        coupled_;              ///< by body id: the order of rows must not depend on addresses
    std::vector<int> opened_;  ///< ids in the order their rows were put in
    std::vector<ContactVoxel> by_body_;
    std::vector<ContactPatch> patches_;
    std::vector<CoupledPatch> previous_;
};

}  // namespace bsoil::bullet
