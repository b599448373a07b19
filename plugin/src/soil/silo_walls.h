/// SiloWalls: hands over what walls bear of the loads of bodies that they are not part of. See
/// docs/decisions/silo_walls.md.
#pragma once

#include <functional>
#include <vector>

#include "contact/wall_friction.h"
#include "soil/body_table.h"
#include "soil/tile_table.h"

namespace bsoil {

class SiloWalls {
  public:
    SiloWalls(SoilCore& core, TileTable& tiles, BodyTable& bodies)
        : core_(core), tiles_(tiles), bodies_(bodies) {}

    /// Before a step's results are read: adds what will be asked, where a load had walls in the
    /// last step. Else nothing.
    void want(bool has_contacts, std::vector<device::ReadRange>& ranges);
    /// Height spans of an awake tile's columns, until the next call.
    using TileSpans = std::function<const int32_t*(int slot)>;
    /// Fills in BodyLoad::held_kg, and appends entries of walls that carry no load themselves.
    /// loads: by index of their body. header: the first words of Buffer::result. Nothing but a look
    /// at loads where all are small, and at contacts where none has a wall.
    void share(std::span<const int32_t> header, std::span<const ContactVoxel> contacts,
               const TileSpans& spans_of, std::vector<BodyLoad>& loads);

  private:
    static constexpr int kGround = -1;  ///< WallFace::wall of static ground

    /// What a body's faces in one load are like.
    struct Wall {
        int body = -1;  ///< SoilBody::id
        double upright_m2 = 0, sole_m2 = 0;
        Vec3 middle_m;          ///< of the upright faces, times their area
        double outward_m2 = 0;  ///< sum of area times n . r / |r|
        bool is_wall() const;
    };

    /// A wall's contact with the load, by the voxel that it is in.
    struct Touch {
        int voxel[3] = {};
        size_t wall = 0;
        const ContactVoxel* contact = nullptr;
    };
    struct VoxelPlace {
        int x = 0, y = 0, z = 0;
    };

    const StepBody* find_body(int id) const;
    void sort_contacts(std::span<const ContactVoxel> contacts);
    double wall_share(const BodyLoad& load) const;
    void share_load(BodyLoad& load, bool has_terrain, std::span<const ContactVoxel*> contacts,
                    const TileSpans& spans_of);
    void list_walls(std::span<const ContactVoxel*> contacts);
    void list_touches(std::span<const ContactVoxel*> contacts);
    void read_solids(const StepBody& floor);
    void read_tile(int tile, std::vector<device::ReadRange>& ranges);
    void list_cells(const StepBody& floor, const TileSpans& spans_of);
    void add_cells(const int32_t* column, int carrier, int x, int y);
    void add_faces(const StepBody& floor, const LoadCell& cell, bool has_terrain);
    void add_body_face(const StepBody& floor, const VoxelPlace& beside, int dx, int dy, int index,
                       WallFace& face);
    void add_terrain_face(const StepBody& floor, const VoxelPlace& beside, int dx, int dy,
                          WallFace& face);
    void add_face(const StepBody& floor, const SoilBody* wall, const WallGrip& grip,
                  WallFace& face);
    Vec3 middle_of(const VoxelPlace& beside, Vec3 outward) const;
    const Touch* find_touch(const VoxelPlace& beside, Vec3 outward, int body) const;
    int plane_count() const;
    size_t tile_words() const;
    int word_at(int plane, const VoxelPlace& at) const;
    int material_at(const VoxelPlace& at) const;
    void hand_over(BodyLoad& load);

    SoilCore& core_;
    TileTable& tiles_;
    BodyTable& bodies_;
    WallFriction friction_;
    Vec3 up_;
    // Scratch, kept so that a step does not allocate once warm.
    std::vector<const ContactVoxel*> by_carrier_;
    std::vector<Wall> walls_;
    std::vector<Touch> touches_;
    std::vector<LoadCell> cells_;
    std::vector<WallFace> faces_;
    std::vector<BodyLoad> borne_;
    // What stands in the tiles of loads and those around, planes of the state tile by tile: what
    // was asked for in the last step is read with everything else.
    std::vector<int> asked_;  ///< tiles
    std::vector<int> read_;   ///< tiles, in the order of their planes
    std::vector<int> missing_;
    std::vector<int> place_;  ///< by tile: in read_, -1 where it is not there
    std::vector<int32_t> planes_;
    std::vector<device::ReadRange> ranges_;
    TileVoxels asleep_;
};

}  // namespace bsoil
