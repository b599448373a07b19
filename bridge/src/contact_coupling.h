/// ContactCoupling: gives the contact of every coupled body to Bullet's solver and takes the
/// impulses back.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "body_state.h"
#include "bsoil/bullet/soil_action.h"
#include "bsoil/contact/contact_memory.h"
#include "link_patch_constraint.h"
#include "rigid_patch_constraint.h"
#include "torque_constraint.h"

class btMultiBodyDynamicsWorld;

namespace bsoil::bullet {

/// Contacts come in once a soil step (set_contacts); rows are in the world from open_substep to
/// close_substep. No pointer to a body is followed before the world's own list has been seen to
/// hold it.
class ContactCoupling {
  public:
    /// threads: they share the work on large contacts; must outlive this.
    ContactCoupling(btDiscreteDynamicsWorld& world, ContactSoil soil, const SoilActionDef& options,
                    const WorkThreads& threads);
    ~ContactCoupling();

    /// Bodies with their contacts of this soil step, in any order. Bodies that are not among them
    /// are let go.
    /// duration_s: time since the last call. are_unchanged: the contacts are those of the last
    /// call, to the bit.
    void set_contacts(std::span<const BodyState> bodies, std::span<const ContactVoxel> contacts,
                      double duration_s, bool are_unchanged = false);
    /// For FirstContacts: puts patches of its own in the place of a body's, until the next
    /// set_contacts.
    void set_patches(const BodyState& body, const BodyMotion& direction,
                     std::span<const ContactPatch> patches);
    /// Against the body's surface; valid until the body is let go.
    const ContactLaw& law_for(const BodyState& body);
    /// A motion as yield sees it: as a share of the speed of a contact `extent_m` off the centre of
    /// mass, zero at rest.
    void as_direction(BodyMotion& motion, double extent_m) const;
    double voxel_m() const { return soil_->voxel_m; }
    /// Bodies that touched others in the last substep, and whether one did.
    void find_touched();
    bool is_touched(const btCollisionObject* object) const;
    /// Start of a substep: puts the rows of all bodies that are still there into the world.
    void open_substep();
    /// End of a substep: reads the impulses and takes the rows out.
    void close_substep(btScalar substep_s);
    /// Takes the rows out without reading them.
    void take_rows_out();
    /// Lets all bodies go, and wakes those that slept on the soil. Between substeps.
    void let_go();

    /// Patches of a wheel, as of the last set_contacts; empty for an id without contact.
    std::span<const ContactPatch> wheel_patches(int body_id) const;
    /// Normal forces that its vehicle has found for these patches.
    void set_wheel_forces(int body_id, std::span<const double> normal_n);
    const ContactSoil& soil() const { return *soil_; }
    /// All zero for an id without contact.
    BodyReport report(int body_id) const;
    /// Calls visit(point_m, force_n) for each force that the last solve found between the soil and
    /// a body: for drawing.
    template <typename Visit>
    void for_each_force(Visit visit) const {
        for (const auto& [id, coupled] : coupled_)
            for (const CoupledPatch& p : coupled.patches) visit(p.patch.point_m, p.applied_force_n);
    }
    /// Mean normal pressure of a body's contact, weighted by force, and the width of its faces;
    /// both 0 without contact. For SoilBody.
    double contact_pressure_pa(int body_id) const;
    double contact_width_m(int body_id) const;

  private:
    friend class CouplingSnapshot;
    struct CoupledPatch {
        ContactPatch patch;
        Vec3 offset_m;  ///< from the centre of mass: the point follows it, the directions stay
        Vec3 shear_offset_m;  ///< the same of the point where the shear force acts
        Vec3 carrier_offset_m, carrier_shear_offset_m;  ///< of both, from the carrier's
        double friction_normal_n = 0;  ///< normal force the friction is reckoned from
        Vec3 applied_force_n;          ///< by the last solve
        Vec3 preload_n;                ///< of it, what was given as a force before the solve
        Vec3 drift_m;                  ///< see PatchRow

