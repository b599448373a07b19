/// What walls bear of the soil between them by friction: Janssen's silo, layer by layer. See
/// docs/decisions/silo_walls.md.
#pragma once

#include <span>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/material.h"

namespace bsoil {

/// Level over vertical stress at rest: 1 - sin phi (Jaky 1944).
double rest_pressure_factor(double friction_angle_rad);

/// Friction of a wall with soil that leans on it.
struct WallGrip {
    double friction = 0;        ///< mu, at most tan phi
    double pressure_share = 0;  ///< K
    /// Level stress by which cohesion relieves the wall, 2 c sqrt(K) (Bell 1915) [Pa].
    double relief_pa = 0;
};
/// surface_friction: of the wall; negative: as the material says. cohesion_pa: of the soil there.
WallGrip wall_grip(const MaterialDef& material, double surface_friction, double cohesion_pa);

/// Vertical part of the friction between a wall and soil that moves against it by
/// `soil_velocity_m_s`: friction acts along the slip. 1 up to rest_m_s, 0 where the soil rises at
/// twice that or faster; linear in between, so that what a solver leaves of rest does not switch
/// it.
double hanging_share(Vec3 soil_velocity_m_s, Vec3 up, double rest_m_s);

/// A voxel of a load.
struct LoadCell {
    int x = 0, y = 0, z = 0;
    double height = 1;  ///< up to which it is filled, 0..1
};

/// A part of a wall beside one voxel of the load.
struct WallFace {
    int voxel[3] = {};       ///< the load's
    double area_voxels = 0;  ///< upright: times the square of the normal's level part
    double friction = 0;     ///< WallGrip::friction times hanging_share()
    double pressure_share = 0;
    double relief_kg =
        0;         ///< WallGrip::relief_pa, as the mass whose weight on a voxel's side it is
    int wall = 0;  ///< whose: the caller's key
    Vec3 position_m;
    double borne_kg = 0;  ///< out: the mass whose weight it bears
};

/// Weight that comes down in each connected part of each layer of voxels, from the top. Stress is
/// even over such a part, as Janssen has it.
class WallFriction {
  public:
    /// cells: of one load, each once. Their soil weighs load_kg together.
    /// Fills in WallFace::borne_kg. The order of faces does not matter but to the last bit.
    void find(std::span<const LoadCell> cells, double load_kg, std::span<WallFace> faces);

  private:
    void list_layers(std::span<const LoadCell> cells);
    void list_faces(std::span<const WallFace> faces);
    void begin_layer(int z, std::span<const WallFace> faces, size_t& next_face);
    size_t column_of(int x, int y) const {
        return static_cast<size_t>(y - low_y_) * static_cast<size_t>(width_) +
               static_cast<size_t>(x - low_x_);
    }
    void gather_part(int z, size_t first);
    void load_part(std::span<WallFace> faces, double voxel_kg);

    int low_x_ = 0, low_y_ = 0, low_z_ = 0, width_ = 0, depth_ = 0;
    std::vector<std::vector<const LoadCell*>> layers_;  ///< from low_z_ up
    std::vector<size_t> face_order_;                    ///< by layer from the top, then by column
    // By column, of the layer in progress.
    std::vector<int> layer_;       ///< z in which it was last filled
    std::vector<int> part_layer_;  ///< z in which it was last put into a part
    std::vector<const LoadCell*> cell_;
    std::vector<double> weight_kg_;               ///< comes down on the layer below it
    std::vector<size_t> first_face_, last_face_;  ///< in face_order_
    std::vector<size_t> part_;                    ///< columns of the part in progress
};

}  // namespace bsoil
