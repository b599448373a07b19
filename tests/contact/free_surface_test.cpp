// Where depths are measured from: beds drawn by hand with depths in metres, and random ones against
// the oracle.
#include "contact/free_surface.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "base/layout.h"
#include "oracle/free_surface.h"

namespace bsoil::free_surface_test {
namespace {

using namespace layout;
using oracle::SurfaceColumn;
using Top = SurfaceColumn::Top;

constexpr double kVoxelM = 0.05;
constexpr int kSide = 64;  // columns

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kPhi = 33 * kDegree, kWall = 22 * kDegree;

/// A bed, column by column, and the free surface that the soil's code finds over it.
class Bed {
  public:
    explicit Bed(const std::function<SurfaceColumn(int x, int y)>& column) {
        map_.nx = map_.ny = kSide;
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x) map_.columns.push_back(column(x, y));
        }
        frame_.size[0] = frame_.size[1] = kSide;
        frame_.size[2] = 64;
        frame_.voxel_m = kVoxelM;
    }
    const oracle::SurfaceMap& map() const { return map_; }

    double sole_width = 4;    ///< of the body [voxels]
    double wedge_length = 2;  ///< over its depth
    SurfaceWedge wedge{std::tan(kPhi), std::tan(kWall)};
    /// Other contacts of the body may lie as deep as this: they decide how far it looks.
    int lowest = 10;
    ContactLawDef law;

    /// Height [voxels] that counts at a place.
    double height(Vec3 at, Vec3 outward) {
        return surface_.height_beside(find(at), at, outward).height;
    }
    /// Depth [voxels] of level ground that pushes a wall there as hard.
    double wedge_depth(Vec3 at, Vec3 outward) { return wedge_before(at, outward).level_depth; }
    double depth_m(Vec3 at, Vec3 outward) { return (height(at, outward) - at.z) * kVoxelM; }

    double inflow_share(Vec3 at, Vec3 outward) { return wedge_before(at, outward).inflow_share; }

  private:
    SurfaceWedge::Found wedge_before(Vec3 at, Vec3 outward) {
        const ContactRecord contact = find(at);
        const double nearest = surface_.height_beside(contact, at, outward).nearest;
        return surface_.wedge_before(contact, at, outward, nearest);
    }
    ContactRecord find(Vec3 at) {
        ContactRecord contact;
        contact.voxel[0] = static_cast<int>(at.x);
        contact.voxel[1] = static_cast<int>(at.y);
        contact.voxel[2] = static_cast<int>(at.z);
        contact.carrier = kOnGround;
        ContactRecord deepest = contact;
        deepest.voxel[2] = lowest;
        const ContactRecord contacts[] = {contact, deepest};
        surface_.find({contacts, {&sole_width, 1}, &frame_, &law, {&wedge_length, 1}, {&wedge, 1}},
                      [this](int tx, int ty) { return words_of(tx, ty); });
        return contact;
    }

    std::span<const int32_t> words_of(int tx, int ty) {
        for (int c = 0; c < kTileColumns; ++c) {
            const SurfaceColumn& column =
                map_.at(tx * kTileSide + c % kTileSide, ty * kTileSide + c / kTileSide);
            const auto q16 = static_cast<int32_t>(std::lround(column.height * 65536));
            words_[static_cast<size_t>(c)] = column.top == Top::soil   ? q16
                                             : column.top == Top::body ? kCovered - q16
                                                                       : kTerrainTop - q16;
        }
        return words_;
    }

    oracle::SurfaceMap map_;
    GridFrame frame_;
    FreeSurface surface_;
    std::array<int32_t, kTileColumns> words_{};
};

constexpr Vec3 kAhead{1, 0, 0}, kBehind{-1, 0, 0}, kAside{0, 1, 0}, kDown{0, 0, -1};

