#include "files/data_files.h"
#include "small_run.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_height_map(Bytes bytes) {
    auto map = scene::read_height_map(scratch_file("map.png", bytes), 0, 1);
    if (!map) return;
    require(
        map->heights_m.size() == static_cast<size_t>(map->width) * static_cast<size_t>(map->height),
        "the heights are not width x height");
    static_cast<void>(small_soil()->fill(*map));
}

}  // namespace bsoil::fuzz
