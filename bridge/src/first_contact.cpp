#include "first_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "bullet_types.h"
#include "coupling_def.h"

namespace bsoil::bullet {
namespace {

// What it is solved with; what it decides is in CouplingDef.
/// Depths between the body's pose and the one it would fall to at which resistance is known; in
/// between it is interpolated. More cost as many searches for patches each.
constexpr int kDepthCount = 4;
/// Parts in which a substep is solved: a body that stops within one stops to a hundredth of the
/// distance.
constexpr int kPartCount = 128;
/// More than the distance in a vacuum, so that the last part has something to interpolate.
constexpr double kSpareWay = 1.01;

Aabb box_of(const btCollisionObject& object, Vec3 shift_m) {
    btVector3 low, high;
    object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
    return {from_bullet(low) + shift_m, from_bullet(high) + shift_m};
}

/// Of a push along n at a point.
double effective_mass_kg(const btRigidBody& body, Vec3 arm_m, Vec3 n) {
    const btVector3 turn = to_bullet(cross(arm_m, n));
    const btScalar mobility = body.getInvMass() + turn.dot(body.getInvInertiaTensorWorld() * turn);
    return 1 / static_cast<double>(mobility);
}

struct Resistance {
    double force_n = 0;    ///< against the motion, at rest
    double drag_kg_m = 0;  ///< what speed adds, per square of speed
};

/// How a body of `mass_kg` that moves at `speed_m_s` is stopped; resistance(way_m) does not push
/// back.
Stopping stop_within(double duration_s, double mass_kg, double speed_m_s, double acceleration_m_s2,
                     const std::function<Resistance(double way_m)>& resistance) {
    const double part_s = duration_s / kPartCount;
    Stopping out{0, speed_m_s};
    for (int part = 0; part < kPartCount; ++part) {
        const Resistance now = resistance(out.way_m + 0.5 * part_s * out.speed_m_s);
        const double held = now.force_n / mass_kg;
        const double drag = now.drag_kg_m / mass_kg * part_s * out.speed_m_s;
        const double next =
            std::max(0.0, (out.speed_m_s + part_s * (acceleration_m_s2 - held)) / (1 + drag));
        out.way_m += 0.5 * part_s * (out.speed_m_s + next);
        out.speed_m_s = next;
    }
    return out;
}

}  // namespace

/// Bodies that constraints of the host hold; ours are not in the world.
void FirstContacts::find_jointed(btDiscreteDynamicsWorld& world) {
    jointed_.clear();
    for (int i = 0; i < world.getNumConstraints(); ++i) {
        btTypedConstraint& joint = *world.getConstraint(i);
        jointed_.push_back(&joint.getRigidBodyA());
        jointed_.push_back(&joint.getRigidBodyB());
    }
    std::sort(jointed_.begin(), jointed_.end(), std::less<>());
}

void FirstContacts::find_carriers(const btDiscreteDynamicsWorld& world,
                                  std::span<const BodyLoad> loads) {
    carriers_.clear();
    if (loads.empty()) return;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const int id = collector_.body_id(*objects[i]);
        if (id >= 0 && std::any_of(loads.begin(), loads.end(),
                                   [id](const BodyLoad& load) { return load.body == id; })) {
            carriers_.push_back(box_of(*objects[i], {}));
        }
    }
}

bool FirstContacts::is_over_carrier(const Aabb& box) const {
    return std::any_of(carriers_.begin(), carriers_.end(), [&](const Aabb& carrier) {
        const Vec3 low = carrier.min - box.max, high = box.min - carrier.max;
        return std::max({low.x, low.y, low.z, high.x, high.y, high.z}) <= 0;
    });
}

void FirstContacts::open_substep(btDiscreteDynamicsWorld& world, std::span<const BodyLoad> loads) {
    const auto substep_s = static_cast<double>(world.getDispatchInfo().m_timeStep);
    if (!(substep_s > 0)) return;
    coupling_.take_rows_out();  // and the preloads: forces are the host's alone
    find_jointed(world);
    find_carriers(world, loads);
    coupling_.find_touched();
    for (auto& [id, falling] : bodies_) falling.is_open = false;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        btRigidBody* body = btRigidBody::upcast(objects[i]);
        if (!body || body->isStaticOrKinematicObject() || !body->isActive()) continue;
        if (std::binary_search(jointed_.begin(), jointed_.end(), objects[i], std::less<>())) {
            continue;
        }
        open(world, *body, substep_s);
    }
    std::erase_if(bodies_, [](const auto& entry) { return !entry.second.is_open; });
}