TEST(FreeSurface, flat_bed_has_one_depth_for_every_face) {
    Bed bed([](int, int) { return SurfaceColumn{Top::soil, 20}; });
    for (const Vec3 outward : {kAhead, kBehind, kAside, kDown, Vec3{0.6, 0, -0.8}}) {
        EXPECT_NEAR(bed.depth_m({32.3, 31.8, 14}, outward), 0.30, 1e-9);
    }
}

TEST(FreeSurface, on_a_slope_a_wall_has_the_depth_at_the_middle_of_its_wedge) {
    // Rises by 0.2 voxels a column along x; 20 at x = 32.
    Bed bed([](int x, int) { return SurfaceColumn{Top::soil, 20 + 0.2 * (x + 0.5 - 32)}; });
    // Columns are steps of 0.2 voxels; half of one is 5 mm.
    const double step_m = 0.1 * kVoxelM;
    // Soil above the wall's foot: 4 voxels, so a wedge of 8; its middle is 4 columns ahead.
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kAhead), (4 + 0.8) * kVoxelM, step_m);
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kBehind), (4 - 0.8) * kVoxelM, step_m);
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kAside), 4 * kVoxelM, step_m);
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kDown), 4 * kVoxelM, 1e-9);
}

TEST(FreeSurface, a_heap_counts_for_the_wall_that_pushes_it) {
    // 4 voxels of heap from 4 columns ahead on.
    Bed bed([](int x, int) { return SurfaceColumn{Top::soil, x < 36 ? 20.0 : 24.0}; });
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kAhead), 0.30, 1e-9);  // half of the wedge lies in it
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kBehind), 0.20, 1e-9);
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kAside), 0.20, 1e-9);
    // A wedge half as long ends where the heap begins.
    bed.wedge_length = 1;
    EXPECT_NEAR(bed.depth_m({32, 32, 16}, kAhead), 0.20, 1e-9);
}

// Behind a blade that is drawn along the soil lies low, and is as near to some of its voxels. The
// wedge is as long as the heap is high where it begins: 20 columns for 10 voxels, of which 16 are
// in reach. By the mean of both sides it would be 12.
TEST(FreeSurface, a_thin_wall_meets_the_ground_before_it_and_not_that_behind) {
    Bed bed([](int x, int) {
        return x < 30   ? SurfaceColumn{Top::soil, 18}
               : x < 33 ? SurfaceColumn{Top::body, 20}
                        : SurfaceColumn{Top::soil, x < 41 ? 26.0 : 20.0};
    });
    for (const double x : {30.5, 31.5, 32.5}) {
        SCOPED_TRACE(x);
        const double low_columns = std::floor(x) + 16 - 41;
        const double mean = (8 * 26 + low_columns * 20) / (8 + low_columns);
        EXPECT_NEAR(bed.depth_m({x, 32, 16}, kAhead), (mean - 16) * kVoxelM, 1e-9);
        EXPECT_NEAR(bed.depth_m({x, 32, 16}, kBehind), 2 * kVoxelM, 1e-9);
    }
}

TEST(FreeSurface, a_rut_and_its_rims_have_the_level_that_the_soil_had) {
    // Pressed down by 2 voxels over 4 columns; as much stands on the 4 beside them.
    Bed bed([](int x, int) {
        const bool is_hollow = x >= 30 && x < 34, is_rim = x >= 28 && x < 36;
        return is_hollow ? SurfaceColumn{Top::body, 18}
                         : SurfaceColumn{Top::soil, is_rim ? 22.0 : 20.0};
    });
    EXPECT_NEAR(bed.depth_m({32, 32, 18}, kDown), 0.10, 1e-9);
    // A wall beside the rut has its rim and not its hollow: 2 columns of 22 and 6 of 20.
    EXPECT_NEAR(bed.depth_m({34, 32, 18}, kAhead), 2.5 * kVoxelM, 1e-9);
    // A sole that looks no further than its own rim measures from that.
    bed.sole_width = 8.0 / 3;  // 1.5 of it: 4 columns either way
    EXPECT_NEAR(bed.depth_m({32, 32, 18}, kDown), 0.10, 1e-9);
    // One that sees twice as much hollow as rim counts a quarter of the hollow.
    bed.sole_width = 2;
    EXPECT_NEAR(bed.depth_m({32, 32, 18}, kDown), ((2 * 22 + 4 * 18 / 4.0) / 3 - 18) * kVoxelM,
                1e-9);
}

