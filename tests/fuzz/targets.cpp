#include "targets.h"

namespace bsoil::fuzz {

std::span<const Target> targets() {
    static constexpr Target kAll[] = {
        {"scene", fuzz_scene},
        {"experiment", fuzz_experiment},
        {"urdf", fuzz_urdf},
        {"mesh_file", fuzz_mesh_file},
        {"height_map", fuzz_height_map},
        {"table", fuzz_table},
        {"baseline", fuzz_baseline},
        {"bullet_file", fuzz_bullet_file},
        {"snapshot_file", fuzz_snapshot_file},
        {"soil_state", fuzz_soil_state},
        {"world_snapshot", fuzz_world_snapshot},
        {"surface_mesher", fuzz_surface_mesher},
        {"soil_calls", fuzz_soil_calls},
        {"action_calls", fuzz_action_calls},
        {"c_calls", fuzz_c_calls},
    };
    return kAll;
}

}  // namespace bsoil::fuzz
