/// What a body's surface samples add up to in the voxels where the body meets soil.
#pragma once

#include <span>
#include <vector>

#include "bsoil/grid_frame.h"
#include "bsoil/work_threads.h"
#include "contact/contact_record.h"
#include "contact/record_places.h"
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
    /// The facing that all of it has, by the first sample that looks so; negative: of several.
    int facing = -1;
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
        const int own = own_lots_[static_cast<size_t>(records_[record].body)];
        const std::vector<SurfacePiece>& pieces =
            own < 0 ? bins_[bin_of(record)].pieces : lots_[static_cast<size_t>(own)].pieces;
        for (int i = heads_[record]; i >= 0; i = pieces[static_cast<size_t>(i)].next) {
            visit(pieces[static_cast<size_t>(i)]);
        }
    }

    size_t count(size_t record) const {
        size_t count = 0;
        for_each(record, [&count](const SurfacePiece&) { ++count; });
        return count;
    }

  private:
    /// Records are put together by this many threads at most, each taking its own.
    static constexpr size_t kBins = 16;
    static size_t bin_of(size_t record) { return record / kBinRecords % kBins; }
    /// Records beside each other that one thread takes: faces are shared out over neighbours.
    static constexpr size_t kBinRecords = 32;
    /// A cache line. Ours: of most processors. Smaller: threads wait for what others write beside
    /// their own.
    static constexpr size_t kLineBytes = 64;

    /// What samples that look one way have in common.
    struct Facing {
        /// As looked at along an axis, over places along the two that follow it.
        struct Along {
            double weight = 0;        ///< share of the area that looks along it
            bool is_towards = false;  ///< towards larger places
            double slope_u = 0, slope_v = 0;
            double turn = 0;  ///< correlation of the places
        };
        Facing() = default;
        Facing(Vec3 sample_normal, const Pose& to_grid);
        /// SurfacePiece::rise_m2 of a part of these widths; half: of the whole piece's height.
        Vec3 rise(int axis, double wide_u, double wide_v, double half) const;

        Vec3 in_body, normal;          ///< normal: in the grid's axes
        double across[3] = {0, 0, 0};  ///< how wide a piece is across each axis over its side
        Along along[3];
    };
    /// What of a sample looks along an axis and is in one voxel across it.
    struct Part {
        Vec3 at_m, normal;
        double area_m2 = 0;
        Vec3 rise_m2;  ///< as SurfacePiece::rise_m2
        int row = -1;
        int facing = 0;  ///< SurfacePiece::facing
        ToothPart part = ToothPart::base;
    };
    /// What a record gets of a part.
    struct Given {
        int record, part;  ///< part: of the same lot
        double share;
    };
    /// Samples of a body that one thread takes, and what they give, in their order: first clusters,
    /// in the last lot of a body what lies over its tips. A body that is one lot is put together
    /// sample by sample, by the same thread.
    struct Lot {
        int body = 0;
        size_t first = 0, last = 0;  ///< of its clusters
        bool is_over_tips = false;
        bool is_whole_body = false;
        int facing = 0;  ///< of the parts to come: the first sample that has it
        std::vector<Part> parts;
        std::vector<Given> given[kBins];   ///< by the bin of the record; of a whole body the first
        std::vector<SurfacePiece> pieces;  ///< of a whole body

        void give(int record, double share) {
            const size_t bin = is_whole_body ? 0 : bin_of(static_cast<size_t>(record));
            given[bin].push_back({record, static_cast<int>(parts.size()), share});
        }
    };
    void make_lots(std::span<const SampledBody> bodies);
    void share_out(const SampledBody& body, Lot& lot);
    void share_sample(const SurfaceSample& sample, Vec3 at, const Facing& facing, Lot& lot) const;
    /// seen: where the soil sees it [voxels], in that voxel. False: no record has it.
    bool share_part(const SurfaceSample& sample, int axis, Vec3 seen, const int voxel[3],
                    const Facing& facing, Lot& lot) const;
    bool share_around(Vec3 seen, const int voxel[3], Vec3 normal, Lot& lot) const;
    void share_over_tips(const OverTips& sample, const Pose& to_grid, Lot& lot) const;
    /// Puts together what the records of a bin are given.
    void add_all(size_t bin);
    /// What a lot that is a whole body has given since the last call.
    void add_given(Lot& lot);
    void add(const Given& given, const Part& part, std::vector<SurfacePiece>& pieces);

    std::span<const ContactRecord> records_;
    std::vector<Lot> lots_;  ///< the first lot_count_ of them
    size_t lot_count_ = 0;
    std::vector<int> own_lots_;  ///< by body: the lot that is all of it; -1: none is
    RecordPlaces places_;
    struct alignas(kLineBytes) Bin {
        std::vector<SurfacePiece> pieces;
    };
    std::vector<int> heads_;  ///< per record, into the pieces of its lot or bin
    Bin bins_[kBins];         ///< by the bin of the record
    double voxel_m_ = 1, same_cosine_ = 0;
};

}  // namespace bsoil