TEST(FreeSurface, a_sole_looks_as_far_around_as_the_law_says) {
    // A ditch runs 5 columns beside the middle of a sole that is 4 wide.
    Bed bed([](int x, int) { return SurfaceColumn{Top::soil, x < 37 ? 20.0 : 16.0}; });
    bed.law.sole_surroundings_widths = 1.25;
    EXPECT_NEAR(bed.depth_m({32, 32, 15}, kDown), 0.25, 1e-9);
    bed.law.sole_surroundings_widths = 2.5;  // 10 columns either way, 5 of 20 lie in the ditch
    EXPECT_NEAR(bed.depth_m({32, 32, 15}, kDown), 0.20, 1e-9);
}

TEST(FreeSurface, a_slabs_edge_is_no_overburden) {
    Bed high([](int x, int) {
        return x < 34 ? SurfaceColumn{Top::soil, 20} : SurfaceColumn{Top::terrain, 30};
    });
    EXPECT_NEAR(high.depth_m({32, 32, 16}, kAhead), 0.20, 1e-9);
    EXPECT_NEAR(high.depth_m({32, 32, 16}, kDown), 0.20, 1e-9);
    // Where the slab lies lower than the bed, the bed ends there: 2 columns of 20 and 6 of 17.
    Bed low([](int x, int) {
        return x < 34 ? SurfaceColumn{Top::soil, 20} : SurfaceColumn{Top::terrain, 17};
    });
    EXPECT_NEAR(low.depth_m({32, 32, 16}, kAhead), 1.75 * kVoxelM, 1e-9);
    EXPECT_NEAR(low.depth_m({32, 32, 16}, kBehind), 0.20, 1e-9);
}

TEST(FreeSurface, a_lug_under_a_wheel_has_the_soil_on_its_own_side) {
    // The wheel stands over 12 columns; soil is 22 high before it and 20 behind it.
    Bed bed([](int x, int) {
        if (x >= 26 && x < 38) return SurfaceColumn{Top::body, 15};
        return SurfaceColumn{Top::soil, x < 26 ? 22.0 : 20.0};
    });
    EXPECT_NEAR(bed.depth_m({28, 32, 18}, kBehind), 0.20, 1e-9);
    EXPECT_NEAR(bed.depth_m({36, 32, 18}, kAhead), 0.10, 1e-9);
}

TEST(FreeSurface, a_body_under_which_all_lies_has_the_nearest_soil) {
    Bed bed([](int x, int) {
        return x < 2 ? SurfaceColumn{Top::soil, 21} : SurfaceColumn{Top::body, 3};
    });
    bed.wedge_length = 0.5;
    EXPECT_NEAR(bed.depth_m({14, 32, 17}, kAhead), 0.20, 1e-9);
}

TEST(SurfaceWedge, of_level_ground_is_as_deep_as_that) {
    Bed bed([](int, int) { return SurfaceColumn{Top::soil, 20}; });
    for (const double z : {19.9, 18.0, 11.0}) {
        EXPECT_NEAR(bed.wedge_depth({32.3, 31.8, z}, kAhead), 20 - z, 1e-9);
        EXPECT_NEAR(bed.inflow_share({32.3, 31.8, z}, kAhead), 1, 1e-9);
        EXPECT_NEAR(bed.wedge_depth({32.3, 31.8, z}, {0.6, 0.5, -0.62}), 20 - z, 1e-9);
    }
    EXPECT_EQ(bed.wedge_depth({32, 32, 21}, kAhead), 0);
}

