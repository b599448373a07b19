#include "contact/tooth_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace bsoil {
namespace {

/// Lengths no further apart than this share of the base's size are the same. Ours: drawings and
/// exports round, a wheel's lugs differ by more where they are meant to. Larger: two sizes of lug
/// count as one row; smaller: a rounded export falls apart into rows of one tooth.
constexpr double kSame = 0.01;
/// A root no further above the base than this share of its size touches it. Ours: half a millimetre
/// of a wheel of 0.5 m, the rounding of a file in single precision with room. Larger: parts beside
/// a base count as its teeth.
constexpr double kTouches = 1e-3;
/// What is more times as wide as its base is no tooth of it. Ours: lugs overhang a rim by some
/// millimetres; an axle or a fender is wider. Larger: those become teeth.
constexpr double kWidest = 1.25;
/// A hull with more planes is no tooth. Ours: a box has 6, with all its edges cut off 18. More:
/// corners are found by trying every three planes, which takes their cube in time.
constexpr size_t kToothPlanes = 24;
/// Three planes with a smaller determinant of their normals meet in no corner, and a corner no
/// further outside of a plane [m] is on it. Ours: for the rounding. Larger: slender corners are
/// lost.
constexpr double kPlaneSlack = 1e-6;

struct Range {
    double low = 1e300, high = -1e300;
    void add(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
    double size() const { return high - low; }
    double middle() const { return (low + high) / 2; }
};

Vec3 solved(const Plane& a, const Plane& b, const Plane& c, double rounding_m, double volume) {
    const Vec3 sum = (a.offset + rounding_m) * cross(b.normal, c.normal) +
                     (b.offset + rounding_m) * cross(c.normal, a.normal) +
                     (c.offset + rounding_m) * cross(a.normal, b.normal);
    return sum * (1 / volume);
}

/// Corners in the body's frame; none of what is no box and no hull of few planes.
std::vector<Vec3> corners_of(const ConvexShape& shape) {
    std::vector<Vec3> out;
    if (shape.kind == ConvexShape::Kind::box) {
        const double g = shape.rounding_m;
        const Vec3 h = shape.half_extents_m + Vec3{g, g, g};
        for (int i = 0; i < 8; ++i) {
            out.push_back(transform(shape.local,
                                    {i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z}));
        }
    } else if (shape.kind == ConvexShape::Kind::hull && shape.planes.size() <= kToothPlanes) {
        const auto& planes = shape.planes;
        for (size_t i = 0; i < planes.size(); ++i) {
            for (size_t j = i + 1; j < planes.size(); ++j) {
                for (size_t k = j + 1; k < planes.size(); ++k) {
                    const double volume =
                        dot(planes[i].normal, cross(planes[j].normal, planes[k].normal));
                    if (std::abs(volume) < kPlaneSlack) continue;
                    const Vec3 p =
                        solved(planes[i], planes[j], planes[k], shape.rounding_m, volume);
                    const bool is_corner =
                        std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
                            return dot(plane.normal, p) <=
                                   plane.offset + shape.rounding_m + kPlaneSlack;
                        });
                    if (is_corner) out.push_back(transform(shape.local, p));
                }
            }
        }
    }
    return out;
}

/// A shape that stands out of a base.
struct Tooth {
    size_t shape = 0;
    double place = 0, height_m = 0, thickness_m = 0, from_m = 0, to_m = 0;
    bool is_like(const Tooth& o, double slack_m) const {
        return std::abs(height_m - o.height_m) < slack_m &&
               std::abs(thickness_m - o.thickness_m) < slack_m &&
               std::abs(from_m - o.from_m) < slack_m && std::abs(to_m - o.to_m) < slack_m;
    }
};

