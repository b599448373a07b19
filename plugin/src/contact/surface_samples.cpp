#include "contact/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "bsoil/contact/orientation.h"
#include "contact/shape_faces.h"

namespace bsoil {
namespace {

/// Samples are no longer than this [voxels]. Ours: where the borders of voxels cut them each part
/// is in one of two. Larger: more parts than two; smaller: more samples for the same faces.
constexpr double kSpacingVoxels = 1;
/// A body with more goes by the coverage field. Ours: a cube of 209 voxels to the side; its samples
/// take 20 MB. Larger: more memory for a body that is as well described by its voxels.
constexpr size_t kSamplesMost = 1 << 18;
/// Pieces of a body that are looked at, hidden ones too. Ours: half of a body's surface may lie
/// inside of it. Larger: longer before a body is found too large; smaller: bodies of many shapes
/// inside each other go by the coverage field.
constexpr double kPiecesMost = 2 * kSamplesMost;
/// Cells of one face's box, of which its pieces are cut. Ours: a tenth of a second where a body is
/// made. Larger: longer; smaller: long narrow faces that lie askew go by the coverage field.
constexpr int64_t kCellsMost = 16 * kSamplesMost;
/// Samples that share a bound, by which a tile finds those near it. Ours: a few rows of a face.
/// Larger: more samples are looked at for nothing; smaller: more bounds are.
constexpr size_t kClusterSamples = 32;
/// Parts along each side in which a piece that another shape cuts is looked at. Ours: its area is
/// known to a 64th. Larger: more exact, by the square more time where a body is made.
constexpr int kCutParts = 8;
/// Faces no further apart than this [voxels] lie on each other. Ours: for the rounding. Larger:
/// thin plates lose their faces.
constexpr double kSameFaceVoxels = 1e-6;
/// Faces of a body that look at each other across less than this [voxels] have no soil between them
/// that the body could press on: what is there goes with it. Ours: soil does not flow into voxels
/// that bodies fill by half. Larger: narrow grooves have no faces; smaller: a rim bears where a lug
/// is put against it.
constexpr double kCrackVoxels = 0.5;
/// Such a crack is looked across in steps of at least this part of its width. Ours: a shape thinner
/// than a thirtieth of a voxel may be missed. Larger: more are; smaller: more steps.
constexpr double kCrackStep = 1.0 / 16;

using Polygon = std::vector<Vec3>;

/// The part of a convex polygon where dot(normal, p) <= offset.
Polygon clipped(const Polygon& polygon, Vec3 normal, double offset) {
    Polygon out;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        const double a = dot(normal, p) - offset, b = dot(normal, q) - offset;
        if (a <= 0) out.push_back(p);
        if ((a < 0 && b > 0) || (a > 0 && b < 0)) out.push_back(p + a / (a - b) * (q - p));
    }
    return out;
}

double bound_m(const ConvexShape& shape) {
    switch (shape.kind) {
        case ConvexShape::Kind::box:
            return length(shape.half_extents_m) + 2 * shape.rounding_m;
        case ConvexShape::Kind::hull:
            return shape.bound_m + 2 * shape.rounding_m;
        case ConvexShape::Kind::lattice:
            return 0;
        default:
            return shape.radius_m + shape.half_height_m + 2 * shape.rounding_m;
    }
}

class Sampler {
  public:
    Sampler(const std::vector<ConvexShape>& shapes, const std::vector<SheetGrowth>& growth,
            double voxel_m, double spacing_m, std::vector<SurfaceSample>& out)
        : shapes_(shapes), growth_(growth), voxel_m_(voxel_m), spacing_m_(spacing_m), out_(out) {
        for (const ConvexShape& shape : shapes) {
            to_shape_.push_back(inverse(shape.local));
            thickest_m_ = std::max(thickest_m_, shape_thickness_m(shape));
        }
    }

