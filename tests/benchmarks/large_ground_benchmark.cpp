// What 100 x 100 m of soil on a static ground take: to fill, to settle, and in the first frames
// after it. benchmark_large_ground [threads].
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "sand_bed.h"

namespace bsoil::bullet {
namespace {

double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

template <typename Work>
double milliseconds_of(Work&& work) {
    const double start_ms = now_ms();
    work();
    return now_ms() - start_ms;
}

/// False when something failed.
bool run(bool is_hilly, double ground_m, int threads) {
    BulletScene scene;
    SoilDef def;
    def.size_m = {100, 4, 100};
    def.backend = Backend::cpu;
    def.thread_count = threads;
    scene.add(0, scene.shape<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(ground_m)),
              btVector3(0, 0, 0));
    auto made = SoilAction::create(*scene.world, def);
    if (!made) return false;
    SoilAction& soil = **made;
    Status filled = Done{};
    const double fill_ms = milliseconds_of([&] {
        if (is_hilly) {
            NoiseFill noise;
            noise.base_m = 1;
            noise.amplitude_m = 0.6;
            noise.wavelength_m = 12;
            filled = soil.fill(noise);
        } else {
            filled = soil.fill(BoxFill{{{-50, 0, -50}, {50, 0.5, 50}}, {}});
        }
    });
    if (!filled) return false;
    const double settle_ms = milliseconds_of([&] { static_cast<void>(soil.settle()); });
    scene.add_box(200, btVector3(0.3f, 0.3f, 0.3f), btVector3(0.02f, 2.2f, 0.02f));
    const double first_ms = milliseconds_of([&] { scene.run(1.0 / 60); });
    double most_ms = 0;
    for (int i = 0; i < 120; ++i) {
        most_ms = std::max(most_ms, milliseconds_of([&] { scene.run(1.0 / 60); }));
    }
    std::printf("%-6s  %8.2f  %8.1f  %9.1f  %8.2f  %8.2f  %9.1f\n", is_hilly ? "hills" : "level",
                ground_m, fill_ms, settle_ms, first_ms, most_ms,
                static_cast<double>(soil.soil().memory_use().asleep_bytes +
                                    soil.soil().memory_use().awake_bytes) /
                    1e6);
    return true;
}

}  // namespace
}  // namespace bsoil::bullet

int main(int argc, char** argv) {
    const int threads = argc > 1 ? std::atoi(argv[1]) : 0;
    std::puts("soil    ground m   fill ms  settle ms  first ms   most ms  memory MB");
    for (const bool is_hilly : {false, true}) {
        for (const double ground_m : {0.0, -0.06, 0.1}) {
            if (!bsoil::bullet::run(is_hilly, ground_m, threads)) return 1;
        }
    }
}
