#include "bsoil/contact/work_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/trapped_soil.h"

namespace bsoil {
namespace {

/// By how much a push along a normal turns before it rises: 90 deg of a level sole, none of a wall.
double turn_of(Vec3 normal, Vec3 up) { return std::asin(std::clamp(-dot(normal, up), -1.0, 1.0)); }

/// What the face and its soil do along the face, of a motion.
struct Dragging {
    double turned_rad = 0;  ///< for WorkPath
    Vec3 shear;             ///< on the body, over the normal stress
};

/// approach > 0 and slide: of the face, along its normal and along itself.
Dragging dragging_of(const WorkPath& path, Vec3 normal, Vec3 up, double approach, Vec3 slide,
                     double creep) {
    const SoleAndWall parts = bearing_parts(looks_down(normal, up));
    const Vec3 along = up - dot(up, normal) * normal;
    const double level = length(along);
    // Towards the free surface. A level face has no such direction: see slide_past_flow().
    const Vec3 to_surface = level > 0 ? along * (1 / level) : Vec3{};
    const double flow = path.rise() * approach * std::min(1.0, level / kLeaningSine);
    // Soil is taken along up a face and across it, under a sole also the other way. Down a wall it
    // cannot go.
    const double risen = dot(slide, to_surface);
    const Vec3 taken = slide - (1 - parts.sole) * std::min(0.0, risen) * to_surface;
    const double size = length(taken);

    Dragging out;
    out.turned_rad = path.turned_by(approach, size);
    if (size > 0) out.shear = taken * (-path.shear_share(out.turned_rad) / size);
    // A wall's soil rises faster than the wall does. Under a sole a wedge goes with it instead.
    const Vec3 past = slide - flow * to_surface;
    const double against = parts.wall * std::max(0.0, -dot(past, to_surface)) /
                           (length(past) + creep * (approach + size));
    out.turned_rad -= against * path.most_turned_rad();
    out.shear += against * path.friction() * to_surface;
    const double most = path.friction(), sheared = length(out.shear);
    if (sheared > most) out.shear = out.shear * (most / sheared);
    return out;
}

}  // namespace

WorkPath::WorkPath(double friction_angle_rad, double friction)
    : sine_(std::sin(friction_angle_rad)),
      tangent_(std::tan(friction_angle_rad)),
      rise_(std::tan(std::numbers::pi / 4 - friction_angle_rad / 2)),
      friction_(std::clamp(friction, 0.0, tangent_)),
      slip_line_rad_(std::numbers::pi / 4 + friction_angle_rad / 2) {
    const double angle = std::atan(friction_);
    if (angle > 0) {
        most_turned_rad_ = (std::asin(std::min(1.0, std::sin(angle) / sine_)) + angle) / 2;
    }
}

double WorkPath::work_share(double turn_rad) const {
    return std::max(1.0, rankine() * std::exp(2 * turn_rad * tangent_));
}

double WorkPath::dragged_share(double turned_rad) const {
    return (1 + sine_ * std::cos(2 * turned_rad)) / (1 + sine_) *
           std::exp(-2 * turned_rad * tangent_);
}

double WorkPath::shear_share(double turned_rad) const {
    return std::min(friction_, std::abs(sine_ * std::sin(2 * turned_rad) /
                                        (1 + sine_ * std::cos(2 * turned_rad))));
}

double WorkPath::turned_by(double approach, double taken_along) const {
    return std::clamp(slip_line_rad_ - std::atan2(approach, taken_along), 0.0, most_turned_rad_);
}

WorkLaw::WorkLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface)
    : ContactLaw(std::move(soil)) {
    for (const MaterialDef& material : this->soil().materials) {
        const double phi = material.friction_angle_rad;
        const double friction = surface.friction >= 0 ? surface.friction : material.tool_friction;
        const WorkPath face(phi, friction);
        strengths_.push_back({material.density_kg_m3 * this->soil().gravity_m_s2, phi,
                              (1 - face.sine()) * face.tangent() / std::sin(std::atan(face.rise())),
                              face, WorkPath(phi, std::tan(phi))});
    }
}

double WorkLaw::zone_m(const WorkPath& path, const FaceExtent& face, double sole,
                       double depth_m) const {
    const double developing_m =
        (def().mobilization_widths - def().mobilization_fall_widths * face.relative_density) *
        face.width_m;
    if (!(developing_m > 0)) return 0;
    return sole * std::min(1.0, depth_m / developing_m) * face.width_m / (2 * path.rise());
}

