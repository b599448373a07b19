// Once a world has been left alone: all sleeps, what rests weighs what it weighs and lies on the
// surface that the soil reports.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "bullet_types.h"
#include "check.h"
#include "lie_of_body.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;

namespace {

/// Soil force and contacts against weight and change of momentum, as means over the last frames
/// before a body slept, of all substeps: Bullet lets it fall asleep while it still sinks or rocks
/// by 0.8 m/s. A fraction of what is borne, and that is the load as well: a body of 1.4 g carried
/// 1 kg of soil, and of those 9.9 N 2 % are more than its weight.
constexpr double kWeightFraction = 0.02;
constexpr size_t kMeanFrames = 30;
/// The surface under a body is known to a column's height [voxels]. Its soil bears over a gap
/// besides, as wide as the contact law says: a mesh of 2.8 g stood 1.21 voxels above it.
constexpr double kHoverVoxels = 1;
/// The surface beside a body is that at this many of its radii: less, and it crosses the body.
constexpr double kBesideRadii = 1.25;
/// A body lies no deeper than its own underside or a plate of this part of its size, whichever
/// sinks deeper, after a fall as far with its load, times this (soils differ), and this many
/// voxels.
constexpr double kPlateFraction = 1.0 / 3, kSinkageFactor = 1.5, kSinkageVoxels = 2;

/// Soil settles within this time once nothing stirs it.
constexpr double kSettlesS = 15;
/// Water in soil moves once in so long.
constexpr double kWaterS = 1;

bool has_water(const SoilDef& def) {
    return std::ranges::any_of(def.materials,
                               [](const MaterialDef& m) { return m.pore_water_fraction > 0; });
}

/// Impulses of Bullet's contacts in the last substep that each was solved in, by object [N s].
std::map<const btCollisionObject*, Vec3> contact_impulses(btDispatcher& dispatcher) {
    std::map<const btCollisionObject*, Vec3> sums;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        for (int k = 0; k < manifold.getNumContacts(); ++k) {
            const btManifoldPoint& p = manifold.getContactPoint(k);
            Vec3 impulse =
                static_cast<double>(p.m_appliedImpulse) * from_bullet(p.m_normalWorldOnB);
            impulse += static_cast<double>(p.m_appliedImpulseLateral1) *
                       from_bullet(p.m_lateralFrictionDir1);
            impulse += static_cast<double>(p.m_appliedImpulseLateral2) *
                       from_bullet(p.m_lateralFrictionDir2);
            sums[manifold.getBody0()] += impulse;
            sums[manifold.getBody1()] += -impulse;
        }
    }
    return sums;
}

/// Bullet's own thresholds, below which it would let the body sleep.
bool is_slow(const MovingPart& part) {
    constexpr double kSlow_m_s = 0.8, kSlow_rad_s = 1;
    return length(part.velocity_m_s) < kSlow_m_s && length(part.spin_rad_s) < kSlow_rad_s;
}

class RestCheck final : public Check {
  public:
    void after_step(BuiltWorld& world, Failures&) override {
        const std::vector<MovingPart> parts = moving_parts(world);
        for (const MovingPart& part : parts) {
            const double now_m =
                height_m(world, part.pose.position) +
                dot(part.velocity_m_s, part.velocity_m_s) / (2 * world.gravity_m_s2());
            const auto [it, is_new] = energy_heights_m_.emplace(part.object, now_m);
            it->second = std::max(it->second, now_m);
            if (part.is_asleep) continue;
            remember_surface(world, part);
            note_awake(world, part);
        }
        still_s_.resize(world.soils().size());
        for (size_t i = 0; i < still_s_.size(); ++i) {
            if (world.soils()[i]->last_report().block_active_count == 0) {
                still_s_[i] = world.time_s();
            }
        }
        if (world.was_touched()) forget_forces(parts);
    }
    void after_substep(BuiltWorld& world) override { record_forces(world); }

    void at_end(BuiltWorld& world, bool rests, Failures& failures) override {
        if (rests) expect_sleep(world, failures);
        if (!world.is_all_asleep()) return;
        expect_weights(world, failures);
        for (const MovingPart& part : moving_parts(world)) expect_held(world, part, failures);
    }

