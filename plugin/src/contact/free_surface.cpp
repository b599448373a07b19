#include "contact/free_surface.h"

#include <algorithm>
#include <cmath>

#include "base/layout.h"
#include "base/make_room.h"
#include "bsoil/contact/orientation.h"

namespace bsoil {

using namespace layout;

namespace {

/// Columns along an axis in which the ground of a wall's voxel begins. Ours: as collect_contacts
/// looks for the wall's soil, two outwards, in a grid turned by 45 deg too. Larger: ground beyond
/// another body; smaller: ground behind a thin wall.
constexpr int kAheadColumns = 3;
/// The least reach of a contact's free surface, in columns as it is a matter of cost. Ours: two
/// tiles hold the wedge of a small body, so nobody has to look at its size. Larger: more columns
/// are read for nothing.
constexpr int kReach = 2 * kTileSide;
/// The greatest reach, in columns as it is a matter of cost. Ours: 12.8 m with voxels of 5 cm.
/// Larger: one huge body reads the whole grid. Smaller: a body's depth counts from the high part of
/// its heap.
constexpr int kReachMost = 32 * kTileSide;
/// A mean over fewer columns than this is none. Ours: for the rounding. Larger: a sliver of a
/// column counts for nothing.
constexpr double kHardlyAny = 1e-6;

/// What is left of a hollow's share where this share of the columns around is free of bodies. Ours:
/// the square, of how much of the rim one sees and of how much of what one sees is this sole's own
/// and not its neighbours'. The share itself would let soles side by side (a track's links) count
/// each other's rims; a higher power would forget a rim that is half seen.
constexpr double own_rim_share(double share, double free_share) {
    return share * free_share * free_share;
}
/// In place of the heights of a body's lowest and highest contact: it has none.
constexpr int kNoContact = -1;
/// In place of a column's height.
constexpr int32_t kNotLookedAt = INT32_MIN;
/// In place of the nearest height of a column that has not been told it yet.
constexpr int32_t kUntold = INT32_MIN + 1;
/// And of one that is being told.
constexpr int32_t kBeingTold = INT32_MIN + 2;

/// Tiles that a reach in columns may lead into.
constexpr int reach_tiles(int reach) { return (reach + kTileSide - 1) / kTileSide; }
/// Side of a cell of contacts, in tiles: where soil around contacts of two cells is read that do
/// not touch, a tile lies between.
constexpr int cell_tiles(int reach) { return 2 * reach_tiles(reach) + 2; }

/// Marks of tiles.
enum : uint8_t { kFar, kWithContacts, kNearContacts };

/// Whether a surface word is that of bare terrain.
constexpr bool is_terrain_top(int32_t word) { return word <= kTerrainTop && word > kBareTop; }
/// Soil or bare ground on top, no body.
constexpr bool is_open(int32_t word) { return word >= 0 || is_terrain_top(word); }

}  // namespace

void FreeSurface::read(const Request& request, const TileWords& words) {
    law_ = request.law;
    wedges_ = request.wedges;
    wedge_length_.assign(request.wedge_length.begin(), request.wedge_length.end());
    body_width_.assign(request.body_width_voxels.begin(), request.body_width_voxels.end());
    look_at(request.contacts);
    find_reach();
    find_cells();
    find_regions(request);
    find_tiles();
    for (const Region& region : regions_) read_heights(region, words);
    if (request.contacts.front().carrier != kOnGround) lay_bare_tops();
}

void FreeSurface::spread() {
    for (const Region& region : regions_) {
        spread_nearest(region);
        sum_up(region);
    }
}

// All that is asked of the contacts before their free surface is known.
void FreeSurface::look_at(std::span<const ContactRecord> contacts) {
    contact_range_.assign(body_width_.size(), {kNoContact, kNoContact});
    spots_.clear();
    for (const ContactRecord& contact : contacts) {
        auto& [low, high] = contact_range_[static_cast<size_t>(contact.body)];
        low = low == kNoContact ? contact.voxel[2] : std::min(low, contact.voxel[2]);
        high = std::max(high, contact.voxel[2]);
        const int tile[2] = {contact.voxel[0] / kTileSide, contact.voxel[1] / kTileSide};
        if (spots_.empty() || spots_.back().tile[0] != tile[0] ||
            spots_.back().tile[1] != tile[1]) {
            spots_.push_back({{tile[0], tile[1]}});
        }
        Spot& spot = spots_.back();
        for (int axis = 0; axis < 2; ++axis) {
            spot.low[axis] = std::min(spot.low[axis], contact.voxel[axis]);
            spot.high[axis] = std::max(spot.high[axis], contact.voxel[axis]);
        }
    }
}

// How far a body's free surface can reach: before its walls as far as a wedge from its lowest
// contact up to its highest one, around its soles as far as the rim.
void FreeSurface::find_reach() {
    const double wedge_length = *std::max_element(wedge_length_.begin(), wedge_length_.end());
    body_reach_.resize(contact_range_.size());
    reach_ = kReach;
    for (size_t b = 0; b < contact_range_.size(); ++b) {
        const double wedge =
            wedge_length * (contact_range_[b].second - contact_range_[b].first + 1);
        const double rim = contact_range_[b].first == kNoContact
                               ? 0
                               : law_->sole_surroundings_widths * body_width_[b];
        body_reach_[b] = std::clamp<double>(std::ceil(std::max(wedge, rim)), kReach, kReachMost);
        reach_ = std::max(reach_, static_cast<int>(body_reach_[b]));
    }
}

FreeSurface::Cell FreeSurface::cell_of(int tile_x, int tile_y) const {
    const int side = cell_tiles(reach_);
    return {tile_x / side, tile_y / side};
}

// Contacts of one region lie in cells that touch each other. Cells are so large that soil within
// reach of contacts in two that do not touch is not the same, nor side by side.
void FreeSurface::find_cells() {
    cells_.clear();
    for (const Spot& spot : spots_) {
        const Cell cell = cell_of(spot.tile[0], spot.tile[1]);
        if (!cells_.empty() && !is_before(cell, cells_.back()) && !is_before(cells_.back(), cell)) {
            continue;
        }
        cells_.push_back(cell);
    }
    const auto before = [](const Cell& a, const Cell& b) { return is_before(a, b); };
    std::sort(cells_.begin(), cells_.end(), before);
    const auto last = std::unique(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) {
        return a.x == b.x && a.y == b.y;
    });
    cells_.erase(last, cells_.end());
}

