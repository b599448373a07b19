// What sources, sinks and open sides move: what is due in a step, and the account of it.
#include "soil/flows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/kernels.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

// The least lump that a source pours, in mass units: a quarter of a voxel of 2000 kg/m3. Thin soil
// flies too slowly, because shares of it that are too small to move stay behind (kShareLeast). Less
// soil waits until it is a lump.
constexpr int64_t kLumpLeast = 16384;
// Steps within which a flow makes up for what found no room, or no soil.
constexpr int kWaitingSteps = 8;
// A sink takes whole units of mass out of each voxel. Of so little of what lies in it no voxel may
// have one: it waits until it is more. Ours: 200 units of a full voxel of 1600 kg/m3. Larger: thin
// soil gives a slow sink none, and all that is due is missed; smaller: it takes more at once when
// soil comes.
constexpr int64_t kHeldParts = 256;
// More in one voxel would not fit by far; keeps the kernel's products within 31 bits.
constexpr int64_t kLumpMost = 1 << 20;

// Voxels of a region that another one does not have.
int64_t count_new(const FlowRegion& region, const FlowRegion& known) {
    int64_t count = region.voxel_count;
    auto there = known.parts.begin();
    for (const FlowPart& part : region.parts) {
        there = std::ranges::lower_bound(there, known.parts.end(), part.tile, {}, &FlowPart::tile);
        if (there == known.parts.end()) break;
        if (there->tile != part.tile) continue;
        for (int c = 0; c < kTileColumns; ++c) {
            const int low = std::max(part.columns[c] & 0xffff, there->columns[c] & 0xffff);
            count -= std::max(0, std::min(part.columns[c] >> 16, there->columns[c] >> 16) - low);
        }
    }
    return count;
}

}  // namespace

double Flow::start_s() const {
    return std::max(since_s, kind == FlowKind::source ? source.start_s : sink.start_s);
}

int64_t Flow::due_units(double t_s) const {
    const double time_s = std::min(t_s, end_s()) - start_s();
    return time_s > 0 ? static_cast<int64_t>(std::floor(units_per_s * time_s)) : 0;
}

double Flow::every_s(const SoilDef& def) const {
    return kind == FlowKind::well ? Water::period_s(def) : def.step_s;
}

int64_t Flow::waiting_most(const SoilDef& def) const {
    return std::max({2 * kLumpLeast, held_units / kHeldParts,
                     static_cast<int64_t>(std::ceil(kWaitingSteps * units_per_s * every_s(def)))});
}

void Flows::start(std::vector<int32_t> material_tables) {
    material_tables_ = std::move(material_tables);
    units_in_.assign(core_.materials.size(), 0);
    units_out_.assign(core_.materials.size(), 0);
    open_sides();
}

void Flows::change_materials(std::vector<int32_t> material_tables) {
    material_tables_ = std::move(material_tables);
    for (Flow& flow : all_) {
        if (flow.kind != FlowKind::source) continue;
        static_cast<void>(place(flow));  // as it was placed before
    }
    is_placed_ = false;
}

Flow* Flows::find(int id) {
    const auto found = std::ranges::find_if(
        all_, [&](const Flow& f) { return f.kind != FlowKind::open_side && f.id == id; });
    return found == all_.end() ? nullptr : &*found;
}

Result<int> Flows::add(Flow flow) {
    if (all_.size() >= kFlowCapacity) {
        return Error{fmt::format(
            "there are {} sources, sinks and open sides, more are not possible; remove one",
            kFlowCapacity)};
    }
    if (Status placed = place(flow); !placed) return Error{placed.error()};
    flow.id = next_id_++;
    flow.since_s = time_s();
    all_.push_back(std::move(flow));
    is_placed_ = false;
    return all_.back().id;
}

Status Flows::change(Flow& flow, Flow to) {
    if (Status placed = place(to); !placed) return placed;
    if (to.held_units > 0) {
        const int64_t fresh = full_units(to, count_new(to.region, flow.region));
        to.held_units = std::min(to.held_units + fresh,
                                 std::max(to.held_units, full_units(to, to.region.voxel_count)));
    }
    flow = std::move(to);
    is_placed_ = false;
    return Done{};
}

Status Flows::remove(int id) {
    const Flow* flow = find(id);
    if (!flow) {
        return Error{fmt::format(
            "there is no source or sink {}; take an id that add_source() or add_sink() gave", id)};
    }
    all_.erase(all_.begin() + (flow - all_.data()));
    is_placed_ = false;
    return Done{};
}

