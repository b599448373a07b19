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

}  // namespace

bool TileSampler::renew(Read& read, int index, int plane_count) const {
    const uint64_t revision = revision_of(index);
    if (index == read.index && revision == read.revision) return false;
    tiles_.read_planes(index, plane_count, read.voxels);
    tiles_.read_ground(index, read.ground);
    read.index = index;
    read.revision = revision;
    return true;
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
    renew(surface_, index, kSurfacePlanes);
    const ColumnFill fill = column_fill(column_of(surface_.voxels, surface_.ground, column));
    if (fill.hanging < 0 || core_.params.bank_strength <= 0) return fill.top_q16;
    return column_fill(column_of(voxels(index), surface_.ground, column)).top_q16;  // a roof?
}

const TileVoxels& TileSampler::voxels(int index) {
    if (renew(whole_, index, core_.kept_planes)) coverage_step_ = slip_step_ = -1;
    return whole_.voxels;
}

const Tile* TileSampler::awake_tile_to_read(int64_t& step, std::vector<int32_t>& words) const {
    if (step == core_.step_index) return nullptr;
    step = core_.step_index;
    words.clear();
    const Tile* tile = tiles_[static_cast<size_t>(whole_.index)].get();
    return tile && tile->is_awake() ? tile : nullptr;
}

std::span<const int32_t> TileSampler::body_coverage() {
    const Tile* tile = awake_tile_to_read(coverage_step_, coverage_);
    if (!tile) return coverage_;
    coverage_.resize(static_cast<size_t>(core_.params.tile_voxels));
    const device::ReadRange range = tiles_.plane_range(kPlaneCoverage, tile->slot, coverage_);
    core_.device->read({&range, 1});
    return coverage_;
}

std::span<const int32_t> TileSampler::slip_speeds() {
    const Tile* tile = awake_tile_to_read(slip_step_, slip_speeds_);
    if (!tile) return slip_speeds_;
    slip_speeds_.resize(kTileColumns);
    const device::ReadRange slides{
        Buffer::spans, tiles_.column_array_offset(kColumnSlides, tile->slot), slip_speeds_};
    core_.device->read({&slides, 1});
    if (std::ranges::all_of(slip_speeds_, [](int32_t slid) { return slid == 0; })) {
        slip_speeds_.clear();
        return slip_speeds_;
    }
    record_words_.resize(kTileColumns * kColumnWords);
    const device::ReadRange records{Buffer::spans, tiles_.spans_offset(tile->slot), record_words_};
    core_.device->read({&records, 1});
    for (size_t c = 0; c < kTileColumns; ++c) {
        if (slip_speeds_[c] == 0) continue;
        // Both sets: that of the last pass, and of the one before.
        const auto first =
            record_words_.begin() + static_cast<std::ptrdiff_t>(c) * kColumnWords + kColumnSpeed;
        slip_speeds_[c] = *std::max_element(first, first + 2 * kSpanCapacity);
    }
    return slip_speeds_;
}

}  // namespace bsoil
