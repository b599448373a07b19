// Nothing rises without work; and nothing is anywhere but in this world.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "check.h"
#include "mechanics.h"

namespace bsoil::random_worlds {
namespace {

/// What counts as no rise: lifting all bodies by this part of a voxel. Bullet pushes bodies that
/// overlap apart by as much. Where they overlap by more, having been put into each other or gone
/// through a plane in one step, it lifts them out: that is its work. So is what joints do, which is
/// counted: a body of 22 kg between two of 550 and 590 kg gave a pendulum 3500 J in 0.2 s. Contacts
/// that take bodies apart are counted as well, since they do so again and again: a pebble of 91 t
/// that spun on a heightfield was lifted by 2 mm every few frames, while the soil bore 3 N of it.
constexpr double kLiftVoxels = 0.2;
/// And this part of the energy that was lost since the start: Bullet's contacts and joints give
/// some of an impact back.
constexpr double kReturned = 0.02;
/// And this part of what joints have done, and of what contacts did against them: their work is
/// told by each substep's impulses and mean velocities. The 22 kg between 550 and 590 kg, three
/// joints, came out 1.2 kJ too high of 4.1 kJ, while the soil's forces fell; 0.9 kJ of it is slack
/// already. A hull that a joint drags along a plane gets back by contacts, 0.3 J, what the joint
/// takes.
constexpr double kCountedWork = 0.1;
/// Bodies that carry more soil than this part of their mass are moved by its weight.
constexpr double kLoad = 0.05;

/// What Bullet's steps keep where nothing but gravity acts. They set a velocity and go on with it,
/// so that the energy is less by m g dt v / 2 on the way down and more by as much on the way up: a
/// pendulum of 14 kg has 3 J less at first, and gets them back. Steps of different lengths keep
/// nothing better than the energy.
double kept_j(const BuiltWorld& world, std::span<const MovingPart> parts) {
    double sum_j = energy_j(world, parts);
    if (world.plan().is_variable) return sum_j;
    const double substep_s = world.plan().frame_s / world.plan().substep_count;
    for (const MovingPart& part : parts) {
        sum_j -= part.mass_kg * world.gravity_m_s2() * substep_s *
                 dot(part.velocity_m_s, world.up()) / 2;
    }
    return sum_j;
}

/// Bullet steps a chain explicitly, too. Where the swing of a link about its joint, w = sqrt(g /
/// half of its length), has w dt of 0.46, a chain of two hanging clear of all soil gains 10 J of
/// the 28 J of its swing in 0.17 s. Up to this it is a tenth of that.
constexpr double kSwingTurn = 0.15;

bool swings_coarsely(const WorldPlan& plan) {
    const double substep_s = plan.frame_s / plan.substep_count;
    return std::any_of(plan.chains.begin(), plan.chains.end(), [&](const ChainPlan& chain) {
        const double rate = std::sqrt(plan.soils[0].def.gravity_m_s2 / (1.2 * chain.half_m));
        return !chain.dropped && rate * substep_s > kSwingTurn;
    });
}

bool has_link(const BuiltWorld::Chain& chain, const btCollisionObject* object) {
    return std::any_of(chain.colliders.begin(), chain.colliders.end(),
                       [object](const auto& link) { return link.get() == object; });
}

/// Links that touch each other, or their base, do not count.
bool meets_others(BuiltWorld& world, const BuiltWorld::Chain& chain) {
    for (const auto& link : chain.colliders) {
        if (length(soil_force_n(world, *link)) > 0 || load_kg(world, *link) > 0) return true;
    }
    const btDispatcher& dispatcher = *world.world().getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold =
            *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
        if (manifold.getNumContacts() == 0) continue;
        if (has_link(chain, manifold.getBody0()) != has_link(chain, manifold.getBody1())) {
            return true;
        }
    }
    return false;
}

/// What chains gain or lose while they touch nothing is Bullet's doing, at any length of a step: a
/// chain of three links with w dt of 0.085 gained 14 J as its last link whipped round, 4 % of the
/// energy of its swing. So is what they do while their links hit each other: the chain of world
/// 10000044, in the air, gains and loses 0.02 J of its 1 J a frame before and after it folds on its
/// base.
class FreeSwings {
  public:
    explicit FreeSwings(const BuiltWorld& world) : swings_(world.chains().size()) {}
    void note(BuiltWorld& world, std::span<const MovingPart> parts) {
        for (size_t i = 0; i < swings_.size(); ++i) {
            const BuiltWorld::Chain& chain = world.chains()[i];
            std::vector<MovingPart> links;
            for (const MovingPart& part : parts) {
                if (has_link(chain, part.object)) links.push_back(part);
            }
            // What its own contacts did is counted with all contacts'.
            const Swing now{kept_j(world, links) - chain.own_contact_work_j,
                            !meets_others(world, chain)};
            if (now.is_free && swings_[i].is_free) work_j_ += now.kept_j - swings_[i].kept_j;
            swings_[i] = now;
        }
    }
    double work_j() const { return work_j_; }

