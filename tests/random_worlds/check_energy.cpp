// Nothing rises without work; and nothing is anywhere but in this world.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "check.h"
#include "mechanics.h"

namespace bsoil::random_worlds {
namespace {

/// What counts as no rise: lifting all bodies by this part of a voxel. Bullet pushes bodies that
/// overlap apart, and joints back into place, by as much. Where they overlap by more, having been
/// put into each other or gone through a plane in one step, it lifts them out: that is its work.
constexpr double kLiftVoxels = 0.2;
/// And this part of the energy that was lost since the start: Bullet's contacts and joints give
/// some of an impact back.
constexpr double kReturned = 0.02;
/// Bodies that carry more soil than this part of their mass are moved by its weight.
constexpr double kLoad = 0.05;

/// Of two bodies of Bullet's in the step that has just been made [m].
double deepest_overlap_m(BuiltWorld& world) {
    btDispatcher& dispatcher = *world.world().getDispatcher();
    double deepest_m = 0;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        for (int k = 0; k < manifold.getNumContacts(); ++k) {
            deepest_m = std::max(deepest_m,
                                 -static_cast<double>(manifold.getContactPoint(k).getDistance()));
        }
    }
    return deepest_m;
}

class EnergyCheck final : public Check {
  public:
    explicit EnergyCheck(const BuiltWorld& world) : is_on_(!has_motors(world.plan())) {
        start(world);
    }
    void after_step(BuiltWorld& world, Failures& failures) override {
        if (!is_on_) return;
        const double voxel_m = world.plan().soils[0].def.voxel_m;
        if (world.was_touched() || deepest_overlap_m(world) > kLiftVoxels * voxel_m) {
            return start(world);
        }
        const std::vector<MovingPart> parts = moving_parts(world);
        double mass_kg = 0, carried_kg = 0;
        for (const MovingPart& part : parts) {
            mass_kg += part.mass_kg;
            carried_kg += load_kg(world, *part.object);
        }
        if (carried_kg > kLoad * mass_kg) {
            is_on_ = false;
            return;
        }
        const double now_j = energy_j(world, parts);
        const double slack_j = kLiftVoxels * voxel_m * mass_kg * world.gravity_m_s2() +
                               kReturned * std::max(0.0, start_j_ - least_j_);
        if (now_j > least_j_ + slack_j) {
            failures.add(
                "energy", "all bodies", world.time_s(),
                fmt::format("no more than {:.6g} J and {:.3g} J of slack", least_j_, slack_j),
                fmt::format("{:.6g} J", now_j));
        }
        least_j_ = std::min(least_j_, now_j);
    }

  private:
    void start(const BuiltWorld& world) {
        start_j_ = least_j_ = energy_j(world, moving_parts(world));
    }
    bool is_on_;
    double start_j_ = 0, least_j_ = 0;
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