  private:
    /// A body has not sunk from the top of a bank that has slid in about it. Nor does the circle
    /// tell the foot of a bank from a slope, where the soil ends on some of its sides. 924051: a
    /// hull fell onto such a foot, and lay 0.07 m deep for 0.15.
    void remember_surface(const BuiltWorld& world, const MovingPart& part) {
        const double radius = radius_m(world, part.object);
        const int index = soil_below(world, part.pose.position, radius);
        if (index < 0 || part.is_of_chain) return;
        const Vec3 lowest = lowest_point(*part.object->getCollisionShape(),
                                         part.object->getWorldTransform(), world.up());
        const auto beside_m =
            surface_beside_m(world, world.soil(index), lowest, kBesideRadii * radius);
        if (!beside_m) return;
        const Met here{part.pose.position, *beside_m};
        const auto [it, is_new] = met_.emplace(part.object, here);
        const Vec3 along = cross(here.at_m - it->second.at_m, world.up());
        if (length(along) > radius) it->second = here;
        it->second.surface_m = std::min(it->second.surface_m, *beside_m);
    }

    /// Where it reaches, whether it is fast, and whether soil acts on it.
    void note_awake(BuiltWorld& world, const MovingPart& part) {
        Awake& awake = awake_[part.object];
        const double now_s = world.time_s();
        for (const bullet::SoilAction* soil : world.soils()) {
            if (reaches_into(*soil, *part.object)) awake.reached_s[soil] = now_s;
        }
        if (!is_slow(part)) awake.fast_s = now_s;
        note_way(world, part);
        if (length(soil_force_n(world, *part.object)) > 0) awake.felt_s = now_s;
    }

    void note_way(const BuiltWorld& world, const MovingPart& part) {
        const std::vector<BodyPlan>& bodies = world.plan().bodies;
        for (size_t i = 0; i < bodies.size(); ++i) {
            if (world.body(static_cast<int>(i)) != part.object) continue;
            const Soil& soil = world.soil(bodies[i].soil).soil();
            if (is_unstoppable(bodies[i], soil)) ways_[part.object].push_back(part.pose.position);
        }
    }

    /// What rocks on others, faster than Bullet lets it sleep, and has felt no soil for a while. In
    /// world 5001006 a mesh stands on a driven one.
    bool is_kept_awake_by_others(BuiltWorld& world, const MovingPart& part) {
        constexpr double kFeltS = 5, kSleepsS = 2;  // Bullet's own
        const Awake& awake = awake_[part.object];
        return touches_others(*world.world().getDispatcher(), *part.object) &&
               world.time_s() - awake.felt_s > kFeltS && world.time_s() - awake.fast_s < kSleepsS;
    }

    /// A body asleep is held as it was when it fell asleep, while it still moved perhaps: what it
    /// bears since a touch counts as a change of that. World 81305: a body of 5 t rocked at 0.11
    /// m/s when it fell asleep, and was filled beside; the last substep alone is 2 % off.
    void forget_forces(const std::vector<MovingPart>& parts) {
        for (const MovingPart& part : parts) {
            Forces& forces = forces_[part.object];
            if (!part.is_asleep || !forces.has_slept) forces = {};
        }
    }

