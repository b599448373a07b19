#include "experiment/experiment_load.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_experiment(Bytes bytes) {
    static_cast<void>(
        experiment::parse_experiment(text_of(bytes), BSOIL_FUZZ_FILES "/experiment.toml", "", {}));
}

}  // namespace bsoil::fuzz
