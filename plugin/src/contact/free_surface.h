/// How high the soil stands around the bodies that touch it: what depths are measured from.
#pragma once

#include <climits>
#include <functional>
#include <span>
#include <vector>

#include "base/layout.h"
#include "bsoil/contact/contact_law_def.h"
#include "bsoil/grid_frame.h"
#include "contact/contact_record.h"
#include "contact/surface_wedge.h"

namespace bsoil {

/// In place of a column's height where the soil that a body carries has none: nothing of it there,
/// or only the body's own top (kBareTop less its height).
inline constexpr int32_t kBare = INT32_MIN + 1, kBareTop = -(1 << 30);

/// The free surface of the soil that one carrier (or the ground) holds, over a rectangle of columns
/// around contacts that lie near each other: a region. Lengths in voxels, grid axes. Keeps its
/// memory from one step to the next.
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
    /// Cost: those columns, wherever in the grid they lie.
    void find(const Request& request, const TileWords& words) {
        read(request, words);
        spread();
    }
    /// The two halves of find(). The second may be on another thread.
    /// @{
    void read(const Request& request, const TileWords& words);
    void spread();
    /// @}

    /// How high the soil beside a surface element of a body is.
    struct Beside {
        double height = 0;   ///< of the free surface that counts: the mean over what would give way
        double nearest = 0;  ///< of the ground right there, ahead of a wall
    };
    /// contact: one of the request's; at: on the element; outward: its unit normal, into the soil.
    Beside height_beside(const ContactRecord& contact, Vec3 at, Vec3 outward) const;

    /// The wedge that the ground as it lies makes before a wall with its foot at the element, in
    /// voxels; no depth above the ground. nearest: as height_beside() has it of the same element.
    /// Needs Request::wedges.
    SurfaceWedge::Found wedge_before(const ContactRecord& contact, Vec3 at, Vec3 outward,
                                     double nearest) const;

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

    /// A rectangle of columns around contacts so near each other that their reaches meet.
    struct Region {
        int low[2] = {INT_MAX, INT_MAX}, high[2] = {-1, -1};  ///< columns, both within
        size_t first_column = 0, first_sum = 0, first_tile = 0;
        int size(int axis) const { return high[axis] - low[axis] + 1; }
        int tile(int axis) const { return low[axis] / layout::kTileSide; }
        int tile_count(int axis) const { return high[axis] / layout::kTileSide - tile(axis) + 1; }
    };
    /// A square of tiles with contacts.
    struct Cell {
        int x = 0, y = 0, region = -1;
    };
    /// Contacts that follow each other in one tile. There are far fewer of these than of contacts.
    struct Spot {
        int tile[2] = {0, 0};
        int low[2] = {INT_MAX, INT_MAX}, high[2] = {-1, -1};  ///< columns, both within
    };

    void look_at(std::span<const ContactRecord> contacts);
    void find_reach();
    void find_cells();
    void find_regions(const Request& request);
    void find_tiles();
    Cell cell_of(int tile_x, int tile_y) const;
    /// The order of cells.
    static bool is_before(const Cell& a, const Cell& b) {
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }
    size_t region_at(int tile_x, int tile_y) const;
    const Region& region_of(const ContactRecord& contact) const {
        return regions_[region_at(contact.voxel[0] / layout::kTileSide,
                                  contact.voxel[1] / layout::kTileSide)];
    }
    void read_heights(const Region& region, const TileWords& words);
    void lay_bare_tops();
    void spread_nearest(const Region& region);
    void sum_up(const Region& region);
    Sum sum_below(const Region& region, double x, double y) const;
    double nearest_beside(const ContactRecord& contact, double otherwise, double wall,
                          Vec3 ahead) const;
    /// Of the ground at distances x along a level direction, between the middles of columns. Where
    /// nobody has looked it is as high as at the distance before, and `nearest` at the first.
    SurfaceWedge::Runs ground_along(const Region& region, Vec3 from, Vec3 ahead,
                                    const SurfaceWedge::Runs& x, double nearest) const;

    int reach_ = 0;                ///< the farthest of all bodies [columns]
    std::vector<Spot> spots_;      ///< in the order of the contacts
    std::vector<Cell> cells_;      ///< in the order of is_before()
    std::vector<int> open_;        ///< cells whose neighbours are to be looked at
    std::vector<Region> regions_;  ///< a column may be of several
    const ContactLawDef* law_ = nullptr;
    std::vector<double> wedge_length_;  ///< by material
    std::span<const SurfaceWedge> wedges_;
    std::vector<double> body_width_;
    std::vector<double> body_reach_;                  ///< by body index [columns]
    std::vector<std::pair<int, int>> contact_range_;  ///< lowest and highest z, by body index
    std::vector<uint8_t> tiles_;       ///< by tile of a region: 1 with contacts, 2 near some
    std::vector<int32_t> words_;       ///< surface words, region by region
    std::vector<int32_t> nearest_;     ///< height of the nearest column with soil on top [Q16]
    std::vector<int> told_, telling_;  ///< columns a step nearer to soil, and those being told
    std::vector<int32_t> heights_;     ///< that they are told
    std::vector<Sum> sums_;            ///< over the columns of a region below and left of a corner
};

}  // namespace bsoil