void FirstContacts::open(btDiscreteDynamicsWorld& world, btRigidBody& body, double substep_s) {
    const Vec3 acceleration_m_s2 =
        static_cast<double>(body.getInvMass()) * from_bullet(body.getTotalForce());
    const Vec3 velocity_m_s = from_bullet(body.getLinearVelocity()) + substep_s * acceleration_m_s2;
    // What no point of it can reach in this substep needs no closer look.
    const Aabb box = box_of(body, {});
    const double radius_m = length(box.max - box.min) / 2;
    const double turn_m_s = radius_m * static_cast<double>(body.getAngularVelocity().length());
    const double fall_m = substep_s * (turn_m_s - dot(velocity_m_s, up_));
    if (!(fall_m > 0) || !is_finite(from_bullet(body.getWorldTransform()))) return;
    const BodyState* state = collector_.meet(world, body);
    if (!state) return;
    const auto known = bodies_.find(state->id);
    // The soil makes way for a body that it holds: its surface is where it was met.
    const BodyReport report = coupling_.report(state->id);
    const bool is_held = report.sinkage_m > 0;
    if (known == bodies_.end() && (is_held || is_over_carrier({box.min - fall_m * up_, box.max}))) {
        return;
    }
    Falling falling = known == bodies_.end() ? Falling{} : known->second;
    if (!is_held) {
        const std::optional<SurfaceSoil> soil = soil_below_.at(0.5 * (box.min + box.max));
        if (!soil) return;
        falling.surface = *soil;
        // Bullet's speed of a body in free fall is that of the substep's middle.
        if (known == bodies_.end()) {
            const Vec3 n = soil->plane.normal;
            const bool falls = dot(from_bullet(body.getLinearVelocity()), n) < 0;
            falling.lead_m_s = falls ? -0.5 * substep_s * dot(acceleration_m_s2, n) : 0;
        }
    }
    if (meet(*state, collector_.shapes_of(*state), acceleration_m_s2, substep_s, falling)) {
        falling.is_open = true;
        falling.age_s += substep_s;
        bodies_[state->id] = falling;
    }
}

