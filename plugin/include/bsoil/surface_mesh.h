/// Triangle meshes of the soil's surface and of the terrain's, for pictures and other tools.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsoil/limits.h"
#include "bsoil/result.h"
#include "bsoil/soil.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Weights of a soil's materials at a place, in the materials' order, 0..255. Their sum is not
/// fixed: a material's share is its weight over the sum, as in equation (2) of the Mevea thesis.
using MaterialWeights = std::array<uint8_t, limits::kMaterialCapacity>;

/// Indexed triangles, counter-clockwise seen from outside. World axes, metres.
struct Mesh {
    std::vector<float> positions;   ///< x, y, z of each vertex [m]; see SurfaceMeshDef::origin_m
    std::vector<float> normals;     ///< unit, x, y, z of each vertex, out of the solid
    std::vector<float> colors;      ///< linear r, g, b of each vertex, 0..1
    std::vector<uint32_t> indices;  ///< three a triangle
    /// Of each vertex, where materials mix: from these the renderer shows them side by side, while
    /// `colors` has their mean. Empty: there is one material.
    std::vector<MaterialWeights> weights;
    std::vector<std::array<float, 3>> palette;  ///< linear RGB of the materials weighed
    /// Of each vertex: water in the soil's pores, from dry (0) to full (255). `colors` are darker
    /// by it; the renderer makes wet soil glossy. Empty: there is none.
    std::vector<uint8_t> wetness;

    /// Number of vertices.
    size_t vertex_count() const { return positions.size() / 3; }
    /// Number of triangles.
    size_t triangle_count() const { return indices.size() / 3; }
    /// Names the list that does not have three numbers a vertex or a triangle, or an index that no
    /// vertex has. Weights and wetness are not looked at: of another length they do not count.
    Status validate() const;
    /// Empties the mesh; keeps its memory.
    void clear();
    /// Adds all of `other` behind what is here. Weights are kept where both have the same palette.
    /// Where only one of the two has wetness the other is dry.
    void append(const Mesh& other);
};

/// Wavefront OBJ with vertex colours behind the coordinates, which have all digits of a float. The
/// error names the file, or says what Mesh::validate() does.
Status write_obj(const Mesh& mesh, const std::string& path);
/// Binary little-endian PLY with normals and 8-bit colours (sRGB). The error as of write_obj().
Status write_ply(const Mesh& mesh, const std::string& path);

/// What SurfaceMesher reads: voxels in tiles of 8 x 8 columns. SoilTiles is the one for a Soil.
class TileSource {
  public:
    virtual ~TileSource() = default;
    virtual const GridFrame& frame() const = 0;  ///< as Soil::frame
    /// As Soil::materials. Their colours may change, and with them the revisions of all tiles.
    virtual const std::vector<MaterialDef>& materials() const = 0;
    /// Grows each time the tile may have changed.
    virtual uint64_t tile_revision(int tx, int ty) const = 0;
    /// These tiles are asked for next, in this order: as Soil::read_ahead. Unless it is overridden,
    /// nothing happens.
    virtual void read_ahead(std::span<const std::array<int, 2>> tiles) const;
    /// As Soil::read_tile. Materials are less than the number of materials(), wherever soil is.
    virtual void read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                           std::vector<uint8_t>& material) const = 0;
    /// How fast the soil of a voxel moves, world axes. Unless it is overridden, it stands.
    virtual Vec3 velocity_m_s(int x, int y, int z) const;
    /// How the soil on top of a column moves along the ground. Unless it is overridden, it rests.
    virtual GroundMotion ground_motion(int x, int y) const;
    /// How much dust a voxel's soil makes when it moves fast, 0..1; `material` is its main one.
    /// Unless it is overridden, 1 without cohesion and 0 from 500 Pa on.
    virtual float dust_at(int x, int y, int z, int material) const;
    /// Linear RGB of a voxel's soil where it lies bare; `material` is its main one. Unless it is
    /// overridden, that material's.
    virtual std::array<float, 3> color_at(int x, int y, int z, int material) const;
    /// How much of each material is in a voxel's soil, by volume; `material` is its main one.
    /// Unless it is overridden, that one is alone. Not asked where there is but one material.
    virtual MaterialWeights weights_at(int x, int y, int z, int material) const;
    /// Whether there may be water in the soil. Unless it is overridden, there is none.
    virtual bool has_water() const;
    /// The share of a voxel's pores that water fills, 0..1. Asked where has_water().
    virtual float saturation_at(int x, int y, int z) const;
    /// As Soil::read_terrain. Unless it is overridden, what read_tile calls solid.
    virtual void read_terrain(int tx, int ty, std::vector<float>& terrain) const;
    /// Where to mesh unless SurfaceMeshDef::backend says so. Unless it is overridden, on the CPU.
    virtual Backend backend() const;
};

