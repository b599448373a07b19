// No status and no refusal without a cause: each cause is looked for apart from the soil.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bullet_types.h"
#include "check.h"
#include "mechanics.h"

namespace bsoil::random_worlds {

using bullet::transform_to_bullet;

namespace {

/// Substeps end between what is seen here, and sinking soil pushes what stands on it: a cause is
/// one from half the limit on.
constexpr double kSpeedMargin = 0.5;

struct Touch final : btCollisionWorld::ContactResultCallback {
    bool is_any = false;
    btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
        is_any = true;
        return 0;
    }
};

/// Whether a body that nothing stops is in the voxel above a place, so that soil has no way up
/// there: what it shuts in with walls, terrain or floor goes into the last voxel left. That is a
/// driven one, or one heavier than all the soil: in world 3002017 a can of 19 t fell into a corner
/// of 3 kg of soil. Seen with the corner of a cube, two sides of the grid and its floor. What is
/// beside the voxel is not asked.
bool is_shut_in(BuiltWorld& world, const Soil& soil, Vec3 place_m) {
    const double voxel_m = soil.frame().voxel_m;
    const auto meets = [&](const btCollisionObject& object, double speed_m_s) {
        // The soil may have met it in a substep.
        btSphereShape ball(static_cast<btScalar>(voxel_m / 2 + speed_m_s * world.frame_s()));
        btCollisionObject probe;
        probe.setCollisionShape(&ball);
        probe.setWorldTransform(transform_to_bullet({place_m + voxel_m * world.up(), Quat{}}));
        Touch touch;
        world.world().contactPairTest(&probe, const_cast<btCollisionObject*>(&object), touch);
        return touch.is_any;
    };
    const std::vector<BodyPlan>& plans = world.plan().bodies;
    for (size_t i = 0; i < plans.size(); ++i) {
        const btRigidBody* body = world.body(static_cast<int>(i));
        if (!body || !is_unstoppable(plans[i], soil)) continue;
        const bool is_driven = plans[i].kind == BodyPlan::Kind::driven;
        const double speed_m_s = is_driven
                                     ? length(plans[i].velocity_m_s)
                                     : static_cast<double>(body->getLinearVelocity().length());
        const double spin_rad_s = is_driven
                                      ? length(plans[i].spin_rad_s)
                                      : static_cast<double>(body->getAngularVelocity().length());
        if (meets(*body, speed_m_s + spin_rad_s * bound_m(plans[i].shape))) return true;
    }
    return false;
}

/// Whether soil fills a place's column from there to the grid's top: there is no way up, either. In
/// world 10001147 a driven ball of 0.68 m stands in the corner of a grid of 2 m from the start, and
/// what it displaces has no room above it.
bool is_full_to_the_top(const Soil& soil, Vec3 place_m) {
    const GridFrame& frame = soil.frame();
    const Vec3 at = frame.to_grid(place_m);
    const auto x = static_cast<int>(at.x), y = static_cast<int>(at.y);
    for (int z = static_cast<int>(at.z) + 1; z < frame.size[2]; ++z) {
        const VoxelSample sample = soil.sample_matter(x, y, z);
        if (sample.volume + sample.coverage < 1) return false;
    }
    return true;
}

/// With the body, the place and the step that it was met at.
std::string text_of(const Soil& soil, StatusBit bit) {
    for (const Condition& condition : soil.conditions()) {
        if (condition.bit == bit) return condition_text(condition);
    }
    return status_texts(static_cast<uint32_t>(bit))[0];
}

class StatusCheck final : public Check {
  public:
    explicit StatusCheck(const BuiltWorld& world)
        : has_left_(world.soils().size()),
          was_fast_(world.soils().size()),
          has_headroom_(world.soils().size()),
          shut_in_(world.soils().size()) {
        watch(const_cast<BuiltWorld&>(world));
    }

    void after_substep(BuiltWorld& world) override { watch_headroom(world); }

    void after_step(BuiltWorld& world, Failures& failures) override {
        watch(world);
        const std::vector<bullet::SoilAction*> soils = world.soils();
        for (size_t i = 0; i < soils.size(); ++i) {
            const uint32_t bits = soils[i]->soil().status_bits();
            const std::string name = fmt::format("soil {}", i);
            for (uint32_t bit = 1; bit != 0 && bit <= bits; bit <<= 1) {
                if ((bits & bit) != 0 && !has_cause(world, i, static_cast<StatusBit>(bit))) {
                    failures.add("status", name, world.time_s(), "no status without its cause",
                                 text_of(soils[i]->soil(), static_cast<StatusBit>(bit)));
                }
            }
            for (const bullet::RefusedBody& refused : soils[i]->refused()) {
                failures.add("refused", name, world.time_s(), "every body takes part",
                             refused.reason);
            }
        }
    }

  private:
    /// What has no way up goes on by its pressure in the next steps: it is looked for at once.
    void watch_headroom(BuiltWorld& world) {
        const std::vector<bullet::SoilAction*> soils = world.soils();
        for (size_t i = 0; i < soils.size(); ++i) {
            const Soil& soil = soils[i]->soil();
            for (const Condition& condition : soil.conditions()) {
                if (condition.bit != StatusBit::amount_headroom || has_headroom_[i]) continue;
                has_headroom_[i] = true;
                shut_in_[i] =
                    condition.position_m && (is_shut_in(world, soil, *condition.position_m) ||
                                             is_full_to_the_top(soil, *condition.position_m));
            }
        }
    }