    void expect_sleep(BuiltWorld& world, Failures& failures) {
        bool are_asleep = true;
        const std::set<int> kept_awake = islands_kept_awake(*world.world().getDispatcher());
        const std::vector<bullet::SoilAction*> soils = world.soils();
        std::set<const bullet::SoilAction*> stirred;
        for (const MovingPart& part : moving_parts(world)) {
            if (part.is_asleep) continue;
            // What has left the soil may roll on. Two balls whose common middle is below both
            // rock for good on a plane beside the soil, and dip into it. So may what no soil acts
            // on: in world 2041029 three balls turn between a heightfield and a plane. In 4003151 a
            // can of 26 t below the floor swings what it is jointed to through the soil.
            const bool feels_soil =
                std::ranges::any_of(soils, [&part](const bullet::SoilAction* soil) {
                    return !soil->options(*part.object).coverage_only;
                });
            if (!feels_soil || has_left_soil(world, part) || is_kept_awake_by_others(world, part)) {
                for (const auto& [soil, last_s] : awake_[part.object].reached_s) {
                    if (world.time_s() - last_s < kSettlesS) stirred.insert(soil);
                }
                continue;
            }
            are_asleep = false;
            if (is_slow(part) && kept_awake.contains(part.object->getIslandTag())) continue;
            failures.add("bodies sleep", world.name_of_object(*part.object), world.time_s(),
                         "asleep",
                         fmt::format("{:.3g} m/s, {:.3g} rad/s", length(part.velocity_m_s),
                                     length(part.spin_rad_s)));
        }
        if (!are_asleep) return;  // they keep the soil beside them awake
        for (size_t i = 0; i < soils.size(); ++i) {
            const StepReport& report = soils[i]->last_report();
            // Rain and what drains are due once a second, and soil looks where they go.
            if (world.time_s() - still_s_[i] < kWaterS && has_water(soils[i]->soil().def())) {
                continue;
            }
            if (report.block_active_count > 0 && !stirred.contains(soils[i])) {
                failures.add("soil sleeps", fmt::format("soil {}", i), world.time_s(),
                             "no active block", fmt::format("{}", report.block_active_count));
            }
        }
    }

    /// The upward force on each body that is awake in a substep: of the soil and of other bodies.
    void record_forces(BuiltWorld& world) {
        const double substep_s = world.plan().frame_s / world.plan().substep_count;
        const size_t most = kMeanFrames * static_cast<size_t>(world.plan().substep_count);
        const auto impulses = contact_impulses(*world.world().getDispatcher());
        for (const MovingPart& part : moving_parts(world)) {
            const auto car = std::find_if(world.cars().begin(), world.cars().end(),
                                          [&](const auto& c) { return c.chassis == part.object; });
            const bool is_car = car != world.cars().end();
            Forces& forces = forces_[part.object];
            double up_n = dot(soil_force_n(world, *part.object), world.up());
            if (const auto it = impulses.find(part.object); it != impulses.end()) {
                up_n += dot(it->second, world.up()) / substep_s;
            }
            if (world.was_touched()) turns_.forget(part.object);
            turns_.note(*part.object, world.up(), !part.is_asleep && up_n > 0);
            if (part.is_asleep && !forces.up_n.empty()) {
                if (!forces.has_slept) forces.up_asleep_n = up_n;
                if (world.was_touched() && !forces.up_untouched_n) {
                    forces.up_untouched_n = forces.up_asleep_n;
                }
                forces.has_slept = true;
                forces.up_asleep_n = up_n;
                continue;
            }
            if (forces.has_slept) {
                forces = {};
                forces.woke_s = world.time_s();
            }
            forces.is_whole = !is_car || tells_its_weight(*car, world.up());
            // Bullet gives bodies their weight at the start of a frame: what wakes within it has
            // none until the next.
            if (!part.is_asleep && forces.woke_s == world.time_s()) continue;
            const double carried_kg = load_kg(world, *part.object);
            const double mass_kg = part.mass_kg + carried_kg;
            forces.load_most_n = std::max(forces.load_most_n, carried_kg * world.gravity_m_s2());
            forces.up_n.push_back(up_n);
            forces.momenta_n_s.push_back(mass_kg * dot(part.velocity_m_s, world.up()));
            forces.each_s = substep_s;
            if (forces.up_n.size() <= most) continue;
            forces.up_n.pop_front();
            forces.momenta_n_s.pop_front();
        }
    }