void FreeSurface::find_regions(const Request& request) {
    const auto find_cell = [&](int x, int y) {
        const Cell wanted{x, y};
        const auto at =
            std::lower_bound(cells_.begin(), cells_.end(), wanted,
                             [](const Cell& a, const Cell& b) { return is_before(a, b); });
        return at != cells_.end() && at->x == x && at->y == y
                   ? static_cast<int>(at - cells_.begin())
                   : -1;
    };
    regions_.clear();
    for (size_t first = 0; first < cells_.size(); ++first) {
        if (cells_[first].region >= 0) continue;
        const int region = static_cast<int>(regions_.size());
        regions_.emplace_back();
        cells_[first].region = region;
        open_.assign(1, static_cast<int>(first));
        while (!open_.empty()) {
            const Cell cell = cells_[static_cast<size_t>(open_.back())];
            open_.pop_back();
            for (int k = 0; k < 9; ++k) {
                const int next = find_cell(cell.x + k % 3 - 1, cell.y + k / 3 - 1);
                if (next < 0 || cells_[static_cast<size_t>(next)].region >= 0) continue;
                cells_[static_cast<size_t>(next)].region = region;
                open_.push_back(next);
            }
        }
    }
    for (const Spot& spot : spots_) {
        Region& region = regions_[region_at(spot.tile[0], spot.tile[1])];
        for (int axis = 0; axis < 2; ++axis) {
            region.low[axis] = std::min(region.low[axis], spot.low[axis]);
            region.high[axis] = std::max(region.high[axis], spot.high[axis]);
        }
    }
    size_t columns = 0, sums = 0, tiles = 0;
    for (Region& region : regions_) {
        for (int axis = 0; axis < 2; ++axis) {
            region.low[axis] = std::max(0, region.low[axis] - reach_);
            region.high[axis] = std::min(request.frame->size[axis] - 1, region.high[axis] + reach_);
        }
        region.first_column = columns;
        region.first_sum = sums;
        region.first_tile = tiles;
        columns += static_cast<size_t>(region.size(0)) * region.size(1);
        sums += static_cast<size_t>(region.size(0) + 1) * (region.size(1) + 1);
        tiles += static_cast<size_t>(region.tile_count(0)) * region.tile_count(1);
    }
    tiles_.assign(tiles, kFar);
    words_.assign(columns, kNotLookedAt);
    nearest_.assign(columns, kNotLookedAt);
    make_room(sums_, sums);
    sums_.resize(sums);
}

