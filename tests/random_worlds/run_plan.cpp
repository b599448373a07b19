#include "run_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bsoil/bullet/world_snapshot.h"
#include "mechanics.h"
#include "run_drawn.h"

namespace bsoil::random_worlds {
namespace {

/// Bodies rest and sleep within this time once they are left alone, and soil that air does not
/// slow.
constexpr double kRestS = 15;
/// A bank that drains through an open side creeps for so long for each column squared [s], and a
/// viscous one for so long over what its viscosity leaves of slides.
struct Drain {
    double plain_s, viscous_s;
};
constexpr Drain kSettles{0.034, 0.045}, kRunsOut{0.05, 0.08};
/// What drag slows while it runs out besides: so many times what a column's width takes at g over
/// the rate of drag. All of them cover the table of docs/decisions/rest.md.
constexpr double kDrainByDrag = 0.15;
/// And a bank whose pores groundwater fills anew [s]. Ours, chosen after world 8010103 rested after
/// 35 s: see docs/decisions/rest.md.
constexpr double kWettedS = 60;
/// More viscous soil is a known fault.
constexpr double kViscosityMost = 0.75;
/// One crumb in so many may take longer to come down than it is given.
constexpr double kLateCrumbs = 1e6;
constexpr int kRepeatedSteps = 60;
constexpr int kStepsOnGl = 12;
/// Past the first water step, which is after a second.
constexpr double kWeatherOnGlS = 1.1;
/// Frames that a restored world is compared for, and how many of the first with their whole states
/// whatever the caller asks for.
constexpr int kStepsRestored = 40, kFirstStates = 3;

std::string hex(uint64_t number) { return fmt::format("{:016x}", number); }

bool is_built(const BuiltWorld& world, Failures& failures) {
    if (!world.error().empty()) {
        failures.add("builds", "world", world.time_s(), "no error", world.error());
    }
    return world.error().empty();
}

/// But for those that have left the soil.
bool do_bodies_sleep(BuiltWorld& world) {
    const std::vector<MovingPart> parts = moving_parts(world);
    return std::all_of(parts.begin(), parts.end(), [&world](const MovingPart& part) {
        return part.is_asleep || has_left_soil(world, part);
    });
}

void run_watched(const WorldPlan& plan, Failures& failures) {
    BuiltWorld world(plan);
    if (!is_built(world, failures)) return;
    std::vector<std::unique_ptr<Check>> checks;
    checks.push_back(make_finite_check());
    checks.push_back(make_units_check(world));
    checks.push_back(make_mesh_check(world));
    checks.push_back(make_energy_check(world));
    checks.push_back(make_status_check(world));
    checks.push_back(make_rest_check(world));
    world.on_substep = [&] {
        for (const auto& check : checks) check->after_substep(world);
    };
    double left_alone_s = 0, given_s = kRestS;
    while (left_alone_s < given_s) {
        world.step();
        for (const auto& check : checks) check->after_step(world, failures);
        if (world.step_count() <= plan.action_steps) continue;
        left_alone_s += world.frame_s();
        if (world.is_all_asleep()) break;
        if (left_alone_s >= kRestS && do_bodies_sleep(world)) given_s = rest_s(plan);
    }
    const bool rests = true;
    for (const auto& check : checks) check->at_end(world, rests, failures);
    is_built(world, failures);
}

void run_repeated(const WorldPlan& plan, Failures& failures) {
    BuiltWorld once(plan), again(plan), with_two(plan, {.thread_count = 2});
    if (!is_built(once, failures)) return;
    for (int i = 0; i < kRepeatedSteps; ++i) {
        for (BuiltWorld* world : {&once, &again, &with_two}) world->step();
        const uint64_t expected = once.checksum();
        if (again.checksum() != expected) {
            return failures.add("repeated", "world", once.time_s(), hex(expected),
                                hex(again.checksum()));
        }
        if (with_two.checksum() != expected) {
            return failures.add("threads", "world", once.time_s(), hex(expected),
                                hex(with_two.checksum()));
        }
    }
}

void run_on_gl(const WorldPlan& plan, Failures& failures) {
    BuiltWorld on_cpu(plan), on_gl(plan, {.backend = Backend::gl});
    if (!is_built(on_gl, failures)) return;
    for (int i = 0; i < kStepsOnGl || (plan.has_weather && on_cpu.time_s() < kWeatherOnGlS); ++i) {
        on_cpu.step();
        on_gl.step();
        if (on_cpu.checksum() != on_gl.checksum()) {
            return failures.add("gl", "world", on_cpu.time_s(), hex(on_cpu.checksum()),
                                hex(on_gl.checksum()));
        }
    }
}

/// What two soils hold to the last word: what only a later step hangs on, too.
bool are_alike(const BuiltWorld& a, const BuiltWorld& b) {
    const std::vector<bullet::SoilAction*> of_a = a.soils(), of_b = b.soils();
    return std::ranges::equal(of_a, of_b, [](bullet::SoilAction* one, bullet::SoilAction* other) {
        return one->soil().state() == other->soil().state();
    });
}

/// Takes a snapshot in the middle of the action, loads it into a world built anew and compares what
/// follows.
void run_restored(const WorldPlan& plan, int states_every, Failures& failures) {
    const std::string path = (std::filesystem::temp_directory_path() /
                              fmt::format("bsoil_random_{}_{}.snapshot", getpid(), plan.seed))
                                 .string();
    const int at_step = plan.action_steps / 2;
    BuiltWorld saved(plan);
    if (!is_built(saved, failures)) return;
    while (saved.step_count() < at_step) saved.step();
    std::vector<bullet::SoilAction*> soils = saved.soils();
    Status done = bullet::save_world(saved.world(), soils, path);
    if (!done) return failures.add("saved", "world", saved.time_s(), "a snapshot", done.error());
    BuiltWorld restored(plan, {}, at_step);
    soils = restored.soils();
    done = bullet::load_world(restored.world(), soils, path);
    std::filesystem::remove(path);
    if (!done) return failures.add("restored", "world", saved.time_s(), "a world", done.error());
    for (int i = 0; i <= kStepsRestored; ++i) {
        const uint64_t expected = saved.checksum(), found = restored.checksum();
        if (found != expected) {
            return failures.add("goes on", "world", saved.time_s(),
                                fmt::format("{} {} steps on", hex(expected), i), hex(found));
        }
        if ((i < kFirstStates || i % states_every == 0) && !are_alike(saved, restored)) {
            return failures.add("goes on", "soil", saved.time_s(), "the same state",
                                fmt::format("another {} steps on", i));
        }
        saved.step();
        restored.step();
    }
}

/// How long the slowest material creeps: viscous soil wherever it lies, else where a side is open.
double drains_s(const SoilDef& def) {
    const double columns = std::max(def.size_m.x, def.size_m.y) / def.voxel_m;
    const int flat = def.up == UpAxis::y ? kOpenLowY | kOpenHighY : kOpenLowZ | kOpenHighZ;
    const bool is_open = (def.open_sides & ~flat) != 0,
               runs_out = def.slides == SlideMotion::run_out;
    double most_s = 0;
    for (const MaterialDef& material : def.materials) {
        if (is_open && def.water_table_m > 0 && material.pore_water_fraction > 0) {
            most_s = std::max(most_s, kWettedS);
        }
        if (!is_open && material.viscosity == 0) continue;
        const double slides = 1 - std::min(material.viscosity, kViscosityMost);
        const Drain& drain = runs_out ? kRunsOut : kSettles;
        double column_s = material.viscosity > 0 ? drain.viscous_s / slides : drain.plain_s;
        if (runs_out && def.gravity_m_s2 > 0) {
            const double drag_per_s = -std::log(slides) * 60;
            column_s += kDrainByDrag * def.voxel_m * drag_per_s / def.gravity_m_s2;
        }
        most_s = std::max(most_s, column_s * columns * columns);
    }
    return most_s;
}

}  // namespace

const char* name_of(Run run) {
    constexpr const char* kNames[] = {"watched", "repeated", "restored", "gl", "drawn"};
    return kNames[static_cast<int>(run)];
}

// Thin soil that falls slowly goes by whole voxels, by chance, as often as its speed asks. Of what
// falls n voxels all but a share exp(-x) is down after (sqrt n + sqrt x)^2 times what one takes:
// Chernoff's bound of Poisson's distribution.
double rest_s(const WorldPlan& plan) {
    double fall_s = 0, quick_s = kRestS;
    for (const SoilPlan& soil : plan.soils) {
        const SoilDef& def = soil.def;
        quick_s = std::max(quick_s, drains_s(def));
        const double root =
            std::sqrt(def.size_m.z / def.voxel_m) + std::sqrt(std::log(kLateCrumbs));
        for (const MaterialDef& material : def.materials) {
            if (material.fall_speed_m_s == 0 || is_held_by_wind(def, material)) continue;
            const double speed_m_s = material.fall_speed_m_s - rising_wind_m_s(def);
            fall_s = std::max(fall_s, root * root * def.voxel_m / speed_m_s);
        }
    }
    return quick_s + fall_s;
}

std::vector<Failure> run_plan(const WorldPlan& plan, Run run, int states_every) {
    Failures failures(plan.seed);
    switch (run) {
        case Run::watched:
            run_watched(plan, failures);
            break;
        case Run::repeated:
            run_repeated(plan, failures);
            break;
        case Run::restored:
            run_restored(plan, states_every, failures);
            break;
        case Run::on_gl:
            run_on_gl(plan, failures);
            break;
        case Run::drawn:
            run_drawn(plan, failures);
            break;
    }
    return failures.list();
}

}  // namespace bsoil::random_worlds
