// The step on the host's side: which bodies, which blocks, which kernels in which order.
#include <algorithm>
#include <cmath>

#include "soil/soil_impl.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;

namespace {

// A body counts as still until it has moved this far since its coverage was last made [voxels]: a
// machine that rocks by micrometres on its tracks is not voxelized anew in every step. Well below
// what the contact forces resolve.
constexpr double kStillVoxels = 1.0 / 512;
// Whole units of mass and momentum do not go into quite equal parts: falling soil can be so much
// faster in a step than gravity makes it [voxels a step].
constexpr double kSpeedMargin = 1.0 / 8;

// Slippage passes in a step of 1/60 s. One pass levels a slope over a voxel; a second makes a metre
// of loose sand come to rest in about a second, as it does. Longer steps have more of them; in
// shorter ones each moves less, so that slopes relax by as much in a second.
constexpr int kSlipPasses = 2;
constexpr double kSlipPassesPerSecond = kSlipPasses * 60.0;
// More of them, one for each so much (Q16 voxels) that the steepest slope stands above a stable
// one.
constexpr int kSlopePerPass = 8192;
constexpr int kSlipPassesMost = 16;
// In these passes soil slides so far at once [m]. A slope carries off what is pushed onto it in
// proportion to the square of that way: with a way of one voxel heaps were the steeper, the finer
// the grid.
constexpr double kSlipWay = 0.04;
constexpr int kSlipStrideMost = kTileSide / 2;  // from opposite sides into one tile, apart

/// Stages as StageTimes has them.
enum Stage { kVoxelize, kDeform, kAdvect, kSlip, kContacts, kActivity };

StageTimes stage_times(std::span<const double> ms) {
    return {ms[kVoxelize], ms[kDeform], ms[kAdvect], ms[kSlip], ms[kContacts], ms[kActivity]};
}

int slip_passes_least(double step_s) {
    const double wanted = std::ceil(step_s * kSlipPassesPerSecond - 1e-9);
    return std::max(kSlipPasses, static_cast<int>(wanted));
}

}  // namespace