  private:
    struct Swing {
        double kept_j = 0;
        bool is_free = false;
    };
    std::vector<Swing> swings_;
    double work_j_ = 0;
};

class EnergyCheck final : public Check {
  public:
    explicit EnergyCheck(const BuiltWorld& world)
        : is_on_(!has_motors(world.plan()) && !swings_coarsely(world.plan())), swings_(world) {
        start(world, parts_at_soil(world));
    }
    void after_step(BuiltWorld& world, Failures& failures) override {
        if (!is_on_) return;
        const double voxel_m = world.plan().soils[0].def.voxel_m;
        const std::vector<MovingPart> parts = parts_at_soil(world);
        swings_.note(world, parts);
        double mass_kg = 0, carried_kg = 0;
        for (const MovingPart& part : parts) {
            mass_kg += part.mass_kg;
            carried_kg += load_kg(world, *part.object);
        }
        if (world.was_touched() && carried_before_kg_ > 0) {
            settled_s_ = world.time_s() + settling_s(world);
        }
        carried_before_kg_ = carried_kg;
        if (world.was_touched() || world.time_s() < settled_s_ ||
            world.deepest_overlap_m() > kLiftVoxels * voxel_m || parts.size() != part_count_ ||
            parts.empty()) {
            return start(world, parts);
        }
        if (carried_kg > kLoad * mass_kg) {
            is_on_ = false;
            return;
        }
        const double now_j = kept_j(world, parts) - work_j(world);
        const double joints_j = std::abs(world.joint_work_j());
        const double counted_j = joints_j + std::min(joints_j, std::abs(world.contact_work_j()));
        const double slack_j = kLiftVoxels * voxel_m * mass_kg * world.gravity_m_s2() +
                               kReturned * std::max(0.0, start_j_ - least_j_) +
                               kCountedWork * counted_j;
        if (!(now_j <= least_j_ + slack_j)) {  // also what is no number
            failures.add(
                "energy", "all bodies", world.time_s(),
                fmt::format("no more than {:.6g} J and {:.3g} J of slack", least_j_, slack_j),
                fmt::format(
                    "{:.6g} J, without {:.3g} J of the joints' work and {:.3g} J of others'", now_j,
                    world.joint_work_j(), work_j(world) - world.joint_work_j()));
        }
        least_j_ = std::min(least_j_, now_j);
    }

  private:
    void start(const BuiltWorld& world, std::span<const MovingPart> parts) {
        part_count_ = parts.size();
        start_j_ = least_j_ = kept_j(world, parts) - work_j(world);
    }
    /// A body that is put elsewhere leaves its load behind. Bullet's solver has given that load
    /// what it would have got in the first step, and the body gets it back over the next soil step.
    /// In world 91022 a joint of 3.7 m takes the body to 24 m/s meanwhile: 4 kJ out and 7 kJ back.
    static double settling_s(const BuiltWorld& world) {
        double longest_s = world.frame_s();
        for (const SoilPlan& soil : world.plan().soils) {
            longest_s = std::max(longest_s, soil.def.step_s);
        }
        return longest_s + world.frame_s() / 2;  // both are sums of roundings
    }
    double work_j(const BuiltWorld& world) const {
        return world.joint_work_j() + world.contact_work_j() + world.poured_work_j() +
               swings_.work_j();
    }
    bool is_on_;
    FreeSwings swings_;
    size_t part_count_ = 0;
    double start_j_ = 0, least_j_ = 0;
    double carried_before_kg_ = 0;  ///< by all bodies, a step ago
    double settled_s_ = 0;          ///< then the loads that a touch left behind are paid for
};

class FiniteCheck final : public Check {
  public:
    void after_step(BuiltWorld& world, Failures& failures) override {
        for (const MovingPart& part : moving_parts(world)) {
            if (!is_finite(part.pose) || !is_finite(part.velocity_m_s) ||
                !is_finite(part.spin_rad_s)) {
                failures.add("finite", world.name_of_object(*part.object), world.time_s(),
                             "numbers", "NaN or infinity");
            }
        }
    }
};

}  // namespace

std::unique_ptr<Check> make_energy_check(const BuiltWorld& world) {
    return std::make_unique<EnergyCheck>(world);
}
std::unique_ptr<Check> make_finite_check() { return std::make_unique<FiniteCheck>(); }

}  // namespace bsoil::random_worlds
