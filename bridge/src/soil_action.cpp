#include "bsoil/bullet/soil_action.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "body_collector.h"
#include "bsoil/limits.h"
#include "bullet_types.h"
#include "carried_load.h"
#include "check_surface.h"
#include "contact_coupling.h"
#include "coupling_snapshot.h"
#include "first_contact.h"
#include "snapshot_access.h"
#include "soil_debug_draw.h"
#include "soil_ground.h"
#include "soil_vehicles.h"
#include "world_anchor.h"
#include "world_gravity.h"
#include "world_objects.h"

namespace bsoil::bullet {
namespace {

/// A substep this close to the soil's step is that step: Bullet's float 1/60 is not the double one.
constexpr double kStepTolerance = 1e-3;
/// Soil steps one substep may ask for. A host that hands Bullet seconds at a time gets no more: the
/// rest of the time is dropped, as Bullet drops what exceeds its own substeps.
constexpr int kStepsPerSubstepMax = 256;

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

/// A section's name; the first soil of a world has no number.
std::string section_name(const char* part, size_t index) {
    return index == 0 ? std::string(part) : part + ('.' + std::to_string(index));
}

void list(StateStream& stream, StepReport& report, std::vector<BodyLoad>& loads) {
    stream(report.substep_count, report.status_bits, report.block_active_count,
           report.block_dispatched_count, report.tile_awake_count,
           report.speed_max_voxels_per_step);
    stream.list(loads, 36, [&](BodyLoad& load) { stream(load.body, load.mass_kg, load.center_m); });
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

struct SoilAction::Impl {
    Impl(btDiscreteDynamicsWorld& bullet_world, std::unique_ptr<Soil> new_soil,
         const SoilActionDef& options)
        : world(&bullet_world),
          soil(std::move(new_soil)),
          box(world_box(soil->frame())),
          collector(box, soil->frame().voxel_m),
          coupling(bullet_world, soil->contact_soil(), soil->known_contacts(), options,
                   soil->threads()),
          carried(bullet_world, up_of(soil->def()), soil->def().gravity_m_s2),
          surface(*soil),
          soil_below(*soil, surface, up_of(soil->def())),
          first_contacts(collector, coupling, soil_below, up_of(soil->def())),
          vehicles(std::make_shared<SoilVehicles>(
              world, collector, coupling, ground, soil->def().voxel_m,
              [this](Vec3 world_m) { return surface_at(world_m); })) {
        named_conditions.reserve(limits::kConditionCapacity + 32);
        for (const btCollisionObject* object : options.ignored) {
            collector.set_options(*object, {.ignored = true});
        }
    }

    std::optional<SurfacePoint> surface_at(Vec3 world_m) const;
    void open_substep() {
        if (!enabled) return;
        carried.open_substep();
        vehicles->open_substep();
        // Before the soil has stepped nobody knows what carries it.
        if (report.substep_count > 0) first_contacts.open_substep(*world, report.loads);
        coupling.open_substep();
    }
    void step_soil(double substep_s);
    Result<SettleReport> settle(int steps_max);
    void look_at_world();
    void take_report(int count, bool are_contacts_unchanged);
    /// Takes down whose the new conditions are.
    void name_conditions();
    /// Lets every body go and forgets where they were.
    void pause();
    CouplingSnapshot::Parts parts() {
        return {*world, collector, coupling, carried, first_contacts, *vehicles, surface};
    }

    btDiscreteDynamicsWorld* world;  ///< null once the host has emptied it
    std::unique_ptr<Soil> soil;
    Aabb box;
    BodyCollector collector;
    ContactCoupling coupling;
    CarriedLoads carried;
    std::unique_ptr<WorldAnchor> anchor;
    GroundSurface surface;
    SoilBelow soil_below;
    FirstContacts first_contacts;
    std::unique_ptr<SoilGround> ground;  ///< null without SoilActionDef::ground
    std::shared_ptr<SoilVehicles> vehicles;
    double unstepped_s = 0;    ///< time that has passed and the soil has not stepped
    double uncollected_s = 0;  ///< time since the bodies were last looked at
    bool enabled = true;
    uint64_t known_def_revision = 0;  ///< of the soil that the coupling knows
    long long step_count = 0;
    StepReport report;
    std::vector<BodyLoad> loaded_loads;  ///< of a report that came from a snapshot
    struct NamedCondition {
        const btCollisionObject* object = nullptr;
        int body = -1;
        int64_t first_step = -1;
    };
    /// In the order of the soil's conditions: whose each is.
    std::vector<NamedCondition> named_conditions;
};

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
        impl_->coupling.take_rows_out();
        impl_->carried.close_substep();
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
}

SoilAction::~SoilAction() {
    if (!impl_->world || !impl_->anchor->world_exists()) return;
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

const StepReport& SoilAction::last_report() const { return impl_->report; }
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
    for (const BodyLoad& load : impl_->report.loads) {
        if (load.body == id) out.load_kg = load.mass_kg;
    }
    return out;
}

int SoilAction::body_id(const btCollisionObject& object) const {
    return impl_->collector.body_id(object);
}

void SnapshotAccess::close_substep(SoilAction& action) {
    action.impl_->coupling.take_rows_out();
    action.impl_->carried.close_substep();
}

Result<std::vector<SnapshotSection>> SnapshotAccess::sections(const SoilAction& action,
                                                              size_t index) {
    SoilAction::Impl& d = *action.impl_;
    if (!d.world) return Error{"the world of the soil has been emptied"};
    StateStream stream;
    std::vector<ObjectKind> kinds = object_kinds(*d.world);
    stream.list(kinds, 1, [&](ObjectKind& kind) { kind.list(stream); });
    stream(d.unstepped_s, d.uncollected_s, d.step_count, d.enabled);
    std::vector<BodyLoad> loads(d.report.loads.begin(), d.report.loads.end());
    list(stream, d.report, loads);
    CouplingSnapshot::of(d.parts()).serialize(stream, *d.world);
    if (!stream.good()) return Error{"a pose, velocity or force of a body is not finite"};
    auto soil = d.soil->checked_state();
    if (!soil) return Error{soil.error()};
    return std::vector<SnapshotSection>{{section_name("soil", index), std::move(*soil)},
                                        {section_name("coupling", index), stream.bytes()}};
}

Result<std::function<void()>> SnapshotAccess::prepare(SoilAction& action,
                                                      std::span<const SnapshotSection> sections,
                                                      size_t index) {
    SoilAction::Impl& d = *action.impl_;
    if (!d.world) return Error{"the world of the soil has been emptied"};
    const std::vector<uint8_t>* soil = find_section(sections, section_name("soil", index));
    const std::vector<uint8_t>* coupling = find_section(sections, section_name("coupling", index));
    if (!soil || !coupling) return Error{"holds no coupled soil of this number"};
    struct Saved {
        double unstepped_s = 0, uncollected_s = 0;
        long long step_count = 0;
        bool enabled = true;
        StepReport report;
        std::vector<BodyLoad> loads;
        CouplingSnapshot memory;
    };
    auto saved = std::make_shared<Saved>();
    StateStream stream(*coupling);
    std::vector<ObjectKind> kinds;
    stream.list(kinds, 32, [&](ObjectKind& kind) { kind.list(stream); });
    if (!stream.good()) return Error{"is damaged"};
    if (const Status same = check_same_objects(kinds, *d.world); !same) return Error{same.error()};
    stream(saved->unstepped_s, saved->uncollected_s, saved->step_count, saved->enabled);
    list(stream, saved->report, saved->loads);
    saved->memory.serialize(stream, *d.world);
    const double step_s = d.soil->def().step_s;
    if (!stream.at_end() || saved->step_count < 0 || std::abs(saved->unstepped_s) > step_s) {
        return Error{"is damaged"};
    }
    if (const Status same = saved->memory.check_same_vehicles(*d.vehicles); !same) {
        return Error{same.error()};
    }
    auto put_soil = d.soil->prepare(*soil);
    if (!put_soil) return Error{put_soil.error()};
    return std::function<void()>([&d, saved, put = std::move(*put_soil)] {
        put();
        saved->memory.put_into(d.parts());
        d.unstepped_s = saved->unstepped_s;
        d.uncollected_s = saved->uncollected_s;
        d.step_count = saved->step_count;
        d.enabled = saved->enabled;
        d.loaded_loads = saved->loads;
        d.report = saved->report;
        d.report.loads = d.loaded_loads;
        d.report.conditions = d.soil->conditions();
        d.named_conditions.clear();
        for (const Condition& condition : d.report.conditions) {
            d.named_conditions.push_back(
                {d.collector.object_of(condition.body), condition.body, condition.first_step});
        }
    });
}

Status SoilAction::save(const std::string& path) const {
    const auto sections = SnapshotAccess::sections(*this, 0);
    if (!sections) return Error{"snapshot '" + path + "': " + sections.error()};
    return write_snapshot_file(path, *sections);
}

Status SoilAction::load(const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const auto put = SnapshotAccess::prepare(*this, *sections, 0);
    if (!put) return Error{"snapshot '" + path + "': " + put.error()};
    (*put)();
    return Done{};
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
    d.coupling.close_substep(substep_s);
    d.first_contacts.close_substep();
    d.carried.close_substep();
    d.vehicles->close_substep();
    d.anchor->ensure_in_world();
    const double passed_s = static_cast<double>(substep_s);
    if (!std::isfinite(passed_s) || passed_s <= 0) return;
    if (d.enabled) {
        d.step_soil(passed_s);
    } else {
        d.pause();
    }
}

void SoilAction::Impl::pause() {
    coupling.let_go();
    carried.let_go();
    collector.let_go();
    first_contacts.let_go();
    report = {};
    report.status_bits = soil->status_bits();
    report.conditions = soil->conditions();
    unstepped_s = uncollected_s = 0;
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
    for (int i = 0; i < count; ++i) {
        report = soil->step(collector.soil_bodies((count - 1 - i) * step_s));
        are_unchanged = are_unchanged && report.contacts_unchanged;
        if (report.condition_new_count > 0) name_conditions();
    }
    take_report(count, are_unchanged);
}

/// Finds the bodies, and whether they weigh as the soil does.
void SoilAction::Impl::look_at_world() {
    collector.collect(*world, uncollected_s);
    vehicles->show_wheels();
    uncollected_s = 0;
    if (!has_gravity_of(*world, soil->def())) soil->set_status(StatusBit::gravity_differs);
}

/// What the last soil steps found goes to the bodies.
void SoilAction::Impl::take_report(int count, bool are_contacts_unchanged) {
    const double step_s = soil->def().step_s;
    step_count += count;
    if (known_def_revision != soil->def_revision()) {
        known_def_revision = soil->def_revision();
        coupling.set_soil(soil->contact_soil());
    }
    coupling.set_contacts(collector.bodies(), report.contacts, count * step_s,
                          are_contacts_unchanged);
    first_contacts.soil_has_stepped(step_s);
    vehicles->take_contacts();
    carried.set_loads(collector.bodies(), report.loads);
    if (ground) ground->drop_stale_contacts();
}

Result<SettleReport> SoilAction::settle(int steps_max) {
    Impl& d = *impl_;
    if (!d.world || !d.anchor->world_exists()) {
        return Error{"the world of the soil has been emptied"};
    }
    if (!d.enabled) return Error{"the soil is switched off: set_enabled(true) before settle()"};
    return d.settle(steps_max);
}

Result<SettleReport> SoilAction::Impl::settle(int steps_max) {
    look_at_world();
    Result<SettleReport> settled = soil->settle(steps_max, collector.soil_bodies(0));
    if (settled) name_conditions();
    if (settled && settled->step_count > 0) {
        report = settled->last_step;
        // No time has passed for the bodies: their contacts are those of one step.
        take_report(1, false);
        step_count += settled->step_count - 1;
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
    // Drawing boxes asks the anchor for its own, which is taken for a substep.
    d.coupling.take_rows_out();
    d.carried.close_substep();
    if (!drawer || !d.enabled) return;
    std::vector<DrawnForce> forces;
    d.coupling.for_each_force([&forces](Vec3 point_m, Vec3 force_n) {
        forces.push_back({point_m, force_n});
    });
    draw_soil(*drawer, *d.soil, d.report.contacts, forces);
}

}  // namespace bsoil::bullet
