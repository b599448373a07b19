/// How high the soil stands around the bodies that touch it: what depths are measured from.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "bsoil/contact/contact_law_def.h"
#include "bsoil/grid_frame.h"
#include "contact/contact_record.h"
#include "contact/surface_wedge.h"

namespace bsoil {

/// In place of a column's height where the soil that a body carries has none: nothing of it there,
/// or only the body's own top (kBareTop less its height).
inline constexpr int32_t kBare = INT32_MIN + 1, kBareTop = -(1 << 30);

/// The free surface of the soil that one carrier (or the ground) holds, over a rectangle of columns
/// around contacts. Lengths in voxels, grid axes. Keeps its memory from one step to the next.
///
/// A column under a body has the mean height of those beside it that are a step nearer to soil; for
/// a wall, that of the ground ahead of it. Bare terrain has no more than that: soil cannot rise
/// against a wall, nor a wall be soil.
class FreeSurface {
  public:
    /// Surface words of a tile's 64 columns: Q16 heights, kCovered and kTerrainTop (soil_layout.h),
    /// and for carried soil kBare and kBareTop.
    using TileWords = std::function<std::span<const int32_t>(int tile_x, int tile_y)>;

    /// What find() works for.
    struct Request {
        std::span<const ContactRecord> contacts;    ///< not empty, of one carrier
        std::span<const double> body_width_voxels;  ///< of each body's contact, by index
        const GridFrame* frame = nullptr;
        const ContactLawDef* law = nullptr;    ///< outlives the calls of height_beside()
        std::span<const double> wedge_length;  ///< of each material, over its depth
        std::span<const SurfaceWedge> wedges;  ///< of each material; outlive wedge_before()'s calls
    };
    /// Reads the columns around the contacts, on the caller's thread, and finds their heights.
    /// Cost: those columns.
    void find(const Request& request, const TileWords& words) {
        read(request, words);
        spread();
    }
    /// The two halves of find(). The second may be on another thread.
    /// @{
    void read(const Request& request, const TileWords& words);
    void spread();
    /// @}

    /// Height of the free surface that counts for a surface element of a body: the mean over the
    /// soil that would give way to it. contact: one of the request's; at: on the element; outward:
    /// its unit normal, into the soil.
    double height_beside(const ContactRecord& contact, Vec3 at, Vec3 outward) const;

    /// The wedge that the ground as it lies makes before a wall with its foot at the element, in
    /// voxels; no depth above the ground. Needs Request::wedges.
    SurfaceWedge::Found wedge_before(const ContactRecord& contact, Vec3 at, Vec3 outward) const;

  private:
    /// Sums over columns.
    struct Sum {
        double height = 0, count = 0;                  ///< of free columns, and of them
        double covered_height = 0, covered_count = 0;  ///< the same of columns under bodies
        Sum operator+(const Sum& o) const {
            return {height + o.height, count + o.count, covered_height + o.covered_height,
                    covered_count + o.covered_count};
        }
        Sum operator*(double f) const {
            return {height * f, count * f, covered_height * f, covered_count * f};
        }
        Sum operator-(const Sum& o) const { return *this + o * -1; }
    };

    void find_reach(const Request& request);
    void find_rectangle(const Request& request);
    void find_tiles(std::span<const ContactRecord> contacts);
    void read_heights(const TileWords& words);
    void lay_bare_tops();
    void spread_nearest();
    void sum_up();
    Sum sum_below(double x, double y) const;
    double nearest_beside(const ContactRecord& contact, double otherwise, double wall,
                          Vec3 ahead) const;
    /// Of the ground at distances x along a level direction, between the middles of columns. Where
    /// nobody has looked it is as high as at the distance before, and `nearest` at the first.
    SurfaceWedge::Runs ground_along(Vec3 from, Vec3 ahead, const SurfaceWedge::Runs& x,
                                    double nearest) const;

    int reach_ = 0;                           ///< the farthest of all bodies [columns]
    int low_[2] = {0, 0}, size_[2] = {0, 0};  ///< of the rectangle [columns]
    const ContactLawDef* law_ = nullptr;
    std::vector<double> wedge_length_;  ///< by material
    std::span<const SurfaceWedge> wedges_;
    std::vector<double> body_width_;
    std::vector<double> body_reach_;                  ///< by body index [columns]
    std::vector<std::pair<int, int>> contact_range_;  ///< lowest and highest z, by body index
    std::vector<uint8_t> tiles_;       ///< by tile of the rectangle: 1 with contacts, 2 near some
    std::vector<int32_t> words_;       ///< surface words
    std::vector<int32_t> nearest_;     ///< height of the nearest column with soil on top [Q16]
    std::vector<int> told_, telling_;  ///< columns a step nearer to soil, and those being told
    std::vector<int32_t> heights_;     ///< that they are told
    std::vector<Sum> sums_;            ///< over the columns below and left of a corner
};

}  // namespace bsoil
