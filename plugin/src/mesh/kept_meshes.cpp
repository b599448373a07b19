#include "mesh/kept_meshes.h"

#include <iterator>

namespace bsoil::mesh {
namespace {

/// A mesh gets room for this much more of itself, so that one that changes seldom moves.
constexpr int64_t kSpareDivisor = 4;

void fit(RangeList& ranges, int64_t count, int64_t& at, int64_t& room) {
    if (count <= room) return;
    ranges.give_back(at, room);
    room = count + count / kSpareDivisor;
    at = ranges.take(room);
}

}  // namespace

int64_t RangeList::take(int64_t count) {
    for (auto range = free_.begin(); range != free_.end(); ++range) {
        const auto [at, room] = *range;
        if (room < count) continue;
        free_.erase(range);
        if (room > count) free_.emplace(at + count, room - count);
        return at;
    }
    const int64_t at = end_;
    end_ += count;
    return at;
}

void RangeList::give_back(int64_t at, int64_t count) {
    if (count == 0) return;
    auto next = free_.lower_bound(at);
    if (next != free_.end() && at + count == next->first) {
        count += next->second;
        next = free_.erase(next);
    }
    if (next != free_.begin()) {
        const auto before = std::prev(next);
        if (before->first + before->second == at) {
            before->second += count;
            return;
        }
    }
    free_.emplace(at, count);
}

const KeptMeshes::Place& KeptMeshes::place(size_t tile, int64_t vertex_count, int64_t index_count) {
    Place& place = places_[tile];
    fit(vertices_, vertex_count, place.vertex_at, place.vertex_room);
    fit(indices_, index_count, place.index_at, place.index_room);
    place.vertex_count = vertex_count;
    place.index_count = index_count;
    return place;
}

}  // namespace bsoil::mesh
