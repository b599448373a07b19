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
/// Records that one thread looks at. Ours, as a matter of cost: some hundredths of a millisecond.
/// Larger: one thread looks at all of a body; smaller: sharing them out takes longer.
constexpr size_t kLookedRecords = 2048;
/// And for each body: so few of them have boxes of their own in each part.
constexpr size_t kLookedABody = 16;
/// Cells that one thread clears. Ours, as a matter of cost: 256 kB. Larger: one thread clears those
/// of a machine; smaller: sharing them out takes longer.
constexpr size_t kClearedCells = 65536;

}  // namespace

void RecordPlaces::fill(std::span<const ContactRecord> records, size_t body_count,
                        const int size[3], const WorkThreads* threads) {
    records_ = records;
    std::copy_n(size, 3, size_);
    look_at(threads, body_count);
    lay_cells(threads);
    link_records();
    mark_near();
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
            if (is_any_near(box, first[0], last[0], y, z)) return true;
        }
    }
    return false;
}

bool RecordPlaces::is_any_near(const Box& box, int first, int last, int y, int z) const {
    const uint64_t* row = &near_[box.row(y, z)];
    for (int word = first / kWordBits; word <= last / kWordBits; ++word) {
        uint64_t bits = row[word];
        if (word == first / kWordBits) bits &= ~uint64_t{0} << first % kWordBits;
        if (word == last / kWordBits) bits &= ~uint64_t{0} >> (kWordBits - 1 - last % kWordBits);
        if (bits != 0) return true;
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
    const int x = box.cell_at(voxel, 0), y = box.cell_at(voxel, 1), z = box.cell_at(voxel, 2);
    if (!is_near(box, x, y, z)) return false;
    if (box.cell_shift == 0) {
        const int32_t* cell = &cells_[box.cell(x, y, z)];
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

void RecordPlaces::Box::add(const Box& part) {
    for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], part.low[k]);
        high[k] = std::max(high[k], part.high[k]);
    }
    record_count += part.record_count;
}

// The length of each gradient, and the boxes round the bodies' records.
void RecordPlaces::look_at(const WorkThreads* threads, size_t body_count) {
    const size_t count = records_.size();
    const size_t part_records = std::max(kLookedRecords, kLookedABody * body_count);
    const size_t parts = (count + part_records - 1) / part_records;
    make_room(gradients_, count);
    gradients_.resize(count);
    part_boxes_.assign(parts * body_count, {});
    for_ranges(threads, parts, 1, [&](size_t first_part, size_t last_part) {
        for (size_t part = first_part; part < last_part; ++part) {
            Box* boxes = &part_boxes_[part * body_count];
            const size_t first = part * part_records, last = std::min(first + part_records, count);
            for (size_t i = first; i < last; ++i) {
                const ContactRecord& record = records_[i];
                gradients_[i] = {record.gradient, length(record.gradient)};
                Box& box = boxes[record.body];
                for (int k = 0; k < 3; ++k) {
                    box.low[k] = std::min(box.low[k], record.voxel[k] - kBoxVoxels);
                    box.high[k] = std::max(box.high[k], record.voxel[k] + kBoxVoxels);
                }
                ++box.record_count;
            }
        }
    });
    boxes_.assign(body_count, {});
    for (size_t i = 0; i < part_boxes_.size(); ++i) boxes_[i % body_count].add(part_boxes_[i]);
}

