/// Where the meshes of tiles stay in a device's buffers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace bsoil::mesh {

/// Ranges of a buffer that grows at its end. The first free range that fits is taken.
class RangeList {
  public:
    /// The place of `count` items.
    int64_t take(int64_t count);
    void give_back(int64_t at, int64_t count);
    /// Behind the last range that is taken or was.
    int64_t end() const { return end_; }

  private:
    std::map<int64_t, int64_t> free_;  ///< place and count; ranges that touch are one
    int64_t end_ = 0;
};

/// The vertices and indices of each tile.
class KeptMeshes {
  public:
    struct Place {
        int64_t vertex_at = 0, vertex_count = 0, vertex_room = 0;
        int64_t index_at = 0, index_count = 0, index_room = 0;
    };
    explicit KeptMeshes(size_t tile_count) : places_(tile_count) {}
    /// A tile's mesh stays where it is while it fits there.
    const Place& place(size_t tile, int64_t vertex_count, int64_t index_count);
    const std::vector<Place>& places() const { return places_; }
    int64_t vertex_end() const { return vertices_.end(); }
    int64_t index_end() const { return indices_.end(); }

  private:
    RangeList vertices_, indices_;
    std::vector<Place> places_;
};

}  // namespace bsoil::mesh