    void expect_weights(BuiltWorld& world, Failures& failures) {
        const WorldPlan& plan = world.plan();
        if (plan.is_variable) return;  // impulses are of steps of different lengths
        const WeighedTogether together(world);
        struct Sum {
            double weight_n = 0, up_n = 0, load_n = 0;
            bool is_whole = true;
        };
        std::map<const btCollisionObject*, Sum> sums;
        for (const MovingPart& part : moving_parts(world)) {
            const btCollisionObject* key = together.key_of(part.object);
            const auto of_part = forces_.find(part.object);
            if (!key || of_part == forces_.end()) continue;
            const Forces& forces = of_part->second;
            Sum& sum = sums[key];
            if (forces.up_n.empty()) {  // it woke within this very frame
                sum.is_whole = false;
                continue;
            }
            sum.weight_n += part.mass_kg * world.gravity_m_s2();
            sum.load_n += forces.load_most_n;
            sum.is_whole &= forces.is_whole;
            if (forces.up_untouched_n) sum.up_n += forces.up_asleep_n - *forces.up_untouched_n;
            const auto count = static_cast<double>(forces.up_n.size() - 1);
            if (count < 1) {  // it has slept all the time
                sum.up_n += forces.up_n.front();
                continue;
            }
            // A momentum is that after its force.
            sum.weight_n +=
                (forces.momenta_n_s.back() - forces.momenta_n_s.front()) / (count * forces.each_s);
            for (size_t i = 1; i < forces.up_n.size(); ++i) sum.up_n += forces.up_n[i] / count;
        }
        for (const auto& [object, sum] : sums) {
            if (!sum.is_whole) continue;
            const double most_n = kWeightFraction * (sum.weight_n + sum.load_n);
            if (!(std::abs(sum.up_n - sum.weight_n) <= most_n)) {  // also what is no number
                failures.add("weight", world.name_of_object(*object), world.time_s(),
                             fmt::format("{:.5g} N", sum.weight_n),
                             fmt::format("{:.5g} N", sum.up_n));
            }
        }
    }

    /// What soil another body carries is no surface of the ground's.
    static bool lies_on_a_load(const bullet::SoilAction& soil, const btCollisionObject& object) {
        const auto& contacts = soil.last_report().contacts;
        const int id = soil.body_id(object);
        return std::any_of(contacts.begin(), contacts.end(), [id](const ContactVoxel& contact) {
            return contact.body == id && contact.carrier >= 0;
        });
    }

    void expect_held(BuiltWorld& world, const MovingPart& part, Failures& failures) {
        const double radius = radius_m(world, part.object);
        const int index = soil_below(world, part.pose.position, radius);
        if (index < 0 || part.is_of_chain || is_jointed(world, part.object) ||
            touches_others(*world.world().getDispatcher(), *part.object)) {
            return;
        }
        bullet::SoilAction& soil = world.soil(index);
        if (soil.options(*part.object).coverage_only || lies_on_a_load(soil, *part.object)) return;
        const double voxel_m = soil.soil().frame().voxel_m;
        const Vec3 lowest = lowest_point(*part.object->getCollisionShape(),
                                         part.object->getWorldTransform(), world.up());
        const double bottom_m = height_m(world, lowest);
        const std::string name = world.name_of_object(*part.object);
        double highest = -std::numeric_limits<double>::infinity();
        const Quat axes = soil.soil().frame().grid_to_world.rotation;
        for (int y = -4; y <= 4; ++y) {
            for (int x = -4; x <= 4; ++x) {
                const Vec3 aside = rotate(axes, Vec3{x * radius / 4, y * radius / 4, 0});
                if (const auto at = soil.surface_at(part.pose.position + aside)) {
                    highest = std::max(highest, height_m(world, at->position_m));
                }
            }
        }
        const double hover_m =
            (kHoverVoxels + soil.soil().def().contact_law.open_gap_voxels) * voxel_m;
        if (bottom_m > highest + hover_m) {
            failures.add("held", name, world.time_s(),
                         fmt::format("its bottom no higher than the surface, {:.5g} m", highest),
                         fmt::format("{:.5g} m", bottom_m));
        }
        const double ring_m = kBesideRadii * radius;
        if (!is_free(world, part.object, index) || is_in_pit(world, index, lowest, ring_m) ||
            is_dug_through(world, part.object, lowest, ring_m)) {
            return;
        }
        auto surface_m = surface_beside_m(world, soil, lowest, ring_m);
        if (!surface_m) return;
        if (const auto met = met_.find(part.object); met != met_.end()) {
            surface_m = std::min(*surface_m, met->second.surface_m);
        }
        const double carried_kg = load_kg(world, *part.object);
        const double weight_n = (part.mass_kg + carried_kg) * world.gravity_m_s2();
        const double fall_m = std::max(0.0, energy_heights_m_.at(part.object) - *surface_m);
        double sinkage_m = 0;
        for (const Underside& underside : {disc(std::clamp(kPlateFraction * radius, 1e-3, 10.0)),
                                           underside_of(*part.object, world.up(), radius)}) {
            const double found_m = sinkage_after_fall_m(soil.soil(), underside, weight_n, fall_m);
            sinkage_m = std::max(sinkage_m, found_m);
        }
        const double bound_m = kSinkageFactor * sinkage_m + kSinkageVoxels * voxel_m +
                               fallen_soil_m(world, index, lowest, ring_m) +
                               turns_.most_m(part.object);
        if (*surface_m - bound_m < ground_height_m(world, index, lowest)) return;
        if (bottom_m < *surface_m - bound_m) {
            failures.add("sinkage", name, world.time_s(),
                         fmt::format("its bottom no more than {:.3g} m below the surface, {:.5g} m",
                                     bound_m, *surface_m),
                         fmt::format("{:.3g} m below it", *surface_m - bottom_m));
        }
    }