// Coulomb's coefficient over sloping ground, in closed form (Mueller-Breslau 1906), as long as its
// plane rises.
TEST(SurfaceWedge, of_a_slope_is_that_of_coulombs_coefficient) {
    const auto coefficient = [](double slope_rad) {
        const double root = std::sqrt(std::sin(kPhi + kWall) * std::sin(kPhi + slope_rad) /
                                      (std::cos(kWall) * std::cos(slope_rad)));
        return 1 / ((1 - root) * (1 - root));
    };
    for (const double slope_deg : {-16.0, -10.0, -5.0, -1.0, 8.0}) {
        const double rise = std::tan(slope_deg * kDegree), depth = 6;
        Bed bed([&](int x, int) { return SurfaceColumn{Top::soil, 22 + rise * (x + 0.5 - 20)}; });
        const double wanted = depth * coefficient(slope_deg * kDegree) / coefficient(0);
        const double found = bed.wedge_depth({20.5, 32, 22 + 0.5 * rise - depth}, kAhead);
        // Where ground rises the plane comes out beyond what a body looks at.
        EXPECT_LT(found, 1.03 * wanted) << slope_deg;
        EXPECT_GT(found, slope_deg < 0 ? 0.97 * wanted : depth) << slope_deg;
    }
}

// A heap at phi before a wall that cuts into level ground; by the least of some thousand planes.
TEST(SurfaceWedge, of_a_heap_is_that_of_the_easiest_plane) {
    for (const double cut : {0.0, 2.0, 5.0}) {
        const double heap = 8, level = 12;
        const auto ground = [&](double x) {
            return level + std::max(0.0, heap - std::tan(kPhi) * x);
        };
        Bed bed([&](int x, int) { return SurfaceColumn{Top::soil, ground(x + 0.5 - 10.5)}; });
        const double depth = heap + cut, foot = level - cut;
        const double wanted =
            oracle::wedge_depth([&](double x) { return ground(x) - foot; }, depth, kPhi, kWall);
        EXPECT_NEAR(bed.wedge_depth({10.5, 32, foot}, kAhead), wanted, 0.04 * wanted) << cut;
        EXPECT_LT(wanted, 0.4 * depth);  // of level ground: all of it
        // New soil comes in below the old level alone.
        EXPECT_NEAR(bed.inflow_share({10.5, 32, foot}, kAhead), cut > 0 ? 1 : 0, 0.05) << cut;
    }
}

// Whichever way the wall looks, and with the columns behind it under its body.
TEST(SurfaceWedge, of_a_heap_does_not_hang_on_the_grid) {
    const double heap = 8, level = 12, cut = 2, depth = heap + cut, foot = level - cut;
    const auto ground = [&](double x) { return level + std::max(0.0, heap - std::tan(kPhi) * x); };
    const double wanted =
        oracle::wedge_depth([&](double x) { return ground(x) - foot; }, depth, kPhi, kWall);
    for (const double yaw_deg : {0.0, 22.5, 45.0, 70.0}) {
        const double c = std::cos(yaw_deg * kDegree), s = std::sin(yaw_deg * kDegree);
        Bed bed([&](int x, int y) {
            const double ahead = c * (x + 0.5 - 20.2) + s * (y + 0.5 - 20.4);
            return ahead < 0 ? SurfaceColumn{Top::body, 5.0}
                             : SurfaceColumn{Top::soil, ground(ahead)};
        });
        double sum = 0;
        for (int k = 0; k < 8; ++k) {
            sum += bed.wedge_depth({20.2 - s * k, 20.4 + c * k, foot}, {c, s, 0}) / 8;
        }
        EXPECT_NEAR(sum, wanted, 0.06 * wanted) << yaw_deg;
    }
}

