// What is asked about single voxels and columns: the tile that was asked for last stays at hand.
#include <algorithm>

#include "soil/column_surface.h"
#include "soil/tile_table.h"

namespace bsoil {

using namespace layout;

namespace {

// Tiles of which tops are kept. Ours: 1.2 MB, what lines of probes and the ground around bodies ask
// for. Larger: a map of the whole ground stays in memory; smaller: tiles asleep are unpacked again.
constexpr size_t kTopsMost = 4096;

// Words of tiles that are read ahead at once. Ours: 16 MiB, fifty tiles of 72 voxels with one
// material, to which a wait is as nothing. Larger: more memory; smaller: more waits.
constexpr size_t kAheadWords = size_t{4} << 20;

std::span<int32_t> slides_of(std::span<int32_t> words, size_t tile) {
    return words.subspan(tile * kTileColumns, kTileColumns);
}

std::span<int32_t> records_of(std::span<int32_t> words, size_t tile) {
    return words.subspan(tile * kTileColumns * kColumnWords, kTileColumns * kColumnWords);
}

bool slips_anywhere(std::span<const int32_t> slides) {
    return std::ranges::any_of(slides, [](int32_t slid) { return slid != 0; });
}

}  // namespace

void TileSampler::renew_surface(int index) {
    if (is_of_now(surface_, index)) return;
    surface_.revision = revision_of(index);
    tiles_.read_planes(index, kSurfacePlanes, surface_.voxels);
    tiles_.read_ground(index, surface_.ground);
    surface_.index = index;
}

uint64_t TileSampler::revision_of(int index) const {
    const auto& tile = tiles_[static_cast<size_t>(index)];
    return tile ? tile->revision : tiles_.revision_base();
}

int32_t TileSampler::top_q16(int index, int column) {
    if (tops_.size() > kTopsMost) tops_.clear();
    Tops& tops = tops_[index];
    if (const uint64_t revision = revision_of(index); tops.revision != revision) {
        tops.revision = revision;
        tops.known = 0;
    }
    const uint64_t bit = uint64_t{1} << column;
    int32_t& top = tops.q16[static_cast<size_t>(column)];
    if ((tops.known & bit) == 0) {
        top = find_top_q16(index, column);
        tops.known |= bit;
    }
    return top;
}

int32_t TileSampler::find_top_q16(int index, int column) {
    renew_surface(index);
    const ColumnFill fill = column_fill(column_of(surface_.voxels, surface_.ground, column));
    if (fill.hanging < 0 || core_.params.bank_strength <= 0) return fill.top_q16;
    return column_fill(column_of(voxels(index), surface_.ground, column)).top_q16;  // a roof?
}

const TileVoxels& TileSampler::voxels(int index, PlaneSet planes) {
    if (!is_of_now(whole_.read, index)) {
        const auto find_ahead = [&] {
            return std::ranges::find_if(ahead_, [&](const Whole& whole) {
                return is_of_now(whole.read, index) && is_motion_of_now(whole);
            });
        };
        auto found = find_ahead();
        if (found == ahead_.end() && fetch(index)) found = find_ahead();
        if (found != ahead_.end()) {
            std::swap(whole_, *found);
        } else {
            whole_.read.index = index;
            whole_.read.revision = revision_of(index);
            tiles_.read_ground(index, whole_.read.ground);
            whole_.planes = 0;
            whole_.motion_step = core_.step_index;
            whole_.coverage_step = whole_.slip_step = -1;
            // Each read of a GPU is a wait: then all at once.
            if (core_.device->backend_name() == "gl") planes = kAllPlanes;
        }
    }
    if (!is_motion_of_now(whole_)) {
        whole_.planes &= kMatterPlanes;
        whole_.motion_step = core_.step_index;
    }
    read_missing(planes & ~whole_.planes);
    return whole_.read.voxels;
}

// A tile asleep has none that could change.
bool TileSampler::is_motion_of_now(const Whole& whole) const {
    const Tile* tile = tiles_[static_cast<size_t>(whole.read.index)].get();
    return !tile || !tile->is_awake() || whole.motion_step == core_.step_index;
}

void TileSampler::read_missing(PlaneSet planes) {
    planes &= (PlaneSet{1} << core_.kept_planes) - 1;
    if (planes == 0) return;
    const int index = whole_.read.index;
    const Tile* tile = tiles_[static_cast<size_t>(index)].get();
    if (tile && tile->is_awake()) {
        ranges_.clear();
        tiles_.want_voxels(index, planes, whole_.read.voxels, ranges_);
        core_.device->read(ranges_);
        whole_.planes |= planes;
    } else {
        tiles_.read_voxels(index, whole_.read.voxels);
        whole_.planes = kAllPlanes;
    }
}

bool TileSampler::fetch(int index) {
    const auto is_awake = [this](int i) {
        const Tile* tile = tiles_[static_cast<size_t>(i)].get();
        return tile && tile->is_awake();
    };
    if (wanted_step_ != core_.step_index || !is_awake(index)) return false;
    const auto first = std::ranges::find(wanted_, index);
    if (first == wanted_.end()) return false;
    constexpr PlaneSet kPlanes = ~kForcePlanes;  // no picture shows those
    const auto tile_words = static_cast<size_t>(core_.params.tile_voxels) *
                                (static_cast<size_t>(core_.kept_planes) + 1) +
                            kTileColumns * (kColumnWords + 1);
    const size_t most = std::max<size_t>(1, kAheadWords / tile_words);
    std::vector<int> indices;
    auto next = first;
    for (; next != wanted_.end() && indices.size() < most; ++next) {
        if (is_awake(*next)) indices.push_back(*next);
    }
    // Whoever comes back to one of them later asks for that one alone.
    wanted_.erase(wanted_.begin(), next);
    ahead_.resize(indices.size());
    slide_words_.resize(indices.size() * kTileColumns);
    record_words_.resize(indices.size() * kTileColumns * kColumnWords);
    ranges_.clear();
    for (size_t i = 0; i < indices.size(); ++i) {
        Whole& whole = ahead_[i];
        whole.planes = kPlanes;
        const int slot = tiles_[static_cast<size_t>(indices[i])]->slot;
        tiles_.want_voxels(indices[i], whole.planes, whole.read.voxels, ranges_);
        whole.coverage.resize(static_cast<size_t>(core_.params.tile_voxels));
        ranges_.push_back(tiles_.plane_range(kPlaneCoverage, slot, whole.coverage));
        ranges_.push_back({Buffer::spans, tiles_.column_array_offset(kColumnSlides, slot),
                           slides_of(slide_words_, i)});
        ranges_.push_back({Buffer::spans, tiles_.spans_offset(slot), records_of(record_words_, i)});
    }
    core_.device->read(ranges_);
    for (size_t i = 0; i < indices.size(); ++i) {
        Whole& whole = ahead_[i];
        tiles_.read_ground(indices[i], whole.read.ground);
        whole.read.index = indices[i];
        whole.read.revision = revision_of(indices[i]);
        whole.motion_step = whole.coverage_step = whole.slip_step = core_.step_index;
        note_slip_speeds(whole, slides_of(slide_words_, i), records_of(record_words_, i));
    }
    return true;
}

const Tile* TileSampler::awake_tile_to_read(int64_t& step, std::vector<int32_t>& words) const {
    if (step == core_.step_index) return nullptr;
    step = core_.step_index;
    words.clear();
    const Tile* tile = tiles_[static_cast<size_t>(whole_.read.index)].get();
    return tile && tile->is_awake() ? tile : nullptr;
}

std::span<const int32_t> TileSampler::body_coverage() {
    const Tile* tile = awake_tile_to_read(whole_.coverage_step, whole_.coverage);
    if (!tile) return whole_.coverage;
    whole_.coverage.resize(static_cast<size_t>(core_.params.tile_voxels));
    const device::ReadRange range = tiles_.plane_range(kPlaneCoverage, tile->slot, whole_.coverage);
    core_.device->read({&range, 1});
    return whole_.coverage;
}

std::span<const int32_t> TileSampler::slip_speeds() {
    const Tile* tile = awake_tile_to_read(whole_.slip_step, whole_.slip_speeds);
    if (!tile) return whole_.slip_speeds;
    slide_words_.resize(kTileColumns);
    const device::ReadRange slides{
        Buffer::spans, tiles_.column_array_offset(kColumnSlides, tile->slot), slide_words_};
    core_.device->read({&slides, 1});
    record_words_.clear();
    if (slips_anywhere(slide_words_)) {
        record_words_.resize(kTileColumns * kColumnWords);
        const device::ReadRange records{Buffer::spans, tiles_.spans_offset(tile->slot),
                                        record_words_};
        core_.device->read({&records, 1});
    }
    note_slip_speeds(whole_, slide_words_, record_words_);
    return whole_.slip_speeds;
}

void TileSampler::note_slip_speeds(Whole& whole, std::span<const int32_t> slides,
                                   std::span<const int32_t> records) const {
    whole.slip_speeds.clear();
    if (!slips_anywhere(slides)) return;
    whole.slip_speeds.assign(slides.begin(), slides.end());
    for (size_t c = 0; c < kTileColumns; ++c) {
        if (slides[c] == 0) continue;
        // Both sets: that of the last pass, and of the one before.
        const auto speeds = records.subspan(c * kColumnWords + kColumnSpeed, 2 * kSpanCapacity);
        whole.slip_speeds[c] = std::ranges::max(speeds);
    }
}

}  // namespace bsoil
