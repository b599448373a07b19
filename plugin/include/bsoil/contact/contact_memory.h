/// ContactMemory: how far a body's surface has slid along the soil beside it, and drawn back from
/// it.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/contact/contact_patches.h"
#include "bsoil/work_threads.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A voxel of soil beside a body, and what the body's surface has done to it.
struct PressedSoil {
    Vec3 center_m;  ///< of the voxel; where a body carries it, as far on as that goes until the
                    ///< next call
    Vec3 normal;    ///< out of the body
    Vec3 slid_m;
    double retreat_m = 0;  ///< of this body alone
};

/// What one of several bodies knows.
struct PressedList {
    /// sorted_soil: by center_m.x; of_body: -1 for any.
    explicit PressedList(std::span<const PressedSoil> sorted_soil, int of_body = -1);
    /// middles: their box, where that is known.
    PressedList(std::span<const PressedSoil> sorted_soil, int of_body, const Aabb& middles)
        : body(of_body), soil(sorted_soil), box(middles) {}

    int body = -1;
    std::span<const PressedSoil> soil;  ///< sorted by center_m.x
    Aabb box;                           ///< of its middles
};

/// Janosi and Hanamoto's shear displacement belongs to the soil. A voxel starts with none when it
/// meets the first body. It adds to it until the last body leaves. So the soil under the front of a
/// track has sheared less than the soil under its end, whether the track is one body or many links.
/// A contact that moves along its normal (a blade, a sinking sole) takes its soil with it. The
/// inclined front of a wheel only presses its soil down. Each surface remembers for itself how far
/// it has drawn back since it pressed on the soil most.
class ContactMemory {
  public:
    /// Of `lists`, what may lie beside these voxels of `body` and is not from its own memory.
    /// Sorted by center_m.x; of what lies at the same x the first list's is first.
    static void near(std::span<const PressedList> lists, std::span<const ContactVoxel> voxels,
                     int body, const ContactLaw& law, std::vector<PressedSoil>& out);

    /// The first half of advance(), which asks nothing of faces or motions: `around` must outlive
    /// that call. Who has not called it leaves it to advance().
    void look_around(std::span<const PressedSoil> around, const ContactLaw& law,
                     const WorkThreads* threads = nullptr);
    /// Adds the motion of `duration_s`, relative to each voxel's carrier (of the list `relative`;
    /// empty: all lie on the ground). around: what other bodies knew at the last call,
    /// sorted by center_m.x; soil that one of them has sheared further comes to this one so.
    /// Returns what there is per voxel, valid until the next call. Cost: O(n log n). threads: to
    /// share the work, or null.
    std::span<const ContactHistory> advance(std::span<const ContactVoxel> voxels,
                                            const BodyMotion& motion, const ContactLaw& law,
                                            double duration_s,
                                            std::span<const PressedSoil> around = {},
                                            std::span<const ContactMotion> relative = {},
                                            const WorkThreads* threads = nullptr);
    /// The same for a body that stands still; nothing is added.
    std::span<const ContactHistory> recall(std::span<const ContactVoxel> voxels,
                                           const ContactLaw& law,
                                           const WorkThreads* threads = nullptr);
    /// Sorted by center_m.x. Until look_around(), and again after advance().
    std::span<const PressedSoil> soil() const { return entries_; }
    /// The same with its box.
    PressedList list(int of_body) const { return {entries_, of_body, box_}; }
    /// What soil() gave, of this memory at another time.
    void set_soil(std::span<const PressedSoil> soil);

  private:
    static constexpr size_t kRangeVoxels = 128;  ///< that one thread takes at least

    /// Finds the soil near a place in a list sorted by center_m.x: in cubic cells.
    class Index {
      public:
        /// box: of the middles. voxel_m: width of a cell, where there are not far more cells than
        /// entries. `soil` must outlive the looks. threads: to share the work, or null.
        void make(std::span<const PressedSoil> soil, const Aabb& box, double voxel_m,
                  const WorkThreads* threads);
        /// The soil of a contact voxel, null where it is not there: the nearest; of an edge's two
        /// faces in one voxel the one that looks the same way. is_own: the soil is that of the
        /// voxel's own body, so that most of what is looked for is in the voxel itself.
        const PressedSoil* find(const ContactVoxel& v, const ContactLaw& law, double cosine_least,
                                bool is_own) const;

      private:
        int cell_at(double off_m, int last) const {
            return static_cast<int>(
                std::min(std::max(off_m * per_cell_, 0.0), static_cast<double>(last)));
        }
        /// Where a row of cells along x begins.
        size_t row_of(int y, int z) const {
            return (static_cast<size_t>(z) * (static_cast<size_t>(last_[1]) + 1) +
                    static_cast<size_t>(y)) *
                   (static_cast<size_t>(last_[0]) + 1);
        }
        /// Whether an entry may lie no further than `half_m` off `middle` along each axis.
        bool may_hold(Vec3 middle, double half_m) const;
        /// Calls visit(entry, apart) for each entry that lies no further than `half` off `middle`
        /// along each axis; apart: from the middle.
        template <typename Visit>
        void visit_box(Vec3 middle, Vec3 half, const Visit& visit) const;

        std::span<const PressedSoil> soil_;
        Aabb box_;  ///< of its middles
        Vec3 low_;  ///< where cells begin
        double per_cell_ = 1;
        std::array<int, 3> last_{};  ///< the last cell along x, y and z
        /// An entry's middle, and its place in the list.
        struct Spot {
            Vec3 center_m;
            size_t place = 0;
        };
        std::vector<size_t> cells_;  ///< of each entry
        std::vector<int> starts_;    ///< of a cell in spots_; one more for the end, and a spare
        std::vector<Spot> spots_;    ///< by cell, row by row
    };

    /// Some entries that follow each other.
    struct Stretch {
        bool is_sorted = true;  ///< with the first of the next one
        Aabb box;               ///< of their middles
    };
    void sort_entries(const WorkThreads* threads);

    std::vector<PressedSoil> entries_, previous_;   ///< sorted by center_m.x
    Aabb box_;                                      ///< of the middles of entries_
    std::vector<Stretch> stretches_;                ///< of entries_
    bool has_looked_ = false;                       ///< look_around(), and advance() has not come
    std::vector<std::pair<double, size_t>> order_;  ///< of entries: center_m.x and place
    std::vector<ContactHistory> history_;
    Index own_index_, around_index_;
};

/// The order of ContactMemory's lists.
inline bool lies_before(const PressedSoil& a, const PressedSoil& b) {
    return a.center_m.x < b.center_m.x;
}

}  // namespace bsoil
#pragma GCC visibility pop