    /// False where the shape has no faces to go by, or too many pieces come out.
    bool add(size_t index) {
        part_ = index;
        const ConvexShape& shape = shapes_[index];
        is_thin_ = shape_thickness_m(shape) + growth_[index].growth_m < voxel_m_ &&
                   thickest_m_ >= voxel_m_;
        const double r = shape.radius_m + shape.rounding_m;
        const double h = shape.half_height_m + shape.rounding_m;
        switch (shape.kind) {
            case ConvexShape::Kind::box: {
                const double g = shape.rounding_m;
                add_box(shape.half_extents_m + Vec3{g, g, g});
                break;
            }
            case ConvexShape::Kind::sphere:
                add_ball(r, 0);
                break;
            case ConvexShape::Kind::capsule:
                add_mantle(r, r, shape.half_height_m, -shape.half_height_m);
                add_ball(r, shape.half_height_m);
                break;
            case ConvexShape::Kind::cylinder:
                add_mantle(r, r, h, -h);
                add_disc(r, h, 1);
                add_disc(r, -h, -1);
                break;
            case ConvexShape::Kind::cone: {
                // Every face moved out by the rounding.
                const double slant = std::hypot(shape.radius_m, 2 * shape.half_height_m);
                const double c = 2 * shape.half_height_m / slant, s = shape.radius_m / slant;
                const double top = shape.half_height_m + shape.rounding_m / s;
                const double base = (shape.rounding_m + (h + shape.half_height_m) * s) / c;
                add_mantle(base, 0, -h, top);
                add_disc(base, -h, -1);
                break;
            }
            case ConvexShape::Kind::hull:
                add_hull(shape);
                break;
            case ConvexShape::Kind::lattice:
                return false;
        }
        return has_room_for(0) && out_.size() <= kSamplesMost;
    }

  private:
    /// No more than one too many.
    int parts(double length_m) const {
        const double count = std::ceil(length_m / spacing_m_ - 1e-9);
        return static_cast<int>(std::clamp(count, 1.0, kSamplesMost + 1.0));
    }

    /// Whether so many more pieces can be taken. Asked before they are made: they may be gigabytes.
    bool has_room_for(double count) {
        looked_at_ += count;
        return looked_at_ <= kPiecesMost;
    }

    void add_rectangle(Vec3 middle, Vec3 a, Vec3 b, Vec3 normal) {
        const int na = parts(length(a)), nb = parts(length(b));
        if (!has_room_for(1.0 * na * nb)) return;
        const Vec3 da = a * (1.0 / na), db = b * (1.0 / nb);
        for (int i = 0; i < na; ++i) {
            for (int j = 0; j < nb; ++j) {
                add_piece(middle + (i + 0.5 - na / 2.0) * da + (j + 0.5 - nb / 2.0) * db, da, db,
                          normal, length(da) * length(db));
            }
        }
    }

    void add_box(Vec3 h) {
        const Vec3 x{2 * h.x, 0, 0}, y{0, 2 * h.y, 0}, z{0, 0, 2 * h.z};
        for (const double s : {-1.0, 1.0}) {
            add_rectangle({s * h.x, 0, 0}, y, z, {s, 0, 0});
            add_rectangle({0, s * h.y, 0}, x, z, {0, s, 0});
            add_rectangle({0, 0, s * h.z}, x, y, {0, 0, s});
        }
    }

