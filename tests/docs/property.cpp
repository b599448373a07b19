/// The worked example of docs/adding_a_property.md: a box of soil falls and a blade goes through
/// it. Prints the salt before, the salt after, a hash of everything else and what the material's
/// new parameter is good for. Built with the sources as they are and with the example's changes.
#include <cstdio>
#include <string>

#include "bsoil/soil.h"
#include "soil/soil_impl.h"

namespace bsoil {

struct SoilProbe {
    static Soil::Impl& impl(Soil& soil) { return *soil.impl_; }
};

namespace {

struct Sums {
    int64_t salt = 0;
    uint64_t others = 0;
};

/// FNV-1a over all kept planes but the salt's, which is the last one where there is one.
Sums sums_of(Soil& soil) {
    const Soil::Impl& s = SoilProbe::impl(soil);
    const int planes = kKeptMaterial + s.params.material_count;
    Sums sums{0, 0xcbf29ce484222325ull};
    TileVoxels voxels;
    for (size_t tile = 0; tile < s.tiles.size(); ++tile) {
        s.tiles.read_voxels(static_cast<int>(tile), voxels);
        for (int plane = 0; plane < s.kept_planes; ++plane) {
            for (int v = 0; v < s.params.tile_voxels; ++v) {
                const int32_t word =
                    voxels.words[static_cast<size_t>(plane) * s.params.tile_voxels + v];
                if (plane < planes) {
                    sums.others = (sums.others ^ static_cast<uint32_t>(word)) * 0x100000001b3ull;
                } else {
                    sums.salt += word;
                }
            }
        }
    }
    return sums;
}

SoilDef cpu_def(Vec3 size_m) {
    SoilDef def;
    def.size_m = size_m;
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    return def;
}

/// Whether the parameter is checked and saved, and decides how much salt a fill brings: "checked
/// saved used", or what of it is missing.
template <typename Material>
std::string parameter_report(Material material) {
    if constexpr (requires { material.salt_fraction; }) {
        SoilDef def = cpu_def({1, 1, 1});
        int64_t salt[2] = {0, 0};
        bool is_saved = false;
        for (int i = 0; i < 2; ++i) {
            material.salt_fraction = 0.125 * (1 + i);
            def.material = material;
            auto soil = Soil::create(def);
            if (!soil || !(*soil)->fill(BoxFill{{{-0.4, -0.4, 0}, {0.4, 0.4, 0.4}}, {}})) {
                return "could_not";
            }
            salt[i] = sums_of(**soil).salt;
            const std::vector<uint8_t> state = (*soil)->state();
            is_saved = std::string(state.begin(), state.end()).find("salt_fraction of") !=
                       std::string::npos;
        }
        material.salt_fraction = 0.6;
        const Status status = material.validate();
        const bool is_checked =
            !status &&
            status.error().find("salt_fraction is 0.6, must be 0 to 0.5") != std::string::npos;
        const bool is_used = salt[0] > 0 && salt[1] == 2 * salt[0];
        return std::string(is_checked ? "checked" : "unchecked") +
               (is_saved ? "_saved" : "_unsaved") + (is_used ? "_used" : "_unused");
    } else {
        return "none";
    }
}

int run() {
    // Sand whose density is state: dug soil swells by its mass.
    SoilDef def = cpu_def({2, 1.2, 0.8});
    def.material = materials::dry_sand();
    auto made = Soil::create(def);
    if (!made) {
        std::fprintf(stderr, "%s\n", made.error().c_str());
        return 2;
    }
    Soil& soil = **made;
    const Status filled = soil.fill(BoxFill{{{-0.8, -0.5, 0}, {0.8, 0.5, 0.3}}, {}});
    const Status dropped = soil.fill(BoxFill{{{-0.2, -0.2, 0.4}, {0.2, 0.2, 0.6}}, {}});
    if (!filled || !dropped) return 2;
    const int64_t salt = sums_of(soil).salt;
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
    std::printf("%lld %lld %016llx %s\n", static_cast<long long>(salt),
                static_cast<long long>(after.salt), static_cast<unsigned long long>(after.others),
                parameter_report(def.material).c_str());
    return 0;
}

}  // namespace
}  // namespace bsoil

int main() { return bsoil::run(); }
