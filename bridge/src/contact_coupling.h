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
#include "bsoil/bullet/soil_action_types.h"
#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/known_contacts.h"
#include "bsoil/contact/shared_soles.h"
#include "substep_rows.h"

namespace bsoil::bullet {

/// Contacts come in once a soil step (set_contacts); rows are in the world from open_substep to
/// close_substep. No pointer to a body is followed before the world's own list has been seen to
/// hold it.
class ContactCoupling {
  public:
    /// threads: they share the work on large contacts; must outlive this.
    /// known: of the soil, which must outlive this; width and pressure of each contact go there.
    ContactCoupling(btDiscreteDynamicsWorld& world, ContactSoil soil, KnownContacts& known,
                    const SoilActionDef& options, const WorkThreads& threads);
    ~ContactCoupling();

    /// The bodies as they are now, in any order, until the next call or set_contacts: whoever makes
    /// the list anew has to say so.
    void set_bodies(std::span<const BodyState> bodies);
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
    /// From now on bodies meet this soil.
    void set_soil(ContactSoil soil) {
        soil_ = std::make_shared<const ContactSoil>(std::move(soil));
    }
    double voxel_m() const { return soil_->voxel_m; }
    /// Bodies that touched others in the last substep, and whether one did.
    void find_touched() { rows_.find_touched(); }
    bool is_touched(const btCollisionObject* object) const { return rows_.is_touched(object); }
    /// Whether the contacts are of longer ago than the last soil step that was due (StepBudget).
    void set_late(bool is_late) { is_late_ = is_late; }
    bool is_late() const { return is_late_; }
    /// Before a substep is opened: lets go of the bodies that their hosts have put elsewhere, and
    /// wakes them. The soil meets them anew in its next step.
    /// swept_most_m: as far the soil on a driven carrier goes along with it.
    void leave_behind(double swept_most_m);
    /// Start of a substep: puts the rows of all bodies that are still there into the world.
    void open_substep() {
        follow();
        rows_.open();
    }
    /// End of a substep: reads the impulses and takes the rows out.
    void close_substep(btScalar substep_s) { rows_.close(substep_s); }
    /// Takes the rows out without reading them.
    void take_rows_out() { rows_.take_out(); }
    /// Lets all bodies go, and wakes those that slept on the soil. Between substeps.
    void let_go();

    /// Patches of a wheel, as of the last set_contacts; empty for an id without contact.
    std::span<const ContactPatch> wheel_patches(int body_id) const;
    /// For a wheel, before its patches are asked for: how far it has moved since they were found.
    void follow_wheel(int body_id, Vec3 shift_m);
    /// Normal forces that its vehicle has found for these patches.
    void set_wheel_forces(int body_id, std::span<const double> normal_n);
    const ContactSoil& soil() const { return *soil_; }
    /// All zero for an id without contact.
    BodyReport report(int body_id) const;
    /// Calls visit(point_m, force_n) for each force that the last solve found between the soil and
    /// a body: for drawing. The solver knows no force on a driven body: there it is the soil's
    /// whole one, where its line of action passes the centre of mass.
    template <typename Visit>
    void for_each_force(Visit visit) const {
        for (const auto& [id, coupled] : coupled_) {
            for (const CoupledPatch& p : coupled.patches) visit(p.patch.point_m, p.applied_force_n);
            if (coupled.body.role != BodyRole::driven) continue;
            const Vec3 force_n = coupled.report.force_n;
            const double square = dot(force_n, force_n);
            if (!(square > 0)) continue;
            visit(coupled.body.motion.center_of_mass_m +
                      cross(force_n, coupled.report.torque_n_m) * (1 / square),
                  force_n);
        }
    }

