// Runs random worlds by the thousand: random_worlds [--seeds A..B] [--minutes M] [--steps N]
//     [--seed N] [--run watched|repeated|restored|gl|drawn] [--kind any|calm|small]
//     [--minimize] [--describe] [--trace] [--every S] [--all] [--weather | --dry]
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "add_weather.h"
#include "known_faults.h"
#include "make_plan.h"
#include "mechanics.h"
#include "minimize.h"
#include "run_drawn.h"

namespace bsoil::random_worlds {
namespace {

/// A world that takes longer hangs [s].
constexpr unsigned kLongest = 600;

/// What is under way, for whoever dies of it.
char under_way[200] = "";

void die(int signal_number) {
    const char* what = signal_number == SIGALRM ? "hangs in " : "crashes in ";
    (void)!write(STDERR_FILENO, what, std::strlen(what));
    (void)!write(STDERR_FILENO, under_way, std::strlen(under_way));
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

/// Ctrl-C: the world under way is the last one, and what all came to is printed.
volatile sig_atomic_t is_last = 0;

struct Arguments {
    uint64_t first = 1, last = 1000;
    double minutes = 1e9;
    int64_t steps = std::numeric_limits<int64_t>::max();
    std::optional<Run> run;
    std::optional<PlanKind> kind;
    double trace_every_s = 0.5;
    bool with_weather = true, without_weather = true;
    bool minimizes = false, describes = false, traces = false, shows_all = false;
};

/// What a seed is run as, unless the command line says so: most are watched.
PlanKind kind_of(uint64_t seed) { return seed % 3 == 0 ? PlanKind::calm : PlanKind::any; }
constexpr uint64_t kOnGlEvery = 50, kWeatherOnGlEvery = 10, kDrawnEvery = 5;

const char* name_of(PlanKind kind) {
    constexpr const char* kNames[] = {"any", "calm", "small"};
    return kNames[static_cast<int>(kind)];
}

/// Where each body is, how fast, and what bears it.
void trace(const WorldPlan& plan, double every_s) {
    BuiltWorld world(plan);
    const GridFrame& frame = world.soil(0).soil().frame();
    constexpr double kLongestS = 20;
    for (double next_s = 0; world.time_s() < kLongestS;) {
        world.step();
        if (world.time_s() < next_s && !world.is_all_asleep()) continue;
        next_s += every_s;
        fmt::print("{:.3f} s: {} blocks\n", world.time_s(),
                   world.soil(0).last_report().block_active_count);
        for (const MovingPart& part : moving_parts(world)) {
            const Vec3 at = frame.to_grid(part.pose.position);
            fmt::print(
                "    {}: at ({:.2f} {:.2f} {:.2f}) voxels, {:.3g} m/s, {:.3g} rad/s, soil "
                "{:.4g} N of {:.4g} N{}\n",
                world.name_of_object(*part.object), at.x, at.y, at.z, length(part.velocity_m_s),
                length(part.spin_rad_s), dot(soil_force_n(world, *part.object), world.up()),
                part.mass_kg * world.gravity_m_s2(), part.is_asleep ? ", asleep" : "");
        }
        if (world.is_all_asleep()) return;
    }
}

struct Tally {
    int worlds = 0, failures = 0;
    std::map<std::string, int> known;
};

struct World {
    uint64_t seed;
    PlanKind kind;
    bool has_weather;
};

void run_one(const World& world, Run run, const Arguments& arguments, Tally& tally) {
    std::snprintf(under_way, sizeof(under_way), "random_worlds --seed %llu --run %s --kind %s %s\n",
                  static_cast<unsigned long long>(world.seed), name_of(run), name_of(world.kind),
                  world.has_weather ? "--weather" : "--dry");
    alarm(kLongest);
    WorldPlan plan = make_plan(world.seed, world.kind);
    if (world.has_weather) add_weather(plan);
    if (arguments.describes) fmt::print("{}", describe(plan));
    if (arguments.traces) trace(plan, arguments.trace_every_s);
    std::fflush(stdout);
    ++tally.worlds;
    for (const Failure& failure : run_plan(plan, run)) {
        const char* known = known_fault(plan, failure);
        if (known) ++tally.known[failure.invariant + ": " + known];
        if (known && !arguments.shows_all) continue;
        ++tally.failures;
        fmt::print("{}\n    replay: {}", text_of(failure), under_way);
        std::fflush(stdout);
        if (arguments.minimizes) {
            alarm(0);
            fmt::print("{}", describe(minimize(plan, run, failure.invariant)));
        }
    }
    std::fflush(stdout);
}

void run_seed(uint64_t seed, bool has_weather, const Arguments& arguments, Tally& tally) {
    const World world{seed, arguments.kind.value_or(kind_of(seed)), has_weather};
    if (arguments.run) return run_one(world, *arguments.run, arguments, tally);
    for (const Run run : {Run::watched, Run::repeated, Run::restored}) {
        run_one(world, run, arguments, tally);
    }
    if (seed % (has_weather ? kWeatherOnGlEvery : kOnGlEvery) == 0) {
        run_one({seed, PlanKind::small, has_weather}, Run::on_gl, arguments, tally);
    }
    if (seed % kDrawnEvery == 0 && can_draw()) run_one(world, Run::drawn, arguments, tally);
}

int run_all(const Arguments& arguments) {
    for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGALRM}) {
        signal(number, die);
    }
    for (const int number : {SIGINT, SIGTERM}) {
        signal(number, [](int) { is_last = 1; });
    }
    const auto start = std::chrono::steady_clock::now();
    Tally tally;
    for (uint64_t seed = arguments.first; seed <= arguments.last; ++seed) {
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
        if (passed.count() > 60 * arguments.minutes || is_last) break;
        if (BuiltWorld::all_step_count() >= arguments.steps) break;
        if (arguments.without_weather) run_seed(seed, false, arguments, tally);
        if (arguments.with_weather) run_seed(seed, true, arguments, tally);
    }
    for (const auto& [fault, count] : tally.known) {
        fmt::print("known, {} times: {}\n", count, fault);
    }
    fmt::print("{} runs, {} steps, {} failures\n", tally.worlds, BuiltWorld::all_step_count(),
               tally.failures);
    if (tally.worlds == 0) fmt::print(stderr, "no world was run\n");
    return tally.failures > 0 || tally.worlds == 0 ? 1 : 0;
}

std::optional<Arguments> parse(int count, char** values) {
    Arguments out;
    for (int i = 1; i < count; ++i) {
        const std::string name = values[i];
        if (name == "--minimize") {
            out.minimizes = true;
            continue;
        }
        if (name == "--describe") {
            out.describes = true;
            continue;
        }
        if (name == "--trace") {
            out.traces = true;
            continue;
        }
        if (name == "--weather" || name == "--dry") {
            (name == "--dry" ? out.with_weather : out.without_weather) = false;
            continue;
        }
        if (name == "--all") {
            out.shows_all = true;
            continue;
        }
        if (++i == count) return {};
        const std::string value = values[i];
        if (name == "--seed") {
            out.first = out.last = std::strtoull(value.c_str(), nullptr, 10);
        } else if (name == "--seeds") {
            const size_t dots = value.find("..");
            if (dots == std::string::npos) return {};
            out.first = std::strtoull(value.c_str(), nullptr, 10);
            out.last = std::strtoull(value.c_str() + dots + 2, nullptr, 10);
        } else if (name == "--every") {
            out.trace_every_s = std::strtod(value.c_str(), nullptr);
        } else if (name == "--steps") {
            out.steps = std::strtoll(value.c_str(), nullptr, 10);
        } else if (name == "--minutes") {
            out.minutes = std::strtod(value.c_str(), nullptr);
        } else if (name == "--run") {
            for (const Run run :
                 {Run::watched, Run::repeated, Run::restored, Run::on_gl, Run::drawn}) {
                if (value == random_worlds::name_of(run)) out.run = run;
            }
            if (!out.run) return {};
        } else if (name == "--kind") {
            for (const PlanKind kind : {PlanKind::any, PlanKind::calm, PlanKind::small}) {
                if (value == name_of(kind)) out.kind = kind;
            }
            if (!out.kind) return {};
        } else {
            return {};
        }
    }
    return out;
}

}  // namespace
}  // namespace bsoil::random_worlds

int main(int argument_count, char** arguments) {
    const auto parsed = bsoil::random_worlds::parse(argument_count, arguments);
    if (!parsed) {
        std::fprintf(
            stderr,
            "usage: random_worlds [--seeds A..B | --seed N] [--minutes M] [--steps N]\n"
            "    [--run watched|repeated|restored|gl|drawn] [--kind any|calm|small]\n"
            "    [--minimize] [--describe] [--trace] [--every S] [--all] [--weather | --dry]\n");
        return 2;
    }
    return bsoil::random_worlds::run_all(*parsed);
}
