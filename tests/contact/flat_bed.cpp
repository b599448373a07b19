#include "flat_bed.h"

#include <algorithm>
#include <cmath>

#include "bsoil/contact/contact_faces.h"
#include "bsoil/contact/granular_law.h"
#include "bsoil/contact/plain_law.h"

namespace bsoil::flat_bed {
namespace {

constexpr double kNever = -1;  ///< a shear displacement that no rule asks for

/// Length of the path that a wheel's surface has slid along the soil since it entered it.
double sheared_m(const ContactLaw& law, const Case& c, Vec3 arm, double sinkage_m) {
    const Vec3 axle = rotate(c.motion.pose.rotation, {0, 1, 0});
    const double omega = dot(c.motion.angular_velocity_rad_s, axle);
    if (!(c.radius_m > 0) || std::abs(omega) < 1e-9) return 1e9;
    constexpr int kSteps = 24;
    // Back along its circle to where it came in.
    double path = 0;
    const double step_rad = kPi / 2 / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const Vec3 velocity = c.motion.velocity_m_s + cross(c.motion.angular_velocity_rad_s, arm);
        const Vec3 flat = arm - dot(arm, axle) * axle;
        const double size = length(flat);
        const Vec3 n = size > 0 ? flat * (1 / size) : Vec3{0, 0, -1};
        ContactVoxel rim;
        rim.normal = n;
        path += length(law.slide_m_s(rim, velocity)) * step_rad / std::abs(omega);
        const double a = omega > 0 ? -step_rad : step_rad;
        const Vec3 turned = std::cos(a) * flat + std::sin(a) * cross(axle, flat);
        arm = turned + dot(arm, axle) * axle;
        if (-arm.z < c.radius_m - sinkage_m) break;
    }
    return path;
}

}  // namespace

oracle::Wrench force_of(const Law& law, const Case& c, double sinkage_m) {
    MaterialDef material;
    material.density_kg_m3 = c.soil.density_kg_m3;
    material.loose_density_kg_m3 = material.compacted_density_kg_m3 = 0;
    material.friction_angle_rad = radians(c.soil.friction_angle_deg);
    material.cohesion_pa = law.is_granular ? c.soil.cohesion_pa : 0;
    material.tool_friction = c.friction;
    material.shear_displacement_m = law.is_granular ? c.soil.published_k_m : 0;
    auto soil = std::make_shared<ContactSoil>();
    soil->materials = {material};
    soil->voxel_m = c.edge_m;
    soil->law.kind = law.is_granular ? ContactLawDef::Kind::granular : ContactLawDef::Kind::plain;
    soil->law.passive_wedge = law.rules.wedge;
    soil->law.trapped_soil = law.rules.lugs == Rules::Lugs::trapped;
    const auto contact_law = ContactLaw::make(soil);
    const SoilStrength strength = strength_of(material, 9.81);
    const double tan_phi = std::tan(material.friction_angle_rad);

    std::vector<ContactVoxel> voxels;
    std::vector<Vec3> arms;
    for (size_t i = 0; i < c.surface->size(); ++i) {
        const oracle::Facet& facet = (*c.surface)[i];
        const Vec3 arm = rotate(c.motion.pose.rotation, facet.at);
        const double depth_m = -(c.motion.pose.position.z + arm.z);
        if (depth_m <= 0) continue;
        ContactVoxel& v = voxels.emplace_back();
        v.center_m = v.position_m = c.motion.pose.position + arm;
        v.normal = rotate(c.motion.pose.rotation, facet.normal);
        v.area_m2 = facet.area_m2;
        v.depth_m = v.bearing_depth_m = depth_m;
        v.relative_density = -1;
        if (c.teeth) {
            v.teeth = (*c.teeth)[i];
            v.teeth.outward = rotate(c.motion.pose.rotation, v.teeth.outward);
        }
        arms.push_back(arm);
    }
    oracle::Wrench sum;
    if (voxels.empty()) return sum;
    ContactFaces faces;
    faces.find(voxels, c.motion.pose.rotation, *contact_law, c.edge_m);
    const BodyBow bow(law.rules.bow, material, c.motion.velocity_m_s, voxels);
    double extent_m = 0;
    for (const Vec3& arm : arms) extent_m = std::max(extent_m, length(arm));
    const double fastest =
        length(c.motion.velocity_m_s) + extent_m * length(c.motion.angular_velocity_rad_s);
    for (size_t i = 0; i < voxels.size(); ++i) {
        const ContactVoxel& v = voxels[i];
        const Vec3 velocity =
            c.motion.velocity_m_s + cross(c.motion.angular_velocity_rad_s, arms[i]);
        const Vec3 share = velocity * (1 / fastest);
        const double approach = dot(share, v.normal);
        if (approach <= 1e-9) continue;
        const FaceExtent& face = faces.of_voxel(i);
        const double k_m = law.is_granular ? c.soil.published_k_m : law.rules.shear_k_m;
        const double j_m = k_m > 0 ? sheared_m(*contact_law, c, arms[i], sinkage_m) : kNever;
        const ElementYield yield =
            contact_law->yield({v, face}, {share, 0}, {j_m < 0 ? 1e9 : j_m, 0});
        double normal_pa = yield.normal_limit_pa, friction = yield.friction;
        const double down = std::max(0.0, -v.normal.z), sole = down * down;
        if (law.rules.bearing) {
            normal_pa *= sole * face_factors(strength, face, v.depth_m).sole + 1 - sole;
        }
        if (law.rules.shear_k_m > 0) {
            friction = std::min(friction, tan_phi * -std::expm1(-j_m / law.rules.shear_k_m));
        }
        const Vec3 slide = yield.slide;
        const double sliding = length(slide);
        Vec3 stress = -normal_pa * v.normal;
        if (yield.normal_limit_pa > 0) {
            stress += (normal_pa / yield.normal_limit_pa) * yield.drag_pa;
        }
        if (sliding > 0) stress += slide * (-(friction * normal_pa + yield.adhesion_pa) / sliding);
        stress = bow.stress_pa(stress, v, velocity);
        const Vec3 force = v.area_m2 * yield.area_share * stress;
        sum.force_n += force;
        sum.moment_n_m += cross(arms[i], force);
    }
    return sum;
}

ConvexShape cylinder(double radius_m, double width_m, bool lies) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::cylinder;
    shape.radius_m = radius_m;
    shape.half_height_m = width_m / 2;
    if (lies) shape.local.rotation = {std::sin(kPi / 4), 0, 0, std::cos(kPi / 4)};
    return shape;
}

}  // namespace bsoil::flat_bed
