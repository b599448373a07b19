#include "bsoil/bullet/soil_action.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bsoil/limits.h"
#include "bullet_types.h"
#include "check_surface.h"
#include "soil_action.h"
#include "soil_debug_draw.h"
#include "world_gravity.h"
#include "world_objects.h"

namespace bsoil::bullet {
namespace {

/// A substep this close to the soil's step is that step: Bullet's float 1/60 is not the double one.
constexpr double kStepTolerance = 1e-3;
/// Soil steps one substep may ask for. A host that hands Bullet seconds at a time gets no more: the
/// rest of the time is dropped, as Bullet drops what exceeds its own substeps.
constexpr int kStepsPerSubstepMax = 256;

/// Of btDispatcherInfo::m_stepCount, which Bullet sets to 0 in each substep and has no use for.
constexpr int kBetweenSubsteps = 1;

Vec3 up_of(const SoilDef& def) { return def.up == UpAxis::y ? Vec3{0, 1, 0} : Vec3{0, 0, 1}; }

/// The grid's box with the world's axes.
Aabb world_box(const GridFrame& frame) {
    Aabb box;
    for (int corner = 0; corner < 8; ++corner) {
        const auto at = [&frame, corner](int axis) {
            return (corner >> axis & 1) != 0 ? static_cast<double>(frame.size[axis]) : 0.0;
        };
        const Vec3 p = frame.to_world({at(0), at(1), at(2)});
        if (corner == 0) box = {p, p};
        box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
        box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
    }
    return box;
}

Status check_fraction(const char* field, double value) {
    if (std::isfinite(value) && value >= 0 && value <= 10) return Done{};
    return Error{std::string("SoilActionDef::") + field + " is " + std::to_string(value) +
                 ", must be 0..10"};
}

}  // namespace

Status SoilActionDef::validate() const {
    for (size_t i = 0; i < ignored.size(); ++i) {
        if (!ignored[i]) {
            return Error{"SoilActionDef::ignored[" + std::to_string(i) +
                         "] is null, must be an object"};
        }
    }
    if (Status s = check_fraction("wake_limit_fraction", wake_limit_fraction); !s) return s;
    return check_fraction("wake_weight_fraction", wake_weight_fraction);
}

Status BodyOptions::validate() const { return check_surface(surface); }

SoilAction::Impl::Impl(btDiscreteDynamicsWorld& bullet_world, std::unique_ptr<Soil> new_soil,
                       const SoilActionDef& options)
    : world(&bullet_world),
      soil(std::move(new_soil)),
      box(world_box(soil->frame())),
      collector(box, soil->frame().voxel_m),
      coupling(bullet_world, soil->contact_soil(), soil->known_contacts(), options,
               soil->threads()),
      carried(bullet_world, up_of(soil->def()), soil->def().gravity_m_s2),
      sleeping(bullet_world, options.wake_weight_fraction),
      surface(*soil),
      soil_below(*soil, surface, up_of(soil->def())),
      first_contacts(collector, coupling, soil_below, up_of(soil->def())),
      vehicles(std::make_shared<SoilVehicles>(
          [this] { return world_if_there(); }, collector, coupling, ground, soil->def().voxel_m,
          [this](Vec3 world_m) { return surface_at(world_m); })) {
    named_conditions.reserve(limits::kConditionCapacity + 32);
    for (const btCollisionObject* object : options.ignored) {
        collector.set_options(*object, {.ignored = true});
    }
}

Result<std::unique_ptr<SoilAction>> SoilAction::create(btDiscreteDynamicsWorld& world,
                                                       const SoilDef& def,
                                                       const SoilActionDef& options) {
    if (const Status s = options.validate(); !s) return Error{s.error()};
    if (const Status s = def.validate(); !s) return Error{s.error()};
    if (const Status s = check_gravity(world, def); !s) return Error{s.error()};
    Result<std::unique_ptr<Soil>> soil = Soil::create(def);
    if (!soil) return Error{soil.error()};
    auto impl = std::make_unique<Impl>(world, std::move(*soil), options);
    return std::unique_ptr<SoilAction>(new SoilAction(std::move(impl), options));
}

SoilAction::SoilAction(std::unique_ptr<Impl> impl, const SoilActionDef& options)
    : impl_(std::move(impl)) {
    Impl& d = *impl_;
    const auto forget_world = [this] {
        impl_->take_out();
        impl_->vehicles->leave_world();
        impl_->world->removeAction(this);
        impl_->world = nullptr;
    };
    d.anchor = std::make_unique<WorldAnchor>(
        *d.world, to_bullet(0.5 * (d.box.min + d.box.max)), [&d] { d.open_substep(); },
        forget_world, d.soil->frame());
    if (options.ground) {
        d.ground = std::make_unique<SoilGround>(
            *d.world, d.surface, d.soil->frame(), options,
            [&d](const btCollisionObject& object) { return d.collector.is_coupled(object); });
    }
    d.world->addAction(this);
    d.end_substep();
    d.world_tells_substeps = true;
}

bool SoilAction::Impl::begins_substep() {
    const bool is_told = world->getDispatchInfo().m_stepCount != kBetweenSubsteps;
    world_tells_substeps = world_tells_substeps || is_told;
    has_substep_begun = has_substep_begun || is_told;
    return is_told || !world_tells_substeps;
}

void SoilAction::Impl::end_substep() {
    world_tells_substeps = std::exchange(has_substep_begun, false);
    world->getDispatchInfo().m_stepCount = kBetweenSubsteps;
}

SoilAction::~SoilAction() {
    if (!impl_->world_if_there()) return;
    impl_->pause();
    impl_->vehicles->leave_world();
    impl_->world->removeAction(this);
}

Soil& SoilAction::soil() { return *impl_->soil; }
const Soil& SoilAction::soil() const { return *impl_->soil; }

Status SoilAction::set_options(const btCollisionObject& object, const BodyOptions& options) {
    if (Status s = options.validate(); !s) return s;
    impl_->collector.set_options(object, options);
    return Done{};
}

BodyOptions SoilAction::options(const btCollisionObject& object) const {
    return impl_->collector.options(object);
}

void SoilAction::set_enabled(bool enabled) { impl_->enabled = enabled; }
bool SoilAction::is_enabled() const { return impl_->enabled; }

const StepReport& SoilAction::last_report() const { return impl_->current_report(); }
long long SoilAction::step_count() const { return impl_->step_count; }
const std::vector<RefusedBody>& SoilAction::refused() const { return impl_->collector.refused(); }

std::vector<ObjectCondition> SoilAction::conditions() const {
    std::vector<ObjectCondition> out;
    for (const Condition& condition : impl_->soil->conditions()) {
        Impl::NamedCondition named;
        if (out.size() < impl_->named_conditions.size()) {
            named = impl_->named_conditions[out.size()];
        }
        // The soil may have been given another state behind our back.
        const bool is_same =
            named.body == condition.body && named.first_step == condition.first_step;
        out.push_back({condition, is_same ? named.object : nullptr});
    }
    return out;
}

BodyReport SoilAction::body_report(const btCollisionObject& object) const {
    const int id = body_id(object);
    BodyReport out = impl_->coupling.report(id);
    for (const BodyLoad& load : impl_->current_report().loads) {
        if (load.body != id) continue;
        out.load_kg = load.mass_kg;
        const SoilDef& def = impl_->soil->def();
        out.load_n = force_of(load, gravity_of(def), def.step_s);
    }
    if (std::ranges::count(impl_->feeling, id) > 0) out.load_n = impl_->carried.felt_n(id);
    return out;
}

int SoilAction::body_id(const btCollisionObject& object) const {
    return impl_->collector.body_id(object);
}

std::optional<SurfacePoint> SoilAction::surface_at(Vec3 world_m) const {
    return impl_->surface_at(world_m);
}

std::optional<SurfacePoint> SoilAction::Impl::surface_at(Vec3 world_m) const {
    if (!is_finite(world_m)) return {};
    const Pose& grid_to_world = soil->frame().grid_to_world;
    const Vec3 at_m = transform(inverse(grid_to_world), world_m);
    std::optional<SurfacePoint> point = surface.at(at_m.x, at_m.y);
    if (!point) return {};
    return SurfacePoint{transform(grid_to_world, point->position_m),
                        rotate(grid_to_world.rotation, point->normal)};
}

std::shared_ptr<SoilVehicles> SoilAction::vehicles() { return impl_->vehicles; }

btRigidBody* SoilAction::ground() const {
    return impl_->ground ? impl_->ground->object() : nullptr;
}

void SoilAction::updateAction(btCollisionWorld*, btScalar substep_s) {
    Impl& d = *impl_;
    d.end_substep();
    d.coupling.close_substep(substep_s);
    d.first_contacts.close_substep();
    d.carried.close_substep(static_cast<double>(substep_s));
    d.vehicles->close_substep();
    d.anchor->ensure_in_world();
    const double passed_s = static_cast<double>(substep_s);
    if (!std::isfinite(passed_s) || passed_s <= 0) return;
    if (d.enabled) {
        d.step_soil(passed_s);
    } else {
        d.pause();
        // What it refuses goes on lying on ground().
        d.collector.collect(*d.world, 0);
        d.note_feeling();
        d.is_paused = true;
    }
}

void SoilAction::Impl::pause() {
    coupling.let_go();
    carried.let_go();
    sleeping.let_go();
    first_contacts.let_go();
    clear_report();
    unstepped_s = uncollected_s = 0;
    untaken_count = 0;
}

void SoilAction::Impl::clear_report() {
    report = {};
    report.status_bits = soil->status_bits();
    report.conditions = soil->conditions();
}

void SoilAction::Impl::keep_report() {
    report_loads.assign(report.loads.begin(), report.loads.end());
    report.loads = report_loads;
    known_state_revision = soil->state_revision();
    was_stepping = soil->is_stepping();
}

const StepReport& SoilAction::Impl::current_report() {
    if (known_state_revision != soil->state_revision()) {
        clear_report();
        known_state_revision = soil->state_revision();
    } else if (was_stepping && !soil->is_stepping()) {
        report.contacts = {};
    }
    return report;
}

void SoilAction::Impl::step_soil(double substep_s) {
    const double step_s = soil->def().step_s;
    unstepped_s += substep_s;
    uncollected_s += substep_s;
    const double due = std::floor(unstepped_s / step_s + kStepTolerance);
    if (due < 1) return;
    look_at_world();
    const int count = static_cast<int>(std::min<double>(due, kStepsPerSubstepMax));
    unstepped_s -= due * step_s;
    bool are_unchanged = true;
    contact_bodies = {};
    untaken_count += count;
    for (int i = 0; i < count; ++i) {
        const int64_t begun_count = soil->step_rate().begun_count;
        report = soil->step(collector.soil_bodies((count - 1 - i) * step_s));
        are_unchanged = are_unchanged && report.contacts_unchanged;
        if (report.condition_new_count > 0) name_conditions();
        note_step(soil->step_rate().begun_count > begun_count);
    }
    keep_report();
    if (contact_bodies) take_report(are_unchanged);
    if (soil->is_stepping()) keep_stepped();
    coupling.set_late(untaken_count > 0 || !are_contacts_fresh);
}

/// With a budget a step sees the bodies of one call and is through in another. Its contacts are of
/// where they were: rows hold them beside the centre of mass, and so go on with the body.
void SoilAction::Impl::note_step(bool has_begun) {
    if (report.has_finished) {
        ++step_count;
        carried.note_given(report.loads);
        are_contacts_fresh = has_begun && !soil->is_stepping();
        if (!are_contacts_fresh) {
            std::erase_if(stepped, [&](const BodyState& body) {
                return body.object && !is_in_world(*world, body);
            });
        }
        contact_bodies = are_contacts_fresh ? collector.bodies() : std::span(stepped);
    }
    is_stepped_new = is_stepped_new || has_begun;
}

/// Once the contacts of the step before are taken.
void SoilAction::Impl::keep_stepped() {
    if (!std::exchange(is_stepped_new, false)) return;
    stepped.assign(collector.bodies().begin(), collector.bodies().end());
    coupling.set_bodies(collector.bodies());  // it may have had those of the step before
    vehicles->keep_stepped();
}

/// Finds the bodies, and whether they weigh as the soil does.
void SoilAction::Impl::look_at_world() {
    if (std::exchange(is_paused, false)) {  // nothing that happened meanwhile is swept
        collector.let_go();
        vehicles->meet_anew();
    }
    collector.collect(*world, uncollected_s);
    note_feeling();
    vehicles->show_wheels();
    coupling.set_bodies(collector.bodies());  // all of them: each that is added may move the list
    uncollected_s = 0;
    if (!has_gravity_of(*world, soil->def())) soil->set_status(StatusBit::gravity_differs);
}

void SoilAction::Impl::note_feeling() {
    feeling.clear();
    for (const BodyState& body : collector.bodies()) {
        const bool feels = body.role == BodyRole::rigid || body.role == BodyRole::link;
        if (feels && !body.is_asleep) feeling.push_back(body.id);
    }
}

/// What the last soil steps found goes to the bodies.
void SoilAction::Impl::take_report(bool are_contacts_unchanged) {
    const double step_s = soil->def().step_s;
    if (known_def_revision != soil->def_revision()) {
        known_def_revision = soil->def_revision();
        coupling.set_soil(soil->contact_soil());
    }
    coupling.set_contacts(*contact_bodies, report.contacts, untaken_count * step_s,
                          are_contacts_unchanged);
    first_contacts.soil_has_stepped(report.call_count * step_s);
    vehicles->take_contacts(are_contacts_fresh);
    carried.set_loads(*contact_bodies, moved_loads(), untaken_count * step_s, soil_speed_m_s());
    sleeping.set_loads(*contact_bodies, report.loads, gravity_of(soil->def()), step_s);
    untaken_count = 0;
    if (ground) ground->drop_stale_contacts();
}

/// Of what has fallen through all of the grid, or of the fastest soil in flight: faster is only
/// what bodies take along.
double SoilAction::Impl::soil_speed_m_s() const {
    const GridFrame& frame = soil->frame();
    const double height_m = frame.voxel_m * frame.size[2];
    const double flight_m_s =  // told along its fastest axis
        std::sqrt(3.0) * report.speed_max_voxels_per_step * frame.voxel_m / soil->def().step_s;
    return std::max(std::sqrt(2 * soil->def().gravity_m_s2 * height_m), flight_m_s);
}

/// Where the bodies have taken them meanwhile.
std::span<const BodyLoad> SoilAction::Impl::moved_loads() {
    if (are_contacts_fresh) return report.loads;
    loads.assign(report.loads.begin(), report.loads.end());
    for (BodyLoad& load : loads) {
        for (const BodyState& body : stepped) {
            if (body.id != load.body || !body.object) continue;
            const Vec3 moved_m = from_bullet(body.object->getWorldTransform().getOrigin()) -
                                 body.motion.center_of_mass_m;
            load.center_m += moved_m;
            load.held_kg_m += load.held_kg * moved_m;
        }
    }
    return loads;
}

Result<SettleReport> SoilAction::settle(int steps_max) {
    Impl& d = *impl_;
    if (!d.world_if_there()) return Error{kWorldIsGone};
    if (!d.enabled) {
        return Error{"the soil is switched off; call set_enabled(true) before settle()"};
    }
    return d.settle(steps_max);
}

Result<SettleReport> SoilAction::Impl::settle(int steps_max) {
    look_at_world();
    Result<SettleReport> settled = soil->settle(steps_max, collector.soil_bodies(0));
    if (settled) name_conditions();
    if (!soil->device_failure().empty()) report = {};  // it was of a soil that is lost
    if (settled && settled->step_count > 0) {
        report = settled->last_step;
        keep_report();
        // No time has passed for the bodies: their contacts are those of one step.
        contact_bodies = collector.bodies();
        are_contacts_fresh = true;
        untaken_count = 1;
        take_report(false);
        step_count += settled->step_count;
    }
    return settled;
}

/// The conditions that are not named yet are of bodies that the soil has just seen.
void SoilAction::Impl::name_conditions() {
    const std::span<const Condition> all = soil->conditions();
    const auto is_known = [&](size_t i) {
        return i < all.size() && named_conditions[i].body == all[i].body &&
               named_conditions[i].first_step == all[i].first_step;
    };
    while (!named_conditions.empty() && !is_known(named_conditions.size() - 1)) {
        named_conditions.pop_back();  // cleared since
    }
    for (const Condition& condition : all.subspan(named_conditions.size())) {
        const auto bodies = collector.bodies();
        const auto whose = std::find_if(bodies.begin(), bodies.end(), [&](const BodyState& body) {
            return body.id == condition.body;
        });
        named_conditions.push_back({whose == bodies.end() ? nullptr : whose->object, condition.body,
                                    condition.first_step});
    }
}

void SoilAction::debugDraw(btIDebugDraw* drawer) {
    Impl& d = *impl_;
    d.take_out();  // drawing boxes asks the anchor for its own, which may be taken for a substep
    if (!drawer || !d.enabled) return;
    std::vector<DrawnForce> forces;
    d.coupling.for_each_force([&forces](Vec3 point_m, Vec3 force_n) {
        forces.push_back({point_m, force_n});
    });
    draw_soil(*drawer, *d.soil, d.current_report().contacts, forces);
}

}  // namespace bsoil::bullet
