/// Vertices of a mesh from places in the grid: turned to the world, with the look of the soil
/// there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh/display_field.h"
#include "mesh/soil_color.h"

namespace bsoil::mesh {

/// A vector in grid axes.
struct GridVector {
    float x, y, z;
    friend bool operator==(const GridVector&, const GridVector&) = default;
};

class VertexWriter {
  public:
    VertexWriter(const TileSource& source, const SurfaceMeshDef& def);
    /// Takes the materials' colours as they are now. Whether some are others.
    bool take_colors(const std::vector<MaterialDef>& materials);
    /// Empties a mesh and tells it the materials.
    void begin(Mesh& mesh) const;

    /// Adds a vertex at a place in voxels. `outward` may have any length.
    void add(Mesh& mesh, GridVector position, GridVector outward, const Look& look) const;
    /// Adds one that differs from another by its normal alone: this one, of unit length.
    void add_copy(Mesh& mesh, uint32_t vertex, GridVector outward) const;

    /// What lies bare at a sample, or else what is inside.
    Look look_at(const DisplayField& field, int i, int j, float z) const;
    /// In walls and at the sides of the grid: the materials there by themselves, whatever became
    /// of the soil, or the mean of those that mix; with their water.
    Look look_inside(const DisplayField& field, int i, int j, float z) const;
    /// The same where the material and the mixture, or null, are known.
    Look look_mixed(uint8_t material, const MixedLayer* mixture) const;
    /// A material by itself.
    const Look& look_of(uint8_t material) const;
    /// Of each material.
    std::span<const Look> plain_looks() const { return looks_; }

  private:
    GridVector rotated(GridVector v) const;
    Color mean_color(const MaterialWeights& weights) const;

    Eigen::Matrix3d rotation_;  ///< of the grid in the world
    Eigen::Vector3d origin_;    ///< of the grid, from SurfaceMeshDef::origin_m
    double voxel_m_ = 0;
    bool is_terrain_ = false, has_water_ = false;
    std::vector<Look> looks_;                    ///< of each material by itself
    std::vector<std::array<float, 3>> palette_;  ///< empty: one material
};

}  // namespace bsoil::mesh
