#include "run/baseline.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_baseline(Bytes bytes) {
    const auto baseline = scene::read_baseline(scratch_file("baseline.json", bytes));
    if (!baseline) return;
    const bool is_sound = !scene::not_a_number_in(*baseline);
    require(scene::compare_baselines(*baseline, *baseline, 0).empty() == is_sound,
            "a baseline differs from itself, or equals itself with what is no number");
    scene::compare_baselines(*baseline, {{"steps", 1}, {"end", {{"checksum", "0"}}}}, 1e-3);
}

}  // namespace bsoil::fuzz