bool stands_on_mantle(const std::vector<Vec3>& corners, double radius_m, double half_m,
                      Tooth& tooth) {
    Vec3 middle;
    for (const Vec3& p : corners) middle += Vec3{p.x, p.y, 0};
    if (!(length(middle) > 0)) return false;
    const Vec3 out = middle * (1 / length(middle)), around{-out.y, out.x, 0};
    Range radial, thick, along;
    for (const Vec3& p : corners) {
        radial.add(dot(p, out));
        thick.add(dot(p, around));
        along.add(p.z);
    }
    tooth.place = std::atan2(out.y, out.x);
    tooth.height_m = radial.high - radius_m;
    tooth.thickness_m = thick.size();
    if (along.size() > kWidest * 2 * half_m) return false;
    tooth.from_m = std::max(along.low, -half_m);
    tooth.to_m = std::min(along.high, half_m);
    return radial.low > 0 && radial.low <= (1 + kTouches) * radius_m &&
           tooth.height_m > kSame * radius_m && tooth.height_m <= radius_m / 2 &&
           tooth.thickness_m <= radius_m && tooth.to_m - tooth.from_m >= half_m;
}

bool stands_on_side(const std::vector<Vec3>& corners, const ToothedFace& side, double across_m,
                    Tooth& tooth) {
    Range out, along, across;
    for (const Vec3& p : corners) {
        out.add(dot(p, side.out));
        along.add(dot(p, side.along));
        across.add(dot(p, side.across));
    }
    tooth.place = along.middle();
    tooth.height_m = out.high - side.level_m;
    tooth.thickness_m = along.size();
    if (across.size() > kWidest * 2 * across_m) return false;
    tooth.from_m = std::max(across.low, -across_m);
    tooth.to_m = std::min(across.high, across_m);
    return out.low <= side.level_m + kTouches * side.half_m &&
           tooth.height_m > kSame * side.half_m && tooth.height_m <= side.half_m &&
           tooth.thickness_m <= side.half_m && std::abs(tooth.place) <= side.half_m &&
           tooth.to_m - tooth.from_m >= across_m;
}

void add_rows(std::vector<Tooth> teeth, const ToothedFace& base, std::vector<ToothedFace>& out) {
    const double slack_m = kSame * (base.is_mantle ? base.level_m : base.half_m);
    while (!teeth.empty()) {
        ToothedFace row = base;
        const Tooth first = teeth.front();
        row.height_m = first.height_m;
        row.thickness_m = first.thickness_m;
        row.from_m = first.from_m;
        row.to_m = first.to_m;
        std::vector<Tooth> others;
        for (const Tooth& tooth : teeth) {
            if (!tooth.is_like(first, slack_m)) {
                others.push_back(tooth);
                continue;
            }
            row.shapes.push_back(tooth.shape);
            row.places.push_back(tooth.place);
        }
        teeth.swap(others);
        std::vector<double> places = row.places;
        std::sort(places.begin(), places.end());
        double widest = base.is_mantle ? places.front() + 2 * std::numbers::pi - places.back() : 0;
        for (size_t i = 1; i < places.size(); ++i) {
            widest = std::max(widest, places[i] - places[i - 1]);
        }
        const auto count = static_cast<double>(places.size());
        row.pitch_m =
            (base.is_mantle ? 2 * std::numbers::pi * base.level_m : 2 * base.half_m) / count;
        // Gaps of a row are no wider than this many pitches. Ours: a row with one tooth in three
        // missing has gaps of 4/3. Larger: two groups of teeth count as one row.
        constexpr double kEvenly = 1.4;
        const bool is_row =
            base.is_mantle ? count >= 5 && widest <= std::numbers::pi / 2
                           : widest <= kEvenly * row.pitch_m && row.height_m <= row.pitch_m / 3;
        if (is_row) out.push_back(std::move(row));
    }
}

}  // namespace

ToothedFace::Above ToothedFace::above(Vec3 at) const {
    if (!is_mantle) return {out, dot(at, out) - level_m};
    const Vec3 flat{at.x, at.y, 0};
    const double r = length(flat);
    return {r > 0 ? flat * (1 / r) : Vec3{1, 0, 0}, r - level_m};
}

bool ToothedFace::has(Vec3 at, Vec3 normal) const {
    const double place = is_mantle ? at.z : dot(at, across);
    if (place < from_m || place > to_m) return false;
    const Above found = above(at);
    return std::abs(found.height_m) < kSame * level_m && dot(found.outward, normal) > 0.9;
}