/// Level ground that pushes as hard as the easiest of the planes that are tried, one after the
/// other, over ground of which nothing is known outside of a square.
double wedge_by_planes(const oracle::SurfaceMap& map, Vec3 at, Vec3 ahead) {
    const double t = std::tan(kPhi), w = std::tan(kWall);
    const auto push = [&](double slope) {
        const double inclined = (slope + t) / (1 - slope * t);
        return 1 - slope * t > 0 && 1 - inclined * w > 0 ? inclined / (1 - inclined * w) : 1e300;
    };
    double before = map.at(static_cast<int>(at.x), static_cast<int>(at.y)).height;
    const double depth = before - at.z;
    const auto height = [&](double x) {
        const double u = at.x + ahead.x * x - 0.5, v = at.y + ahead.y * x - 0.5;
        if (u < 0 || v < 0 || u >= kSide - 1 || v >= kSide - 1) return before;
        const int i = static_cast<int>(u), j = static_cast<int>(v);
        const auto along = [&](int row) {
            return std::lerp(map.at(i, row).height, map.at(i + 1, row).height, u - i);
        };
        return before = std::lerp(along(j), along(j + 1), v - j);
    };
    double least = 1e300, level = 1e300, lowest = 1e300, area = 0, last_x = 0, last = depth;
    for (int k = 0; k < 17; ++k) {  // each a fourth root of 2 further
        const double run = 0.5 * std::pow(2, k / 4.0);
        level = std::min(level, run * push(1 / run));
    }
    for (int k = 0; k < 17; ++k) {
        const double x = 0.5 * std::pow(2, k / 4.0) * depth, here = height(x) - at.z;
        if (here <= 0) {
            const double ends = last_x + (x - last_x) * last / (last - here);
            return 2 * std::min(least, (area + last * (ends - last_x) / 2) * push(0)) /
                   (depth * level);
        }
        area += (last + here) / 2 * (x - last_x);
        if (here / x <= lowest) {
            lowest = here / x;
            least = std::min(least, (area - here * x / 2) * push(lowest));
        }
        last_x = x;
        last = here;
    }
    return 2 * least / (depth * level);
}

TEST(SurfaceWedge, random_beds_have_the_easiest_of_all_planes) {
    int beyond = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        std::mt19937 random(seed);
        const auto uniform = [&random](double low, double high) {
            return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
        };
        const double rough = uniform(0, 4);
        Bed bed([&](int, int) {
            return SurfaceColumn{Top::soil,
                                 std::floor((20 + uniform(-rough, rough)) * 65536) / 65536};
        });
        bed.lowest = 2;  // so that it looks at all columns
        bed.wedge_length = 20;
        for (int k = 0; k < 20; ++k) {
            const double turn = uniform(0, 2 * std::numbers::pi);
            const Vec3 ahead{std::cos(turn), std::sin(turn), 0};
            const Vec3 at{uniform(1, kSide - 1), uniform(1, kSide - 1), uniform(8, 15.9)};
            const double wanted = wedge_by_planes(bed.map(), at, ahead);
            EXPECT_NEAR(bed.wedge_depth(at, ahead), wanted, 1e-9 * wanted) << seed << ", " << k;
            const double end = 8 * (20 - at.z);
            const double x = at.x + end * ahead.x, y = at.y + end * ahead.y;
            beyond += std::min(x, y) < 0 || std::max(x, y) > kSide ? 1 : 0;
        }
    }
    EXPECT_GT(beyond, 200);  // of 800
    EXPECT_LT(beyond, 790);
}

