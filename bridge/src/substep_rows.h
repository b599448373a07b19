/// SubstepRows: the rows by which coupled bodies meet the soil in one of Bullet's substeps.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <map>
#include <memory>
#include <vector>

#include "bsoil/contact/known_contacts.h"
#include "coupled_body.h"
#include "torque_constraint.h"

class btMultiBodyDynamicsWorld;

namespace bsoil::bullet {

/// No pointer to a body is followed before the world's own list has been seen to hold it.
class SubstepRows {
  public:
    /// bodies: by id, since the order of rows must not depend on addresses; must outlive this.
    /// known: of the soil; the pressure that a substep has found goes there. voxel_m: its.
    SubstepRows(btDiscreteDynamicsWorld& world, std::map<int, CoupledBody>& bodies,
                KnownContacts& known, double voxel_m);

    /// Whether a constraint is a row of any soil's, and no joint of the host's.
    static bool is_row(const btTypedConstraint& constraint);
    /// Bodies that touched others in the last substep, and whether one did.
    void find_touched();
    bool is_touched(const btCollisionObject* object) const;
    /// Puts the rows of all bodies that are still there into the world.
    void open();
    /// Reads the impulses and takes the rows out.
    void close(btScalar substep_s);
    /// Takes the rows out without reading them.
    void take_out();

  private:
    /// Torque of preloads on a rigid body that others touch.
    struct PreloadTorque {
        btRigidBody* body = nullptr;
        Vec3 torque_n_m;
        std::unique_ptr<TorqueConstraint> row;
        bool is_used = false, is_in = false;
    };

    /// Direction of the first, and the share of the limit that the second has.
    struct TangentialRows {
        Vec3 first;
        double second_share = 1;
    };
    static TangentialRows tangential_rows(const ContactMotion& motion, const CoupledPatch& patch);
    PatchRow row_of(const CoupledBody& coupled, const CoupledPatch& patch) const;
    void preload(CoupledBody& coupled);
    void add_preload_torque(const BodyState& body, Vec3 torque_n_m);
    void put_in_preload_torque(PreloadTorque& torque);
    /// sign: -1 takes it back.
    static void apply_preload(CoupledBody& coupled, const CoupledPatch& patch, double sign);
    void find_gone();
    bool is_gone(const btRigidBody& body) const;
    void take_out_found();
    bool read_forces(CoupledBody& coupled, btScalar substep_s, Vec3& torque_n_m);
    void add_drift(CoupledBody& coupled, double substep_s);
    void note_left(CoupledBody& coupled, btScalar substep_s) const;
    void open_body(CoupledBody& coupled);
    void open_rigid_row(CoupledBody& coupled, size_t index);
    void open_link_rows(CoupledBody& coupled, Carrier& carrier);

    btDiscreteDynamicsWorld& world_;
    btMultiBodyDynamicsWorld* multibody_world_;  ///< world_, if it is one
    std::map<int, CoupledBody>& bodies_;
    KnownContacts& known_;
    double voxel_m_;
    std::vector<int> opened_;  ///< ids of the bodies whose rows are in the world
    std::vector<btTypedConstraint*> rigid_rows_in_;  ///< in the order they were put in
    std::vector<LinkPatchConstraint*> link_rows_in_;
    std::vector<const btCollisionObject*> touched_;  ///< sorted
    std::vector<const btCollisionObject*> gone_;     ///< as of find_gone
    std::map<int, PreloadTorque> preload_torques_;   ///< by body id; of this substep
};

}  // namespace bsoil::bullet