/// A Soil as a TileSource.
class SoilTiles final : public TileSource {
  public:
    /// The soil must outlive it.
    explicit SoilTiles(const Soil& soil) : soil_(soil) {}
    const GridFrame& frame() const override;
    const std::vector<MaterialDef>& materials() const override;
    uint64_t tile_revision(int tx, int ty) const override;
    void read_ahead(std::span<const std::array<int, 2>> tiles) const override;
    void read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                   std::vector<uint8_t>& material) const override;
    Vec3 velocity_m_s(int x, int y, int z) const override;
    GroundMotion ground_motion(int x, int y) const override;
    /// Nor does soil with water in a tenth of its pores make any.
    float dust_at(int x, int y, int z, int material) const override;
    /// The mean of its materials. Moved soil is darker and richer than ground that settled, wet
    /// soil darker, what a body has compacted paler.
    std::array<float, 3> color_at(int x, int y, int z, int material) const override;
    MaterialWeights weights_at(int x, int y, int z, int material) const override;
    bool has_water() const override;
    float saturation_at(int x, int y, int z) const override;
    void read_terrain(int tx, int ty, std::vector<float>& terrain) const override;
    /// Where the soil is computed.
    Backend backend() const override;

  private:
    const Soil& soil_;
};

/// What is meshed and how.
struct SurfaceMeshDef {
    /// What is meshed.
    enum class Layer {
        soil,    ///< VoxelSample::volume; dives a little into the terrain so that no crack shows
        terrain  ///< terrain; static bodies are the host's own to draw
    };
    Layer layer = Layer::soil;
    /// Also the faces on the grid's floor, which no one sees from above. With them the mesh is
    /// closed.
    bool close_floor = true;
    std::array<float, 3> terrain_color{0.34f, 0.32f, 0.30f};  ///< linear RGB, 0..1, layer terrain
    /// Where tiles are meshed; none: TileSource::backend says. `gl` is OpenGL 4.5 compute, software
    /// too, `automatic` a hardware GPU alone; where there is none it is the CPU. The mesh is the
    /// same, bit for bit.
    std::optional<Backend> backend = std::nullopt;
    /// Threads of the host that mesh, 0..1024; 0: all cores. The mesh is the same. TileSource is
    /// read in the caller's thread alone.
    int thread_count = 0;
    /// Mesh::positions are world places less this. They are floats, which tell a millimetre apart
    /// as far as 10 km from zero, and half a metre at 5,000 km: for soil out there a place near it.
    Vec3 origin_m = {};
};

/// Soil of a voxel that no surface shows: in the air, and less than half a voxel that is part of
/// nothing thicker, or a voxel all by itself. It falls or flies, and a picture shows it as grains.
struct LooseVoxel {
    Vec3 center_m;                 ///< of the voxel, world
    Vec3 velocity_m_s;             ///< world axes
    float side_m = 0;              ///< of the voxel
    float height_m = 0;            ///< above the soil or terrain below it, or the grid's floor
    float volume = 0;              ///< soil, fraction of a voxel
    std::array<float, 3> color{};  ///< of its material, linear RGB
    float dust = 0;                ///< TileSource::dust_at
    uint32_t seed = 0;             ///< the voxel's, the same whenever it holds loose soil
};

/// Soil on top of a column that rolls and slides along the ground. Its surface shows it only by
/// where it goes; a picture shows it as grains as well.
struct RollingSoil {
    Vec3 center_m;      ///< on the surface, world
    Vec3 normal;        ///< of the surface, unit, world axes
    Vec3 velocity_m_s;  ///< along the surface, world axes
    /// How much moves, 0..1: 1 is what hides the ground.
    float amount = 0;
    float side_m = 0;              ///< of a voxel
    std::array<float, 3> color{};  ///< of the surface, linear RGB
    float dust = 0;                ///< as LooseVoxel::dust
    uint32_t seed = 0;             ///< the column's
};

