/// libFuzzer's entry: runs the target that BSOIL_FUZZ_TARGET names.
#include <cstdlib>
#include <cstring>

#include "fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const bsoil::fuzz::Target* const kTarget = [] {
        const char* name = std::getenv("BSOIL_FUZZ_TARGET");
        for (const bsoil::fuzz::Target& target : bsoil::fuzz::targets()) {
            if (name && std::strcmp(target.name, name) == 0) return &target;
        }
        bsoil::fuzz::fail("BSOIL_FUZZ_TARGET names no target; see tests/fuzz/targets.h");
    }();
    kTarget->run({data, size});
    return 0;
}