        /// Of a force [N] on it, about the centre of mass.
        Vec3 torque_n_m(Vec3 force_n) const {
            const Vec3 normal_n = dot(force_n, patch.normal) * patch.normal;
            return cross(offset_m, normal_n) + cross(shear_offset_m, force_n - normal_n);
        }
        /// Of the force on the carrier, about its centre of mass.
        Vec3 carrier_torque_n_m(Vec3 force_n) const {
            const Vec3 normal_n = dot(force_n, patch.normal) * patch.normal;
            return -1.0 * (cross(carrier_offset_m, normal_n) +
                           cross(carrier_shear_offset_m, force_n - normal_n));
        }
        double shear_limit_n() const {
            return patch.shear_share * (patch.friction * friction_normal_n + patch.adhesion_n);
        }
    };
    /// What carries soil that a body touches: the ground, or another body.
    struct Carrier {
        int id = -1;
        BodyState body;  ///< of the ground: fixed
        Pose pose_at_open;
        bool is_touched = false;  ///< by other bodies, in this substep
        /// With it or with the body a link.
        std::unique_ptr<LinkPatchConstraint> link_rows;

        bool is_rigid() const { return body.role == BodyRole::rigid; }
        bool is_link() const { return body.role == BodyRole::link; }
        bool feels() const { return is_rigid() || is_link(); }
        /// Of a point of it since the substep was opened.
        Vec3 motion_in(double substep_s, Vec3 offset_m) const;
    };
    struct Coupled {
        BodyState body;
        std::vector<CoupledPatch> patches;        ///< none for a wheel
        std::vector<ContactPatch> wheel_patches;  ///< only for a wheel
        std::vector<std::unique_ptr<RigidPatchConstraint>>
            rigid_rows;  ///< a pool; the first patches.size() in use
        /// By id, so the ground first; always there. And the body's motion relative to each.
        std::vector<Carrier> carriers;
        std::vector<ContactMotion> motions;
        bool is_touched = false;    ///< by other bodies, in this substep
        Pose pose_at_open;          ///< at the start of the substep
        int asleep_step_count = 0;  ///< soil steps since it fell asleep; 0: awake
        /// Normal limits by bin, now; not known of one that comes from a snapshot.
        std::array<double, kNormalBinCount> limits_n{};
        bool has_limits = false;
        /// Of its normal limits by bin: the mean while it slept, and what that was at first.
        std::array<double, kNormalBinCount> mean_limits_n{}, limits_at_sleep_n{};
        BodyReport report;
        ContactMemory memory;
        double pressure_pa = 0, width_m = 0;
        std::unique_ptr<const ContactLaw> law;  ///< against this body's surface
        SurfaceFriction law_surface;
        bool seen = false;

        Carrier& carrier_of(const CoupledPatch& p) {
            return *std::find_if(carriers.begin(), carriers.end(),
                                 [&p](const Carrier& c) { return c.id == p.patch.carrier; });
        }
        const Carrier& carrier_of(const CoupledPatch& p) const {
            return const_cast<Coupled*>(this)->carrier_of(p);
        }
        /// Whether a patch's row is one of a LinkPatchConstraint.
        bool is_link_row(const CoupledPatch& p) const {
            return body.role == BodyRole::link || carrier_of(p).is_link();
        }
    };
    /// Torque of preloads on a rigid body that others touch.
    struct PreloadTorque {
        btRigidBody* body = nullptr;
        Vec3 torque_n_m;
        std::unique_ptr<TorqueConstraint> row;
        bool is_used = false, is_in = false;
    };

