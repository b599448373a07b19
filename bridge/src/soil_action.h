/// SoilAction::Impl: the parts of a coupled soil.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "body_collector.h"
#include "bsoil/bullet/soil_action.h"
#include "carried_load.h"
#include "contact_coupling.h"
#include "coupling_snapshot.h"
#include "first_contact.h"
#include "sleeping_loads.h"
#include "soil_ground.h"
#include "soil_vehicles.h"
#include "world_anchor.h"

namespace bsoil::bullet {

inline constexpr char kWorldIsGone[] =
    "the world of the soil has been emptied or destroyed; make a new SoilAction";

struct SoilAction::Impl {
    Impl(btDiscreteDynamicsWorld& bullet_world, std::unique_ptr<Soil> new_soil,
         const SoilActionDef& options);

    std::optional<SurfacePoint> surface_at(Vec3 world_m) const;
    void open_substep() {
        if (ground) ground->open_substep();
        if (!begins_substep()) return;
        vehicles->open_substep();
        if (!enabled) return;
        const double swept_most_m = soil->def().substeps_max * soil->def().voxel_m;
        carried.open_substep(swept_most_m);
        coupling.leave_behind(swept_most_m);
        const StepReport& known = current_report();
        first_contacts.open_substep(*world, known.loads, known.substep_count > 0);
        coupling.open_substep();
    }
    /// Whether it is a substep of Bullet's that asks the anchor, and not its host, who looks for
    /// contacts or boxes between two. What is put in for a substep that does not come would stay,
    /// and forces would be cleared without what they go with.
    bool begins_substep();
    /// From now on who asks the anchor is the host.
    void end_substep();
    /// Takes what it has in the world for a substep out of it, where none comes.
    void take_out() {
        coupling.take_rows_out();
        carried.close_substep(0);
    }
    /// Without what is no longer true or there: somebody else may have had the soil finish a step,
    /// or put another state in its place.
    const StepReport& current_report();
    /// Of the soil's last call, so that it outlasts the soil's own lists as far as it can.
    void keep_report();
    void clear_report();
    void step_soil(double substep_s);
    Result<SettleReport> settle(int steps_max);
    void look_at_world();
    void note_feeling();
    void note_step(bool has_begun);
    void keep_stepped();
    void take_report(bool are_contacts_unchanged);
    double soil_speed_m_s() const;
    std::span<const BodyLoad> moved_loads();
    /// Takes down whose the new conditions are.
    void name_conditions();
    /// Lets every body go.
    void pause();
    CouplingSnapshot::Parts parts() {
        return {*world, collector, coupling, carried, sleeping, first_contacts, *vehicles, surface};
    }

    /// Null once the host has emptied or destroyed it.
    btDiscreteDynamicsWorld* world_if_there() const {
        return anchor && !anchor->world_exists() ? nullptr : world;
    }

    btDiscreteDynamicsWorld* world;  ///< null once the host has emptied it
    std::unique_ptr<Soil> soil;
    Aabb box;
    BodyCollector collector;
    ContactCoupling coupling;
    CarriedLoads carried;
    SleepingLoads sleeping;
    std::unique_ptr<WorldAnchor> anchor;
    GroundSurface surface;
    SoilBelow soil_below;
    FirstContacts first_contacts;
    std::unique_ptr<SoilGround> ground;  ///< null without SoilActionDef::ground
    std::shared_ptr<SoilVehicles> vehicles;
    double unstepped_s = 0;    ///< time that has passed and the soil has not stepped
    double uncollected_s = 0;  ///< time since the bodies were last looked at
    bool enabled = true;
    bool is_paused = false;          ///< a substep has passed since it was switched off
    bool has_substep_begun = false;  ///< in which the anchor was asked
    /// Bullet's own worlds do; in a host's world that does not every request opens a substep.
    bool world_tells_substeps = true;
    uint64_t known_def_revision = 0;  ///< of the soil that the coupling knows
    long long step_count = 0;
    StepReport report;                   ///< see current_report()
    std::vector<BodyLoad> report_loads;  ///< of it
    std::vector<int> feeling;  ///< bodies that feel their loads, as of the last look at the world
    uint64_t known_state_revision = 0;  ///< of the soil when it was kept
    bool was_stepping = false;          ///< the soil then
    std::vector<BodyState> stepped;     ///< as the step in progress saw them
    bool is_stepped_new = false;        ///< it began in this substep
    /// As the step saw them whose contacts are to be taken; none: no step is through.
    std::optional<std::span<const BodyState>> contact_bodies;
    bool are_contacts_fresh = true;  ///< it began and ended in one call
    int untaken_count = 0;           ///< steps that were due since contacts were taken
    std::vector<BodyLoad> loads;
    struct NamedCondition {
        const btCollisionObject* object = nullptr;
        int body = -1;
        int64_t first_step = -1;
    };
    /// In the order of the soil's conditions: whose each is.
    std::vector<NamedCondition> named_conditions;
};

}  // namespace bsoil::bullet
