#include "run/baseline.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_baseline(Bytes bytes) {
    const auto baseline = scene::read_baseline(scratch_file("baseline.json", bytes));
    if (!baseline) return;
    require(scene::compare_baselines(*baseline, *baseline, 0).empty(),
            "a baseline differs from itself");
    scene::compare_baselines(*baseline, {{"steps", 1}, {"end", {{"checksum", "0"}}}}, 1e-3);
}

}  // namespace bsoil::fuzz
