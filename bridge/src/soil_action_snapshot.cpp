// Snapshots of a coupled soil: the soil, and what the coupling remembers.
#include <cmath>
#include <utility>

#include "snapshot_access.h"
#include "soil_action.h"
#include "world_objects.h"

namespace bsoil::bullet {
namespace {

/// Steps of a million years and more.
constexpr long long kStepsMost = 1ll << 53;

/// A section's name; the first soil of a world has no number.
std::string section_name(const char* part, size_t index) {
    return index == 0 ? std::string(part) : part + ('.' + std::to_string(index));
}

void list(StateStream& stream, StepReport& report, std::vector<BodyLoad>& loads) {
    stream(report.substep_count, report.status_bits, report.block_active_count,
           report.block_dispatched_count, report.tile_awake_count,
           report.speed_max_voxels_per_step);
    stream.list(loads, 92, [&](BodyLoad& load) {
        stream(load.body, load.mass_kg, load.center_m, load.impulse_n_s, load.held_kg,
               load.held_kg_m);
    });
}

}  // namespace

void SnapshotAccess::close_substep(SoilAction& action) { action.impl_->take_out(); }

Result<std::vector<SnapshotSection>> SnapshotAccess::sections(const SoilAction& action,
                                                              size_t index) {
    SoilAction::Impl& d = *action.impl_;
    if (!d.world_if_there()) return Error{kWorldIsGone};
    d.take_out();  // loads and their bodies are told apart
    StateStream stream;
    std::vector<ObjectKind> kinds = object_kinds(*d.world);
    stream.list(kinds, 1, [&](ObjectKind& kind) { kind.list(stream); });
    stream(d.unstepped_s, d.uncollected_s, d.step_count, d.enabled, d.is_paused,
           d.world_tells_substeps, d.feeling);
    StepReport report = d.current_report();
    std::vector<BodyLoad> loads(report.loads.begin(), report.loads.end());
    list(stream, report, loads);
    CouplingSnapshot::of(d.parts()).serialize(stream, *d.world);
    if (!stream.good()) {
        return Error{"a pose, velocity or force of a body is not finite; take that body out"};
    }
    auto soil = d.soil->checked_state();
    if (!soil) return Error{soil.error()};
    return std::vector<SnapshotSection>{{section_name("soil", index), std::move(*soil)},
                                        {section_name("coupling", index), stream.bytes()}};
}

Result<std::function<void()>> SnapshotAccess::prepare(SoilAction& action,
                                                      std::span<const SnapshotSection> sections,
                                                      size_t index) {
    SoilAction::Impl& d = *action.impl_;
    if (!d.world_if_there()) return Error{kWorldIsGone};
    d.take_out();  // loads and their bodies are told apart
    const std::vector<uint8_t>* soil = find_section(sections, section_name("soil", index));
    const std::vector<uint8_t>* coupling = find_section(sections, section_name("coupling", index));
    if (!soil || !coupling) {
        return Error{
            "holds no coupled soil of this number; load a file that a SoilAction or save_world() "
            "wrote"};
    }
    struct Saved {
        double unstepped_s = 0, uncollected_s = 0;
        long long step_count = 0;
        bool enabled = true, is_paused = false, world_tells_substeps = true;
        StepReport report;
        std::vector<int> feeling;
        std::vector<BodyLoad> loads;
        CouplingSnapshot memory;
    };
    auto saved = std::make_shared<Saved>();
    StateStream stream(*coupling);
    std::vector<ObjectKind> kinds;
    stream.list(kinds, 32, [&](ObjectKind& kind) { kind.list(stream); });
    if (!stream.good()) return Error{std::string("is damaged") + kTakeAnotherCopy};
    if (const Status same = check_same_objects(kinds, *d.world); !same) return Error{same.error()};
    stream(saved->unstepped_s, saved->uncollected_s, saved->step_count, saved->enabled,
           saved->is_paused, saved->world_tells_substeps, saved->feeling);
    list(stream, saved->report, saved->loads);
    saved->memory.serialize(stream, *d.world);
    const double step_s = d.soil->def().step_s;
    if (!stream.at_end() || saved->step_count < 0 || saved->step_count > kStepsMost ||
        std::abs(saved->unstepped_s) > step_s) {
        return Error{std::string("is damaged") + kTakeAnotherCopy};
    }
    if (const Status same = saved->memory.check_same_vehicles(*d.vehicles); !same) {
        return Error{same.error()};
    }
    if (const Status sound = saved->memory.check_loads(*d.soil); !sound) {
        return Error{sound.error()};
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
        d.is_paused = saved->is_paused;
        d.world_tells_substeps = saved->world_tells_substeps;
        d.feeling = saved->feeling;
        d.report = saved->report;
        d.report.loads = saved->loads;
        d.report.conditions = d.soil->conditions();
        d.keep_report();
        // Of the run that was here before; the saved one's step in progress has been finished.
        d.untaken_count = 0;
        d.coupling.set_late(d.soil->def().step_budget_ms > 0);
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

}  // namespace bsoil::bullet
