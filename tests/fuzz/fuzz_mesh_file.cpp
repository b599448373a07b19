#include <cstdlib>

#include "bsoil/distance_lattice.h"
#include "files/data_files.h"
#include "robots/convex_parts.h"
#include "small_run.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_mesh_file(Bytes bytes) {
    Choices choices(bytes);
    const int how = choices.below(256);
    constexpr const char* kNames[] = {"mesh.obj", "mesh.stl", "mesh.dae"};
    scene::MeshSkin skin;
    const auto mesh = scene::read_mesh(scratch_file(kNames[how % 3], choices.rest()),
                                       how % 2 == 0 ? nullptr : &skin);
    if (mesh && how % 2 == 1 && skin.places.size() != mesh->vertices.size()) std::abort();
    if (!mesh || mesh->triangles.size() > 500) return;
    const int use = how / 3 % 4;
    if (use == 0) {
        static_cast<void>(small_soil()->add_terrain(*mesh));
    } else if (use == 1) {
        scene::convex_hull(mesh->vertices);
        scene::component_hulls(*mesh);
    } else if (use == 2) {
        scene::convex_parts(*mesh, 4);
    } else {
        LatticeDef def;
        def.voxel_m = 0.1;
        def.region = {{-1, -1, -1}, {1, 1, 1}};
        const auto lattice = DistanceLattice::from_mesh(*mesh, def);
        if (lattice) (*lattice)->nearest_face({0.1, 0.2, 0.3});
    }
}

}  // namespace bsoil::fuzz
