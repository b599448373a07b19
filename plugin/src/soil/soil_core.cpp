#include "soil/soil_core.h"

#include <algorithm>
#include <utility>

#include "soil/shape_bounds.h"

namespace bsoil {

using namespace layout;

int32_t& PassStamps::told(Looker looker) {
    return looker == Looker::support ? params_.support_stamp
           : looker == Looker::spans ? params_.spans_stamp
           : looker == Looker::slide ? params_.slide_stamp
                                     : params_.slip_stamp;
}

void PassStamps::begin_look(Looker looker) {
    told(looker) = std::exchange(last_look_[static_cast<size_t>(looker)], params_.pass_stamp);
}

void PassStamps::forget() { last_look_.fill(-1); }

BlockBox SoilCore::blocks_at(const Aabb& box, double margin) const {
    if (box.max.x < 0 || box.max.y < 0 || box.max.z < 0 || box.min.x > frame.size[0] ||
        box.min.y > frame.size[1] || box.min.z > height) {
        return {};
    }
    const auto block_of = [](double voxel, int count) {
        return clamped_floor(voxel / kTileSide, 0, count - 1);
    };
    return {{block_of(box.min.x - margin, tiles_x), block_of(box.min.y - margin, tiles_y),
             block_of(box.min.z - margin, blocks_per_tile)},
            {block_of(box.max.x + margin, tiles_x), block_of(box.max.y + margin, tiles_y),
             block_of(box.max.z + margin, blocks_per_tile)}};
}

BlockBox SoilCore::tiles_around(int tx, int ty) const {
    return {{std::max(0, tx - 1), std::max(0, ty - 1), 0},
            {std::min(tiles_x - 1, tx + 1), std::min(tiles_y - 1, ty + 1), -1}};
}

void SoilCore::ensure_capacity(device::BufferIndex buffer, size_t& capacity, size_t words) {
    if (words > capacity) {
        capacity = std::max(words, 2 * capacity);
        if (const Status allocated = device->allocate(buffer, static_cast<int64_t>(capacity));
            !allocated) {
            device->give_up(allocated.error());  // what would be written has no place
            capacity = 0;
        }
    }
}

}  // namespace bsoil
