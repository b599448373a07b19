/// Mechanics of the bodies of a world, reckoned from what Bullet shows of them.
#pragma once

#include <map>
#include <set>

#include "built_world.h"

namespace bsoil::random_worlds {

/// One solid that moves: a rigid body or a part of a multibody.
struct MovingPart {
    const btCollisionObject* object = nullptr;
    double mass_kg = 0;
    Vec3 inertia_kg_m2;  ///< about its own axes
    Pose pose;           ///< of its centre of mass
    Vec3 velocity_m_s, spin_rad_s;
    bool is_asleep = false;
    bool is_of_chain = false;
};
/// All of them that are in the world now; fixed bases and driven bodies are not.
std::vector<MovingPart> moving_parts(const BuiltWorld& world);
/// All but rigid bodies that have left the soil with all that joints hold them to: what they do on
/// the floor below is Bullet's alone.
std::vector<MovingPart> parts_at_soil(const BuiltWorld& world);
/// The velocities of a multibody's base and links, the base first [m/s, rad/s], world.
struct LinkMotion {
    btVector3 velocity, spin;
};
std::vector<LinkMotion> link_motions(const btMultiBody& multibody);

/// Kinetic energy, and potential energy above the lowest soil's floor [J].
double energy_j(const BuiltWorld& world, std::span<const MovingPart> parts);
/// Distance along up [m].
double height_m(const BuiltWorld& world, Vec3 world_m);
/// Force of all soils on the body, and of the ground on a car's wheels, with the weight of what it
/// carries, the push of what falls on it and what stands on that: what bears it [N].
Vec3 soil_force_n(const BuiltWorld& world, const btCollisionObject& object);
double load_kg(const BuiltWorld& world, const btCollisionObject& object);
/// Whether the forces on a car that stands add up to its weight: none of them is left out.
bool tells_its_weight(const BuiltWorld::Car& car, Vec3 up);

/// The index of the soil over whose grid a point lies, -1: none. `margin_m` within its sides.
int soil_below(const BuiltWorld& world, Vec3 world_m, double margin_m);
/// Whether it touches anything but soil.
bool touches_others(btDispatcher& dispatcher, const btCollisionObject& object);
/// Bullet wakes a body in each step whose box meets that of a driven body which its host never lets
/// sleep, and with it the body's island: the tags of such islands. World 81157: a body at rest
/// beside a driven one.
std::set<int> islands_kept_awake(btDispatcher& dispatcher);
/// Whether nothing stops a body: it is driven, or heavier than all the soil.
bool is_unstoppable(const BodyPlan& body, const Soil& soil);
/// Whether Bullet's box about an object reaches into a soil's grid.
bool reaches_into(const bullet::SoilAction& soil, const btCollisionObject& object);
/// Whether a body is over no soil, or has gone through its floor.
bool has_left_soil(const BuiltWorld& world, const MovingPart& part);

/// Bodies of a joint and a chain's links: together they weigh what soil bears of them.
class WeighedTogether {
  public:
    explicit WeighedTogether(const BuiltWorld& world);
    /// The same for bodies that weigh together; null where nobody can tell.
    const btCollisionObject* key_of(const btCollisionObject* object) const;

  private:
    void join(const btCollisionObject* a, const btCollisionObject* b);

    std::map<const btCollisionObject*, const btCollisionObject*> keys_;
};

}  // namespace bsoil::random_worlds