    /// Bullet's own sphere about a small shape is many times too large: it has the default margin.
    static double radius_m(const BuiltWorld& world, const btCollisionObject* object) {
        const std::vector<BodyPlan>& bodies = world.plan().bodies;
        for (size_t i = 0; i < bodies.size(); ++i) {
            if (world.body(static_cast<int>(i)) == object) return bound_m(bodies[i].shape);
        }
        return 0;
    }

    /// Whether it fell onto soil that bore it all the time: nobody put it into soil or soil onto
    /// it, or switched the soil or the forces on the body off.
    static bool is_free(const BuiltWorld& world, const btCollisionObject* object, int soil) {
        using Kind = EventPlan::Kind;
        for (const EventPlan& event : world.plan().events) {
            if (event.dropped || event.kind == Kind::push) continue;
            const bool is_of_soil = event.kind == Kind::fill || event.kind == Kind::disable ||
                                    event.kind == Kind::enable;
            if (is_of_soil ? event.body == soil : world.body(event.body) == object) return false;
        }
        const std::vector<FlowPlan>& flows = world.plan().soils[static_cast<size_t>(soil)].flows;
        return std::none_of(flows.begin(), flows.end(),
                            [](const FlowPlan& flow) { return flow.is_source && !flow.dropped; });
    }

    /// Whether the surface within this radius may be that around a pit, which a sink has dug: what
    /// lies in one has not sunk from there. A pit is as wide as the region that the sink empties
    /// and the slopes above it, which stand at phi. Worlds 80080 and 80141 have bodies in pits.
    static bool is_in_pit(const BuiltWorld& world, int soil, Vec3 at, double radius_m) {
        const SoilPlan& plan = world.plan().soils[static_cast<size_t>(soil)];
        double deep_m = plan.terrain_m, phi_rad = std::numbers::pi / 4;
        for (const FillPlan& fill : plan.fills) {
            if (!fill.dropped) deep_m = std::max(deep_m, fill.high_m.z);
        }
        for (const MaterialDef& material : plan.def.materials) {
            phi_rad = std::min(phi_rad, material.friction_angle_rad);
        }
        const GridFrame& frame = world.soil(soil).soil().frame();
        const Vec3 here = frame.to_grid(at) * frame.voxel_m;
        const auto digs_at = [&](const FlowPlan& flow, Vec3 center) {
            const ConvexShape& region = flow.sink.region;
            const double half_m =
                region.kind == ConvexShape::Kind::box
                    ? length(region.half_extents_m)
                    : std::hypot(region.radius_m, region.half_height_m) + region.radius_m;
            const double slope_m = std::max(0.0, deep_m - center.z + half_m) / std::tan(phi_rad);
            return std::hypot(center.x - here.x, center.y - here.y) < radius_m + half_m + slope_m;
        };
        return std::any_of(plan.flows.begin(), plan.flows.end(), [&](const FlowPlan& flow) {
            const bool digs = !flow.dropped && !flow.is_source && flow.sink.water_kg_s == 0;
            return digs && (digs_at(flow, flow.sink.pose.position) ||
                            (flow.moves_step >= 0 && digs_at(flow, flow.moved_to_m)));
        });
    }

