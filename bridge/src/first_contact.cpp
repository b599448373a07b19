#include "first_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "bullet_types.h"
#include "coupling_def.h"
#include "rigid_patch_constraint.h"

namespace bsoil::bullet {
namespace {

/// The table of resistance reaches this much deeper than the body would fall in a vacuum. Ours: the
/// last part of the path needs a point behind it to interpolate. Larger: the underside is sampled
/// deeper than it ever gets.
constexpr double kSparePath = 1.01;

/// Soil this much below the plane that a body comes down on [voxels] is not what its underside
/// there meets. Ours: as well as a column's height is known. Larger: a body is held in the air over
/// soil that lies between its legs, or in it; smaller: a body on uneven ground is held at its bumps
/// alone.
constexpr double kSamePlaneVoxels = 1;
/// What falls by less than this in a substep before the soil's first step [voxels] waits for that
/// step. Ours: what stands there from the start does, and has its contacts from then on. Larger: a
/// body that is thrown at once goes deeper; smaller: what was put on the soil is held twice.
constexpr double kFastVoxels = 0.1;

Aabb box_of(const btCollisionObject& object, Vec3 shift_m) {
    btVector3 low, high;
    object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
    return {from_bullet(low) + shift_m, from_bullet(high) + shift_m};
}

/// A body that moves along a push by less than this share of what it would without its host's
/// factors is locked against it. Ours: for the rounding. Larger: a body that gives way a little
/// waits for the soil's step.
constexpr double kLockedShare = 1e-6;

/// Of a push along n at a point; empty where the body's host has locked it against that.
std::optional<double> effective_mass_kg(const btRigidBody& body, Vec3 arm_m, Vec3 n) {
    const Vec3 factor = from_bullet(body.getLinearFactor());
    const double share =
        1 - n.x * n.x * (1 - factor.x) - n.y * n.y * (1 - factor.y) - n.z * n.z * (1 - factor.z);
    const btVector3 turn = to_bullet(cross(arm_m, n));
    const btVector3 turned = body.getInvInertiaTensorWorld() * turn * body.getAngularFactor();
    const btScalar mobility = body.getInvMass() * static_cast<btScalar>(share) + turn.dot(turned);
    const double mobility_per_kg = static_cast<double>(mobility);
    if (!(mobility_per_kg > kLockedShare * static_cast<double>(body.getInvMass()))) return {};
    return 1 / mobility_per_kg;
}

}  // namespace

/// Bodies that constraints of the host hold. Ours are not in the world, but those of another soil
/// may be, with what it has given the body beforehand. A joint that broke stays in the world,
/// switched off.
void FirstContacts::find_jointed(btDiscreteDynamicsWorld& world) {
    jointed_.clear();
    given_n_.clear();
    for (int i = 0; i < world.getNumConstraints(); ++i) {
        btTypedConstraint& joint = *world.getConstraint(i);
        if (const auto* row = dynamic_cast<const RigidPatchConstraint*>(&joint)) {
            for (const btRigidBody* body : {&joint.getRigidBodyA(), &joint.getRigidBodyB()}) {
                if (!body->isStaticObject()) given_n_[body] += from_bullet(row->preload_n(*body));
            }
        }
        if (!joint.isEnabled() || SubstepRows::is_row(joint)) continue;
        jointed_.push_back(&joint.getRigidBodyA());
        jointed_.push_back(&joint.getRigidBodyB());
    }
    std::sort(jointed_.begin(), jointed_.end(), std::less<>());
}

/// Before the soil's first step nobody knows, and each body that moves may be one.
void FirstContacts::find_carriers(const btDiscreteDynamicsWorld& world,
                                  std::span<const BodyLoad> loads, bool has_stepped) {
    carriers_.clear();
    if (loads.empty() && has_stepped) return;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const int id = collector_.body_id(*objects[i]);
        const auto is_of_it = [id](const BodyLoad& load) {
            return load.body == id && load.mass_kg > 0;
        };
        const bool carries = has_stepped ? id >= 0 && std::ranges::any_of(loads, is_of_it)
                                         : !objects[i]->isStaticObject();
        if (carries) carriers_.emplace_back(objects[i], box_of(*objects[i], {}));
    }
}