    /// About z, from radius r0 at height z0 to r1 at z1.
    void add_mantle(double r0, double r1, double z0, double z1) {
        const double slant = std::hypot(r1 - r0, z1 - z0);
        const int rows = parts(slant);
        if (!(slant > 0) || !has_room_for(1.0 * rows * parts(std::numbers::pi * (r0 + r1)))) return;
        const double up = (r0 - r1) / slant * (z1 > z0 ? 1 : -1);
        const double out = std::sqrt(std::max(0.0, 1 - up * up));
        for (int j = 0; j < rows; ++j) {
            const double t = (j + 0.5) / rows, r = r0 + t * (r1 - r0), z = z0 + t * (z1 - z0);
            const int around = std::max(8, parts(2 * std::numbers::pi * r));
            for (int i = 0; i < around; ++i) {
                const double angle = 2 * std::numbers::pi * (i + 0.5) / around;
                const Vec3 radial{std::cos(angle), std::sin(angle), 0};
                const Vec3 along =
                    Vec3{-radial.y, radial.x, 0} * (2 * std::numbers::pi * r / around);
                const Vec3 rise = ((r1 - r0) * radial + Vec3{0, 0, z1 - z0}) * (1.0 / rows);
                add_piece(r * radial + Vec3{0, 0, z}, along, rise, out * radial + Vec3{0, 0, up},
                          length(along) * slant / rows);
            }
        }
    }

    void add_disc(double radius, double z, double side) {
        const int rings = parts(radius);
        if (!has_room_for(1.0 * rings * parts(std::numbers::pi * radius))) return;
        for (int j = 0; j < rings; ++j) {
            // The middle of a ring's piece, by area.
            const double inner = radius * j / rings, outer = radius * (j + 1) / rings;
            const double r = 2.0 / 3 * (outer * outer * outer - inner * inner * inner) /
                             (outer * outer - inner * inner);
            const int around = std::max(4, parts(2 * std::numbers::pi * r));
            for (int i = 0; i < around; ++i) {
                const double angle = 2 * std::numbers::pi * (i + 0.5) / around;
                const Vec3 radial{std::cos(angle), std::sin(angle), 0};
                add_piece(r * radial + Vec3{0, 0, z},
                          Vec3{-radial.y, radial.x, 0} * (2 * std::numbers::pi * r / around),
                          radial * (radius / rings), {0, 0, side},
                          std::numbers::pi * (outer * outer - inner * inner) / around);
            }
        }
    }

    /// A ball cut at its middle, its halves moved apart by `apart` each.
    void add_ball(double radius, double apart) {
        const int bands = 2 * std::max(2, parts(std::numbers::pi / 2 * radius));
        if (!has_room_for(1.0 * bands * parts(4 * radius))) return;
        for (int j = 0; j < bands; ++j) {
            const double low = -std::numbers::pi / 2 + std::numbers::pi * j / bands,
                         high = low + std::numbers::pi / bands;
            const double share = std::sin(high) - std::sin(low),
                         z = (std::sin(high) + std::sin(low)) / 2;
            const double out = std::sqrt(1 - z * z);
            const int around = std::max(4, parts(2 * std::numbers::pi * radius * out));
            for (int i = 0; i < around; ++i) {
                const double angle = 2 * std::numbers::pi * (i + 0.5) / around;
                const Vec3 normal{out * std::cos(angle), out * std::sin(angle), z};
                const Vec3 along = Vec3{-std::sin(angle), std::cos(angle), 0} *
                                   (2 * std::numbers::pi * radius * out / around);
                const Vec3 rise = cross(normal, Vec3{-std::sin(angle), std::cos(angle), 0}) *
                                  (std::numbers::pi * radius / bands);
                add_piece(radius * normal + Vec3{0, 0, z > 0 ? apart : -apart}, along, rise, normal,
                          2 * std::numbers::pi * radius * radius * share / around);
            }
        }
    }

    void add_hull(const ConvexShape& hull) {
        const double far = 4 * bound_m(hull);
        for (size_t i = 0; i < hull.planes.size(); ++i) {
            const Vec3 n = hull.planes[i].normal;
            const Vec3 a = unit_across(n), b = cross(n, a);
            const Vec3 at = (hull.planes[i].offset + hull.rounding_m) * n;
            Polygon face{at - far * a - far * b, at + far * a - far * b, at + far * a + far * b,
                         at - far * a + far * b};
            for (size_t j = 0; j < hull.planes.size() && !face.empty(); ++j) {
                if (j != i) {
                    face = clipped(face, hull.planes[j].normal,
                                   hull.planes[j].offset + hull.rounding_m);
                }
            }
            add_polygon(face, a, b, n);
        }
    }