size_t FreeSurface::region_at(int tile_x, int tile_y) const {
    if (regions_.size() == 1) return 0;
    const auto at = std::lower_bound(cells_.begin(), cells_.end(), cell_of(tile_x, tile_y),
                                     [](const Cell& a, const Cell& b) { return is_before(a, b); });
    return static_cast<size_t>(at->region);
}

// Marks the tiles within reach of a contact.
void FreeSurface::find_tiles() {
    const int reach = reach_tiles(reach_);
    for (const Spot& spot : spots_) {
        const Region& region = regions_[region_at(spot.tile[0], spot.tile[1])];
        const int nx = region.tile_count(0), ny = region.tile_count(1);
        const int tx = spot.tile[0] - region.tile(0), ty = spot.tile[1] - region.tile(1);
        uint8_t* marks = &tiles_[region.first_tile];
        if (marks[ty * nx + tx] == kWithContacts) continue;
        for (int y = std::max(0, ty - reach); y <= std::min(ny - 1, ty + reach); ++y) {
            for (int x = std::max(0, tx - reach); x <= std::min(nx - 1, tx + reach); ++x) {
                uint8_t& mark = marks[y * nx + x];
                mark = mark == kWithContacts ? kWithContacts : kNearContacts;
            }
        }
        marks[ty * nx + tx] = kWithContacts;
    }
}

void FreeSurface::read_heights(const Region& region, const TileWords& words) {
    const int nx = region.tile_count(0), width = region.size(0);
    for (int ty = 0; ty < region.tile_count(1); ++ty) {
        for (int tx = 0; tx < nx; ++tx) {
            if (tiles_[region.first_tile + static_cast<size_t>(ty * nx + tx)] == kFar) continue;
            const std::span<const int32_t> heights =
                words(region.tile(0) + tx, region.tile(1) + ty);
            const int x0 = (region.tile(0) + tx) * kTileSide - region.low[0];
            const int y0 = (region.tile(1) + ty) * kTileSide - region.low[1];
            for (int y = std::max(0, y0); y < std::min(region.size(1), y0 + kTileSide); ++y) {
                for (int x = std::max(0, x0); x < std::min(width, x0 + kTileSide); ++x) {
                    const int32_t word = heights[(y - y0) * kTileSide + x - x0];
                    const size_t at = region.first_column + static_cast<size_t>(y * width + x);
                    words_[at] = word;
                    nearest_[at] = word >= 0 ? word : kUntold;
                }
            }
        }
    }
}

