/// A run's state as files that other programs open.
#pragma once

#include <string>
#include <vector>

#include "scene_run.h"

namespace bsoil::scene {

/// The formats that export_run knows, as file name endings.
const std::vector<std::string>& export_endings();

/// Writes a file in the format that its name ends in:
///
///     .glb   glTF 2.0: soil, terrain and each body as a node of its own, with materials,
///            vertex colours and textures; Y up, as glTF has it
///     .obj   Wavefront: the same as one mesh in world coordinates, with vertex colours
///     .ply   the same with normals and 8-bit colours
///     .asc   ESRI ASCII grid: heights of the surface [m] in the world, north is the grid's y
///     .tif   GeoTIFF of the same heights, 32-bit floats; where the build had libtiff
///     .png   16-bit heights of the surface, 0 at `low_m` and 65535 at `high_m` of the result
///     .vti   VTK image of the voxels: volume, bulk density [kg/m3], velocity [m/s], material,
///            undisturbed share, terrain
///     .vdb   OpenVDB grids: volume, density [kg/m3], velocity [m/s], material, terrain; where the
///            build had OpenVDB
///
/// Returns what to tell the person beside the file's name; empty: nothing. The error names the
/// file.
Result<std::string> export_run(const SceneRun& run, const std::string& path);

}  // namespace bsoil::scene
