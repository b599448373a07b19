#include "soil/passes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/kernels.h"
#include "bsoil/limits.h"
#include "soil/soil_kernels.h"

namespace bsoil {

using namespace layout;
using Looker = PassStamps::Looker;

namespace {

// Slippage passes in a step of 1/60 s. One pass levels a slope over a voxel. With two a metre of
// loose sand comes to rest in about a second, as real sand does. Longer steps have more passes. In
// shorter steps each pass moves less, so that slopes relax equally fast.
constexpr int kSlipPasses = 2;
constexpr double kSlipPassesPerSecond = kSlipPasses * 60.0;
// One more pass for each 1/8 voxel (Q16) by which the steepest slope exceeds a stable one.
constexpr int kSlopePerPass = 8192;
constexpr int kSlipPassesMost = 16;
// Soil that keeps its momentum crosses so many voxels in a part of a step, by its speed in the last
// step, and one at most in a slide pass. What drives it is found once in a part. Ours: larger, and
// soil slides on by a slope that it has left behind; smaller costs passes.
constexpr double kSlidePartVoxels = 2;
// A column slides when the one before it has left: failure goes back by one in a part. In soil the
// whole wedge goes at once. So a step has as many parts as this speed [m/s] asks for, and no more
// than kPartsPerWedge for each voxel that fails. Ours, seen with 10 to 90 m/s and 1 to 12: smaller,
// and columns run out less far in finer grids; larger costs passes.
constexpr double kFailureSpeed = 20;
constexpr int kPartsPerWedge = 4;
// That many at 1 cm and 60 Hz. Ours: larger, and a face that fails in a grid of millimetres takes
// seconds a step; smaller, and columns run out less far in grids of centimetres.
constexpr int kSlidePartsMost = 32;
// Distance that soil slides in one of these passes [m]. The soil that a slope can carry off grows
// with the square of this distance. Sliding one voxel per pass made heaps steeper on finer grids.
constexpr double kSlipDistanceM = 0.04;
constexpr int kSlipStrideMost = kTileSide / 2;  // from opposite sides into one tile, apart

int slip_passes_least(double step_s) {
    const double wanted = std::ceil(step_s * kSlipPassesPerSecond - 1e-9);
    return std::max(kSlipPasses, static_cast<int>(wanted));
}

}  // namespace

void Passes::start() {
    const double step_s = core_.def.step_s;
    const double share = step_s * kSlipPassesPerSecond / slip_passes_least(step_s);
    core_.params.slip_rate_least = static_cast<int>(std::lround(kSlipRateLeast * share));
    core_.params.slip_rate_most = static_cast<int>(std::lround(kSlipRateMost * share));
}

void Passes::run(Kernel kernel, const ListedWork& work) {
    if (work.group_count == 0) return;
    core_.params.list_offset = work.list_offset;
    core_.params.pair_offset = work.list_offset;
    core_.device->dispatch(static_cast<int>(kernel), words_of(core_.params), work);
}

// A kernel that leaves out the columns that have not changed since it last ran.
void Passes::look(Kernel kernel, Looker looker, const ListedWork& work) {
    core_.stamps.begin_look(looker);
    run(kernel, work);
}

void Passes::move(Kernel kernel, const ListedWork& work) {
    core_.stamps.begin_pass();
    run(kernel, work);
    run(Kernel::apply_flow, lists_.listed());
}

// What moves in tiles beside them asks for it. Stamp 0 is of no step: for all others these tiles
// are not dispatched in this one. What they find of conditions has been noted before.
void Passes::look_at_restored() {
    if (lists_.restored().group_count == 0) return;
    const int32_t step_stamp = std::exchange(core_.params.step_stamp, 0);
    core_.stamps.begin_partial_look(Looker::support);
    run(Kernel::find_support, lists_.restored());
    core_.stamps.begin_partial_look(Looker::spans);
    run(Kernel::build_spans, lists_.restored());
    core_.params.step_stamp = step_stamp;
    core_.device->fill_zero(Buffer::result, 0, kResultHeader);
}

void Passes::voxelize() {
    run(Kernel::clear_coverage, lists_.rebuild());
    run(Kernel::voxelize_shapes, lists_.pairs());
}

// thesis (18)
void Passes::apply_force() {
    core_.stamps.begin_pass();
    run(Kernel::apply_force, lists_.listed());
}

// thesis (18), an iteration
void Passes::propagate_force() { move(Kernel::propagate_force, lists_.listed()); }

// thesis (19)
void Passes::advect() {
    look(Kernel::find_support, Looker::support, lists_.tiles());
    move(Kernel::advect_soil, lists_.listed());
}

void Passes::spread_overflow() { move(Kernel::resolve_overflow, lists_.listed()); }

// What falls apart slides in the passes that follow.
void Passes::fail_banks() {
    core_.stamps.begin_look(Looker::failures);
    core_.params.fails_near = 0;
    find_failures();
}

// A bank elsewhere waits for the next look everywhere.
void Passes::fail_banks_again() {
    core_.stamps.begin_partial_look(Looker::failures);
    core_.params.fails_near = 1;
    find_failures();
}

void Passes::find_failures() {
    look(Kernel::build_spans, Looker::spans, lists_.tiles());
    core_.stamps.begin_change();
    run(Kernel::find_failures, lists_.tiles());
    run(Kernel::break_bonds, lists_.tiles());
}

// Bodies build slopes up by some voxels a step. The steeper the last step left them, the more
// passes.
int Passes::slip_passes_wanted() const {
    const int least = slip_passes_least(core_.def.step_s);
    const int wanted = std::min(kSlipPasses + core_.slope_q16 / kSlopePerPass, kSlipPassesMost) *
                       least / kSlipPasses;
    return std::clamp(wanted, least, std::max(least, slips_most_));
}

int Passes::slide_part_count() const {
    if (core_.params.slides == 0) return 1;
    const double pace = core_.slide_q16 / 65536.0, wedge = core_.slope_q16 / 65536.0;
    const double back = kFailureSpeed * core_.def.step_s / core_.frame.voxel_m;
    const double wanted = std::max(pace / kSlidePartVoxels, std::min(kPartsPerWedge * wedge, back));
    return std::clamp(static_cast<int>(std::ceil(wanted)), 1, kSlidePartsMost);
}

// What slides with its momentum runs down steep slopes by itself.
int Passes::slip_pass_count(int parts) const {
    if (core_.params.slides == 0) return slip_passes_wanted();
    return (slip_passes_least(core_.def.step_s) + parts - 1) / parts;
}

int Passes::slide_pass_count(int parts) const {
    if (core_.params.slides == 0) return 0;
    return std::max(1, static_cast<int>(std::ceil(core_.slide_q16 / 65536.0 / parts)));
}

// thesis (20). The last passes move soil by one voxel each, which smooths what the long slides
// left.
void Passes::slip(int pass, int passes) {
    const int least = slip_passes_least(core_.def.step_s);
    const int stride_most = std::clamp(
        static_cast<int>(std::lround(kSlipDistanceM / core_.frame.voxel_m)), 1, kSlipStrideMost);
    const bool is_last = pass == passes - 1;
    core_.params.slide_kick = core_.params.slides != 0 && is_last
                                  ? core_.params.gravity_q16 * kOneQ8 / core_.params.substep_count
                                  : 0;
    const int stride = pass < passes - least ? stride_most : 1;
    // Else they were built for the banks.
    if (core_.params.keeps_cohesion == 0) look(Kernel::build_spans, Looker::spans, lists_.tiles());
    core_.params.slip_stride = stride;
    core_.params.slip_turn = 1 - core_.params.slip_turn;
    if (is_last) core_.device->fill_zero(Buffer::result, kResultSlope, 1);
    core_.stamps.begin_look(stride > 1 ? Looker::slip_far : Looker::slip);
    move(Kernel::slip_soil, lists_.tiles());
}

void Passes::slide(int passes) {
    core_.params.slide_count = passes;
    look(Kernel::build_spans, Looker::spans, lists_.tiles());
    core_.stamps.begin_look(Looker::slide);
    // One pass: apply_flow notes what both have changed.
    core_.stamps.begin_pass();
    run(Kernel::slow_slides, lists_.tiles());
    run(Kernel::slide_soil, lists_.tiles());
    run(Kernel::apply_flow, lists_.listed());
}

void Passes::collect_contacts() {
    run(Kernel::collect_contacts, lists_.contacts());
    run(Kernel::collect_small_bodies, lists_.small_bodies());
}

}  // namespace bsoil
