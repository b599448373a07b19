/// What a body's surface samples add up to in the voxels where the body meets soil.
#pragma once

#include <span>
#include <vector>

#include "bsoil/grid_frame.h"
#include "bsoil/work_threads.h"
#include "contact/contact_record.h"
#include "contact/surface_samples.h"

namespace bsoil {

/// A body and its surface where it stands.
struct SampledBody {
    const SurfaceSamples* surface = nullptr;  ///< null: none to be gathered
    Pose to_grid;                             ///< body frame -> grid, metres
};

/// The part of a body's surface that one voxel's soil answers and that looks one way. Grid axes,
/// metres.
struct SurfacePiece {
    Vec3 area;    ///< sum of normal times area
    Vec3 moment;  ///< sum of place times area
    Vec3 origin;  ///< what `spread` is counted from
    Vec3 spread;  ///< sum of area times height times place
    double area_m2 = 0;
    int next = -1;  ///< of the same record
    int row = -1;   ///< SurfaceSample::row
    ToothPart part = ToothPart::base;

    Vec3 middle() const { return moment * (1 / area_m2); }
    /// How its height goes with its place about its middle: the covariance of height and place.
    Vec3 rise_m2() const {
        const Vec3 off = middle() - origin;
        return spread * (1 / area_m2) - off.z * off;
    }
};

/// Shares out each sample over the records of its body. Along an axis goes what of its area looks
/// that way. A face that lies at the share f of its way through a voxel belongs to that one by
/// half, to the one before it by (1 - f) / 2 and to the one beyond by f / 2; across, each voxel has
/// what of the face lies in it: the shares of the coverage's gradient, which do not jump as the
/// body moves. Of the three only records count whose gradient agrees with the face; in a corner,
/// where there is none, those beside that agree. The sample's area does not depend on how many
/// there are; what of it has none has no soil at it.
class SurfacePieces {
  public:
    /// bodies: by index, as in the records. same_cosine: samples of a voxel whose normals are no
    /// further apart are one piece. threads: to share the work, or null.
    void gather(std::span<const ContactRecord> records, std::span<const SampledBody> bodies,
                const GridFrame& frame, double same_cosine, const WorkThreads* threads = nullptr);
    /// Of a record: calls visit(piece), in an order that does not depend on threads.
    template <typename Visit>
    void for_each(size_t record, Visit&& visit) const {
        for (int i = heads_[record]; i >= 0; i = pieces_[static_cast<size_t>(i)].next) {
            visit(pieces_[static_cast<size_t>(i)]);
        }
    }

  private:
    /// Round a body's records, and the cells over it: see mark_near().
    struct Box {
        int low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {-1, -1, -1};
        size_t record_count = 0;
        size_t cells = 0;  ///< where they begin in near_
        int cell_shift = 0, cell_count[3] = {0, 0, 0};
        size_t cell(int x, int y, int z) const {
            return cells + (static_cast<size_t>(z) * cell_count[1] + y) * cell_count[0] + x;
        }
    };
    void fill_table(std::span<const ContactRecord> records);
    void find_boxes(std::span<const ContactRecord> records, size_t body_count);
    /// Marks the cells in which a part may have a record: most of a body is far from any.
    void mark_near(std::span<const ContactRecord> records);
    bool may_have_record(const Box& box, Vec3 seen) const;
    /// -1: none.
    int find(const int voxel[3], int body) const;
    /// What of a sample looks along an axis and is in one voxel across it.
    struct Part {
        Vec3 seen;  ///< where the soil sees it [voxels]
        Vec3 at_m, normal;
        double area_m2 = 0;
        Vec3 rise_m2;  ///< as SurfacePiece::rise_m2
    };
    /// What a record gets of a part.
    struct Given {
        int record;
        const SurfaceSample* sample;
        Part part;
        double share;
    };
    /// Samples of a body that one thread takes, and what they give, in their order: first clusters,
    /// in the last lot of a body what lies over its tips.
    struct Lot {
        int body = 0;
        size_t first = 0, last = 0;  ///< of its clusters
        bool is_over_tips = false;
        std::vector<Given> given;
    };
    void make_lots(std::span<const SampledBody> bodies);
    void share_out(const SampledBody& body, Lot& lot) const;
    void share_sample(const SurfaceSample& sample, Vec3 at, Vec3 normal, Lot& lot) const;
    void share_part(const SurfaceSample& sample, int axis, const Part& part, Lot& lot) const;
    void share_around(const SurfaceSample& sample, const Part& part, Lot& lot) const;
    void share_over_tips(const OverTips& sample, const Pose& to_grid, Lot& lot) const;
    void add(const Given& given);

    std::vector<Lot> lots_;  ///< the first lot_count_ of them
    size_t lot_count_ = 0;
    std::span<const ContactRecord> records_;
    std::vector<int> heads_;  ///< per record, into pieces_
    std::vector<SurfacePiece> pieces_;
    std::vector<uint64_t> keys_;  ///< open addressing
    std::vector<int> found_;
    std::vector<Box> boxes_;
    std::vector<uint8_t> near_;  ///< by body, then cell
    int size_[3] = {0, 0, 0};    ///< of the grid [voxels]
    double voxel_m_ = 1, same_cosine_ = 0;
};

}  // namespace bsoil