// A carrier's own top is where its soil ends, as the bed around a heap is; not so what stands above
// all of that soil, as a bed's walls.
void FreeSurface::lay_bare_tops() {
    int32_t highest = 0;
    for (const int32_t word : words_) highest = std::max(highest, word);
    for (size_t i = 0; i < words_.size(); ++i) {
        int32_t& word = words_[i];
        if (word > kBareTop || word <= kBare) continue;
        word = kBareTop - word < highest ? kBareTop - word : kBare;
        if (word >= 0) nearest_[i] = word;
    }
}

// A breadth-first walk from the columns with soil on top over all others, by one step at a time. Of
// several that a column is next to it has the mean: no order of them, and so no axis of the grid,
// says which one is nearest.
void FreeSurface::spread_nearest(const Region& region) {
    const int nx = region.size(0), count = nx * region.size(1);
    int32_t* nearest = &nearest_[region.first_column];
    const auto for_beside = [&](int at, auto&& visit) {
        const int x = at % nx;
        if (x + 1 < nx) visit(at + 1);
        if (x > 0) visit(at - 1);
        if (at + nx < count) visit(at + nx);
        if (at >= nx) visit(at - nx);
    };
    const auto tell_next = [&](int next) {
        if (nearest[next] != kUntold) return;
        nearest[next] = kBeingTold;
        telling_.push_back(next);
    };
    // Few columns are under bodies: the first are found from those.
    telling_.clear();
    for (int at = 0; at < count; ++at) {
        if (nearest[at] != kUntold) continue;
        bool is_beside = false;
        for_beside(at, [&](int next) { is_beside = is_beside || nearest[next] > kBeingTold; });
        if (is_beside) tell_next(at);
    }
    while (!telling_.empty()) {
        heights_.clear();
        for (const int at : telling_) {
            int64_t sum = 0;
            int told = 0;
            for_beside(at, [&](int next) {
                if (nearest[next] <= kBeingTold) return;
                sum += nearest[next];
                ++told;
            });
            heights_.push_back(static_cast<int32_t>(sum / told));
        }
        for (size_t i = 0; i < telling_.size(); ++i) nearest[telling_[i]] = heights_[i];
        std::swap(told_, telling_);
        telling_.clear();
        for (const int at : told_) for_beside(at, tell_next);
    }
    const int32_t* words = &words_[region.first_column];
    for (int at = 0; at < count; ++at) {
        if (!is_terrain_top(words[at])) continue;
        const int32_t own = kTerrainTop - words[at];
        nearest[at] = nearest[at] == kUntold ? own : std::min(own, nearest[at]);
    }
}

// Sums over all free columns of a rectangle are four words of these.
void FreeSurface::sum_up(const Region& region) {
    const int nx = region.size(0), ny = region.size(1);
    const int32_t* words = &words_[region.first_column];
    const int32_t* nearest = &nearest_[region.first_column];
    Sum* above = &sums_[region.first_sum];
    std::fill_n(above, nx + 1, Sum{});
    for (int y = 0; y < ny; ++y) {
        Sum row;
        Sum* sums = above + nx + 1;
        sums[0] = row;
        for (int x = 0; x < nx; ++x) {
            const int32_t word = words[y * nx + x];
            if (word >= 0 || is_terrain_top(word)) {
                row.height += nearest[y * nx + x] / 65536.0;
                row.count += 1;
            } else if (word > kBareTop) {
                row.covered_height += (kCovered - word) / 65536.0;
                row.covered_count += 1;
            }
            sums[x + 1] = above[x + 1] + row;
        }
        above = sums;
    }
}

// Bilinear lookup in the summed-area table.
FreeSurface::Sum FreeSurface::sum_below(const Region& region, double x, double y) const {
    const int nx = region.size(0), ny = region.size(1);
    const int ix = std::min(static_cast<int>(x), nx - 1),
              iy = std::min(static_cast<int>(y), ny - 1);
    const double fx = x - ix, fy = y - iy;
    const Sum* low = &sums_[region.first_sum + static_cast<size_t>(iy * (nx + 1) + ix)];
    const Sum* high = low + nx + 1;
    return ((low[0] * (1 - fx) + low[1] * fx) * (1 - fy)) +
           ((high[0] * (1 - fx) + high[1] * fx) * fy);
}

