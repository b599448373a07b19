#include "exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "bsoil/render/image.h"
#include "bsoil/render/primitives.h"
#include "bsoil/surface_mesh.h"
#include "files/text_file.h"
#include "gltf_file.h"
#include "height_map.h"
#include "openvdb_grids.h"
#include "scene_models.h"
#include "soil_field.h"

namespace bsoil::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary formats are little-endian");

template <typename T>
void append(std::string& bytes, const std::vector<T>& values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

std::vector<NamedMesh> meshes_of(const SceneRun& run) {
    std::vector<NamedMesh> meshes;
    if (run.has_soil()) {
        const SoilTiles tiles(run.soil());
        const auto add = [&](const char* name, SurfaceMeshDef::Layer layer) {
            SurfaceMeshDef def;
            def.layer = layer;
            def.backend = run.mesh_backend();
            SurfaceMesher mesher(tiles, def);
            mesher.update();
            NamedMesh named{name, {}, {}, 1};
            mesher.gather(named.look.mesh);
            meshes.push_back(std::move(named));
        };
        add("soil", SurfaceMeshDef::Layer::soil);
        if (!run.scene().terrains.empty()) add("terrain", SurfaceMeshDef::Layer::terrain);
    }
    for (const SceneBody& body : run.bullet().bodies()) {
        meshes.push_back({body.name, body_look(*body.item), body.pose(), 0.5});
    }
    std::erase_if(meshes, [](const NamedMesh& named) { return named.look.mesh.indices.empty(); });
    return meshes;
}

Mesh one_mesh(const SceneRun& run) {
    Mesh all;
    for (NamedMesh& named : meshes_of(run)) {
        render::transform_mesh(named.look.mesh, named.pose);
        all.append(named.look.mesh);
    }
    return all;
}

/// Heights of the surface above the grid's floor by column, x the fastest.
std::vector<double> heights_of(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    std::vector<double> heights;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) heights.push_back(soil.surface_height_m(x, y));
    }
    return heights;
}

/// ESRI's ASCII grid: a head of six lines, then rows from north to south.
std::string ascii_grid(const HeightMap& map) {
    std::string text = fmt::format(
        "ncols {}\nnrows {}\nxllcorner {:.6f}\nyllcorner {:.6f}\ncellsize {}\nNODATA_value "
        "-9999\n",
        map.width, map.height, map.corner.east_m, map.corner.north_m - map.height * map.cell_m,
        map.cell_m);
    for (size_t i = 0; i < map.heights_m.size(); ++i) {
        const bool ends_row = (i + 1) % static_cast<size_t>(map.width) == 0;
        text += fmt::format("{:.5f}{}", map.heights_m[i], ends_row ? '\n' : ' ');
    }
    return text;
}

/// Heights as a picture; what it has to be read with.
Result<std::string> height_picture(const Soil& soil, const std::string& path) {
    const GridFrame& frame = soil.frame();
    const std::vector<double> heights = heights_of(soil);
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    const double range = std::max(1e-9, *high - *low);
    // Columns along the first horizontal world axis, rows along the second: as a [[fill]] of kind
    // height_map reads them.
    const bool y_up = soil.def().up == UpAxis::y;
    const int width = frame.size[y_up ? 1 : 0], height = frame.size[y_up ? 0 : 1];
    std::vector<uint16_t> levels;
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            const int x = y_up ? row : column, y = y_up ? column : row;
            const double share =
                (heights[static_cast<size_t>(y) * frame.size[0] + x] - *low) / range;
            levels.push_back(static_cast<uint16_t>(std::lround(65535 * share)));
        }
    }
    if (const Status written = render::write_grey_png(width, height, levels, path); !written) {
        return Error{written.error()};
    }
    return fmt::format("min_height_m = {:.6f}, max_height_m = {:.6f}", *low, *high);
}

