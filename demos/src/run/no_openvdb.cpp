/// OpenVDB of a build without its library.
#include "openvdb_grids.h"

namespace bsoil::scene {

Status write_openvdb(const Soil&, const std::string& path) {
    return Error{path +
                 ": this bsoil was built without OpenVDB; install it and build anew (Debian: "
                 "libopenvdb-dev and libboost-dev)"};
}

}  // namespace bsoil::scene