bool GivenBody::operator==(const GivenBody& o) const {
    const auto same = [](Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
    const Quat &a = pose.rotation, &b = o.pose.rotation;
    return same(pose.position, o.pose.position) && a.x == b.x && a.y == b.y && a.z == b.z &&
           a.w == b.w && same(linear_velocity_m_s, o.linear_velocity_m_s) &&
           same(angular_velocity_rad_s, o.angular_velocity_rad_s) &&
           same(center_of_mass_m, o.center_of_mass_m) && contact_width_m == o.contact_width_m;
}

void Soil::Impl::dispatch(Kernel kernel, const ListedWork& work) {
    if (work.group_count == 0) {
        return;
    }
    params.list_offset = work.list_offset;
    params.pair_offset = work.list_offset;
    device->dispatch(static_cast<int>(kernel), words_of(params), work);
}

// thesis (18)
void Soil::Impl::run_deformation() {
    ++params.pass_stamp;
    dispatch(Kernel::apply_force, listed_work);
    for (int i = 0; i < def.propagation_iterations; ++i) {
        ++params.pass_stamp;
        dispatch(Kernel::propagate_force, listed_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

// thesis (19)
void Soil::Impl::run_advection() {
    dispatch(Kernel::find_support, tile_work);
    params.support_stamp = params.pass_stamp;
    ++params.pass_stamp;
    dispatch(Kernel::advect_soil, listed_work);
    dispatch(Kernel::apply_flow, listed_work);
    for (int i = 0; i < def.overflow_passes; ++i) {
        ++params.pass_stamp;
        dispatch(Kernel::resolve_overflow, listed_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

// Which banks fail as a whole. What falls apart slides in the passes that follow.
void Soil::Impl::run_failures() {
    dispatch(Kernel::build_spans, tile_work);
    params.spans_stamp = params.pass_stamp;
    params.slip_stamp = failure_stamp;
    failure_stamp = params.pass_stamp;
    ++params.pass_stamp;
    dispatch(Kernel::find_failures, tile_work);
    dispatch(Kernel::break_bonds, tile_work);
}

void Soil::Impl::set_slip_rates() {
    const double share = def.step_s * kSlipPassesPerSecond / slip_passes_least(def.step_s);
    params.slip_rate_least = static_cast<int>(std::lround(kSlipRateLeast * share));
    params.slip_rate_most = static_cast<int>(std::lround(kSlipRateMost * share));
}

// thesis (20)
void Soil::Impl::run_slippage() {
    // Bodies build slopes up at so many voxels a step: the steeper the step before has left them,
    // the more passes. The last ones go by single voxels, which smooths what the long ways left.
    const int least = slip_passes_least(def.step_s);
    const int passes =
        std::min(kSlipPasses + slope_q16 / kSlopePerPass, kSlipPassesMost) * least / kSlipPasses;
    const int stride_most =
        std::clamp(static_cast<int>(std::lround(kSlipWay / frame.voxel_m)), 1, kSlipStrideMost);
    for (int pass = 0; pass < passes; ++pass) {
        const int stride = pass < passes - least ? stride_most : 1;
        int32_t& slip_stamp = slip_stamps[stride > 1];
        params.slip_stride = stride;
        params.slip_stamp = slip_stamp;
        dispatch(Kernel::build_spans, tile_work);
        params.spans_stamp = params.pass_stamp;
        slip_stamp = params.pass_stamp;
        ++params.pass_stamp;
        params.slip_turn = 1 - params.slip_turn;
        if (pass == passes - 1) {
            device->fill_zero(Buffer::result, kResultSlope, 1);
        }
        dispatch(Kernel::slip_soil, tile_work);
        dispatch(Kernel::apply_flow, listed_work);
    }
}

StepReport Soil::Impl::step(std::span<const SoilBody> input) {
    StepReport report;
    device::DeviceSession session(*device);
    ++step_index;
    const int32_t stamp = step_stamp_of(step_index);
    conditions.begin_step(step_index, def.step_s);
    if (stamp < params.step_stamp || params.pass_stamp > (1 << 30)) {
        params.pass_stamp = 0;
        table_dirty = true;
        device->fill_zero(Buffer::block_flags, 0,
                          static_cast<int64_t>(kFlagArrays) * slot_count * blocks_per_tile);
        forget_stamps();
    }
    params.step_stamp = stamp;

    // --- bodies: who is here, who moved, how fast
    std::vector<StepBody>& step_bodies = body_scratch;
    step_bodies.clear();
    double reach = 0;
    const SoilBody* fastest = nullptr;  // the one with this reach
    bool same_bodies = true;
    for (const SoilBody& body : input) {
        if (!accept_body(body)) {
            continue;
        }
        if (static_cast<int>(step_bodies.size()) >= limits::kBodyCapacity) {
            conditions.note(StatusBit::shape_refused, body.id, body.center_of_mass_m);
            break;
        }
        BodyTrack& track = bodies[body.id];
        if (track.last_step == step_index) {
            continue;  // the same id twice in one step: the first counts
        }
        const Pose to = world_to_grid * body.pose;
        StepBody entry{&body, &track, to, to, true, true};
        if (track.index < 0 || track.shape_revision != body.shape_revision ||
            track.walls.growth.size() != body.shapes->size()) {
            track.walls.make(*body.shapes, frame.voxel_m);
            track.surface = {};
        }
        if (def.contact_law.faces_by_shape && !body.is_static && !track.surface.is_made) {
            track.surface.make(*body.shapes, track.walls.growth, frame.voxel_m);
        }
        if (track.index < 0) {
            track.index = take_body_index(body.id);
        } else if (track.shape_revision == body.shape_revision) {
            entry.from = track.pose;
            const double move = body_reach_voxels(entry);
            entry.moved = move > kStillVoxels;
            entry.placed = move > def.substeps_max;
            if (!entry.moved) {
                entry.to = entry.from;
            } else if (move > def.substeps_max) {
                conditions.note(StatusBit::body_teleported, body.id, body.center_of_mass_m);
                entry.from = to;
            } else {
                fastest = move > reach ? &body : fastest;
                reach = std::max(reach, move);
            }
        }
        const GivenBody given{body.pose, body.linear_velocity_m_s, body.angular_velocity_rad_s,
                              body.center_of_mass_m, body.contact_width_m};
        same_bodies = same_bodies && !entry.moved && given == track.given;
        track.given = given;
        entry.turned_static = track.is_static != body.is_static;
        track.pose = entry.to;
        track.shape_revision = body.shape_revision;
        track.is_static = body.is_static;
        track.last_step = step_index;
        if (!body.is_static && !body.may_leave && !frame.is_above(body.center_of_mass_m)) {
            conditions.note(StatusBit::body_outside_grid, body.id, body.center_of_mass_m);
        }
        step_bodies.push_back(entry);
    }
    // Bodies and soil may each cross one voxel at a time. What falls is faster by gravity in this
    // step than in the last, and may get a body's speed.
    const double fall =
        speed_q16 > 0
            ? std::max(reach, static_cast<double>(speed_q16 + params.gravity_q16) / 65536) +
                  kSpeedMargin
            : 0;
    const int body_substeps = std::clamp(static_cast<int>(std::ceil(reach)), 1, def.substeps_max);
    const int fall_substeps = std::clamp(static_cast<int>(std::ceil(fall / body_substeps)), 1,
                                         std::max(1, def.substeps_max / body_substeps));
    if (fall > body_substeps * fall_substeps) {
        const bool by_body = fastest && reach * 65536 > static_cast<double>(speed_q16);
        conditions.note(StatusBit::speed_clamped, by_body ? fastest->id : -1);
    }

    // --- blocks: where coverage changes, what is active, what to dispatch
    for (auto it = bodies.begin(); it != bodies.end();) {
        if (it->second.last_step != step_index) {  // gone: its room is free again
            same_bodies = false;
            mark_rebuild(it->second.blocks, true);
            body_ids[it->second.index] = -1;
            if (it->second.is_ground) {
                mark_ground(it->second);
            }
            it = bodies.erase(it);
        } else {
            ++it;
        }
    }
    update_ground(step_bodies);
    if (any_unchecked) {
        wake_unstable_columns();
    }
    bool any_moved = false;
    std::vector<BlockKey>& blocks = block_scratch;
    for (StepBody& body : step_bodies) {
        const bool is_static = body.input->is_static;
        find_body_blocks(body, body.moved || !is_static, blocks);
        if (body.moved) {
            mark_rebuild(body.track->blocks, true);
            mark_rebuild(blocks, true);
            any_moved = true;
        } else {
            fresh_blocks.clear();
            std::set_difference(blocks.begin(), blocks.end(), body.track->blocks.begin(),
                                body.track->blocks.end(), std::back_inserter(fresh_blocks));
            mark_rebuild(body.turned_static ? blocks : fresh_blocks, false);
        }
        body.track->blocks = blocks;
    }
    list_active_blocks();
    // A tile that woke just now has no coverage yet, and its bodies may not have been looked up
    // with it awake.
    for (StepBody& body : step_bodies) {
        find_body_blocks(body, false, blocks);
        body.track->blocks = blocks;
        for (BlockKey key : blocks) {
            const int block = device_block(key);
            if (woken_step[block / blocks_per_tile] == step_index) {
                rebuild_step[block] = step_index;
            }
            if (!body.input->is_static) {
                contact_step[block] = step_index;
            }
        }
    }
    upload_tile_table();
    build_work_lists();
    list_words_uploaded = 0;
    // No body has moved and no soil may move: all there is to find out is known.
    const bool is_quiet = same_bodies && contacts_known && listed_work.group_count == 0 &&
                          rebuild_work.group_count == 0 && tile_work.group_count == 0;

    // --- the step itself
    device->fill_zero(Buffer::result, 0,
                      kResultHeader + static_cast<int64_t>(limits::kBodyCapacity) * kLoadWords);
    params.body_substep_count = body_substeps;
    for (int s = 0; s < body_substeps; ++s) {
        device->mark_stage(kVoxelize);
        if ((s == 0 && !is_quiet) || any_moved) {
            upload_bodies(step_bodies, static_cast<double>(s + 1) / body_substeps);
            build_pairs();
            dispatch(Kernel::clear_coverage, rebuild_work);
            dispatch(Kernel::voxelize_shapes, pair_work);
        }
        device->mark_stage(kDeform);
        run_deformation();
        device->mark_stage(kAdvect);
        params.substep_count = body_substeps * fall_substeps;
        for (int f = 0; f < fall_substeps; ++f) {
            run_advection();
        }
        device->mark_stage(kSlip);
        params.substep_count = body_substeps;
        if (s == 0 && params.bank_strength > 0) {
            run_failures();
        }
        run_slippage();
    }

    device->mark_stage(kContacts);
    if (is_quiet) {
        speed_q16 = slope_q16 = 0;
    } else {
        params.contact_offset = kResultHeader + limits::kBodyCapacity * kLoadWords;
        params.contact_capacity = limits::kContactCapacity;
        dispatch(Kernel::collect_contacts, contact_work);
        read_back();
        read_results(step_bodies);
        contacts_known = (result_head[kResultStatus] & kStatusContactsFull) == 0;
    }

    device->mark_stage(kActivity);
    if (!is_quiet) {
        read_activity();
    }
    sleep_idle_tiles();
    session.end();
    report.stage_ms = stage_times(device->stage_ms());

    report.substep_count = body_substeps * fall_substeps;
    report.status_bits = conditions.bits();
    report.condition_new_count = conditions.take_new_count();
    report.conditions = conditions.all();
    report.block_active_count = block_active_count;
    report.block_dispatched_count = listed_work.group_count;
    report.tile_awake_count = slot_count - static_cast<int>(free_slots.size());
    report.speed_max_voxels_per_step = static_cast<double>(speed_q16) / 65536;
    report.contacts = contacts;
    report.contacts_unchanged = is_quiet;
    report.loads = loads;
    return report;
}

}  // namespace bsoil