/// How coarse the mesh may be, by how far it is from the eye: cells are 1, 2, 4 or 8 voxels wide.
/// By default all have one voxel.
struct SurfaceDetail {
    Vec3 eye_m;  ///< world
    /// The eye sees a wider cell under no more than this angle [rad]; 0: does not matter.
    double cell_angle_rad = 0;
    /// Or it sees how far the surface then is off by no more than this angle [rad]; negative: does
    /// not matter. Ground where nothing happens is coarse by this, however near.
    double error_angle_rad = -1;
};

/// What one update() did.
struct SurfaceMeshReport {
    int tile_read_count = 0;    ///< tiles whose revision had changed
    int tile_built_count = 0;   ///< tiles meshed anew: those that did change, and their neighbours
    int tile_coarse_count = 0;  ///< tiles that are not at full detail
    int tile_gl_count = 0;      ///< of those built, the ones that OpenGL has meshed
};

namespace mesh {
class DeviceMesher;
}

/// Marching cubes at isovalue 0.5 over a display field that makes planes of planar slopes, tile by
/// tile.
///
/// Samples lie at voxel centres. The soil of a column is reduced to runs [bottom, top]; the display
/// field is 0.5 plus the vertical distance [voxels] into the nearest run, so between two columns
/// the surface is the straight line through their tops (the remedy the thesis asks for in 5.3.2).
/// Where tops differ by several voxels the surface stands upright half way between the columns
/// instead. At the grid's sides and floor the soil is cut by exact planes.
///
/// A tile has a level of detail: its cells are 1, 2, 4 or 8 voxels wide. Tiles that touch are at
/// most one level apart, and where they are the cells of the coarser one take over the finer faces,
/// so the mesh stays closed.
class SurfaceMesher {
  public:
    /// The source must outlive the mesher.
    explicit SurfaceMesher(const TileSource& source, const SurfaceMeshDef& def = {});
    ~SurfaceMesher();

    /// Meshes again the tiles that changed since the last call, and their neighbours. After warm-up
    /// it allocates nothing as long as the meshes do not grow. Tiles keep their level of detail,
    /// which is full at first.
    SurfaceMeshReport update();
    /// Likewise; each tile gets the level that its distance allows. Near the distance where that
    /// changes a tile keeps the one it has, so that an eye that trembles changes nothing.
    SurfaceMeshReport update(const SurfaceDetail& detail);
    /// Likewise, with the levels that are asked for, 0..kLevelMost, ty * tile_count_x() + tx;
    /// lowered where tiles that touch would be more than one apart.
    SurfaceMeshReport update(std::span<const uint8_t> levels);

    /// The coarsest level: one cell a tile.
    static constexpr int kLevelMost = 3;
    /// The level of a tile's mesh, as of the last update(): its cells are 2^level voxels wide.
    int tile_level(int tx, int ty) const;

    /// "gl" where OpenGL meshes, all but cells beside finer tiles; else "cpu".
    std::string backend_name() const;
    /// Why, in a sentence.
    const std::string& backend_reason() const;

    Vec3 origin_m() const;     ///< SurfaceMeshDef::origin_m
    int tile_count_x() const;  ///< tiles of 8 columns along grid x
    int tile_count_y() const;  ///< and along grid y
    /// The mesh of a tile as of the last update().
    const Mesh& tile_mesh(int tx, int ty) const;
    /// The tiles that the last update() has meshed, each as ty * tile_count_x() + tx.
    std::span<const int> changed_tiles() const;
    /// Calls visit(tx, ty, mesh) for each of those: what a host's own renderer has to copy. A mesh
    /// without triangles says that the tile has none any more.
    void visit_changed(const std::function<void(int, int, const Mesh&)>& visit) const;
    /// Grows each time the tile's mesh was built; 0 before the first time.
    uint64_t tile_mesh_revision(int tx, int ty) const;
    /// The loose soil of a tile as of the last update(), from its lowest layer up. Layer soil only.
    std::span<const LooseVoxel> loose_soil(int tx, int ty) const;
    /// What rolls on a tile as of the last update(), column by column. Layer soil only.
    std::span<const RollingSoil> rolling_soil(int tx, int ty) const;
    /// All tiles in one mesh. Vertices on tile borders appear once per tile, at equal positions.
    void gather(Mesh& mesh) const;

  private:
    friend class SharedSurface;
    SurfaceMesher(const TileSource& source, const SurfaceMeshDef& def,
                  std::unique_ptr<mesh::DeviceMesher> device_mesher);
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil
#pragma GCC visibility pop
