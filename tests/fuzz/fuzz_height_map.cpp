#include <cmath>

#include "bsoil/soil.h"
#include "files/data_files.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_height_map(Bytes bytes) {
    auto map = scene::read_height_map(scratch_file("map.png", bytes), 0, 1);
    if (!map) return;
    require(
        map->heights_m.size() == static_cast<size_t>(map->width) * static_cast<size_t>(map->height),
        "the heights are not width x height");
    SoilDef def;
    def.size_m = {1, 1, 1};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    def.thread_count = 1;
    const auto soil = Soil::create(def);
    require(soil.ok(), "no soil");
    static_cast<void>((*soil)->fill(*map));
}

}  // namespace bsoil::fuzz