bool ToothedFace::looks_along(Vec3 at, Vec3 normal) const {
    const double place = is_mantle ? at.z : dot(at, across);
    if (place < from_m || place > to_m) return false;
    // Nearer to the row's direction than to that of the tips or of the ends.
    const Vec3 outward = above(at).outward;
    const Vec3 side = is_mantle ? Vec3{0, 0, 1} : across;
    const double along_row = std::abs(dot(normal, cross(outward, side)));
    return along_row > std::max(std::abs(dot(normal, outward)), std::abs(dot(normal, side)));
}

Vec3 ToothedFace::root(Vec3 at) const {
    const Above found = above(at);
    return at - found.height_m * found.outward;
}

Vec3 ToothedFace::nearest_tip(Vec3 at) const {
    const double here = is_mantle ? std::atan2(at.y, at.x) : dot(at, along);
    const auto apart = [&](double place) {
        return std::abs(is_mantle ? std::remainder(place - here, 2 * std::numbers::pi)
                                  : place - here);
    };
    const double place = *std::min_element(places.begin(), places.end(),
                                           [&](double a, double b) { return apart(a) < apart(b); });
    const double top = level_m + height_m;
    if (is_mantle) return {top * std::cos(place), top * std::sin(place), at.z};
    return top * out + place * along + dot(at, across) * across;
}

std::vector<ToothedFace> find_toothed_faces(const std::vector<ConvexShape>& shapes) {
    std::vector<std::vector<Vec3>> corners;
    for (const ConvexShape& shape : shapes) corners.push_back(corners_of(shape));
    std::vector<ToothedFace> rows;
    std::vector<Vec3> local;
    const auto teeth_on = [&](size_t base, const auto& stands) {
        const Pose to_base = inverse(shapes[base].local);
        std::vector<Tooth> teeth;
        for (size_t j = 0; j < shapes.size(); ++j) {
            if (j == base || corners[j].empty()) continue;
            local.clear();
            for (const Vec3& p : corners[j]) local.push_back(transform(to_base, p));
            Tooth tooth;
            tooth.shape = j;
            if (stands(local, tooth)) teeth.push_back(tooth);
        }
        return teeth;
    };
    for (size_t i = 0; i < shapes.size(); ++i) {
        const ConvexShape& shape = shapes[i];
        ToothedFace base;
        base.base = i;
        base.to_body = shape.local;
        if (shape.kind == ConvexShape::Kind::cylinder) {
            base.is_mantle = true;
            base.level_m = shape.radius_m + shape.rounding_m;
            const double half_m = shape.half_height_m + shape.rounding_m;
            add_rows(teeth_on(i,
                              [&](const std::vector<Vec3>& p, Tooth& tooth) {
                                  return stands_on_mantle(p, base.level_m, half_m, tooth);
                              }),
                     base, rows);
        } else if (shape.kind == ConvexShape::Kind::box) {
            const double g = shape.rounding_m;
            const std::array<double, 3> half{shape.half_extents_m.x + g, shape.half_extents_m.y + g,
                                             shape.half_extents_m.z + g};
            const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
            // Six sides, and a row along either of a side's axes.
            for (size_t k = 0; k < 12; ++k) {
                const size_t axis = k % 3, along = (axis + 1 + k / 6) % 3,
                             across = 3 - axis - along;
                base.out = k / 3 % 2 ? -axes[axis] : axes[axis];
                base.level_m = half[axis];
                base.along = axes[along];
                base.across = axes[across];
                base.half_m = half[along];
                add_rows(teeth_on(i,
                                  [&](const std::vector<Vec3>& p, Tooth& tooth) {
                                      return stands_on_side(p, base, half[across], tooth);
                                  }),
                         base, rows);
            }
        }
    }
    // A shape is of one row alone.
    std::vector<bool> is_taken(shapes.size(), false);
    std::erase_if(rows, [&](const ToothedFace& row) {
        const bool has_taken = std::any_of(row.shapes.begin(), row.shapes.end(),
                                           [&](size_t shape) { return is_taken[shape]; });
        for (const size_t shape : row.shapes) is_taken[shape] = true;
        return has_taken;
    });
    return rows;
}

}  // namespace bsoil