bool FirstContacts::meet(const BodyState& state, std::span<const ConvexShape> shapes,
                         Vec3 acceleration_m_s2, double substep_s, Falling& falling) {
    btRigidBody& body = *static_cast<btRigidBody*>(state.object);
    const Vec3 n = falling.surface.plane.normal;
    const double rise = dot(n, up_);
    const BodyMotion& motion = state.motion;
    // Along the plane's normal, downwards. First the way of the centre of mass.
    const double driven_m_s2 = -dot(acceleration_m_s2, n);
    const auto way_of = [&](double speed_m_s) {
        return std::max(0.0,
                        substep_s * (speed_m_s + falling.lead_m_s + 0.5 * substep_s * driven_m_s2));
    };
    const double most_m =
        kSpareWay * way_of(-dot(motion.linear_velocity_m_s, n) +
                           length(motion.angular_velocity_rad_s) *
                               length(box_of(body, {}).max - box_of(body, {}).min) / 2);
    if (!(most_m > 0)) return false;
    Pose deepest = motion.pose;
    deepest.position = deepest.position - most_m * n;
    const double apart_m =
        sample_underside(shapes, deepest, box_of(body, -most_m * n), falling.surface, up_,
                         coupling_.voxel_m(), state.id, elements_);
    if (elements_.empty()) return false;

    // The point that meets it, and the mass that is behind it.
    Vec3 center;
    double weight = 0;
    for (const ContactVoxel& element : elements_) {
        center += element.area_m2 * element.depth_m * element.position_m;
        weight += element.area_m2 * element.depth_m;
    }
    center = center * (1 / weight) + most_m * n;
    const double mass_kg = effective_mass_kg(body, center - motion.center_of_mass_m, n);
    const double bullet_m_s = -dot(motion.velocity_at(center), n);
    const double speed_m_s = std::max(0.0, bullet_m_s + falling.lead_m_s);

    const ContactLaw& law = coupling_.law_for(state);
    const auto material = static_cast<size_t>(falling.surface.material);
    if (material >= law.soil().materials.size()) return false;
    const MaterialDef& soil = law.soil().materials[material];
    const double density_kg_m3 =
        soil.density_kg_m3 * soil.wet_mass_share(falling.surface.saturation);
    BodyMotion still = motion, direction = motion;
    still.linear_velocity_m_s = still.angular_velocity_rad_s = {};
    coupling_.as_direction(direction, length(center - motion.center_of_mass_m));
    /// The body on its way down: its patches, and what they resist.
    const auto resistance_at = [&](double way_m) {
        lifted_.clear();
        Resistance out;
        for (ContactVoxel element : elements_) {
            element.depth_m -= (most_m - way_m) / rise;
            if (!(element.depth_m > 0)) continue;
            element.bearing_depth_m = element.depth_m;
            element.position_m += (most_m - way_m) * n;
            element.center_m = element.position_m;
            lifted_.push_back(element);
            const double facing = std::max(0.0, -dot(element.normal, n));
            out.drag_kg_m += density_kg_m3 * element.area_m2 * facing * facing * facing;
        }
        const ContactMotion on_ground{-1, still, direction, {}, {}};
        found_.find(lifted_, {&on_ground, 1}, law, {}, nullptr, apart_m);
        for (const ContactPatch& patch : found_.patches()) {
            out.force_n -= patch.normal_limit_n * dot(patch.normal, n);
        }
        return out;
    };
    // More closely where it starts: a ball's resistance grows with the square of its depth.
    double depth_m = 0;
    for (const ContactVoxel& element : elements_) depth_m = std::max(depth_m, element.depth_m);
    const double met_m = std::max(0.0, most_m - depth_m * rise);
    const double here_n = resistance_at(0).force_n;
    std::array<Resistance, kDepthCount + 1> known;
    for (int i = 0; i <= kDepthCount; ++i) {
        const double part = static_cast<double>(i) / kDepthCount;
        known[i] = resistance_at(met_m + part * part * (most_m - met_m));
    }
    const auto resistance = [&](double way_m) {
        if (way_m <= met_m) return known[0];
        const double part = std::min(1.0, (way_m - met_m) / (most_m - met_m));
        const int i = std::min(static_cast<int>(std::sqrt(part) * kDepthCount), kDepthCount - 1);
        const double low = i * i, high = (i + 1) * (i + 1);
        const double t = (part * kDepthCount * kDepthCount - low) / (high - low);
        return Resistance{known[i].force_n + t * (known[i + 1].force_n - known[i].force_n),
                          known[i].drag_kg_m + t * (known[i + 1].drag_kg_m - known[i].drag_kg_m)};
    };
    const Stopping stopping = stop_within(substep_s, mass_kg, speed_m_s, driven_m_s2, resistance);
    // Bullet moves the body by its speed after the solve times the substep.
    const double next_m_s = stopping.way_m / substep_s;
    double limit_n = mass_kg * ((bullet_m_s - next_m_s) / substep_s + driven_m_s2);
    // What stands, or has others on it, the soil holds with all it has.
    const bool is_alone = falling.age_s < kCoupling.impact_most_s && !coupling_.is_touched(&body);
    if (!is_alone || !(speed_m_s > 0)) limit_n = std::max(limit_n, here_n);
    falling.next_lead_m_s = stopping.speed_m_s - next_m_s;
    falling.speed_m_s = stopping.speed_m_s;

    const double first_m = (most_m - met_m) / (kDepthCount * kDepthCount);
    const double way_m = std::max(stopping.way_m, met_m + first_m);
    const double force_n = resistance_at(way_m).force_n;
    if (!(force_n > 0) || !(limit_n > 0)) return true;
    patches_.assign(found_.patches().begin(), found_.patches().end());
    for (ContactPatch& patch : patches_) patch.normal_limit_n *= limit_n / force_n;
    coupling_.set_patches(state, direction, patches_);
    return true;
}

void FirstContacts::close_substep() {
    for (auto& [id, falling] : bodies_) {
        if (falling.is_open) falling.lead_m_s = falling.next_lead_m_s;
    }
}

bool FirstContacts::has_stopped(double speed_m_s, double duration_s) const {
    return speed_m_s * duration_s < kCoupling.stopped_voxels * coupling_.voxel_m();
}

void FirstContacts::soil_has_stepped(double step_s) {
    std::erase_if(bodies_, [&](const auto& entry) {
        const auto& [id, falling] = entry;
        const BodyReport report = coupling_.report(id);
        return report.sinkage_m > 0 &&
               (has_stopped(falling.speed_m_s, step_s) || falling.age_s > kCoupling.impact_most_s);
    });
}

}  // namespace bsoil::bullet
