/// GeoTIFF of a build without libtiff.
#include "height_map.h"

namespace bsoil::scene {

Status write_geotiff(const HeightMap&, const std::string& path) {
    return Error{path +
                 ": this bsoil was built without libtiff; install it and build anew (Debian: "
                 "libtiff-dev)"};
}

}  // namespace bsoil::scene