bool FirstContacts::is_over_carrier(const Aabb& box, const btCollisionObject& but) const {
    return std::any_of(carriers_.begin(), carriers_.end(), [&](const auto& carrier) {
        const Vec3 low = carrier.second.min - box.max, high = box.min - carrier.second.max;
        return carrier.first != &but &&
               std::max({low.x, low.y, low.z, high.x, high.y, high.z}) <= 0;
    });
}

void FirstContacts::open_substep(btDiscreteDynamicsWorld& world, std::span<const BodyLoad> loads,
                                 bool has_stepped) {
    const auto substep_s = static_cast<double>(world.getDispatchInfo().m_timeStep);
    if (!(substep_s > 0)) return;
    coupling_.take_rows_out();  // and the preloads: forces are the host's alone
    find_jointed(world);
    find_carriers(world, loads, has_stepped);
    coupling_.find_touched();
    for (auto& [id, falling] : bodies_) falling.is_open = false;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        btRigidBody* body = btRigidBody::upcast(objects[i]);
        if (!body || body->isStaticOrKinematicObject() || !body->isActive()) continue;
        if (std::binary_search(jointed_.begin(), jointed_.end(), objects[i], std::less<>())) {
            continue;
        }
        open(world, *body, substep_s, has_stepped);
    }
    std::erase_if(bodies_, [](const auto& entry) { return !entry.second.is_open; });
}

