/// The worked example of docs/adding_a_property.md: a box of soil falls and a blade goes through
/// it. Prints the water before, the water after and a hash of everything else. Built with the
/// sources as they are and with the example's changes.
#include <cstdio>

#include "bsoil/soil.h"
#include "soil/soil_impl.h"

namespace bsoil {

struct SoilProbe {
    static Soil::Impl& impl(Soil& soil) { return *soil.impl_; }
};

namespace {

struct Sums {
    int64_t water = 0;
    uint64_t others = 0;
};

/// FNV-1a over all kept planes but the water's, which is the last one where there is one.
Sums sums_of(Soil& soil) {
    const Soil::Impl& s = SoilProbe::impl(soil);
    const int planes = kKeptMaterial + s.params.material_count;
    Sums sums{0, 0xcbf29ce484222325ull};
    TileVoxels voxels;
    for (size_t tile = 0; tile < s.tiles.size(); ++tile) {
        s.read_voxels(static_cast<int>(tile), voxels);
        for (int plane = 0; plane < s.kept_planes; ++plane) {
            for (int v = 0; v < s.params.tile_voxels; ++v) {
                const int32_t word =
                    voxels.words[static_cast<size_t>(plane) * s.params.tile_voxels + v];
                if (plane < planes) {
                    sums.others = (sums.others ^ static_cast<uint32_t>(word)) * 0x100000001b3ull;
                } else {
                    sums.water += word;
                }
            }
        }
    }
    return sums;
}

int run() {
    // Sand whose density is state: dug soil swells by its mass.
    SoilDef def{.material = materials::dry_sand(),
                .size_m = {2, 1.2, 0.8},
                .up = UpAxis::z,
                .backend = Backend::cpu};
    auto made = Soil::create(def);
    if (!made) {
        std::fprintf(stderr, "%s\n", made.error().c_str());
        return 2;
    }
    Soil& soil = **made;
    const Status filled = soil.fill(BoxFill{{{-0.8, -0.5, 0}, {0.8, 0.5, 0.3}}, {}});
    const Status dropped = soil.fill(BoxFill{{{-0.2, -0.2, 0.4}, {0.2, 0.2, 0.6}}, {}});
    if (!filled || !dropped) {
        return 2;
    }
    const int64_t water = sums_of(soil).water;
    ConvexShape blade;
    blade.half_extents_m = {0.05, 0.3, 0.2};
    const std::vector<ConvexShape> shapes{blade};
    SoilBody body;
    body.shapes = &shapes;
    body.linear_velocity_m_s = {0.6, 0, 0};
    for (int i = 0; i < 120; ++i) {
        body.pose.position = {-0.6 + 0.6 * i / 60, 0, 0.35};
        body.center_of_mass_m = body.pose.position;
        soil.step({&body, 1});
    }
    const Sums after = sums_of(soil);
    std::printf("%lld %lld %016llx\n", static_cast<long long>(water),
                static_cast<long long>(after.water), static_cast<unsigned long long>(after.others));
    return 0;
}

}  // namespace
}  // namespace bsoil

int main() { return bsoil::run(); }
