// The step on the host's side, as the diagram of plugin/README.md has it.
#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

// How much faster falling soil can get in a step than gravity makes it [voxels a step]: whole units
// of mass and momentum cannot be cut into quite equal parts.
constexpr double kSpeedMargin = 1.0 / 8;

/// Stages as StageTimes has them.
enum Stage { kVoxelize, kDeform, kAdvect, kSlip, kContacts, kActivity };

StageTimes stage_times(std::span<const double> ms) {
    return {ms[kVoxelize], ms[kDeform], ms[kAdvect], ms[kSlip], ms[kContacts], ms[kActivity]};
}

/// Into how many parts a step is cut, so that bodies and soil cross at most one voxel at a time.
struct Substeps {
    int of_bodies = 1;
    int of_falls = 1;  ///< of each of these
    int count() const { return of_bodies * of_falls; }
};

// What falls is faster by gravity in this step than in the last, and may get a body's speed.
Substeps cut_step(SoilCore& core, const BodyTable& bodies, double pouring_speed_voxels) {
    const int most = core.def.substeps_max;
    const double reach = bodies.reach_voxels();
    const double speed =
        std::max(static_cast<double>(core.speed_q16) / 65536, pouring_speed_voxels);
    const double fall =
        speed > 0 ? std::max(reach, speed + core.params.gravity_q16 / 65536.0) + kSpeedMargin : 0;
    Substeps cut;
    cut.of_bodies = std::clamp(static_cast<int>(std::ceil(reach)), 1, most);
    cut.of_falls = std::clamp(static_cast<int>(std::ceil(fall / cut.of_bodies)), 1,
                              std::max(1, most / cut.of_bodies));
    if (fall > cut.count()) {
        const bool by_body =
            bodies.fastest() && reach * 65536 > static_cast<double>(core.speed_q16);
        core.conditions.note(StatusBit::speed_clamped, by_body ? bodies.fastest()->id : -1);
    }
    return cut;
}

}  // namespace

void Soil::Impl::begin_step() {
    ++step_index;
    const int32_t stamp = step_stamp_of(step_index);
    conditions.begin_step(step_index, def.step_s);
    if (stamp < params.step_stamp || stamps.are_used_up()) {
        stamps.restart();
        tiles.note_dirty();
        device->fill_zero(Buffer::block_flags, 0, kFlagArrays * tiles.block_count());
        tiles.forget_stamps();
    }
    params.step_stamp = stamp;
    // Gusts drift with the wind: whole parts of a voxel since the first step, whatever came
    // between.
    const int64_t period = int64_t{kGustPeriod} * params.gust_cell * kOneQ8;
    const auto back = [&](int wind) {
        const int64_t way = step_index * wind / (kVoxelFull / kOneQ8) % period;
        return static_cast<int32_t>((period - way) % period);
    };
    params.gust_x = back(params.wind_x);
    params.gust_y = back(params.wind_y);
}

// Which blocks have changed or may change: the work lists.
void Soil::Impl::list_work() {
    bodies.drop_gone([&](const BodyTrack& track) {  // its room is free again
        lists.mark_rebuild(track.blocks, true);
        if (track.is_ground) ground.drop(track);
    });
    ground.update(bodies.in_step());
    if (tiles.any_unchecked) wake_unstable_columns();
    flows.begin_step();
    water.begin_step();
    lists.mark_bodies(bodies.in_step());
    lists.wake_active();
    lists.mark_woken(bodies.in_step());
    tiles.upload();
    lists.build();
    flows.list();
    lists.list_small_bodies(bodies.in_step());
}

StepReport Soil::Impl::step(std::span<const SoilBody> input) {
    device::DeviceSession session(*device);
    begin_step();
    bodies.meet(input);
    const Substeps substeps = cut_step(*this, bodies, flows.pouring_speed_voxels());
    list_work();
    // No body has moved and no soil may move: all there is to find out is known.
    const bool is_quiet = bodies.are_same() && contacts.are_known() && !lists.any_work();

    device->fill_zero(Buffer::result, 0, kContactsFirst);
    flows.clear_results();
    params.body_substep_count = substeps.of_bodies;
    for (int s = 0; s < substeps.of_bodies; ++s) {
        device->mark_stage(kVoxelize);
        if ((s == 0 && !is_quiet) || bodies.any_moved()) {
            shapes.upload(bodies.in_step(), bodies.ids(),
                          static_cast<double>(s + 1) / substeps.of_bodies);
            lists.build_pairs(shapes);
            passes.voxelize();
        }
        if (s == 0) flows.pour();
        device->mark_stage(kDeform);
        passes.deform();
        device->mark_stage(kAdvect);
        params.substep_count = substeps.count();
        for (int f = 0; f < substeps.of_falls; ++f) passes.advect();
        device->mark_stage(kSlip);
        params.substep_count = substeps.of_bodies;
        if (s == 0 && params.bank_strength > 0) passes.fail_banks();
        passes.slip();
    }

    flows.take();
    water.move();

    device->mark_stage(kContacts);
    if (is_quiet) {
        speed_q16 = slope_q16 = 0;
    } else {
        passes.collect_contacts();
        results.read();
    }
    device->mark_stage(kActivity);
    if (!is_quiet) {
        const bool has_changed = results.note_activity();
        water.note_results(results.header(), has_changed);
    }
    flows.note_results(is_quiet);
    tiles.sleep_idle();
    session.end();
    return report(substeps.count(), is_quiet);
}

StepReport Soil::Impl::report(int substep_count, bool is_quiet) {
    StepReport report;
    report.stage_ms = stage_times(device->stage_ms());
    report.substep_count = substep_count;
    report.status_bits = conditions.bits();
    report.condition_new_count = conditions.take_new_count();
    report.conditions = conditions.all();
    report.block_active_count = lists.active_count();
    report.block_dispatched_count = lists.listed().group_count;
    report.tile_awake_count = tiles.awake_count();
    report.speed_max_voxels_per_step = static_cast<double>(speed_q16) / 65536;
    report.contacts = contacts.contacts();
    report.contacts_unchanged = is_quiet;
    report.loads = contacts.loads();
    return report;
}

}  // namespace bsoil
