#include "openvdb_grids.h"

#include <openvdb/openvdb.h>

namespace bsoil::scene {
namespace {

constexpr int kTileSide = 8;  // tile by tile: that is how the soil's cache reads

openvdb::math::Transform::Ptr transform_of(const GridFrame& frame) {
    // A grid's points are the middles of our voxels.
    const Vec3 origin = frame.to_world({0.5, 0.5, 0.5});
    const Vec3 axes[3] = {frame.to_world({1.5, 0.5, 0.5}) - origin,
                          frame.to_world({0.5, 1.5, 0.5}) - origin,
                          frame.to_world({0.5, 0.5, 1.5}) - origin};
    openvdb::Mat4R matrix = openvdb::Mat4R::identity();  // row vectors, as OpenVDB has them
    for (int row = 0; row < 3; ++row) {
        matrix[row][0] = axes[row].x;
        matrix[row][1] = axes[row].y;
        matrix[row][2] = axes[row].z;
    }
    matrix[3][0] = origin.x;
    matrix[3][1] = origin.y;
    matrix[3][2] = origin.z;
    return openvdb::math::Transform::createLinearTransform(matrix);
}

template <typename Grid>
typename Grid::Ptr make_grid(const char* name, const GridFrame& frame) {
    typename Grid::Ptr grid = Grid::create();
    grid->setName(name);
    grid->setTransform(transform_of(frame));
    return grid;
}

}  // namespace

Status write_openvdb(const Soil& soil, const std::string& path) {
    openvdb::initialize();
    const GridFrame& frame = soil.frame();
    const auto volume = make_grid<openvdb::FloatGrid>("volume", frame);
    volume->setGridClass(openvdb::GRID_FOG_VOLUME);
    const auto density = make_grid<openvdb::FloatGrid>("density", frame);
    const auto velocity = make_grid<openvdb::Vec3SGrid>("velocity", frame);
    const auto material = make_grid<openvdb::Int32Grid>("material", frame);
    const auto terrain = make_grid<openvdb::FloatGrid>("terrain", frame);
    auto set_volume = volume->getAccessor();
    auto set_density = density->getAccessor();
    auto set_velocity = velocity->getAccessor();
    auto set_material = material->getAccessor();
    auto set_terrain = terrain->getAccessor();
    const auto read = [&](int x, int y, int z) {
        const VoxelSample s = soil.sample(x, y, z);
        const openvdb::Coord at(x, y, z);
        if (s.coverage > 0) set_terrain.setValue(at, static_cast<float>(s.coverage));
        if (s.volume <= 0) return;
        set_volume.setValue(at, static_cast<float>(s.volume));
        set_density.setValue(at, static_cast<float>(s.density_kg_m3));
        set_velocity.setValue(at, openvdb::Vec3s(openvdb::Vec3d(s.velocity_m_s.x, s.velocity_m_s.y,
                                                                s.velocity_m_s.z)));
        set_material.setValue(at, s.material);
    };
    for (int ty = 0; ty < frame.size[1]; ty += kTileSide) {
        for (int tx = 0; tx < frame.size[0]; tx += kTileSide) {
            for (int z = 0; z < frame.size[2]; ++z) {
                for (int y = ty; y < std::min(frame.size[1], ty + kTileSide); ++y) {
                    for (int x = tx; x < std::min(frame.size[0], tx + kTileSide); ++x) {
                        read(x, y, z);
                    }
                }
            }
        }
    }
    try {
        openvdb::io::File file(path);
        file.write({volume, density, velocity, material, terrain});
        file.close();
    } catch (const std::exception& failure) {
        return Error{path + ": " + failure.what()};
    }
    return Done{};
}

}  // namespace bsoil::scene