    void watch(BuiltWorld& world) {
        watch_headroom(world);
        const std::vector<bullet::SoilAction*> soils = world.soils();
        for (const EventPlan& event : world.plan().events) {
            has_teleport_ |= !event.dropped && event.kind == EventPlan::Kind::teleport;
        }
        const auto look = [&](Vec3 at_m, double speed_m_s) {
            for (size_t i = 0; i < soils.size(); ++i) {
                const SoilDef& def = soils[i]->soil().def();
                const GridFrame& frame = soils[i]->soil().frame();
                const Vec3 at = frame.to_grid(at_m);
                // It may have been there in a substep.
                const double slack = speed_m_s * world.frame_s() / def.voxel_m;
                has_left_[i] = has_left_[i] || at.x < slack || at.y < slack || at.z < slack ||
                               at.x > frame.size[0] - slack || at.y > frame.size[1] - slack;
                was_fast_[i] = was_fast_[i] || speed_m_s * def.step_s / def.voxel_m >
                                                   kSpeedMargin * def.substeps_max;
            }
        };
        for (const MovingPart& part : moving_parts(world)) {
            btVector3 middle;
            btScalar radius = 0;
            part.object->getCollisionShape()->getBoundingSphere(middle, radius);
            const auto reach_m = static_cast<double>(radius + middle.length());
            look(part.pose.position, length(part.velocity_m_s) + length(part.spin_rad_s) * reach_m);
            look_for_jolt(world, part, reach_m);
        }
        for (size_t i = 0; i < world.plan().bodies.size(); ++i) {
            const BodyPlan& plan = world.plan().bodies[i];
            const btRigidBody* body = world.body(static_cast<int>(i));
            if (!body || plan.kind != BodyPlan::Kind::driven) continue;
            const btVector3& at = body->getWorldTransform().getOrigin();
            look({static_cast<double>(at.x()), static_cast<double>(at.y()),
                  static_cast<double>(at.z())},
                 length(plan.velocity_m_s) + length(plan.spin_rad_s) * bound_m(plan.shape));
        }
        // Wheels hang below the chassis and beside it, and turn by themselves.
        if (!world.cars().empty()) was_fast_.assign(soils.size(), true);
        for (const BuiltWorld::Car& car : world.cars()) {
            for (int i = 0; i < car.vehicle->getNumWheels(); ++i) {
                look(bullet::from_bullet(car.vehicle->getWheelInfo(i).m_worldTransform.getOrigin()),
                     static_cast<double>(car.chassis->getLinearVelocity().length()));
            }
        }
    }

    /// The soil's steps within one of Bullet's go back from its end by the velocity there. What
    /// Bullet gave in between is a jump in the first of them: in world 10009001 a chain of 2 cm
    /// whips round in a step of 1/30 s, from 26 rad/s to 80, over eight steps of the soil.
    void look_for_jolt(const BuiltWorld& world, const MovingPart& part, double reach_m) {
        const auto [before, is_new] = velocities_.try_emplace(part.object);
        auto& [velocity, spin] = before->second;
        const double jump_m = world.frame_s() * (length(part.velocity_m_s - velocity) +
                                                 length(part.spin_rad_s - spin) * reach_m);
        velocity = part.velocity_m_s;
        spin = part.spin_rad_s;
        const std::vector<bullet::SoilAction*> soils = world.soils();
        for (size_t i = 0; i < soils.size() && !is_new; ++i) {
            const SoilDef& def = soils[i]->soil().def();
            was_fast_[i] = was_fast_[i] || jump_m > kSpeedMargin * def.substeps_max * def.voxel_m;
        }
    }

    bool has_cause(const BuiltWorld& world, size_t soil, StatusBit bit) const {
        const SoilDef& def = world.soil(static_cast<int>(soil)).soil().def();
        // Soil may fall from the grid's top.
        const double height_m = world.plan().soils[soil].def.size_m.z;
        const double fall_voxels =
            std::sqrt(2 * def.gravity_m_s2 * height_m) * def.step_s / def.voxel_m;
        switch (bit) {
            case StatusBit::speed_clamped:
                return was_fast_[soil] || has_teleport_ ||
                       fall_voxels > kSpeedMargin * def.substeps_max;
            case StatusBit::body_teleported:
                return was_fast_[soil] || has_teleport_;
            case StatusBit::body_outside_grid:
                return has_left_[soil];
            case StatusBit::amount_headroom:
                return shut_in_[soil];
            default:
                return false;
        }
    }

    std::map<const btCollisionObject*, std::pair<Vec3, Vec3>> velocities_;  ///< and spins
    std::vector<bool> has_left_, was_fast_;
    std::vector<bool> has_headroom_, shut_in_;  ///< amount_headroom, when it was first met
    bool has_teleport_ = false;
};

}  // namespace

std::unique_ptr<Check> make_status_check(const BuiltWorld& world) {
    return std::make_unique<StatusCheck>(world);
}

}  // namespace bsoil::random_worlds
