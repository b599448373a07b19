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
    /// Whether one of a body's records may be in a voxel from low to high or beside one. Says yes
    /// too often for a large body with few records.
    bool may_be_beside(int body, const int low[3], const int high[3]) const;
    bool is_in_grid(const int voxel[3]) const;
    /// A body's record, the first of several; -1: none.
    int find(const int voxel[3], int body) const;
    /// Those in a voxel and round it, in its layer and the one above, x fastest; negative:
    /// none. The voxel is one that may_be_beside() says yes to. False: there is no record.
    static constexpr int kAround = 18;
    bool find_around(const int voxel[3], int body, int (&found)[kAround]) const;
    /// Of a record's gradient and the normal of a face that it may belong to.
    double cosine(int record, Vec3 normal) const {
        const Gradient& gradient = gradients_[static_cast<size_t>(record)];
        return -dot(gradient.vector, normal) / gradient.length;
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
    void find_boxes(size_t body_count);
    void lay_cells();
    /// Marks the cells that have a record in them or beside: most of a body is far from any.
    void mark_near();
    void link_records();

    std::span<const ContactRecord> records_;
    std::vector<Gradient> gradients_;
    std::vector<Box> boxes_;      ///< by body
    std::vector<int32_t> cells_;  ///< by body, then cell: its first record
    std::vector<int32_t> next_;   ///< by record: the next one in its cell
    int size_[3] = {0, 0, 0};
};

}  // namespace bsoil
