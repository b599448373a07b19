/// What must always hold, as checks that watch a world while it runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "built_world.h"

namespace bsoil::random_worlds {

/// A promise that was not kept.
struct Failure {
    std::string invariant;  ///< the check's name: known_faults.h and the minimizer go by it
    uint64_t seed = 0;
    std::string body;  ///< or "soil 0"
    double time_s = 0;
    std::string expected, found;
};
std::string text_of(const Failure& failure);

/// Collects failures; of each invariant and body the first one counts. A known fault of one body
/// is none of another.
class Failures {
  public:
    explicit Failures(uint64_t seed) : seed_(seed) {}
    void add(const std::string& invariant, const std::string& body, double time_s,
             const std::string& expected, const std::string& found);
    void add(const Failures& others);
    const std::vector<Failure>& list() const { return list_; }

  private:
    uint64_t seed_;
    std::vector<Failure> list_;
};

/// Watches one world from its start.
class Check {
  public:
    virtual ~Check() = default;
    virtual void after_step(BuiltWorld& world, Failures& failures) = 0;
    /// From within the step, after each of Bullet's.
    virtual void after_substep(BuiltWorld&) {}
    /// Once, at the end. `rests`: everything has been left alone for as long as it may take to come
    /// to rest.
    virtual void at_end(BuiltWorld&, bool /*rests*/, Failures&) {}
};

/// Units per material stay equal, but for what comes in and goes out; no amount is negative.
std::unique_ptr<Check> make_units_check(const BuiltWorld& world);
/// The mesh made step by step equals one made anew, and lies within the grid.
std::unique_ptr<Check> make_mesh_check(const BuiltWorld& world);
/// Poses and velocities are finite.
std::unique_ptr<Check> make_finite_check();
/// Bodies' mechanical energy does not grow where nothing does work.
std::unique_ptr<Check> make_energy_check(const BuiltWorld& world);
/// A status bit or a refusal has its cause.
std::unique_ptr<Check> make_status_check(const BuiltWorld& world);
/// What rests weighs what it weighs, is held at the surface, and sleeps.
std::unique_ptr<Check> make_rest_check(const BuiltWorld& world);

}  // namespace bsoil::random_worlds