    void add_polygon(const Polygon& face, Vec3 a, Vec3 b, Vec3 n) {
        if (face.size() < 3) return;
        double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
        for (const Vec3& p : face) {
            const double at[2] = {dot(p, a), dot(p, b)};
            for (int k = 0; k < 2; ++k) {
                low[k] = std::min(low[k], at[k]);
                high[k] = std::max(high[k], at[k]);
            }
        }
        const int na = parts(high[0] - low[0]), nb = parts(high[1] - low[1]);
        double area_m2 = 0;
        for (size_t i = 2; i < face.size(); ++i) {
            area_m2 += dot(cross(face[i - 1] - face[0], face[i] - face[0]), n) / 2;
        }
        double count = std::abs(area_m2) / (spacing_m_ * spacing_m_);
        if (static_cast<int64_t>(na) * nb > kCellsMost) count = kPiecesMost + 1;
        if (!has_room_for(count)) return;
        const double da = (high[0] - low[0]) / na, db = (high[1] - low[1]) / nb;
        for (int i = 0; i < na; ++i) {
            Polygon strip = clipped(face, a, low[0] + (i + 1) * da);
            strip = clipped(strip, -a, -(low[0] + i * da));
            for (int j = 0; j < nb && strip.size() > 2; ++j) {
                Polygon cell = clipped(strip, b, low[1] + (j + 1) * db);
                cell = clipped(cell, -b, -(low[1] + j * db));
                add_cell(cell, da * a, db * b, n);
            }
        }
    }

    void add_cell(const Polygon& cell, Vec3 a, Vec3 b, Vec3 n) {
        Vec3 sum;
        double area = 0;
        for (size_t i = 2; i < cell.size(); ++i) {
            const double part = dot(cross(cell[i - 1] - cell[0], cell[i] - cell[0]), n) / 2;
            area += part;
            sum += part / 3 * (cell[0] + cell[i - 1] + cell[i]);
        }
        const double whole = length(a) * length(b);
        if (!(std::abs(area) > 1e-9 * whole)) return;
        const double size = std::sqrt(std::min(1.0, std::abs(area) / whole));
        add_piece(sum * (1 / area), size * a, size * b, n, std::abs(area));
    }

    /// In the shape's frame; a, b: its sides.
    void add_piece(Vec3 at, Vec3 a, Vec3 b, Vec3 normal, double area_m2) {
        const ConvexShape& shape = shapes_[part_];
        SurfaceSample piece{transform(shape.local, at), rotate(shape.local.rotation, normal),
                            area_m2, 0, is_thin_};
        const SheetGrowth& growth = growth_[part_];
        if (growth.is_thin()) {
            piece.out_m = std::abs(dot(growth.normal, normal)) * growth.growth_m / 2;
        }
        if (is_cut(piece.at, (length(a) + length(b)) / 2 + kCrackVoxels * voxel_m_)) {
            const Vec3 da = rotate(shape.local.rotation, a) * (1.0 / kCutParts);
            const Vec3 db = rotate(shape.local.rotation, b) * (1.0 / kCutParts);
            Vec3 sum;
            int seen = 0;
            for (int i = 0; i < kCutParts; ++i) {
                for (int j = 0; j < kCutParts; ++j) {
                    const Vec3 p = piece.at + (i + 0.5 - kCutParts / 2.0) * da +
                                   (j + 0.5 - kCutParts / 2.0) * db;
                    if (is_hidden(p, piece.normal)) continue;
                    sum += p;
                    ++seen;
                }
            }
            if (seen == 0) return;
            piece.at = sum * (1.0 / seen);
            piece.area_m2 *= static_cast<double>(seen) / (kCutParts * kCutParts);
        }
        out_.push_back(piece);
    }