// The ground that a contact's voxel lies below; `otherwise` where all soil lies under bodies. A
// wall's begins where it looks: a thin blade has other ground behind it, which is as near. wall,
// ahead: share of the normal that is a wall's, and its level part.
double FreeSurface::nearest_beside(const ContactRecord& contact, double otherwise, double wall,
                                   Vec3 ahead) const {
    const Region& region = region_of(contact);
    const int place[2] = {contact.voxel[0] - region.low[0], contact.voxel[1] - region.low[1]};
    const int nx = region.size(0), at = place[1] * nx + place[0];
    const int32_t* nearest = &nearest_[region.first_column];
    const int32_t* words = &words_[region.first_column];
    const int32_t here = nearest[at];
    if (here < 0) return otherwise;
    const double level = ahead.x * ahead.x + ahead.y * ahead.y;
    // A sole, as of a wheel's rim, has what lies around it.
    const double upright = std::clamp(2 * wall - 1, 0.0, 1.0);
    if (is_open(words[at]) || !(upright * level > 0)) return here / 65536.0;
    const auto along = [&](int axis, double part) {
        const int way = part > 0 ? 1 : -1, step = way * (axis == 0 ? 1 : nx);
        for (int n = 1; n <= kAheadColumns; ++n) {
            const int column = place[axis] + n * way;
            if (column < 0 || column >= region.size(axis)) break;
            if (is_open(words[at + n * step])) return nearest[at + n * step];
        }
        return here;
    };
    const double before =
        (ahead.x * ahead.x * along(0, ahead.x) + ahead.y * ahead.y * along(1, ahead.y)) / level;
    return ((1 - upright) * here + upright * before) / 65536.0;
}

SurfaceWedge::Found FreeSurface::wedge_before(const ContactRecord& contact, Vec3 at, Vec3 outward,
                                              double nearest) const {
    const double depth = nearest - at.z;
    const double level = std::hypot(outward.x, outward.y);
    if (!(depth > 0) || !(level > 0)) return {std::max(0.0, depth), 1};
    const double ahead_x = outward.x / level, ahead_y = outward.y / level;
    const Region& region = region_of(contact);
    return wedges_[static_cast<size_t>(contact.material)].find(depth, [&](const SurfaceWedge::Runs&
                                                                              x) {
        SurfaceWedge::Runs heights = ground_along(region, at, {ahead_x, ahead_y, 0}, x, nearest);
        for (double& height : heights) height -= at.z;
        return heights;
    });
}