    /// Whether another body that nothing stops went through the soil within this radius. 6100001:
    /// 12.8 kg lay 0.16 m deep where 3.4 t had gone.
    bool is_dug_through(const BuiltWorld& world, const btCollisionObject* object, Vec3 at,
                        double ring_m) const {
        return std::any_of(ways_.begin(), ways_.end(), [&](const auto& way) {
            if (way.first == object) return false;
            const double reach_m = ring_m + radius_m(world, way.first);
            return std::ranges::any_of(way.second, [&](Vec3 was) {
                return length(cross(was - at, world.up())) < reach_m;
            });
        });
    }

    /// Height of the soil that hung in the air within this radius. It has come down beside the body
    /// perhaps, which met what lay below it: 90114 came down with its own slab.
    static double fallen_soil_m(const BuiltWorld& world, int soil, Vec3 at, double radius_m) {
        const GridFrame& frame = world.soil(soil).soil().frame();
        const Vec3 here = frame.to_grid(at) * frame.voxel_m;
        double sum_m = 0;
        for (const FillPlan& fill : world.plan().soils[static_cast<size_t>(soil)].fills) {
            const Vec3 low = fill.low_m - here, high = here - fill.high_m;
            const bool is_near = std::max({low.x, low.y, high.x, high.y}) < radius_m;
            if (!fill.dropped && fill.is_hanging && is_near) sum_m += fill.high_m.z - fill.low_m.z;
        }
        return sum_m;
    }

    static bool is_jointed(const BuiltWorld& world, const btCollisionObject* object) {
        for (const JointPlan& joint : world.plan().joints) {
            if (!joint.dropped &&
                (world.body(joint.a) == object || world.body(joint.b) == object)) {
                return true;
            }
        }
        for (const BuiltWorld::Car& car : world.cars()) {
            if (car.chassis == object) return true;
        }
        return false;
    }

    /// On a body while it was awake last, and its upward momentum and its load's after each.
    struct Forces {
        std::deque<double> up_n, momenta_n_s;
        double each_s = 0;                     ///< how long each acts
        bool has_slept = false;                ///< since the last of them
        double load_most_n = 0;                ///< weight of the soil that it carried
        bool is_whole = true;                  ///< nothing else bears it
        double up_asleep_n = 0;                ///< on it since it sleeps
        std::optional<double> up_untouched_n;  ///< and before the first touch since
        std::optional<double> woke_s;          ///< the world's time in the frame it woke in
    };
    std::map<const btCollisionObject*, Forces> forces_;
    /// The world's time when a body was last awake and so.
    struct Awake {
        std::map<const bullet::SoilAction*, double> reached_s;  ///< into each soil's grid
        double fast_s = 0, felt_s = 0;
    };
    std::map<const btCollisionObject*, Awake> awake_;
    /// Where bodies have been that nothing stops.
    std::map<const btCollisionObject*, std::vector<Vec3>> ways_;
    std::vector<double> still_s_;  ///< by soil: the world's time when no block was active last
    /// The highest that each body has been, its speed reckoned in.
    std::map<const btCollisionObject*, double> energy_heights_m_;
    /// Where a body came to, and the lowest surface beside it since: within its radius, level.
    struct Met {
        Vec3 at_m;
        double surface_m = 0;
    };
    std::map<const btCollisionObject*, Met> met_;
    Turns turns_;
};

}  // namespace

std::unique_ptr<Check> make_rest_check(const BuiltWorld&) { return std::make_unique<RestCheck>(); }

}  // namespace bsoil::random_worlds