void Flows::look_anew() {
    for (Flow& flow : all_) {
        flow.is_fresh = true;
        if (flow.takes_all() || flow.held_units == 0) continue;
        const bool may_be_new = std::ranges::any_of(flow.region.parts, [this](const FlowPart& p) {
            const Tile* tile = tiles_[static_cast<size_t>(p.tile)].get();
            return tile && tile->unchecked;
        });
        if (!may_be_new) continue;
        flow.held_units = std::max(flow.held_units, full_units(flow, flow.region.voxel_count));
    }
}

int64_t Flows::full_units(const Flow& flow, int64_t voxel_count) const {
    double most = 0;
    for (const MaterialDef& soil : core_.materials) {
        const double units = std::max(soil.density_kg_m3, soil.compacted_density_kg_m3) /
                             kReferenceDensity * kVoxelFull;
        const bool is_well = flow.kind == FlowKind::well;
        most = std::max(most, is_well ? units * soil.pore_water_fraction * kWaterParts : units);
    }
    return static_cast<int64_t>(std::ceil(most * static_cast<double>(voxel_count)));
}

bool Flows::may_work() const {
    return std::ranges::any_of(all_, [](const Flow& flow) { return flow.is_fresh; });
}

void Flows::restart(std::vector<Flow> flows, int next_id, std::vector<int64_t> units_in,
                    std::vector<int64_t> units_out) {
    for (size_t i = 0; i < flows.size(); ++i) {
        if (flows[i].kind == FlowKind::open_side) {
            flows[i].region = std::move(all_[i].region);
        } else {
            static_cast<void>(place(flows[i]));  // it has been tried
        }
    }
    all_ = std::move(flows);
    next_id_ = next_id;
    units_in_ = std::move(units_in);
    units_out_ = std::move(units_out);
    is_placed_ = false;
}

// Flows that have voxels in common take their turns: what one takes the next cannot take as well.
void Flows::set_rounds() {
    const auto meet = [](const Flow& a, const Flow& b) {
        if ((a.kind == FlowKind::source) != (b.kind == FlowKind::source)) return false;
        for (const FlowPart& pa : a.region.parts) {
            for (const FlowPart& pb : b.region.parts) {
                if (pa.tile != pb.tile) continue;
                for (int c = 0; c < kTileColumns; ++c) {
                    const int low = std::max(pa.columns[c] & 0xffff, pb.columns[c] & 0xffff);
                    if (low < std::min(pa.columns[c] >> 16, pb.columns[c] >> 16)) return true;
                }
            }
        }
        return false;
    };
    size_t pours = 0, takes = 0;
    for (size_t i = 0; i < all_.size(); ++i) {
        Flow& flow = all_[i];
        flow.round = 0;
        for (size_t k = 0; k < i; ++k) {
            if (all_[k].round == flow.round && meet(all_[k], flow)) {
                ++flow.round;
                k = static_cast<size_t>(-1);  // from the first again
            }
        }
        size_t& rounds = flow.kind == FlowKind::source ? pours : takes;
        rounds = std::max(rounds, static_cast<size_t>(flow.round) + 1);
    }
    pour_.resize(pours);
    take_.resize(takes);
}

// Their words behind the materials' tables: in the first step after one has come or gone.
void Flows::upload() {
    set_rounds();
    std::vector<int32_t> words = material_tables_;
    core_.params.flow_offset = static_cast<int32_t>(words.size());
    words.resize(words.size() + all_.size() * kFlowWords);
    for (size_t i = 0; i < all_.size(); ++i) {
        for (FlowPart& part : all_[i].region.parts) {
            part.place = static_cast<int32_t>(words.size());
            words.push_back(static_cast<int32_t>(i));
            words.insert(words.end(), std::begin(part.columns), std::end(part.columns));
            words.insert(words.end(), std::begin(part.first), std::end(part.first));
        }
    }
    if (const Status allocated =
            core_.device->allocate(Buffer::tables, static_cast<int64_t>(words.size()));
        !allocated) {
        core_.device->give_up(allocated.error());  // the materials' tables are gone
        return;
    }
    core_.device->write(Buffer::tables, 0, words);
    words_.resize(all_.size() * kFlowWords);
    results_.assign(all_.size() * kFlowResultWords, 0);
    is_placed_ = true;
}

double Flows::pouring_speed_voxels() const {
    double fastest = 0;
    for (const Flow& flow : all_) {
        if (flow.kind != FlowKind::source || time_s() <= flow.start_s() ||
            time_s() > flow.end_s() + kWaitingSteps * core_.def.step_s) {
            continue;
        }
        const double way_m = flow.source.speed_m_s * core_.def.step_s;
        fastest = std::max(fastest, way_m / core_.frame.voxel_m / std::cos(flow.source.spread_rad));
    }
    return fastest;
}

