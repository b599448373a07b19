#include "bsoil/contact/work_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/load_side.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/trapped_soil.h"

namespace bsoil {
namespace {

/// By how much a push along a normal turns before it rises: 90 deg of a level sole, none of a wall.
double turn_of(Vec3 normal, Vec3 up) { return std::asin(std::clamp(-dot(normal, up), -1.0, 1.0)); }

/// What friction along a face does, of a motion.
struct Rubbed {
    double share = 1;  ///< WorkPath::rubbed_share()
    Vec3 shear;        ///< on the body, over the normal stress
};

/// approach > 0 and slide: of the face, along its normal and along itself.
Rubbed rubbed_by(const WorkPath& path, Vec3 normal, Vec3 up, double approach, Vec3 slide,
                 double creep) {
    const Vec3 along = up - dot(up, normal) * normal;
    const double level = length(along);
    // Towards the free surface. A level face has no such direction: see slide_past_flow(). Under it
    // soil goes out to both sides, and what it drags on the one it holds on the other.
    const Vec3 to_surface = level > 0 ? along * (1 / level) : Vec3{};
    const double flow = path.rise() * std::min(1.0, level / kLeaningSine);
    const Vec3 past = slide - flow * approach * to_surface;
    const Vec3 rubs = past * (1 / (length(past) + creep * (approach + length(slide))));
    return {path.rubbed_share(flow * dot(rubs, to_surface)), -path.friction() * rubs};
}

}  // namespace

WorkPath::WorkPath(double friction_angle_rad, double friction)
    : sine_(std::sin(friction_angle_rad)),
      tangent_(std::tan(friction_angle_rad)),
      rise_(std::tan(std::numbers::pi / 4 - friction_angle_rad / 2)),
      friction_(std::clamp(friction, 0.0, tangent_)) {}

double WorkPath::work_share(double turn_rad) const {
    return std::max(1.0, rankine() * std::exp(2 * turn_rad * tangent_));
}

double WorkPath::rubbed_share(double past_flow) const { return 1 / (1 + friction_ * past_flow); }

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
    return sole * developed_bearing(face, depth_m, def()) * face.width_m / (2 * path.rise());
}

WorkPath WorkLaw::dense_path(const Strength& soil, const WorkPath& path, const FaceExtent& face,
                             Vec3 normal, double depth_m) const {
    const double sole = bearing_parts(looks_down(normal, up())).sole;
    const double overburden_pa =
        soil.weight_n_m3 * (depth_m + zone_m(path, face, sole, depth_m) / 2);
    const double mean_pa =
        overburden_pa / (1 - path.sine()) * std::exp(turn_of(normal, up()) * path.tangent());
    const double peak_rad = peak_friction_angle(soil.friction_angle_rad, face.relative_density,
                                                mean_pa, slimness_of(face));
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
    if (contact.is_load_side) return load_side_yield(this->soil(), contact, along);
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
    const Rubbed rubbed = rubbed_by(path, n, up(), std::max(approach, 0.0) + creep, slide, creep);
    out.pushed_pa = work_pa * rubbed.share;
    out.normal_limit_pa = unloaded_share(depth_m, memory.retreat_m, def()) * out.pushed_pa;
    const double against = sliding > 0 ? std::max(0.0, -dot(rubbed.shear, slide) / sliding) : 0;
    const double moving = length(motion) / (length(motion) + creep);
    out.drag_pa = (out.normal_limit_pa * moving) * rubbed.shear;
    if (sliding > 0) {
        out.drag_pa += (out.normal_limit_pa * moving * against / sliding) * slide;
        out.slide = slide * (1 / (sliding + creep));
    }
    out.friction = path.friction() + moving * (against - path.friction());
    if (along.asks_mobilized && approach > 0) {
        const Rubbed moved = rubbed_by(path, n, up(), approach, slide, creep);
        out.mobilized_pa = work_pa * moved.share * (moved.shear - n);
    }
    return out;
}

}  // namespace bsoil