void RecordPlaces::lay_cells(const WorkThreads* threads) {
    size_t cell_count = 0, word_count = 0;
    for (Box& box : boxes_) {
        if (box.high[0] < 0) continue;
        box.cells = cell_count;
        box.rows = word_count;
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
        box.row_words = (box.cell_count[0] + kWordBits - 1) / kWordBits;
        cell_count += own;
        word_count +=
            own / static_cast<size_t>(box.cell_count[0]) * static_cast<size_t>(box.row_words);
    }
    make_room(cells_, cell_count);
    cells_.resize(cell_count);
    const size_t parts = (cell_count + kClearedCells - 1) / kClearedCells;
    for_ranges(threads, parts, 1, [&](size_t first, size_t last) {
        const auto begin = cells_.begin();
        std::fill(begin + static_cast<std::ptrdiff_t>(first * kClearedCells),
                  begin + static_cast<std::ptrdiff_t>(std::min(last * kClearedCells, cell_count)),
                  kNone);
    });
    for (std::vector<uint64_t>* words : {&marks_, &near_}) {
        make_room(*words, word_count);
        words->assign(word_count, 0);
    }
}

// From the last one: the first of a cell is its head.
void RecordPlaces::link_records() {
    make_room(next_, records_.size());
    next_.resize(records_.size());
    for (size_t i = records_.size(); i-- > 0;) {
        const ContactRecord& record = records_[i];
        const Box& box = boxes_[static_cast<size_t>(record.body)];
        const int x = box.cell_at(record.voxel, 0), y = box.cell_at(record.voxel, 1),
                  z = box.cell_at(record.voxel, 2);
        int32_t& head = cells_[box.cell(x, y, z)];
        next_[i] = head;
        head = static_cast<int32_t>(i);
        marks_[box.row(y, z) + static_cast<size_t>(x / kWordBits)] |= uint64_t{1} << x % kWordBits;
    }
}

void RecordPlaces::mark_near() {
    bool is_one_coarse = false;
    for (const Box& box : boxes_) {
        if (box.high[0] < 0) continue;
        is_one_coarse = is_one_coarse || box.cell_shift > 0;
        if (box.cell_shift == 0) mark_near_voxels(box);
    }
    if (!is_one_coarse) return;
    for (const ContactRecord& record : records_) {
        if (boxes_[static_cast<size_t>(record.body)].cell_shift > 0) mark_near_cells(record);
    }
}

// Where a cell is a voxel: a record answers for itself and those round it, in its layer and the one
// below, and for the one right over it. No record is within two cells of the border.
void RecordPlaces::mark_near_voxels(const Box& box) {
    const auto words = static_cast<size_t>(box.row_words);
    for (int z = 1; z + 1 < box.cell_count[2]; ++z) {
        for (int y = 1; y + 1 < box.cell_count[1]; ++y) {
            const uint64_t* here = &marks_[box.row(y, z)];
            const uint64_t* above = &marks_[box.row(y, z + 1)];
            const uint64_t* below = &marks_[box.row(y, z - 1)];
            // Of the rows before and behind as well: they lie side by side.
            const auto round = [&](size_t i) {
                return here[i] | above[i] | *(here + i - words) | *(above + i - words) |
                       here[i + words] | above[i + words];
            };
            uint64_t* near = &near_[box.row(y, z)];
            uint64_t before = 0, now = round(0);
            for (size_t i = 0; i < words; ++i) {
                const uint64_t next = i + 1 < words ? round(i + 1) : 0;
                near[i] = now | now << 1 | before >> (kWordBits - 1) | now >> 1 |
                          next << (kWordBits - 1) | below[i];
                before = now;
                now = next;
            }
        }
    }
}

// Where cells are larger than voxels: all that one of its voxels beside reaches.
void RecordPlaces::mark_near_cells(const ContactRecord& record) {
    const Box& box = boxes_[static_cast<size_t>(record.body)];
    int low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        const int at = record.voxel[k] - box.low[k];
        low[k] = (at - kAnswerVoxels) >> box.cell_shift;
        high[k] = (at + kAnswerVoxels) >> box.cell_shift;
    }
    for (int z = low[2]; z <= high[2]; ++z) {
        for (int y = low[1]; y <= high[1]; ++y) {
            uint64_t* row = &near_[box.row(y, z)];
            for (int x = low[0]; x <= high[0]; ++x) {
                row[x / kWordBits] |= uint64_t{1} << x % kWordBits;
            }
        }
    }
}

}  // namespace bsoil
