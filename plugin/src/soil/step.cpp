// The step on the host's side, as the diagram of plugin/README.md has it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "bsoil/limits.h"
#include "soil/kernel_params.h"
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

Stage stage_of(PieceKind kind) {
    switch (kind) {
        case PieceKind::apply_force:
        case PieceKind::propagate_force:
            return kDeform;
        case PieceKind::advect:
        case PieceKind::spread_overflow:
            return kAdvect;
        case PieceKind::fail_banks:
        case PieceKind::fail_banks_again:
        case PieceKind::slip:
        case PieceKind::slide:
        case PieceKind::take:
        case PieceKind::move_water:
            return kSlip;
        case PieceKind::collect_contacts:
        case PieceKind::ask:
        case PieceKind::read:
            return kContacts;
        case PieceKind::close:
            return kActivity;
        default:
            return kVoxelize;
    }
}

// So long the host rests before it asks a GPU again whether it is through.
constexpr std::chrono::microseconds kGpuPatience{50};

// What falls is faster by gravity in this step than in the last, and may get a body's speed.
Substeps cut_step(SoilCore& core, const BodyTable& bodies, const Passes& passes,
                  double pouring_speed_voxels, int substeps_most) {
    const int most = std::min(core.def.substeps_max, substeps_most);
    core.params.resolved_most = most * layout::kVoxelFull;
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
    // In a step that is late slopes slide once.
    if (core.due_count == 1) {
        cut.of_slides = (passes.slide_part_count() + cut.of_bodies - 1) / cut.of_bodies;
    }
    return cut;
}

}  // namespace