WorkPath WorkLaw::dense_path(const Strength& soil, const WorkPath& path, const FaceExtent& face,
                             Vec3 normal, double depth_m) const {
    const double sole = bearing_parts(looks_down(normal, up())).sole;
    const double overburden_pa =
        soil.weight_n_m3 * (depth_m + zone_m(path, face, sole, depth_m) / 2);
    const double mean_pa =
        overburden_pa / (1 - path.sine()) * std::exp(turn_of(normal, up()) * path.tangent());
    const double slimness = face.length_m > 0 ? face.width_m / face.length_m : 1;
    const double peak_rad =
        peak_friction_angle(soil.friction_angle_rad, face.relative_density, mean_pa, slimness);
    return {std::lerp(soil.friction_angle_rad, peak_rad, sole), path.friction()};
}

double WorkLaw::overburden_m(const Strength& soil, const WorkPath& path, const FaceExtent& face,
                             Vec3 normal, double depth_m) const {
    if (!(depth_m > 0)) return 0;
    const double sole = bearing_parts(looks_down(normal, up())).sole;
    const double work = path.work_share(turn_of(normal, up()));
    const double below_m = zone_m(path, face, sole, depth_m);
    const double width_m = std::lerp(face.width_m, face.length_m, sole);
    const double sides_m =
        width_m > 0 ? soil.sides * (depth_m * (depth_m + below_m) + below_m * below_m / 3) /
                          (path.rankine() * width_m)
                    : 0;
    return depth_m + (work - 1) * (depth_m + below_m / 2) + work * sides_m;
}

double WorkLaw::lifting_pa(const ContactVoxel& contact) const {
    const auto material = static_cast<size_t>(contact.material);
    return soil().materials[material].wet_mass_share(contact.saturation) *
           strengths_[material].weight_n_m3 * bearing_depth_of(contact, up());
}

ElementYield WorkLaw::yield(const ContactElement& element, const ElementMotion& along,
                            const ContactHistory& memory) const {
    const ContactVoxel& contact = element.voxel;
    const auto material = static_cast<size_t>(contact.material);
    const MaterialDef& sand = this->soil().materials[material];
    const Strength& soil = strengths_[material];
    const double depth_m = bearing_depth_of(contact, up()), creep = def().creep;
    const Vec3 n = contact.normal, motion = along.share;
    const WorkPath& loose = contact.teeth.part == ToothPart::over_tips ? soil.trapped : soil.face;
    const WorkPath path = element.face.relative_density > 0 && depth_m > 0
                              ? dense_path(soil, loose, element.face, n, depth_m)
                              : loose;
    const double work_pa = sand.wet_mass_share(contact.saturation) * soil.weight_n_m3 *
                           overburden_m(soil, path, element.face, n, depth_m);
    const double approach = dot(motion, n);
    const Vec3 slide = motion - approach * n;
    const double sliding = length(slide);

    ElementYield out;
    out.area_share = area_share_of(contact, sand.friction_angle_rad, def(), up());
    // As PlainLaw: a creep along the normal makes the limit of an element at rest that of a push.
    const Dragging dragging =
        dragging_of(path, n, up(), std::max(approach, 0.0) + creep, slide, creep);
    out.normal_limit_pa = unloaded_share(depth_m, memory.retreat_m, def()) * work_pa *
                          path.dragged_share(dragging.turned_rad);
    const double against = sliding > 0 ? std::max(0.0, -dot(dragging.shear, slide) / sliding) : 0;
    const double moving = length(motion) / (length(motion) + creep);
    out.drag_pa = (out.normal_limit_pa * moving) * dragging.shear;
    if (sliding > 0) {
        out.drag_pa += (out.normal_limit_pa * moving * against / sliding) * slide;
        out.slide = slide * (1 / (sliding + creep));
    }
    out.friction = path.friction() + moving * (against - path.friction());
    if (along.asks_mobilized && approach > 0) {
        const Dragging moved = dragging_of(path, n, up(), approach, slide, creep);
        out.mobilized_pa = work_pa * path.dragged_share(moved.turned_rad) * (moved.shear - n);
    }
    return out;
}

}  // namespace bsoil
