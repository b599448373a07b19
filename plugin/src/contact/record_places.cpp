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

/// In place of a cell's first record.
enum : int32_t { kNoneNear = -2, kNoneHere = -1 };

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
    for (int k = 0; k < 3; ++k) {
        if (voxel[k] < box.low[k] || voxel[k] > box.high[k]) return -1;
    }
    int record = cells_[box.cell_of(voxel)];
    while (record >= 0 &&
           !std::equal(voxel, voxel + 3, records_[static_cast<size_t>(record)].voxel)) {
        record = next_[static_cast<size_t>(record)];
    }
    return std::max(record, -1);
}

bool RecordPlaces::find_around(const int voxel[3], int body, int (&found)[kAround]) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    bool is_any = false;
    for (int dz = 0, i = 0; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
            if (box.cell_shift > 0) {
                for (int dx = -1; dx <= 1; ++dx, ++i) {
                    const int beside[3] = {voxel[0] + dx, voxel[1] + dy, voxel[2] + dz};
                    found[i] = find(beside, body);
                    is_any = is_any || found[i] >= 0;
                }
                continue;
            }
            // A cell is a voxel: its first record is of that voxel.
            const int32_t* row = &cells_[box.cell(
                voxel[0] - box.low[0] - 1, voxel[1] - box.low[1] + dy, voxel[2] - box.low[2] + dz)];
            for (int dx = 0; dx < 3; ++dx, ++i) {
                found[i] = row[dx];
                is_any = is_any || found[i] >= 0;
            }
        }
    }
    return is_any;
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

void RecordPlaces::mark_near() {
    for (const ContactRecord& record : records_) {
        const Box& box = boxes_[static_cast<size_t>(record.body)];
        int low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            const int at = record.voxel[k] - box.low[k];
            low[k] = (at - kAnswerVoxels) >> box.cell_shift;
            high[k] = (at + kAnswerVoxels) >> box.cell_shift;
        }
        for (int z = low[2]; z <= high[2]; ++z) {
            for (int y = low[1]; y <= high[1]; ++y) {
                std::fill_n(&cells_[box.cell(low[0], y, z)], high[0] - low[0] + 1, kNoneHere);
            }
        }
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
