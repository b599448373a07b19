#include "contact/contact_voxels.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/layout.h"
#include "base/make_room.h"
#include "bsoil/contact/contact_law.h"
#include "bsoil/contact/orientation.h"

namespace bsoil {

using namespace layout;

namespace {

/// A point no further above a face is on it [voxels]. Ours: for the rounding. Larger: points stay
/// short of the face they belong to.
constexpr double kOnFace = 1e-3;
/// Contacts that one thread takes at a time.
constexpr size_t kChunkRecords = 128;
/// A shape's surface is no further than this from the middle of a voxel that it goes through. Ours:
/// half a voxel's diagonal is 0.87, and the coverage field is smeared over most of one more.
/// Larger: a wrong nearest face puts the element far off; smaller: it stays short of its surface.
constexpr double kFaceReachVoxels = 1.5;
/// An edge's other face is looked for so far along the rest of the gradient [voxels], first far,
/// then near. Ours: a voxel's edge round the corner, and half of it for parts thinner than that.
/// Larger: faces of other parts are found; smaller: the first face is found again.
constexpr double kEdgeReachVoxels[] = {1, 0.5};
/// And so much of that into the body: past the edge the other face falls away. Ours: half, 27 deg
/// below the first face. Larger: the point lies deep in thin parts; smaller: above round edges.
constexpr double kEdgeDip = 0.5;
/// A wall's part of an element below this has no wedge that bounds it. Heights of columns are known
/// to 1/65536 voxel: what shifts the depth of a voxel by less cannot be told. Ours: that, a sole
/// that leans by 0.2 deg. Larger: soles that lean bear more than the ground before them allows;
/// smaller: planes are tried before soles that a machine's weight tilts by hundredths of a degree.
constexpr double kLeastWall = 1.0 / 65536;

/// A piece that rises by less than this either way is level [voxels]. Ours: for the rounding.
/// Larger: pieces that lean bear with all of them or with nothing; smaller: rounding cuts them.
constexpr double kLevelVoxels = 1e-6;

// A face's plane goes on beyond its edges, the face does not: a voxel under the edge of a box 1 mm
// deep would give its flank a depth of half a voxel. One step for each face that may meet there.
Vec3 onto_body(Vec3 point_m, const ContactBody& body, double voxel_m) {
    for (int face_index = 0; face_index < 3; ++face_index) {
        const std::optional<NearestFace> face =
            body.faces.nearest_below(point_m, voxel_m, kOnFace * voxel_m);
        if (!face) break;
        point_m = point_m - face->distance_m * face->normal;
    }
    return point_m;
}

// What is too much for a voxel has been pressed in along the surface in it. area_share: of that
// surface, over a voxel's face.
double compression_m(const ContactVoxels::Request& request, const ContactRecord& record,
                     double area_share) {
    const double excess = record.excess / kVoxelFull - request.law->under_way_share;
    return std::clamp(excess / area_share, 0.0, 1.0) * request.frame->voxel_m;
}

/// Whether a face is so level that what lies on it is a load: kPlugSlope. outward: in grid axes, of
/// any length.
bool is_level_up(Vec3 outward) {
    return kPlugSlope * std::max(std::abs(outward.x), std::abs(outward.y)) < outward.z;
}

// The first of them that lie on what the first one lies on: carrier by carrier they are in order.
std::span<const ContactRecord> of_one_carrier(std::span<const ContactRecord> records) {
    if (records.empty()) return records;
    const auto last =
        std::ranges::upper_bound(records, records.front().carrier, {}, &ContactRecord::carrier);
    return {records.begin(), last};
}

}  // namespace

/// A voxel's contact before it is told which faces it is of.
struct ContactVoxels::Element {
    const Request& request;
    const ContactRecord& record;
    const ContactBody& body;
    ContactVoxel contact;  ///< normal and area of the coverage's gradient
};

void ContactVoxels::make(const Request& request, const TileWords& words,
                         std::vector<ContactVoxel>& out) {
    decode_contacts(request.words, order_, records_, request.threads);
    size_t out_count = 0;
    make_room(out, 2 * records_.size());
    std::span<const ContactRecord> rest = records_, carried = of_one_carrier(rest);
    // For the ground's heights nobody asks the device, which knows its caller's thread alone.
    const bool is_ground = !rest.empty() && carried.front().carrier == kOnGround;
    if (!rest.empty() && !is_ground) read_surface(request, carried, words);
    // Neither needs the other.
    for_ranges(request.threads, 2, 1, [&](size_t first, size_t last) {
        if (first == 0) gather_pieces(request);
        if (last < 2) return;
        if (is_ground) read_surface(request, carried, words);
        if (!rest.empty()) surface_.spread();
    });
    while (!rest.empty()) {
        add_all(request, carried, out_count, out);
        rest = rest.subspan(carried.size());
        carried = of_one_carrier(rest);
        if (rest.empty()) break;
        read_surface(request, carried, words);
        surface_.spread();
    }
    out.resize(out_count);
}

void ContactVoxels::read_surface(const Request& request, std::span<const ContactRecord> carried,
                                 const TileWords& words) {
    surface_.read({carried, request.body_width_voxels, request.frame, request.law,
                   request.wedge_length, request.wedges},
                  [&](int tx, int ty) { return words(tx, ty, carried.front().carrier); });
}

void ContactVoxels::gather_pieces(const Request& request) {
    sampled_.assign(request.bodies.size(), {});
    for (size_t b = 0; b < sampled_.size(); ++b) {
        const ContactBody& body = request.bodies[b];
        if (body.input && body.surface && !body.is_small) {
            sampled_[b] = {body.surface, *request.world_to_grid * body.input->pose};
        }
    }
    pieces_.gather(records_, sampled_, *request.frame, request.law->edge_face_cosine,
                   request.threads);
}

// In chunks. How many pieces of surfaces there are is known: they are put where they belong. A
// chunk with others has a list of its own, joined in order.
void ContactVoxels::add_all(const Request& request, std::span<const ContactRecord> records,
                            size_t& out_count, std::vector<ContactVoxel>& out) {
    const size_t chunk_count = (records.size() + kChunkRecords - 1) / kChunkRecords;
    chunks_.resize(std::max(chunks_.size(), chunk_count));
    chunk_starts_.assign(chunk_count + 1, 0);
    const auto for_chunks = [&](const auto& act) {
        for_ranges(request.threads, chunk_count, 1, [&](size_t first_chunk, size_t last_chunk) {
            for (size_t chunk = first_chunk; chunk < last_chunk; ++chunk) {
                const size_t first = chunk * kChunkRecords;
                const auto own =
                    records.subspan(first, std::min(kChunkRecords, records.size() - first));
                act(chunk, own, std::ranges::all_of(own, [&](const ContactRecord& record) {
                        return is_of_pieces(request, record);
                    }));
            }
        });
    };
    for_chunks([&](size_t chunk, std::span<const ContactRecord> own, bool are_pieces) {
        size_t& count = chunk_starts_[chunk + 1];
        if (are_pieces) {
            for (const ContactRecord& record : own) count += count_pieces(request, record);
        } else {
            chunks_[chunk].clear();
            chunks_[chunk].reserve(2 * kChunkRecords);  // few voxels have more than two faces
            for (const ContactRecord& record : own) add(request, record, chunks_[chunk]);
            count = chunks_[chunk].size();
        }
    });
    chunk_starts_.front() = out_count;
    std::partial_sum(chunk_starts_.begin(), chunk_starts_.end(), chunk_starts_.begin());
    out_count = chunk_starts_.back();
    if (out.size() < out_count) out.resize(out_count);
    for_chunks([&](size_t chunk, std::span<const ContactRecord> own, bool are_pieces) {
        ContactVoxel* next = out.data() + chunk_starts_[chunk];
        if (are_pieces) {
            for (const ContactRecord& record : own) {
                next = add_pieces(element_of(request, record), next);
            }
        } else {
            std::ranges::copy(chunks_[chunk], next);
        }
    });
}

size_t ContactVoxels::place_of(const ContactRecord& record) const {
    return static_cast<size_t>(&record - records_.data());
}

// Each contact of it is a piece of its body's surface.
bool ContactVoxels::is_of_pieces(const Request& request, const ContactRecord& record) {
    const ContactBody& body = request.bodies[static_cast<size_t>(record.body)];
    return body.input && body.surface && !record.is_of_small_body();
}

ContactVoxels::Element ContactVoxels::element_of(const Request& request,
                                                 const ContactRecord& record) const {
    const GridFrame& frame = *request.frame;
    Element element{request, record, request.bodies[static_cast<size_t>(record.body)], {}};
    ContactVoxel& contact = element.contact;
    contact.body = request.body_ids[static_cast<size_t>(record.body)];
    contact.carrier =
        record.carrier == kOnGround ? -1 : request.body_ids[static_cast<size_t>(record.carrier)];
    contact.center_m =
        frame.to_world({record.voxel[0] + 0.5, record.voxel[1] + 0.5, record.voxel[2] + 0.5});
    contact.material = record.material;
    contact.relative_density = record.density == kDensityFixed ? -1 : record.density / kVoxelFull;
    contact.saturation = record.saturation / static_cast<double>(kVoxelFull);
    contact.undisturbed = record.undisturbed / static_cast<double>(kVoxelFull);
    contact.is_between_walls = record.is_between_walls;
    return element;
}

void ContactVoxels::add(const Request& request, const ContactRecord& record,
                        std::vector<ContactVoxel>& out) const {
    const ContactBody& body = request.bodies[static_cast<size_t>(record.body)];
    if (!body.input) return;
    Element element = element_of(request, record);
    if (is_of_pieces(request, record)) {
        const size_t first = out.size();
        out.resize(first + count_pieces(request, record));
        add_pieces(element, out.data() + first);
        return;
    }
    if (body.surface) {
        add_samples(element, out);
        return;
    }
    const GridFrame& frame = *request.frame;
    const double voxel = frame.voxel_m;
    ContactVoxel& contact = element.contact;
    // The shape knows better than the coverage where its surface is: of a body smaller than a
    // voxel the grid has hardly a trace.
    const NearestFace face = body.faces.nearest(contact.center_m, voxel);
    const double above_m =
        std::clamp(face.distance_m, -kFaceReachVoxels * voxel, kFaceReachVoxels * voxel);
    contact.position_m = contact.center_m - above_m * face.normal;
    const double steep = length(record.gradient);
    const double share = steep / (2.0 * kVoxelFull);  // area of surface in this voxel / voxel face
    contact.compression_m = compression_m(request, record, share);
    contact.normal = rotate(frame.grid_to_world.rotation, record.gradient * (-1 / steep));
    contact.area_m2 = share * voxel * voxel;
    if (face.rim_share < 1) {
        // The rim of a thickened sheet is wider in the grid than it is.
        const Vec3 flat = dot(contact.normal, face.sheet_normal) * face.sheet_normal;
        const Vec3 area = flat + face.rim_share * (contact.normal - flat);
        contact.area_m2 *= length(area);
        contact.normal = area * (1 / std::max(length(area), 1e-9));
    }
    add_faces(element, face.normal, out);
    if (const auto end = load_end(request, record)) out.push_back(load_side(element, *end));
}

// Of a column the uppermost record says where its load ends, where that lies on a level face. The
// column's sides are the grid's: one counts by its part along the edge's normal, so that the steps
// of an edge that stands askew are as long as the edge.
std::optional<ContactVoxels::LoadEnd> ContactVoxels::load_end(const Request& request,
                                                              const ContactRecord& record) const {
    if (record.load_sides == 0 || record.carrier != kOnGround) return {};
    const auto bottom = [](const ContactRecord& r) { return r.voxel[2] + r.load_above; };
    for (size_t next = place_of(record) + 1; next < records_.size(); ++next) {
        const ContactRecord& above = records_[next];
        if (above.carrier != kOnGround || !std::equal(above.voxel, above.voxel + 2, record.voxel)) {
            break;
        }
        const bool is_same = above.body == record.body && above.load_sides != 0;
        if (is_same && bottom(above) == bottom(record)) return {};
    }
    const double level = std::hypot(record.gradient.x, record.gradient.y);
    if (!(level > 0)) return {};
    const Vec3 outward{-record.gradient.x / level, -record.gradient.y / level, 0};
    const double along[4] = {outward.x, -outward.x, outward.y, -outward.y};
    LoadEnd end;
    for (int side = 0; side < 4; ++side) {
        if ((record.load_sides >> side & 1) != 0) end.sides += std::max(0.0, along[side]);
    }
    if (!(end.sides > 0)) return {};
    // A voxel within the edge no face beside is nearer than the one that looks up.
    const GridFrame& frame = *request.frame;
    end.at = {record.voxel[0] + 0.5, record.voxel[1] + 0.5, static_cast<double>(bottom(record))};
    const NearestFace face = request.bodies[static_cast<size_t>(record.body)].faces.nearest(
        frame.to_world(end.at - outward), frame.voxel_m);
    const Vec3 normal = rotate(conjugate(frame.grid_to_world.rotation), face.normal);
    if (!is_level_up(normal)) return {};
    // Its plane, from there out to the edge.
    end.at += 0.5 * outward;
    end.at.z -= (face.distance_m / frame.voxel_m + 1.5 * dot(outward, normal)) / normal.z;
    return end;
}

ContactVoxel ContactVoxels::load_side(const Element& element, const LoadEnd& end) const {
    const GridFrame& frame = *element.request.frame;
    ContactVoxel contact = element.contact;
    contact.is_load_side = true;
    contact.area_m2 = end.sides * frame.voxel_m * frame.voxel_m;
    contact.normal = rotate(frame.grid_to_world.rotation, Vec3{0, 0, 1});
    contact.position_m = frame.to_world(end.at);
    const FreeSurface::Beside surface =
        surface_.height_beside(element.record, end.at, Vec3{0, 0, 1});
    contact.depth_m = std::max(0.0, surface.nearest - end.at.z) * frame.voxel_m;
    contact.bearing_depth_m = contact.depth_m;
    contact.compression_m = 0;
    return contact;
}

size_t ContactVoxels::count_pieces(const Request& request, const ContactRecord& record) const {
    return pieces_.count(place_of(record)) + (load_end(request, record) ? 1 : 0);
}

// In next and behind it, where there is room for them; returns what comes behind them.
ContactVoxel* ContactVoxels::add_pieces(const Element& element, ContactVoxel* next) const {
    const Pose& grid_to_world = element.request.frame->grid_to_world;
    const size_t record = place_of(element.record);
    const double voxel = element.request.frame->voxel_m;
    double area_m2 = 0;
    pieces_.for_each(record, [&](const SurfacePiece& piece) {
        area_m2 += piece.part == ToothPart::over_tips ? 0 : piece.area_m2;
    });
    const double pressed_m =
        area_m2 > 0 ? compression_m(element.request, element.record, area_m2 / (voxel * voxel)) : 0;
    pieces_.for_each(record, [&](const SurfacePiece& piece) {
        ContactVoxel& contact = *next++ = element.contact;
        contact.compression_m = pressed_m;
        contact.area_m2 = length(piece.area);
        contact.normal = rotate(grid_to_world.rotation, piece.area * (1 / contact.area_m2));
        contact.position_m = transform(grid_to_world, piece.middle());
        const bool is_over_tips = piece.part == ToothPart::over_tips;
        const Vec3 rise_m2 = is_over_tips ? Vec3{} : piece.rise_m2();
        finish(element, contact, rotate(grid_to_world.rotation, rise_m2));
        if (piece.row >= 0) set_teeth(element.body, piece, contact);
    });
    if (const auto end = load_end(element.request, element.record)) {
        *next++ = load_side(element, *end);
    }
    return next;
}

// A small body's samples, each an element of its own: where it is and which way it looks tells
// samples apart from step to step, as voxels do for larger bodies.
void ContactVoxels::add_samples(const Element& element, std::vector<ContactVoxel>& out) const {
    const Pose& pose = element.body.input->pose;
    for (const SurfaceSample& sample : element.body.surface->samples) {
        ContactVoxel& contact = out.emplace_back(element.contact);
        contact.area_m2 = sample.area_m2;
        contact.normal = rotate(pose.rotation, sample.normal);
        contact.center_m = contact.position_m = transform(pose, sample.at);
        finish(element, contact);
        if (!(contact.depth_m > 0)) out.pop_back();
    }
}

void ContactVoxels::set_teeth(const ContactBody& body, const SurfacePiece& piece,
                              ContactVoxel& contact) const {
    const ToothedFace& row = body.surface->rows[static_cast<size_t>(piece.row)];
    const Pose to_world = body.input->pose * row.to_body;
    const ToothedFace::Above above = row.above(transform(inverse(to_world), contact.position_m));
    contact.teeth = {row.height_m,
                     row.thickness_m,
                     row.pitch_m,
                     above.height_m,
                     rotate(to_world.rotation, above.outward),
                     piece.part};
}

// The gradient errs in the direction of an inclined face, from voxel to voxel, and at an edge
// points between two faces. The soil meets the shape's faces: the area vector is projected on the
// nearest one, and at an edge the rest of it on the other.
void ContactVoxels::add_faces(const Element& element, Vec3 face_normal,
                              std::vector<ContactVoxel>& out) const {
    const ContactLawDef& law = *element.request.law;
    const ContactVoxel& contact = element.contact;
    ContactVoxel& nearest = out.emplace_back(contact);
    const double along = dot(face_normal, contact.normal);
    if (along <= 0) {  // the face of a part that lies within another
        finish(element, nearest);
        return;
    }
    nearest.normal = face_normal;
    nearest.area_m2 = contact.area_m2 * along;
    finish(element, nearest);
    const Vec3 rest = contact.normal - along * face_normal;
    const double across = length(rest);
    if (across < law.edge_sine) return;
    // The other face is looked for round the edge, for small parts halfway; from there it lies half
    // as far on. Where no face has turned that way there is no edge, but the staircase of a curved
    // face.
    const double voxel = element.request.frame->voxel_m;
    const Vec3 across_normal = rest * (1 / across);
    Vec3 beyond;
    NearestFace face;
    const auto has_turned = [&](double thin_m) {
        face = element.body.faces.nearest(beyond, thin_m);
        return dot(face.normal, across_normal) >= law.edge_sine;
    };
    bool is_edge = false, is_thin = false;
    for (const double reach : kEdgeReachVoxels) {
        beyond = contact.position_m + reach * voxel * (across_normal - kEdgeDip * face_normal);
        // Of a part thinner than a voxel, like a wheel's lug, the gradient tells what there is.
        is_thin = !has_turned(voxel);
        is_edge = !is_thin || has_turned(0);
        if (is_edge) break;
    }
    if (!is_edge) return;
    ContactVoxel& other = out.emplace_back(contact);
    other.normal = across_normal;
    other.area_m2 = contact.area_m2 * across;
    const double same = dot(face.normal, across_normal);
    if (!is_thin && same >= law.edge_face_cosine && std::abs(face.distance_m) <= voxel) {
        other.position_m = beyond - face.distance_m * face.normal;
        other.normal = face.normal;
        other.area_m2 *= same;
    }
    finish(element, other);
}

// A wall meets no more than the wedge over the ground as it lies, which before a heap is a part of
// what its mean height has. depth_m of the contact is known.
void ContactVoxels::bound_by_wedge(const Element& element, Vec3 at, Vec3 outward, double nearest,
                                   ContactVoxel& contact) const {
    contact.bearing_depth_m = contact.depth_m;
    const double wall = surface_parts(outward).wall;
    if (!(contact.depth_m > 0) || wall < kLeastWall) return;
    const SurfaceWedge::Found wedge = surface_.wedge_before(element.record, at, outward, nearest);
    const double wedge_m = wedge.level_depth * element.request.frame->voxel_m;
    contact.bearing_depth_m -= wall * std::max(0.0, contact.depth_m - wedge_m);
    contact.inflow_share = 1 - wall * (1 - wedge.inflow_share);
}

// Of a piece that the surface of the soil cuts, the part below it bears: as of one whose area is
// spread evenly over its heights.
bool ContactVoxels::keep_what_is_below(double depth_m, Vec3 rise_m2, Vec3 up, double voxel_m,
                                       ContactVoxel& contact) {
    const double variance_m2 = dot(rise_m2, up);
    const double half_m = std::sqrt(3 * std::max(0.0, variance_m2));
    if (!(half_m > kLevelVoxels * voxel_m) || !(std::abs(depth_m) < half_m)) return false;
    const double below_m = half_m + depth_m;
    // What is pressed in by more than that bears with all of it, below the surface or not.
    if (below_m * below_m <= 4 * half_m * contact.compression_m) return false;
    const double lower_m = (half_m - depth_m) / 2;
    contact.area_m2 *= below_m / (2 * half_m);
    contact.position_m = contact.position_m - lower_m / variance_m2 * rise_m2;
    return true;
}

// Each face has the gap and the free surface that lie along its own normal: soil heaved beside a
// wheel counts for its flank and not for its sole.
void ContactVoxels::finish(const Element& element, ContactVoxel& contact, Vec3 rise_m2) const {
    const GridFrame& frame = *element.request.frame;
    const ContactRecord& record = element.record;
    if (!element.body.surface) {
        contact.position_m = onto_body(contact.position_m, element.body, frame.voxel_m);
    }
    const Vec3 n = rotate(conjugate(frame.grid_to_world.rotation), contact.normal);
    const Vec3 gap_m = record.gap * (frame.voxel_m / kVoxelFull);
    contact.gap_m = n.x * n.x * gap_m.x + n.y * n.y * gap_m.y + n.z * n.z * gap_m.z;
    const auto place = [&] {
        return transform(*element.request.world_to_grid, contact.position_m) * (1 / frame.voxel_m);
    };
    Vec3 at = place();
    FreeSurface::Beside surface = surface_.height_beside(record, at, n);
    if (dot(rise_m2, rise_m2) > 0) {
        const Vec3 up = rotate(frame.grid_to_world.rotation, Vec3{0, 0, 1});
        if (keep_what_is_below((surface.height - at.z) * frame.voxel_m, rise_m2, up, frame.voxel_m,
                               contact)) {
            at = place();
            surface = surface_.height_beside(record, at, n);
        }
    }
    contact.depth_m = std::max(0.0, surface.height - at.z) * frame.voxel_m;
    bound_by_wedge(element, at, n, surface.nearest, contact);
    contact.bearing_depth_m = std::max(contact.bearing_depth_m, contact.compression_m);
    contact.touching = touching_share(contact, frame.voxel_m, *element.request.law);
    // A load is no contact, nor where the voxel has ground beside the face as well.
    if (record.load_above >= 0 && is_level_up(n)) contact.touching = 0;
}

}  // namespace bsoil