void Flows::begin_step() {
    if (all_.empty()) return;
    if (!is_placed_) upload();
    if (!is_placed_) return;  // the device is lost
    for (size_t i = 0; i < all_.size(); ++i) {
        Flow& flow = all_[i];
        if (flow.kind == FlowKind::source) {
            begin_source(flow);
        } else {
            begin_sink(flow);
        }
        std::ranges::copy(flow.words, &words_[i * kFlowWords]);
    }
    core_.device->write(Buffer::tables, core_.params.flow_offset, words_);
}

void Flows::begin_source(Flow& flow) {
    const double to_s = time_s();
    const int64_t wanted = flow.due_units(to_s) - flow.units - flow.missed_units;
    flow.works = flow.is_fresh = false;
    if (to_s <= flow.start_s() || (to_s - core_.def.step_s >= flow.end_s() && wanted <= 0)) return;
    for (const FlowPart& part : flow.region.parts) {
        Tile& tile = tiles_.make(part.tile);
        tile.top = std::max(tile.top, part.high);
        activate(part, core_.height);
    }
    if (wanted <= 0 || (wanted < kLumpLeast && to_s < flow.end_s())) return;
    flow.works = true;
    const int64_t count = flow.region.voxel_count;
    const int64_t lumps = std::clamp<int64_t>(wanted / kLumpLeast, 1, count);
    flow.words[kFlowLumps] = static_cast<int32_t>(lumps);
    flow.words[kFlowUnits] = static_cast<int32_t>(std::min(wanted / lumps, kLumpMost));
    flow.words[kFlowRest] = static_cast<int32_t>(wanted % lumps);
    // On from where the last step ended.
    flow.words[kFlowTurn] = static_cast<int32_t>((count - flow.lump_count % count) % count);
    flow.lump_count += lumps;
}

void Flows::begin_sink(Flow& flow) {
    const double to_s = time_s();
    flow.works = to_s > flow.start_s() && to_s - flow.every_s(core_.def) < flow.end_s();
    if (flow.works && flow.kind == FlowKind::well && !Water::is_due(core_)) {
        flow.works = false;
        return;
    }
    if (!flow.works) {
        flow.is_fresh = true;  // what comes into its region until it begins again is not seen
        return;
    }
    double share = flow.takes_all() ? 1 : 0;
    if (!flow.takes_all() && flow.held_units > 0) {
        const int64_t wanted = flow.due_units(to_s) - flow.units - flow.missed_units;
        share = std::clamp(static_cast<double>(wanted) / static_cast<double>(flow.held_units), 0.0,
                           1.0);
    }
    flow.words[kFlowShare] = static_cast<int32_t>(std::floor(share * kVoxelFull));
    // What has changed since its last look is awake.
    if (flow.is_fresh || (!flow.takes_all() && flow.held_units > 0)) {
        for (const FlowPart& part : flow.region.parts) {
            if (const Tile* tile = tiles_[static_cast<size_t>(part.tile)].get()) {
                activate(part, tile->top);
            }
        }
    }
    flow.is_fresh = false;
}

// The blocks of a part below `top`.
void Flows::activate(const FlowPart& part, int top) {
    for (int z = part.low / kTileSide * kTileSide; z < std::min(part.high, top); z += kTileSide) {
        lists_.activate(core_.block_key(part.tile, z / kTileSide));
    }
}

// Groups of pour_soil and take_soil: the parts in tiles of which something is listed.
void Flows::list() {
    for (const bool pours : {true, false}) {
        std::vector<ListedWork>& rounds = pours ? pour_ : take_;
        for (size_t round = 0; round < rounds.size(); ++round) {
            groups_.clear();
            for (const Flow& flow : all_) {
                if (flow.works && (flow.kind == FlowKind::source) == pours &&
                    flow.round == static_cast<int>(round)) {
                    list_parts(flow);
                }
            }
            std::ranges::sort(groups_);
            lists_.add_list(rounds[round], groups_);
        }
    }
}

void Flows::list_parts(const Flow& flow) {
    for (const FlowPart& part : flow.region.parts) {
        const Tile* tile = tiles_[static_cast<size_t>(part.tile)].get();
        if (!tile || !tile->is_awake()) continue;
        for (int zb = part.low / kTileSide; zb <= (part.high - 1) / kTileSide; ++zb) {
            if (lists_.is_listed(tile->slot, zb)) {
                groups_.push_back({tile->slot, part.place});
                break;
            }
        }
    }
}