    /// Whether another shape's surface comes that near, or it lies inside of one.
    bool is_cut(Vec3 at, double reach_m) const {
        for (size_t j = 0; j < shapes_.size(); ++j) {
            if (j == part_ ||
                length(at - shapes_[j].local.position) > bound_m(shapes_[j]) + reach_m) {
                continue;
            }
            if (nearest_face(shapes_[j], transform(to_shape_[j], at)).distance_m < reach_m) {
                return true;
            }
        }
        return false;
    }

    /// Inside another shape, or on its face: faces that meet are hidden, of two in one plane the
    /// later is. Or with one right before it.
    bool is_hidden(Vec3 at, Vec3 normal) const {
        const double same_m = kSameFaceVoxels * voxel_m_, crack_m = kCrackVoxels * voxel_m_;
        for (size_t j = 0; j < shapes_.size(); ++j) {
            if (j == part_ ||
                length(at - shapes_[j].local.position) > bound_m(shapes_[j]) + crack_m) {
                continue;
            }
            const NearestFace face = nearest_face(shapes_[j], transform(to_shape_[j], at));
            if (face.distance_m > same_m) {
                if (meets(j, at, normal, face.distance_m)) return true;
                continue;
            }
            if (face.distance_m < -same_m) return true;
            const double along = dot(rotate(shapes_[j].local.rotation, face.normal), normal);
            if (along < 0 || j < part_) return true;
        }
        return false;
    }

    /// Whether the way along `normal` goes into a shape before a crack's width. distance_m: of `at`
    /// from the shape, which is no nearer than that.
    bool meets(size_t shape, Vec3 at, Vec3 normal, double distance_m) const {
        const double crack_m = kCrackVoxels * voxel_m_;
        for (double way_m = distance_m; way_m < crack_m;) {
            const Vec3 p = transform(to_shape_[shape], at + way_m * normal);
            distance_m = nearest_face(shapes_[shape], p).distance_m;
            if (distance_m < -kSameFaceVoxels * voxel_m_) return true;
            way_m += std::max(distance_m, kCrackStep * crack_m);
        }
        return false;
    }

    const std::vector<ConvexShape>& shapes_;
    const std::vector<SheetGrowth>& growth_;
    double voxel_m_, spacing_m_, thickest_m_ = 0;
    std::vector<SurfaceSample>& out_;
    std::vector<Pose> to_shape_;
    size_t part_ = 0;
    bool is_thin_ = false;
    double looked_at_ = 0;
};

}  // namespace

void SurfaceSamples::make(const std::vector<ConvexShape>& shapes,
                          const std::vector<SheetGrowth>& growth, double voxel_m, bool with_teeth,
                          double cut_voxel_m) {
    samples.clear();
    clusters.clear();
    rows.clear();
    over_tips.clear();
    const double spacing_m = kSpacingVoxels * std::min(voxel_m, cut_voxel_m);
    Sampler sampler(shapes, growth, voxel_m, spacing_m, samples);
    is_whole = is_made = true;
    std::vector<size_t> ends;  // of each shape's samples
    for (size_t i = 0; i < shapes.size() && is_whole; ++i) {
        is_whole = sampler.add(i);
        ends.push_back(samples.size());
    }
    if (!is_whole) {
        samples.clear();
        return;
    }
    if (with_teeth) add_rows(shapes, spacing_m, ends);
    for (size_t first = 0; first < samples.size(); first += kClusterSamples) {
        SampleCluster cluster{{}, 0, first, std::min(first + kClusterSamples, samples.size())};
        for (size_t i = first; i < cluster.last; ++i) cluster.center += samples[i].at;
        cluster.center = cluster.center * (1.0 / static_cast<double>(cluster.last - first));
        for (size_t i = first; i < cluster.last; ++i) {
            cluster.radius_m = std::max(cluster.radius_m, length(samples[i].at - cluster.center));
        }
        clusters.push_back(cluster);
    }
}