void Soil::Impl::begin_step() {
    ++step_index;
    const int32_t stamp = step_stamp_of(step_index);
    conditions.begin_step(step_index, def.step_s);
    stamps.begin_step(step_index);
    if (stamp < params.step_stamp || stamps.are_used_up()) {
        stamps.restart();
        tiles.note_dirty();
        device->fill_zero(Buffer::block_flags, 0, kFlagArrays * tiles.block_count());
        tiles.forget_stamps();
    }
    params.step_stamp = stamp;
    params.gravity_q16 = gravity_q16(def, step_index);
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

void Soil::Impl::begin_pieces(std::span<const SoilBody> input) {
    begin_step();
    bodies.meet(input);
    passes.limit_slips(std::numeric_limits<int>::max());
    const StepBudget::Room room = budget.room(def, passes, due_count);
    passes.limit_slips(room.slips);
    pieces.plan(*this, passes,
                cut_step(*this, bodies, passes, flows.pouring_speed_voxels(), room.substeps));
    list_work();
    // No body has moved and no soil may move: all there is to find out is known.
    is_quiet = bodies.are_same() && contacts.are_known() && !lists.any_work();
    contacts.make_room(lists.contacts().group_count);
    device->fill_zero(Buffer::result, 0,
                      kResultHeader + static_cast<int64_t>(bodies.ids().size()) * kLoadWords);
    flows.clear_results();
    params.body_substep_count = pieces.substeps().of_bodies;
    // Where slides settle, what is pushed rests as well.
    params.push_speed =
        params.slides == 0 ? 0 : static_cast<int>(std::lround(bodies.reach_voxels() * kOneQ16));
}

void Soil::Impl::run_piece(StepPiece piece) {
    const Substeps substeps = pieces.substeps();
    switch (piece.kind) {
        case PieceKind::voxelize:
            if ((piece.part == 0 && !is_quiet) || bodies.any_moved()) {
                shapes.upload(bodies.in_step(), bodies.ids(),
                              static_cast<double>(piece.part + 1) / substeps.of_bodies);
                lists.build_pairs(shapes);
                if (piece.part == 0) passes.look_at_restored();
                passes.voxelize();
            }
            break;
        case PieceKind::pour:
            flows.pour();
            break;
        case PieceKind::apply_force:
            passes.apply_force();
            break;
        case PieceKind::propagate_force:
            passes.propagate_force();
            break;
        case PieceKind::advect:
            params.substep_count = substeps.count();
            params.substep = piece.part;
            passes.advect();
            break;
        case PieceKind::spread_overflow:
            passes.spread_overflow();
            break;
        case PieceKind::fail_banks:
            params.substep_count = substeps.of_bodies;
            passes.fail_banks();
            break;
        case PieceKind::fail_banks_again:
            passes.fail_banks_again();
            break;
        case PieceKind::slip:
            params.substep_count = substeps.slide_count();
            passes.slip(piece.part, passes.slip_pass_count(substeps.of_slides));
            break;
        case PieceKind::slide:
            passes.slide(passes.slide_pass_count(substeps.slide_count()) * substeps.slide_count());
            break;
        case PieceKind::take:
            flows.take();
            break;
        case PieceKind::move_water:
            water.move();
            break;
        case PieceKind::collect_contacts:
            if (!is_quiet) passes.collect_contacts();
            break;
        case PieceKind::ask:
            if (!is_quiet) results.ask();
            break;
        case PieceKind::read:
            if (!is_quiet) results.read();
            break;
        case PieceKind::close:
            close_step();
            break;
        case PieceKind::begin:
        case PieceKind::count:
            break;
    }
}

void Soil::Impl::close_step() {
    if (is_quiet) {
        speed_q16 = slope_q16 = 0;
        contacts.note_quiet();
    } else {
        const bool has_changed = results.note_activity();
        water.note_results(results.header(), has_changed);
    }
    flows.note_results(is_quiet);
    tiles.sleep_idle();
}

// Whether the step is through. Without a budget it is.
bool Soil::Impl::go_on() {
    int stage = -1;
    while (pieces.is_open()) {
        const StepPiece piece = pieces.next();
        if (!budget.has_time_for(piece.kind)) return false;
        if (budget.is_limited() && piece.kind == PieceKind::read) {
            while (!device->is_read_done()) {
                if (!budget.has_time()) return false;
                std::this_thread::sleep_for(kGpuPatience);
            }
        }
        if (const int now = stage_of(piece.kind); now != stage) device->mark_stage(stage = now);
        budget.begin_piece();
        pieces.pass();
        run_piece(piece);
        budget.end_piece(piece.kind);
    }
    note_finished();
    return true;
}

void Soil::Impl::note_finished() {
    // Who looked at the soil while the step went on has seen it half done.
    if (budget.call_count() > 1) sampler.forget();
    last_report.has_finished = true;
    last_report.call_count = budget.call_count();
    last_report.substep_count = pieces.substeps().count();
    last_report.block_active_count = lists.active_count();
    last_report.block_dispatched_count = lists.listed().group_count;
    last_report.speed_max_voxels_per_step = static_cast<double>(speed_q16) / 65536;
    last_report.contacts_unchanged = is_quiet && !is_undelivered;
    is_undelivered = true;
}

StepReport Soil::Impl::step(std::span<const SoilBody> input, double budget_ms) {
    device::DeviceSession session(*device);
    // Of the first step the caller waits for the end: until then nothing is known of contacts.
    budget.begin_call(last_report.substep_count > 0 ? budget_ms : 0);
    bool begins = true;
    if (pieces.is_open()) {
        if (budget.continue_step() >= def.step_spread_max) {
            budget.lift();
            budget.note_held();
            conditions.note(StatusBit::budget_exceeded);
        }
        begins = go_on() && budget.may_begin();
    }
    if (begins) {
        due_count = budget.begin_step();
        budget.begin_piece();
        begin_pieces(input);
        budget.end_piece(PieceKind::begin);
        go_on();
        if (pieces.is_open()) bodies.keep_given();
    } else {
        conditions.note(StatusBit::rate_lowered);
    }
    if (pieces.is_open()) sampler.forget();  // what has been read is of another piece
    session.end();
    budget.end_call();
    return report();
}

void Soil::Impl::finish() {
    if (!pieces.is_open()) return;
    device::DeviceSession session(*device);
    budget.lift();
    go_on();
    sampler.forget();
}

void Soil::Impl::drop_step() {
    device->finish_read();
    pieces.drop();
    is_undelivered = false;
    last_report = {};
}

StepReport Soil::Impl::report() {
    StepReport out = last_report;
    out.has_finished = std::exchange(is_undelivered, false);
    out.contacts_unchanged = !out.has_finished || last_report.contacts_unchanged;
    out.stage_ms = stage_times(device->stage_ms());
    if (!device->failure().empty()) conditions.note(StatusBit::device_lost);
    out.status_bits = conditions.bits();
    out.condition_new_count = conditions.take_new_count();
    out.conditions = conditions.all();
    out.tile_awake_count = tiles.awake_count();
    out.contacts = contacts.contacts();
    out.loads = contacts.loads();
    out.momentum = contacts.momentum();
    return out;
}

}  // namespace bsoil