    /// A body's part of set_contacts. What it takes from the contacts is found for many bodies at
    /// the same time; before and after that they are looked at one by one.
    struct BodyWork {
        enum class Kind {
            moved,
            /// It slept in the last step as well. What holds it up stays as it was when it fell
            /// asleep; looked at is only whether the soil beside it could still give as much. Its
            /// width stays too: depth and width of a contact follow from each other, and their last
            /// bits may go round for good.
            slept,
            kept,  ///< it slept, and its contacts are those of the last step
        };
        Kind kind = Kind::moved;
        Coupled* coupled = nullptr;
        std::span<const ContactVoxel> voxels;
        std::vector<PressedSoil> pressed_around;  ///< of pressed_soil_, what may lie beside it
        ContactPatches found;
        BodyContact contact;
    };
    void prepare(BodyWork& work, const BodyState& body, std::span<const ContactVoxel> voxels,
                 double duration_s, bool are_unchanged);
    /// Changes nothing but the body's memory and `work`.
    void find_contact(BodyWork& work, double duration_s) const;
    void report_contact(const BodyWork& work);
    /// Gives the contact of a body that moved to who acts on it: the solver, a vehicle or nobody.
    void act(const BodyWork& work);
    /// Of set_contacts; null for an id that is not among them.
    const BodyState* state_of(int id) const;
    double sinkage_m(const BodyState& body, const BodyContact& contact) const;
    void sort_by_body(std::span<const ContactVoxel> contacts);
    /// The place of a body of set_contacts in by_id_; -1: not among them.
    int rank_of(int id) const;
    void gather_pressed_soil();
    void take_over_patches(Coupled& coupled, std::span<const ContactPatch> patches);
    void update_law(Coupled& coupled);
    /// Keeps what is known of carriers that were there before.
    void update_carriers(Coupled& coupled, std::span<const ContactVoxel> voxels);
    /// After update_carriers.
    void update_motions(Coupled& coupled, std::span<const ContactVoxel> voxels,
                        double duration_s) const;
    void update_motion(const Coupled& coupled, const Carrier& carrier, ContactMotion& motion,
                       std::span<const ContactVoxel> voxels, double duration_s, bool is_new) const;
    void keep_awake_with_carriers(Coupled& coupled);
    void wake(Coupled& coupled);
    void wake(const BodyState& body);
    void wake_if_changed(Coupled& coupled);
    /// Direction of the first, and the share of the limit that the second has.
    struct TangentialRows {
        Vec3 first;
        double second_share = 1;
    };
    static TangentialRows tangential_rows(const ContactMotion& motion, const CoupledPatch& patch);
    PatchRow row_of(const Coupled& coupled, const CoupledPatch& patch) const;
    void preload(Coupled& coupled);
    void add_preload_torque(const BodyState& body, Vec3 torque_n_m);
    void put_in_preload_torque(PreloadTorque& torque);
    /// sign: -1 takes it back.
    static void apply_preload(Coupled& coupled, const CoupledPatch& patch, double sign);
    bool read_forces(Coupled& coupled, btScalar substep_s, Vec3& torque_n_m);
    void add_drift(Coupled& coupled, double substep_s);
    void open(Coupled& coupled);
    void open_rigid_row(Coupled& coupled, size_t index);
    void open_link_rows(Coupled& coupled, Carrier& carrier);

    btDiscreteDynamicsWorld& world_;
    btMultiBodyDynamicsWorld* multibody_world_;  ///< world_, if it is one
    std::shared_ptr<const ContactSoil> soil_;
    const WorkThreads& threads_;
    double wake_limit_fraction_, wake_weight_fraction_;
    std::map<int, Coupled>
        coupled_;              ///< by body id: the order of rows must not depend on addresses
    std::vector<int> opened_;  ///< ids of the bodies whose rows are in the world
    std::vector<btTypedConstraint*> rigid_rows_in_;  ///< in the order they were put in
    std::vector<LinkPatchConstraint*> link_rows_in_;
    /// The contacts of set_contacts by body, in the order of by_id_; where each body's begin.
    std::vector<ContactVoxel> by_body_;
    std::vector<size_t> starts_, next_;
    std::vector<int> ranks_;       ///< the place of each contact's body in by_id_, or -1
    size_t contact_count_ = 0;     ///< of the last set_contacts
    std::vector<BodyWork> works_;  ///< a pool
    std::vector<CoupledPatch> previous_;
    std::vector<double> heirs_;  ///< sum of the limits of the new patches nearest to an old one
    std::vector<int> nearest_;   ///< old patch of each new one, or -1
    std::vector<const btCollisionObject*> touched_;  ///< sorted
    std::map<int, PreloadTorque> preload_torques_;   ///< by body id; of this substep
    std::vector<const BodyState*> by_id_;            ///< the bodies of set_contacts, sorted by id
    std::vector<int> carrier_ids_;
    std::vector<Carrier> previous_carriers_;
    std::vector<ContactMotion> previous_motions_;
    std::vector<PressedSoil> pressed_soil_;  ///< beside all bodies, as of the last set_contacts
};

}  // namespace bsoil::bullet
