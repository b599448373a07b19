/// What a body's surface samples add up to in the voxels where the body meets soil.
#pragma once

#include <span>
#include <vector>

#include "bsoil/grid_frame.h"
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
    /// further apart are one piece.
    void gather(std::span<const ContactRecord> records, std::span<const SampledBody> bodies,
                const GridFrame& frame, double same_cosine);
    /// Of a record: calls visit(piece), in an order that does not depend on threads.
    template <typename Visit>
    void for_each(size_t record, Visit&& visit) const {
        for (int i = heads_[record]; i >= 0; i = pieces_[static_cast<size_t>(i)].next) {
            visit(pieces_[static_cast<size_t>(i)]);
        }
    }

  private:
    struct Box {
        int low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {-1, -1, -1};
    };
    void fill_table(std::span<const ContactRecord> records);
    /// -1: none.
    int find(const int voxel[3], int body) const;
    void add_sample(std::span<const ContactRecord> records, int body, const SurfaceSample& sample,
                    Vec3 at, Vec3 normal);
    /// What of a sample looks along an axis and is in one voxel across it.
    struct Part {
        Vec3 seen;  ///< where the soil sees it [voxels]
        Vec3 at_m, normal;
        double area_m2 = 0;
        Vec3 rise_m2;  ///< as SurfacePiece::rise_m2
    };
    void add_part(std::span<const ContactRecord> records, int body, const SurfaceSample& sample,
                  int axis, const Part& part);
    void add_around(std::span<const ContactRecord> records, int body, const SurfaceSample& sample,
                    const Part& part);
    void add_over_tips(int body, const OverTips& sample, const Pose& to_grid);
    /// Adds `share` of a part.
    void add_to(int record, const SurfaceSample& sample, const Part& part, double share);

    std::vector<int> heads_;  ///< per record, into pieces_
    std::vector<SurfacePiece> pieces_;
    std::vector<uint64_t> keys_;  ///< open addressing
    std::vector<int> found_;
    std::vector<Box> boxes_;
    int size_[3] = {0, 0, 0};  ///< of the grid [voxels]
    double voxel_m_ = 1, same_cosine_ = 0;
};

}  // namespace bsoil