void Flows::clear_results() {
    if (!results_.empty()) {
        core_.device->fill_zero(Buffer::result, core_.params.flow_result,
                                static_cast<int64_t>(results_.size()));
    }
}

void Flows::pour() {
    for (const ListedWork& work : pour_) {
        if (work.group_count > 0) passes_.move(Kernel::pour_soil, work);
    }
}

void Flows::take() {
    for (const ListedWork& work : take_) {
        if (work.group_count > 0) passes_.move(Kernel::take_soil, work);
    }
}

void Flows::want(std::vector<device::ReadRange>& ranges) {
    if (!results_.empty()) ranges.push_back({Buffer::result, core_.params.flow_result, results_});
}

void Flows::note_results(bool is_quiet) {
    if (!is_placed_) return;
    if (is_quiet) std::ranges::fill(results_, 0);
    for (size_t i = 0; i < all_.size(); ++i) {
        Flow& flow = all_[i];
        const int32_t* words = &results_[i * kFlowResultWords];
        const bool is_source = flow.kind == FlowKind::source;
        std::vector<int64_t>& total = is_source ? units_in_ : units_out_;
        const bool is_well = flow.kind == FlowKind::well;  // its water is in Water's account
        if (is_well) flow.units += wide_sum(words);
        for (size_t m = 0; !is_well && m < total.size(); ++m) {
            const int64_t moved = wide_sum(words + 2 * m);
            flow.units += moved;
            total[m] += moved;
        }
        if (flow.works && !is_source && !is_quiet) flow.held_units = wide_sum(words + kFlowHeld);
        if (flow.takes_all()) continue;
        const int64_t waits = flow.due_units(time_s()) - flow.units - flow.missed_units;
        const bool is_over = time_s() > flow.end_s() + kWaitingSteps * flow.every_s(core_.def);
        const int64_t most = is_over ? 0 : flow.waiting_most(core_.def);
        flow.missed_units += std::max<int64_t>(0, waits - most);
    }
}

// --- Soil

Result<int> Soil::add_source(const SourceDef& def) {
    impl_->finish();
    Flow flow;
    flow.kind = FlowKind::source;
    flow.source = def;
    return impl_->flows.add(std::move(flow));
}

Result<int> Soil::add_sink(const SinkDef& def) {
    impl_->finish();
    Flow flow;
    flow.sink = def;
    if (def.water_kg_s != 0) flow.kind = FlowKind::well;
    return impl_->flows.add(std::move(flow));
}

Status Soil::move_source(int id, Vec3 center_m, Vec3 direction) {
    impl_->finish();
    Flow* flow = impl_->flows.find(id);
    if (!flow || flow->kind != FlowKind::source) {
        return Error{fmt::format("there is no source {}; take an id that add_source() gave", id)};
    }
    Flow moved = *flow;
    moved.source.center_m = center_m;
    moved.source.direction = direction;
    return impl_->flows.change(*flow, std::move(moved));
}

Status Soil::move_sink(int id, const Pose& pose) {
    impl_->finish();
    Flow* flow = impl_->flows.find(id);
    if (!flow || flow->kind == FlowKind::source) {
        return Error{fmt::format("there is no sink {}; take an id that add_sink() gave", id)};
    }
    Flow moved = *flow;
    moved.sink.pose = pose;
    moved.is_fresh = true;
    return impl_->flows.change(*flow, std::move(moved));
}

Status Soil::remove_flow(int id) {
    impl_->finish();
    return impl_->flows.remove(id);
}

double Soil::moved_kg(FlowWay way) const {
    const Flows& flows = impl_->flows;
    const std::vector<int64_t>& units = way == FlowWay::in ? flows.units_in() : flows.units_out();
    return static_cast<double>(std::accumulate(units.begin(), units.end(), int64_t{0})) *
           impl_->kg_per_unit;
}

Result<FlowState> Soil::flow_state(int id) const {
    const Flow* flow = impl_->flows.find(id);
    if (!flow) {
        return Error{fmt::format(
            "there is no source or sink {}; take an id that add_source() or add_sink() gave", id)};
    }
    const double kg =
        flow->kind == FlowKind::well ? impl_->kg_per_unit / kWaterParts : impl_->kg_per_unit;
    return FlowState{flow->units, flow->missed_units, static_cast<double>(flow->units) * kg,
                     static_cast<double>(flow->missed_units) * kg};
}

}  // namespace bsoil