/// VTK's XML image: cell data in one block of raw numbers behind the XML.
std::string vtk_image(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    const size_t count = static_cast<size_t>(frame.size[0]) * static_cast<size_t>(frame.size[1]) *
                         static_cast<size_t>(frame.size[2]);
    std::vector<float> volume(count), density(count), velocity(3 * count), undisturbed(count),
        terrain(count), saturation(count);
    std::vector<uint8_t> material(count);
    constexpr int kTileSide = 8;  // tile by tile: that is how the soil's cache reads
    for (int ty = 0; ty < frame.size[1]; ty += kTileSide) {
        for (int tx = 0; tx < frame.size[0]; tx += kTileSide) {
            for (int z = 0; z < frame.size[2]; ++z) {
                for (int y = ty; y < std::min(frame.size[1], ty + kTileSide); ++y) {
                    for (int x = tx; x < std::min(frame.size[0], tx + kTileSide); ++x) {
                        const VoxelSample s = soil.sample(x, y, z);
                        const size_t v = (static_cast<size_t>(z) * frame.size[1] + y) *
                                             static_cast<size_t>(frame.size[0]) +
                                         static_cast<size_t>(x);
                        volume[v] = static_cast<float>(s.volume);
                        density[v] = static_cast<float>(s.density_kg_m3);
                        velocity[3 * v] = static_cast<float>(s.velocity_m_s.x);
                        velocity[3 * v + 1] = static_cast<float>(s.velocity_m_s.y);
                        velocity[3 * v + 2] = static_cast<float>(s.velocity_m_s.z);
                        undisturbed[v] = static_cast<float>(s.undisturbed);
                        terrain[v] = static_cast<float>(s.coverage);
                        saturation[v] = static_cast<float>(s.saturation);
                        material[v] = static_cast<uint8_t>(s.material);
                    }
                }
            }
        }
    }
    std::string raw, arrays;
    const auto add = [&](const char* name, const char* type, int parts, const auto& values) {
        arrays += fmt::format(
            "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" "
            "format=\"appended\" offset=\"{}\"/>\n",
            type, name, parts, raw.size());
        const uint64_t size = values.size() * sizeof(values[0]);
        raw.append(reinterpret_cast<const char*>(&size), 8);
        append(raw, values);
    };
    add("volume", "Float32", 1, volume);
    add("density_kg_m3", "Float32", 1, density);
    add("velocity_m_s", "Float32", 3, velocity);
    add("undisturbed", "Float32", 1, undisturbed);
    add("terrain", "Float32", 1, terrain);
    add("material", "UInt8", 1, material);
    if (has_field(soil.materials(), Field::moisture)) add("saturation", "Float32", 1, saturation);
    const Vec3 origin = frame.to_world({0, 0, 0});
    const Quat turn = frame.grid_to_world.rotation;
    const Vec3 x = rotate(turn, {1, 0, 0}), y = rotate(turn, {0, 1, 0}),
               z = rotate(turn, {0, 0, 1});
    const std::string extent =
        fmt::format("0 {} 0 {} 0 {}", frame.size[0], frame.size[1], frame.size[2]);
    return fmt::format(
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
               "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
               "  <ImageData WholeExtent=\"{0}\" Origin=\"{1} {2} {3}\" Spacing=\"{4} {4} {4}\" "
               "Direction=\"{5} {6} {7} {8} {9} {10} {11} {12} {13}\">\n"
               "    <Piece Extent=\"{0}\">\n      <CellData Scalars=\"volume\">\n{14}      "
               "</CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData "
               "encoding=\"raw\">\n_",
               extent, origin.x, origin.y, origin.z, frame.voxel_m, x.x, y.x, z.x, x.y, y.y, z.y,
               x.z, y.z, z.z, arrays) +
           raw + "\n  </AppendedData>\n</VTKFile>\n";
}

}  // namespace

const std::vector<std::string>& export_endings() {
    static const std::vector<std::string> endings{".glb", ".obj", ".ply", ".asc",
                                                  ".tif", ".png", ".vti", ".vdb"};
    return endings;
}

Result<std::string> export_run(const SceneRun& run, const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    const auto& known = export_endings();
    if (std::find(known.begin(), known.end(), ending) == known.end()) {
        return Error{
            fmt::format("{}: the name has to end in one of {}", path, fmt::join(known, ", "))};
    }
    const bool is_mesh = ending == ".glb" || ending == ".obj" || ending == ".ply";
    if (!is_mesh && !run.has_soil()) {
        return Error{
            fmt::format("{}: this scene has no soil to export; export it as a mesh", path)};
    }
    Status written = Done{};
    if (ending == ".glb") {
        std::vector<std::string> notes;
        const std::string bytes = glb(meshes_of(run), run.scene().world.up == "z", notes);
        if (bytes.size() > std::numeric_limits<uint32_t>::max()) {
            return Error{path + ": more than the 4 GiB that a .glb can hold; take a .ply"};
        }
        written = write_file(path, bytes);
        if (written) return fmt::format("{}", fmt::join(notes, "\n"));
    } else if (ending == ".obj") {
        written = write_obj(one_mesh(run), path);
    } else if (ending == ".ply") {
        written = write_ply(one_mesh(run), path);
    } else if (ending == ".asc") {
        const HeightMap map = height_map(run.soil());
        written = map.is_turned() ? Status(Error{path + ": this soil's grid is turned, which an "
                                                        "ASCII grid cannot say; take a .tif"})
                                  : write_file(path, ascii_grid(map));
    } else if (ending == ".tif") {
        written = write_geotiff(height_map(run.soil()), path);
    } else if (ending == ".vdb") {
        written = write_openvdb(run.soil(), path);
    } else if (ending == ".vti") {
        written = write_file(path, vtk_image(run.soil()));
    } else {
        return height_picture(run.soil(), path);
    }
    if (!written) return Error{written.error()};
    return std::string();
}

}  // namespace bsoil::scene
