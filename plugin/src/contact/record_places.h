/// Where bodies' contact records are, by voxel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/work_threads.h"
#include "contact/contact_record.h"

namespace bsoil {

/// The voxel that a place is in, along an axis; of places whose voxel has an index in int.
inline int voxel_of(double place) {
    const int towards_0 = static_cast<int>(place);
    return towards_0 - (place < towards_0 ? 1 : 0);
}

/// Of the records of all bodies, each in its voxel. Places in voxels, in the grid's axes.
class RecordPlaces {
  public:
    /// size: of the grid. threads: to share the work, or null. Keeps its memory from one call to
    /// the next. Cost: the records, and up to 400 bytes more each cleared where a body's records
    /// are far apart.
    void fill(std::span<const ContactRecord> records, size_t body_count, const int size[3],
              const WorkThreads* threads = nullptr);

    bool has_any(int body) const { return boxes_[static_cast<size_t>(body)].high[0] >= 0; }
    /// Whether a place is no further than this from the box round a body's records, along each
    /// axis.
    bool is_near_box(int body, Vec3 at, double reach) const;
    /// Whether one of a body's records may answer for a voxel from low to high: it is in it or
    /// round it in its layer or the one above, or right below. Says yes too often for a large body
    /// with few records.
    bool may_be_beside(int body, const int low[3], const int high[3]) const;
    bool is_in_grid(const int voxel[3]) const;
    /// A body's record, the first of several; -1: none.
    int find(const int voxel[3], int body) const;
    /// Those in three voxels along an axis: the one before a voxel, itself and the one behind it;
    /// negative: none. step: 1 or -1, towards what is behind. False where may_be_beside() says no
    /// of the voxel.
    bool find_along(const int voxel[3], int axis, int step, int body, int (&found)[3]) const;
    /// Calls visit(dx, dy, dz, record) for those in a voxel and round it, in its layer and the one
    /// above, x fastest; dx, dy: 0, 1, 2 for the voxel before, itself and the one behind; dz: 0, 1.
    /// The voxel is one that may_be_beside() says yes to.
    template <typename Visit>
    void visit_around(const int voxel[3], int body, Visit&& visit) const;
    /// Of a record's gradient and the normal of a face that it may belong to.
    double cosine(int record, Vec3 normal) const {
        const Gradient& gradient = gradients_[static_cast<size_t>(record)];
        return -dot(gradient.vector, normal) / gradient.length;
    }
    /// Whether that is more than 0.
    bool looks_along(int record, Vec3 normal) const {
        return dot(gradients_[static_cast<size_t>(record)].vector, normal) < 0;
    }

  private:
    /// Round a body's records and two voxels more, so that what is beside a voxel that is beside a
    /// record is in it, and the cells over it.
    struct Box {
        int low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {-1, -1, -1};
        size_t record_count = 0;
        size_t cells = 0;  ///< where they begin in cells_
        size_t rows = 0;   ///< where rows of marks begin in marks_ and near_
        int cell_shift = 0, cell_count[3] = {0, 0, 0};
        int row_words = 0;
        void add(const Box& part);
        size_t cell(int x, int y, int z) const {
            return cells + (static_cast<size_t>(z) * cell_count[1] + y) * cell_count[0] + x;
        }
        /// The first word of the marks of a row of cells along x.
        size_t row(int y, int z) const {
            return rows +
                   (static_cast<size_t>(z) * cell_count[1] + y) * static_cast<size_t>(row_words);
        }
        /// Between cells beside each other along an axis.
        ptrdiff_t stride(int axis) const {
            const ptrdiff_t row = cell_count[0];
            return axis == 0 ? 1 : axis == 1 ? row : row * cell_count[1];
        }
        bool holds(const int voxel[3]) const {
            return voxel[0] >= low[0] && voxel[0] <= high[0] && voxel[1] >= low[1] &&
                   voxel[1] <= high[1] && voxel[2] >= low[2] && voxel[2] <= high[2];
        }
        /// Of a voxel in the box.
        int cell_at(const int voxel[3], int axis) const {
            return (voxel[axis] - low[axis]) >> cell_shift;
        }
        size_t cell_of(const int voxel[3]) const {
            return cell(cell_at(voxel, 0), cell_at(voxel, 1), cell_at(voxel, 2));
        }
    };
    struct Gradient {
        Vec3 vector;
        double length = 0;
    };
    static constexpr int32_t kNone = -1;  ///< in place of a cell's first record
    static constexpr int kWordBits = 64;
    void look_at(const WorkThreads* threads, size_t body_count);
    void lay_cells(const WorkThreads* threads);
    void link_records();
    /// Marks the cells that a record answers for: most of a body is far from any.
    void mark_near();
    void mark_near_voxels(const Box& box);
    void mark_near_cells(const ContactRecord& record);
    /// Whether a cell is marked.
    bool is_near(const Box& box, int x, int y, int z) const {
        const uint64_t word = near_[box.row(y, z) + static_cast<size_t>(x / kWordBits)];
        return (word >> x % kWordBits & 1) != 0;
    }
    /// Whether a cell of a row from first to last is marked.
    bool is_any_near(const Box& box, int first, int last, int y, int z) const;

    std::span<const ContactRecord> records_;
    std::vector<Gradient> gradients_;
    std::vector<Box> boxes_;       ///< by body
    std::vector<Box> part_boxes_;  ///< the same of a part of the records, part by part
    std::vector<int32_t> cells_;   ///< by body, then cell: its first record
    std::vector<int32_t> next_;    ///< by record: the next one in its cell
    /// By body, then row of cells along x, a bit a cell: whether a record is in it; whether one
    /// answers for it.
    std::vector<uint64_t> marks_, near_;
    int size_[3] = {0, 0, 0};
};

template <typename Visit>
void RecordPlaces::visit_around(const int voxel[3], int body, Visit&& visit) const {
    const Box& box = boxes_[static_cast<size_t>(body)];
    for (int dz = 0; dz <= 1; ++dz) {
        for (int dy = 0; dy < 3; ++dy) {
            int beside[3] = {voxel[0] - 1, voxel[1] + dy - 1, voxel[2] + dz};
            // Where a cell is a voxel its first record is of that voxel.
            const int32_t* row = box.cell_shift == 0 ? &cells_[box.cell_of(beside)] : nullptr;
            for (int dx = 0; dx < 3; ++dx, ++beside[0]) {
                const int record = row ? row[dx] : find(beside, body);
                if (record >= 0) visit(dx, dy, dz, record);
            }
        }
    }
}

}  // namespace bsoil