  private:
    friend class CouplingSnapshot;
    /// What set_contacts does for one body. It finds the contacts of many bodies in parallel; the
    /// work before and after that goes body by body.
    struct BodyWork {
        enum class Kind {
            moved,
            /// It slept in the last step as well. The patches that hold it stay as they were when
            /// it fell asleep. This step only asks whether the soil beside it could still give as
            /// much. The width stays too: depth and width of a contact follow from each other, and
            /// their last bits could alternate forever.
            slept,
            kept,  ///< it slept, and its own contacts are those of the last step
        };
        Kind kind = Kind::moved;
        CoupledBody* coupled = nullptr;
        BodyMotion moved;  ///< where it is now, with its mean velocities since the last step
        std::span<const ContactVoxel> voxels;
        std::span<const int> carriers;            ///< ContactVoxel::carrier of each
        std::vector<PressedSoil> pressed_around;  ///< of pressed_, what may lie beside it
        ContactPatches found;
        BodyContact contact;
    };
    void prepare(BodyWork& work, const BodyState& body, double duration_s, bool are_unchanged);
    /// How a body has come from where it was duration_s ago: with mean velocities. What it has at
    /// the end of the soil's step says little of the way: it may have sunk and be about to rise.
    static BodyMotion moved_since(const CoupledBody& coupled, const BodyState& body,
                                  double duration_s);
    /// What other bodies know of the soil beside a body, before any of them learns more.
    void find_pressed_around(BodyWork& work) const;
    /// That and the faces of all bodies' contacts; soles beside each other are one.
    void find_faces(std::span<BodyWork> works);
    /// Changes nothing but the body's memory and `work`.
    void find_contact(BodyWork& work, double duration_s) const;
    static bool stays_held(const BodyWork& work);
    void report_contact(const BodyWork& work);
    /// Gives the contact of a body that moved to who acts on it: the solver, a vehicle or nobody.
    void act(const BodyWork& work);
    /// Puts new patches in place of those that a body has. They take over what their nearest old
    /// ones had.
    void replace_patches(CoupledBody& coupled, std::span<const ContactPatch> patches);
    /// Of set_contacts; null for an id that is not among them.
    const BodyState* state_of(int id) const;
    void leave_carriers(CoupledBody& coupled, double slack_m, double swept_most_m);
    /// Bodies are where their contacts are.
    void note_found(CoupledBody& coupled) const;
    /// Whether its host has put a body elsewhere since it was seen, duration_s ago.
    bool is_elsewhere(const BodyState& body, double duration_s) const;
    double sinkage_m(const BodyState& body, const BodyContact& contact) const;
    void sort_by_body(std::span<const ContactVoxel> contacts);
    /// The place of a body of set_contacts in by_id_; -1: not among them.
    int rank_of(int id) const;
    void list_pressed_soil();
    /// Whether the body had it already.
    bool update_law(CoupledBody& coupled);
    /// Limits follow what bodies have moved since their contacts were found.
    void follow();
    /// limit_shares() of a body's patches, in shares_.
    void find_shares(const CoupledBody& coupled, size_t patch_count, Vec3 shift_m);
    void set_wheel_patches(CoupledBody& coupled, const ContactPatches& found) const;
    /// Keeps what is known of carriers that were there before.
    void update_carriers(CoupledBody& coupled, std::span<const int> carriers);
    /// After update_carriers.
    void update_motions(CoupledBody& coupled, std::span<const ContactVoxel> voxels,
                        double duration_s) const;
    void keep_awake_with_carriers(CoupledBody& coupled);
    void wake(CoupledBody& coupled);
    void wake_if_changed(CoupledBody& coupled);
    btDiscreteDynamicsWorld& world_;
    std::shared_ptr<const ContactSoil> soil_;
    KnownContacts& known_;
    const WorkThreads& threads_;
    double wake_limit_fraction_, wake_weight_fraction_;
    /// By body id: the order of rows must not depend on addresses.
    std::map<int, CoupledBody> coupled_;
    SubstepRows rows_;
    bool is_late_ = false;
    std::vector<double> shares_;
    /// The contacts of set_contacts by body, in the order of by_id_; where each body's begin.
    std::vector<ContactVoxel> by_body_;
    std::vector<int> carriers_;  ///< of by_body_
    std::vector<BodySoles> soles_;
    std::vector<size_t> starts_, next_;
    std::vector<size_t> places_;   ///< of each contact in by_body_, where ranks_ is not -1
    std::vector<int> sorted_ids_;  ///< of by_id_, when they were sorted
    std::vector<int> ranks_;       ///< the place of each contact's body in by_id_, or -1
    size_t contact_count_ = 0;     ///< of the last set_contacts
    std::vector<BodyWork> works_;  ///< a pool
    PatchHeirs patch_heirs_;
    std::vector<CoupledPatch> previous_patches_;
    std::vector<PlacedPatch> old_places_, new_places_;
    std::vector<const BodyState*> by_id_;  ///< the bodies, sorted by id
    std::vector<int> carrier_ids_;
    std::vector<Carrier> previous_carriers_;
    std::vector<ContactMotion> previous_motions_;
    /// What bodies know, as of the last set_contacts, until the first of them learns more.
    std::vector<PressedList> pressed_;
};

}  // namespace bsoil::bullet
