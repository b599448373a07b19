// What a frame of BasicExample takes, second by second, until its boxes sleep and the soil is
// quiet: benchmark_boxes [rigid|sand] [iterations of Bullet's solver] [threads].
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "basic_boxes.h"

namespace bsoil::bullet {
namespace {

constexpr int kSeconds = 14;

double milliseconds(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

void run(Boxes& boxes) {
    std::puts("second  cpu ms  wall ms a frame   awake  contacts");
    for (int second = 1; second <= kSeconds; ++second) {
        const double cpu_ms = milliseconds(CLOCK_PROCESS_CPUTIME_ID);
        const double wall_ms = milliseconds(CLOCK_MONOTONIC);
        boxes.run(1);
        const size_t contacts =
            boxes.has_soil() ? boxes.soil().last_report().contacts.size() : size_t{0};
        std::printf("%6d  %6.2f  %7.2f %15d  %8zu\n", second,
                    (milliseconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_ms) / kFramesPerS,
                    (milliseconds(CLOCK_MONOTONIC) - wall_ms) / kFramesPerS, boxes.awake_count(),
                    contacts);
    }
    if (boxes.has_soil()) {
        std::printf("checksum %016llx\n",
                    static_cast<unsigned long long>(boxes.soil().soil().checksum()));
    }
}

}  // namespace
}  // namespace bsoil::bullet

int main(int argc, char** argv) {
    using namespace bsoil::bullet;
    const bool is_rigid = argc > 1 && std::string_view(argv[1]) == "rigid";
    Boxes boxes(is_rigid ? Ground::rigid : Ground::sand, argc > 2 ? std::atoi(argv[2]) : 10,
                argc > 3 ? std::atoi(argv[3]) : 0);
    run(boxes);
}