// In loops of which the compiler makes vectors: no height hangs on the one before, but where nobody
// has looked.
SurfaceWedge::Runs FreeSurface::ground_along(const Region& region, Vec3 from, Vec3 ahead,
                                             const SurfaceWedge::Runs& x, double nearest) const {
    constexpr size_t kCount = SurfaceWedge::kRunCount;
    const double low_x = region.low[0], low_y = region.low[1];
    SurfaceWedge::Runs u, v;
    for (size_t k = 0; k < kCount; ++k) {
        u[k] = from.x + ahead.x * x[k] - low_x - 0.5;
        v[k] = from.y + ahead.y * x[k] - low_y - 0.5;
    }
    const int width = region.size(0);
    const double u_most = width - 1, v_most = region.size(1) - 1;
    const auto is_inside = [&](size_t k) {
        return u[k] >= 0 && v[k] >= 0 && u[k] < u_most && v[k] < v_most;
    };
    // The way is straight: it leaves the rectangle once, and may come into it once before.
    size_t first = 0, last = kCount;
    while (first < last && !is_inside(first)) ++first;
    while (first < last && !is_inside(last - 1)) --last;
    std::array<int32_t, kCount> ix, iy;
    for (size_t k = 0; k < kCount; ++k) {  // outside of the rectangle none is asked for
        ix[k] = static_cast<int32_t>(std::clamp(u[k], 0.0, u_most));
        iy[k] = static_cast<int32_t>(std::clamp(v[k], 0.0, v_most));
    }
    std::array<std::array<int32_t, kCount>, 4> corner{};
    std::array<int32_t, kCount> told;
    told.fill(-1);
    for (size_t k = first; k < last; ++k) {
        const int32_t* low =
            &nearest_[region.first_column + static_cast<size_t>(iy[k] * width + ix[k])];
        const int32_t* high = low + width;
        corner[0][k] = low[0];
        corner[1][k] = low[1];
        corner[2][k] = high[0];
        corner[3][k] = high[1];
        told[k] = low[0] | low[1] | high[0] | high[1];
    }
    SurfaceWedge::Runs height;
    for (size_t k = 0; k < kCount; ++k) {
        const double fx = u[k] - ix[k], fy = v[k] - iy[k];
        height[k] = ((corner[0][k] * (1 - fx) + corner[1][k] * fx) * (1 - fy) +
                     (corner[2][k] * (1 - fx) + corner[3][k] * fx) * fy) /
                    65536.0;
    }
    double before = nearest;
    for (size_t k = 0; k < kCount; ++k) {
        if (told[k] < 0) height[k] = before;
        before = height[k];
    }
    return height;
}

FreeSurface::Beside FreeSurface::height_beside(const ContactRecord& contact, Vec3 at,
                                               Vec3 outward) const {
    const int x = contact.voxel[0], y = contact.voxel[1];
    const auto body = static_cast<size_t>(contact.body);
    const Region& region = region_of(contact);
    // Before a wall the wedge counts, under a sole what lies around it as far as it is wide.
    const auto [sole, wall] = surface_parts(outward);
    const double nearest = nearest_beside(contact, at.z, wall, outward);
    const double wedge =
        wedge_length_[static_cast<size_t>(contact.material)] * std::max(0.0, nearest - at.z);
    const double rim = law_->sole_surroundings_widths * body_width_[body];
    const double half = std::max(1.0, wall * wedge / 2 + sole * rim);
    const double cx = at.x + outward.x * wedge / 2, cy = at.y + outward.y * wedge / 2;
    // Nothing beyond this contact's own reach counts, wherever other bodies are. A column at the
    // border counts by the part of it that lies inside: a blade that moves on by a voxel must not
    // feel the border.
    const double reach =
        std::clamp(wall * wedge + sole * rim, static_cast<double>(kReach), body_reach_[body]);
    const auto clip = [&](double v, int column, int axis) {
        const double near = std::clamp(v, column - reach, column + reach);
        return std::clamp(near - region.low[axis], 0.0, static_cast<double>(region.size(axis)));
    };
    const double x0 = clip(cx - half, x, 0), x1 = clip(cx + half, x, 0);
    const double y0 = clip(cy - half, y, 1), y1 = clip(cy + half, y, 1);
    const Sum inside = sum_below(region, x1, y1) - sum_below(region, x0, y1) -
                       sum_below(region, x1, y0) + sum_below(region, x0, y0);
    if (inside.count < kHardlyAny) return {nearest, nearest};
    // The soil that a sole has pressed out is a rim within one width of it. Hollow and rim together
    // are as high as the soil was. Where the rim is out of reach or under other bodies (links of a
    // track), the hollow counts by the part of the rim that is seen. A wall has no hollow: its soil
    // lies before it.
    const double wanted = 4 * half * half;
    const double seen = std::min(1.0, (x1 - x0) * (y1 - y0) / wanted);
    const double apart = std::min(1.0, inside.count / std::max(1.0, inside.covered_count));
    const double share = own_rim_share(law_->hollow_share * sole * seen, apart);
    return {(inside.height + share * inside.covered_height) /
                (inside.count + share * inside.covered_count),
            nearest};
}

}  // namespace bsoil
