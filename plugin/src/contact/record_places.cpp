#include "contact/record_places.h"

#include <algorithm>

#include "base/make_room.h"

namespace bsoil {
namespace {

/// A record answers what is no more voxels off.
constexpr int kAnswerVoxels = 1;
/// What is beside a voxel that it answers is no more voxels off.
constexpr int kBoxVoxels = kAnswerVoxels + 1;
/// Cells that tell where records are, for each record at most. Ours: a voxel is a cell of what is
/// no larger than a machine. Larger: more memory for a body that few records spread over; smaller:
/// more is looked at for nothing.
constexpr size_t kCellsPerRecord = 64;
/// And for a body that has hardly any records.
constexpr size_t kCellsLeast = 256;

}  // namespace

void RecordPlaces::fill(std::span<const ContactRecord> records, size_t body_count,
                        const int size[3]) {
    records_ = records;
    std::copy_n(size, 3, size_);
    make_room(gradients_, records.size());
    gradients_.clear();
    for (const ContactRecord& record : records) {
        gradients_.push_back({record.gradient, length(record.gradient)});
    }
    find_boxes(body_count);
    lay_cells();
    mark_near();
    link_records();
}

bool RecordPlaces::is_near_box(int body, Vec3 at, double reach) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    const double place[3] = {at.x, at.y, at.z};
    const double more = reach - kBoxVoxels;
    for (int k = 0; k < 3; ++k) {
        if (place[k] < box.low[k] - more || place[k] > box.high[k] + 1 + more) return false;
    }
    return true;
}

bool RecordPlaces::may_be_beside(int body, const int low[3], const int high[3]) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    int first[3], last[3];
    for (int k = 0; k < 3; ++k) {
        if (high[k] < box.low[k] || low[k] > box.high[k]) return false;
        first[k] = (std::max(low[k], box.low[k]) - box.low[k]) >> box.cell_shift;
        last[k] = (std::min(high[k], box.high[k]) - box.low[k]) >> box.cell_shift;
    }
    for (int z = first[2]; z <= last[2]; ++z) {
        for (int y = first[1]; y <= last[1]; ++y) {
            for (int x = first[0]; x <= last[0]; ++x) {
                if (cells_[box.cell(x, y, z)] != kNoneNear) return true;
            }
        }
    }
    return false;
}

bool RecordPlaces::is_in_grid(const int voxel[3]) const {
    for (int k = 0; k < 3; ++k) {
        if (voxel[k] < 0 || voxel[k] >= size_[k]) return false;
    }
    return true;
}

int RecordPlaces::find(const int voxel[3], int body) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    if (!box.holds(voxel)) return -1;
    int record = cells_[box.cell_of(voxel)];
    while (record >= 0 &&
           !std::equal(voxel, voxel + 3, records_[static_cast<size_t>(record)].voxel)) {
        record = next_[static_cast<size_t>(record)];
    }
    return std::max(record, -1);
}

bool RecordPlaces::find_along(const int voxel[3], int axis, int step, int body,
                              int (&found)[3]) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    if (!box.holds(voxel)) return false;
    const int32_t* cell = &cells_[box.cell_of(voxel)];
    if (*cell == kNoneNear) return false;
    if (box.cell_shift == 0) {
        // A cell is a voxel: its first record is of that voxel, and those beside are in the box.
        const ptrdiff_t apart = step * box.stride(axis);
        found[0] = cell[-apart];
        found[1] = *cell;
        found[2] = cell[apart];
        return true;
    }
    for (int i = 0; i < 3; ++i) {
        int beside[3] = {voxel[0], voxel[1], voxel[2]};
        beside[axis] += (i - 1) * step;
        found[i] = find(beside, body);
    }
    return true;
}

void RecordPlaces::find_boxes(size_t body_count) {
    boxes_.assign(body_count, {});
    for (const ContactRecord& record : records_) {
        Box& box = boxes_[static_cast<size_t>(record.body)];
        for (int k = 0; k < 3; ++k) {
            box.low[k] = std::min(box.low[k], record.voxel[k] - kBoxVoxels);
            box.high[k] = std::max(box.high[k], record.voxel[k] + kBoxVoxels);
        }
        ++box.record_count;
    }
}

void RecordPlaces::lay_cells() {
    size_t cell_count = 0;
    for (Box& box : boxes_) {
        if (box.high[0] < 0) continue;
        box.cells = cell_count;
        size_t own = 0;
        const size_t most = std::max(kCellsLeast, kCellsPerRecord * box.record_count);
        for (box.cell_shift = 0; own == 0 || own > most; ++box.cell_shift) {
            own = 1;
            for (int k = 0; k < 3; ++k) {
                box.cell_count[k] = ((box.high[k] - box.low[k]) >> box.cell_shift) + 1;
                own *= static_cast<size_t>(box.cell_count[k]);
            }
        }
        --box.cell_shift;
        cell_count += own;
    }
    make_room(cells_, cell_count);
    cells_.assign(cell_count, kNoneNear);
}

// Where cells are larger than voxels, all that one of its voxels beside reaches.
void RecordPlaces::mark_near() {
    for (const ContactRecord& record : records_) {
        const Box& box = boxes_[static_cast<size_t>(record.body)];
        int low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            const int at = record.voxel[k] - box.low[k];
            low[k] = (at - kAnswerVoxels) >> box.cell_shift;
            high[k] = (at + kAnswerVoxels) >> box.cell_shift;
        }
        const bool is_voxel = box.cell_shift == 0;
        const int last_layer = is_voxel ? high[2] - kAnswerVoxels : high[2];
        for (int z = low[2]; z <= last_layer; ++z) {
            for (int y = low[1]; y <= high[1]; ++y) {
                int32_t* const row = &cells_[box.cell(0, y, z)];
                for (int x = low[0]; x <= high[0]; ++x) row[x] = kNoneHere;
            }
        }
        if (!is_voxel) continue;
        cells_[box.cell(low[0] + kAnswerVoxels, low[1] + kAnswerVoxels, high[2])] = kNoneHere;
    }
}

// From the last one: the first of a cell is its head.
void RecordPlaces::link_records() {
    make_room(next_, records_.size());
    next_.resize(records_.size());
    for (size_t i = records_.size(); i-- > 0;) {
        const ContactRecord& record = records_[i];
        int32_t& head = cells_[boxes_[static_cast<size_t>(record.body)].cell_of(record.voxel)];
        next_[i] = head;
        head = static_cast<int32_t>(i);
    }
}

}  // namespace bsoil