TEST(FreeSurface, random_beds_as_the_oracle_has_them) {
    for (unsigned seed = 1; seed <= 60; ++seed) {
        std::mt19937 random(seed);
        const auto uniform = [&random](double low, double high) {
            return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
        };
        // Heights in whole 1/65536 voxel.
        Bed bed([&](int, int) {
            const double what = uniform(0, 1);
            SurfaceColumn column{what < 0.6 ? Top::soil : what < 0.9 ? Top::body : Top::terrain, 0};
            column.height = column.top == Top::terrain ? uniform(0, 10) : uniform(12, 30);
            column.height = std::floor(column.height * 65536) / 65536;
            return column;
        });
        bed.sole_width = uniform(0.5, 14);
        bed.wedge_length = uniform(1.2, 2.2);
        bed.lowest = 4;
        for (int k = 0; k < 10; ++k) {
            const double turn = uniform(0, 2 * std::numbers::pi), rise = uniform(-1, 0.3);
            const double level = std::sqrt(1 - rise * rise);
            const Vec3 outward{level * std::cos(turn), level * std::sin(turn), rise};
            const Vec3 at{uniform(0.1, kSide - 0.1), uniform(0.1, kSide - 0.1), uniform(5, 25)};
            oracle::SurfacePiece piece;
            piece.x = static_cast<int>(at.x);
            piece.y = static_cast<int>(at.y);
            piece.at = at;
            piece.outward = outward;
            piece.body_width = bed.sole_width;
            piece.wedge_length = bed.wedge_length;
            // As far as the wedge over all of the body's contacts, or its rim.
            const int range = std::abs(static_cast<int>(at.z) - bed.lowest) + 1;
            piece.reach_most = std::clamp(
                std::ceil(std::max(bed.wedge_length * range, 1.5 * bed.sole_width)), 16.0, 256.0);
            const std::optional<double> expected = oracle::free_surface(bed.map(), piece);
            ASSERT_TRUE(expected);
            // Sums over 4,096 columns of heights up to 30, in double precision.
            EXPECT_NEAR(bed.height(at, outward), *expected, 1e-9)
                << "seed " << seed << ", piece " << k;
        }
    }
}

// Two bodies at the ends of a grid as large as one may be: what lies between them is neither read
// nor held, and each finds what it finds alone.
TEST(FreeSurface, costs_what_lies_around_the_bodies) {
    GridFrame frame;
    frame.size[0] = frame.size[1] = 8192;
    frame.size[2] = 64;
    const ContactLawDef law;
    const double width = 4, wedge_length = 2;
    const SurfaceWedge wedge{std::tan(kPhi), std::tan(kWall)};
    std::array<int32_t, kTileColumns> words{};
    int read_count = 0;
    const auto words_of = [&](int tx, int ty) -> std::span<const int32_t> {
        ++read_count;
        for (int c = 0; c < kTileColumns; ++c) {
            words[static_cast<size_t>(c)] =
                (20 << 16) + 3000 * (tx % 7 + c % 8) + 2000 * (ty % 5 + c / 8);
        }
        return words;
    };
    std::vector<ContactRecord> contacts;
    for (const auto& [x, y] : {std::pair{30, 40}, {8160, 8150}, {4000, 30}, {4040, 30}}) {
        ContactRecord contact;
        contact.voxel[0] = x;
        contact.voxel[1] = y;
        contact.voxel[2] = 16;
        contact.carrier = kOnGround;
        contacts.push_back(contact);
    }
    const auto found = [&](std::span<const ContactRecord> known, FreeSurface& surface) {
        std::vector<double> heights;
        surface.find({known, {&width, 1}, &frame, &law, {&wedge_length, 1}, {&wedge, 1}}, words_of);
        for (const ContactRecord& contact : known) {
            const Vec3 at{contact.voxel[0] + 0.4, contact.voxel[1] + 0.3, 16.5};
            for (const Vec3 outward : {kAhead, kAside, kDown}) {
                const FreeSurface::Beside beside = surface.height_beside(contact, at, outward);
                heights.push_back(beside.height);
                heights.push_back(
                    surface.wedge_before(contact, at, outward, beside.nearest).level_depth);
            }
        }
        return heights;
    };
    FreeSurface surface;
    const std::vector<double> all = found(contacts, surface);
    EXPECT_LE(read_count, 4 * 5 * 5);
    std::vector<double> alone;
    for (const std::span<const ContactRecord> some :
         {std::span(contacts).first(1), std::span(contacts).subspan(1, 1),
          std::span(contacts).subspan(2)}) {
        FreeSurface other;
        for (const double height : found(some, other)) alone.push_back(height);
    }
    EXPECT_EQ(all, alone);
}
}  // namespace
}  // namespace bsoil::free_surface_test