void SurfaceSamples::add_rows(const std::vector<ConvexShape>& shapes, double spacing_m,
                              const std::vector<size_t>& ends) {
    rows = find_toothed_faces(shapes);
    const auto samples_of = [&](size_t shape) {
        const size_t first = shape > 0 ? ends[shape - 1] : 0;
        return std::span(samples).subspan(first, ends[shape] - first);
    };
    const auto parts = [&](double length_m) {
        return std::max(1, static_cast<int>(std::ceil(length_m / spacing_m - 1e-9)));
    };
    for (size_t r = 0; r < rows.size(); ++r) {
        const ToothedFace& row = rows[r];
        const Pose to_base = inverse(row.to_body);
        for (const size_t tooth : row.shapes) {
            for (SurfaceSample& sample : samples_of(tooth)) {
                if (!row.looks_along(transform(to_base, sample.at),
                                     rotate(to_base.rotation, sample.normal))) {
                    continue;
                }
                sample.row = static_cast<int>(r);
                sample.part = ToothPart::tooth;
            }
        }
        for (SurfaceSample& sample : samples_of(row.base)) {
            if (row.has(transform(to_base, sample.at), rotate(to_base.rotation, sample.normal))) {
                sample.row = static_cast<int>(r);
                sample.part = ToothPart::base;
            }
        }
        const auto add = [&](Vec3 at, Vec3 normal, double area_m2) {
            OverTips& made = over_tips.emplace_back();
            made.piece = {transform(row.to_body, at), rotate(row.to_body.rotation, normal),
                          area_m2};
            made.piece.row = static_cast<int>(r);
            made.piece.part = ToothPart::over_tips;
            made.root = transform(row.to_body, row.root(at));
            made.tip = transform(row.to_body, row.nearest_tip(at));
        };
        const double wide_m = row.to_m - row.from_m, top_m = row.level_m + row.height_m;
        const int across = parts(wide_m), up = parts(row.height_m);
        const auto at_height = [&](int i) { return row.level_m + (i + 0.5) / up * row.height_m; };
        const auto at_place = [&](int j) { return row.from_m + (j + 0.5) / across * wide_m; };
        if (row.is_mantle) {
            const int around = std::max(8, parts(2 * std::numbers::pi * top_m));
            for (int i = 0; i < around; ++i) {
                const double turn = 2 * std::numbers::pi / around, angle = (i + 0.5) * turn;
                const Vec3 radial{std::cos(angle), std::sin(angle), 0};
                for (int j = 0; j < across; ++j) {
                    add(top_m * radial + Vec3{0, 0, at_place(j)}, radial,
                        turn * top_m * wide_m / across);
                }
                for (int j = 0; j < up; ++j) {
                    for (const double side : {-1.0, 1.0}) {
                        add(at_height(j) * radial + Vec3{0, 0, side < 0 ? row.from_m : row.to_m},
                            {0, 0, side}, turn * at_height(j) * row.height_m / up);
                    }
                }
            }
            continue;
        }
        const int along = parts(2 * row.half_m);
        const double step_m = 2 * row.half_m / along;
        for (int i = 0; i < along; ++i) {
            const Vec3 at = ((i + 0.5) * step_m - row.half_m) * row.along;
            for (int j = 0; j < across; ++j) {
                add(top_m * row.out + at + at_place(j) * row.across, row.out,
                    step_m * wide_m / across);
            }
            for (int j = 0; j < up; ++j) {
                for (const double side : {-1.0, 1.0}) {
                    add(at_height(j) * row.out + at +
                            (side < 0 ? row.from_m : row.to_m) * row.across,
                        side * row.across, step_m * row.height_m / up);
                }
            }
        }
        for (int i = 0; i < across; ++i) {
            for (int j = 0; j < up; ++j) {
                for (const double side : {-1.0, 1.0}) {
                    add(at_height(j) * row.out + side * row.half_m * row.along +
                            at_place(i) * row.across,
                        side * row.along, wide_m / across * row.height_m / up);
                }
            }
        }
    }
}

}  // namespace bsoil
