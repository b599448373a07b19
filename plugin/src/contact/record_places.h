/// Where bodies' contact records are, by voxel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/geometry.h"
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
    /// size: of the grid. Keeps its memory from one call to the next. Cost: 27 words a record are
    /// marked, and up to 256 bytes more each cleared where a body's records are far apart.
    void fill(std::span<const ContactRecord> records, size_t body_count, const int size[3]);

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
        int cell_shift = 0, cell_count[3] = {0, 0, 0};
        size_t cell(int x, int y, int z) const {
            return cells + (static_cast<size_t>(z) * cell_count[1] + y) * cell_count[0] + x;
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
        size_t cell_of(const int voxel[3]) const {
            return cell((voxel[0] - low[0]) >> cell_shift, (voxel[1] - low[1]) >> cell_shift,
                        (voxel[2] - low[2]) >> cell_shift);
        }
    };
    struct Gradient {
        Vec3 vector;
        double length = 0;
    };
    /// In place of a cell's first record. The one that is written row by row is no row of equal
    /// bytes, of which a compiler makes a call.
    enum : int32_t { kNoneHere = -2, kNoneNear = -1 };
    void find_boxes(size_t body_count);
    void lay_cells();
    /// Marks the cells that a record answers for: most of a body is far from any.
    void mark_near();
    void link_records();

    std::span<const ContactRecord> records_;
    std::vector<Gradient> gradients_;
    std::vector<Box> boxes_;      ///< by body
    std::vector<int32_t> cells_;  ///< by body, then cell: its first record
    std::vector<int32_t> next_;   ///< by record: the next one in its cell
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