void FirstContacts::open(btDiscreteDynamicsWorld& world, btRigidBody& body, double substep_s,
                         bool has_stepped) {
    const auto given = given_n_.find(&body);
    const Vec3 force_n =
        from_bullet(body.getTotalForce()) - (given == given_n_.end() ? Vec3{} : given->second);
    const Vec3 acceleration_m_s2 = static_cast<double>(body.getInvMass()) * force_n;
    const Vec3 velocity_m_s = from_bullet(body.getLinearVelocity()) + substep_s * acceleration_m_s2;
    // What no point of it can reach in this substep needs no closer look.
    const Aabb box = box_of(body, {});
    const double radius_m = length(box.max - box.min) / 2;
    const double turn_m_s = radius_m * static_cast<double>(body.getAngularVelocity().length());
    const double fall_m = substep_s * (turn_m_s - dot(velocity_m_s, up_));
    if (!(fall_m > 0) || !is_rigid(from_bullet(body.getWorldTransform()))) return;
    if (!has_stepped && fall_m < kFastVoxels * coupling_.voxel_m()) return;
    const BodyState* state = collector_.meet(world, body);
    if (!state) return;
    const auto known = bodies_.find(state->id);
    const bool is_new = known == bodies_.end();
    // A body that the soil holds has displaced it: the surface stays where the body met it.
    const BodyReport report = coupling_.report(state->id);
    const bool is_held = report.sinkage_m > 0;
    if (is_new && (is_held || is_over_carrier({box.min - fall_m * up_, box.max}, body))) return;
    Falling falling = is_new ? Falling{} : known->second;
    falling.is_new = is_new;
    if (!is_held) {
        const std::optional<SurfaceSoil> soil = soil_below_.under(box);
        if (!soil) return;
        falling.surface = *soil;
        // Bullet's speed of a body in free fall is that of the substep's middle.
        if (is_new) {
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

/// Of a body with a hollow the plane under its middle may be that of soil in there, and of a body
/// that carries soil, its own. The underside meets what lies below it: looked for from where it is
/// now, `up_m` above where it would go.
void FirstContacts::leave_what_meets(Vec3 up_m, const SurfacePoint& plane) {
    const double least_m = -kSamePlaneVoxels * coupling_.voxel_m();
    std::erase_if(elements_, [&](const ContactVoxel& element) {
        const std::optional<SurfaceSoil> below = soil_below_.at(element.position_m + up_m);
        if (!below) return true;
        const Vec3 at = below->plane.position_m;
        const double above_plane_m =
            dot(at - plane.position_m, plane.normal) / dot(plane.normal, up_);
        return above_plane_m < least_m;
    });
}

std::optional<FirstContacts::Approach> FirstContacts::approach(const BodyState& state,
                                                               std::span<const ConvexShape> shapes,
                                                               Vec3 acceleration_m_s2,
                                                               double substep_s,
                                                               const Falling& falling) {
    const btRigidBody& body = *static_cast<const btRigidBody*>(state.object);
    const Vec3 n = falling.surface.plane.normal;
    const BodyMotion& motion = state.motion;
    // Downwards along the plane's normal. First the path of the centre of mass.
    const double driven_m_s2 = -dot(acceleration_m_s2, n);
    const double size_m = length(box_of(body, {}).max - box_of(body, {}).min);
    const double fastest_m_s =
        -dot(motion.linear_velocity_m_s, n) + length(motion.angular_velocity_rad_s) * size_m / 2;
    const double most_m =
        kSparePath *
        std::max(0.0, substep_s * (fastest_m_s + falling.lead_m_s + 0.5 * substep_s * driven_m_s2));
    if (!(most_m > 0)) return {};
    Pose deepest = motion.pose;
    deepest.position = deepest.position - most_m * n;
    const double apart_m =
        sample_underside(shapes, deepest, box_of(body, -most_m * n), falling.surface, up_,
                         coupling_.voxel_m(), state.id, elements_);
    if (falling.is_new) leave_what_meets(most_m * n, falling.surface.plane);
    if (elements_.empty()) return {};

    // The point that meets it, and the mass that is behind it.
    const Vec3 center = Impact::center_m(elements_, most_m, n);
    const std::optional<double> mass_kg =
        effective_mass_kg(body, center - motion.center_of_mass_m, n);
    if (!mass_kg) return {};
    Approach out;
    out.bullet_m_s = -dot(motion.velocity_at(center), n);
    out.fall = {*mass_kg, std::max(0.0, out.bullet_m_s + falling.lead_m_s), driven_m_s2};
    const ContactLaw& law = coupling_.law_for(state);
    const auto material = static_cast<size_t>(falling.surface.material);
    if (material >= law.soil().materials.size()) return {};
    const MaterialDef& soil = law.soil().materials[material];
    const BodyMotion direction = as_share(motion, length(center - motion.center_of_mass_m),
                                          {.voxel_m = coupling_.voxel_m()});
    impact_.start(law, elements_,
                  {motion, direction, most_m, apart_m,
                   soil.density_kg_m3 * soil.wet_mass_share(falling.surface.saturation), n});
    out.direction = direction;
    return out;
}

bool FirstContacts::meet(const BodyState& state, std::span<const ConvexShape> shapes,
                         Vec3 acceleration_m_s2, double substep_s, Falling& falling) {
    const std::optional<Approach> found =
        approach(state, shapes, acceleration_m_s2, substep_s, falling);
    if (!found) return false;
    const Fall& fall = found->fall;
    const Stopping stopping = impact_.stop(fall, substep_s);
    // Bullet moves the body by its speed after the solve times the substep.
    const double next_m_s = stopping.way_m / substep_s;
    double limit_n =
        fall.mass_kg * ((found->bullet_m_s - next_m_s) / substep_s + fall.acceleration_m_s2);
    // What stands, or has others on it, the soil holds with all it has.
    const bool is_alone =
        falling.age_s < kCoupling.impact_most_s && !coupling_.is_touched(state.object);
    if (!is_alone || !(fall.speed_m_s > 0)) limit_n = std::max(limit_n, impact_.resting_force_n());
    falling.next_lead_m_s = stopping.speed_m_s - next_m_s;
    falling.speed_m_s = stopping.speed_m_s;

    const double force_n = impact_.at(std::max(stopping.way_m, impact_.first_way_m())).force_n;
    if (!(force_n > 0) || !(limit_n > 0)) return true;
    patches_.assign(impact_.patches().begin(), impact_.patches().end());
    for (ContactPatch& patch : patches_) patch.normal_limit_n *= limit_n / force_n;
    coupling_.set_patches(state, found->direction, patches_);
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
