#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "bsoil/surface_mesh.h"
#include "mesh/column_runs.h"
#include "mesh/display_field.h"
#include "mesh/marching_cases.h"
#include "mesh/plane_strips.h"

namespace bsoil {
namespace {

using mesh::DisplayField;
using mesh::kTileSide;
using mesh::shifted_down;

/// A vector in grid axes.
struct GridVector {
    float x, y, z;
};

/// Calls visit(q) for each set bit.
template <typename Visit>
void for_each_bit(uint64_t bits, int word, Visit visit) {
    for (; bits != 0; bits &= bits - 1) visit(64 * word + std::countr_zero(bits));
}

bool bit_at(const uint64_t* bits, int q) { return (bits[q / 64] >> (q % 64) & 1) != 0; }

/// Meshes one tile after the other; holds what is reused from tile to tile.
class TileMesher {
  public:
    TileMesher(const TileSource& source, const SurfaceMeshDef& def) : def_(def) {
        const GridFrame& frame = source.frame();
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 along{axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
            const Vec3 column = rotate(frame.grid_to_world.rotation, along);
            rotation_[0][axis] = column.x;
            rotation_[1][axis] = column.y;
            rotation_[2][axis] = column.z;
        }
        origin_ = frame.grid_to_world.position;
        voxel_m_ = frame.voxel_m;
        if (def.layer == SurfaceMeshDef::Layer::terrain) {
            colors_.push_back(def.terrain_color);
        } else {
            for (const MaterialDef& material : source.materials()) {
                colors_.push_back(material.color);
            }
        }
    }

    void build(const mesh::GridColumns& grid, int tx, int ty, Mesh& out) {
        field_.build(grid, tx, ty);
        out_ = &out;
        out.clear();
        sample_count_ = field_.sample_count_z();
        const size_t edge_count =
            static_cast<size_t>(3 * DisplayField::kWindow * DisplayField::kWindow * sample_count_);
        if (edge_vertices_.size() < edge_count) edge_vertices_.resize(edge_count);
        for (int j = field_.cell_first(1); j <= field_.cell_last(1) + 1; ++j) {
            for (int i = field_.cell_first(0); i <= field_.cell_last(0) + 1; ++i) {
                add_vertices_up(i, j);
                if (i <= field_.cell_last(0)) add_vertices_aside(0, i, j);
                if (j <= field_.cell_last(1)) add_vertices_aside(1, i, j);
            }
        }
        for (int j = field_.cell_first(1); j <= field_.cell_last(1); ++j) {
            if (def_.close_floor) add_floor_strips(j);
            for (int i = field_.cell_first(0); i <= field_.cell_last(0); ++i) add_cells(grid, i, j);
        }
    }

  private:
    /// The vertex of the edge that leaves sample (i, j, q) along an axis. Only crossed edges are
    /// set.
    uint32_t& edge_vertex(int axis, int i, int j, int q) {
        const int column = field_.column_index(i, j);
        return edge_vertices_[static_cast<size_t>((column * 3 + axis) * sample_count_ + q)];
    }

    GridVector unit(GridVector v) const {
        const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
        return length > 0 ? GridVector{v.x / length, v.y / length, v.z / length}
                          : GridVector{0, 0, 1};
    }

    GridVector rotated(GridVector v) const {
        const auto along = [&](const double* row) {
            return static_cast<float>(row[0] * v.x + row[1] * v.y + row[2] * v.z);
        };
        return {along(rotation_[0]), along(rotation_[1]), along(rotation_[2])};
    }

    static void push(std::vector<float>& list, GridVector v) {
        const float values[3] = {v.x, v.y, v.z};
        list.insert(list.end(), values, values + 3);
    }

    uint32_t add_vertex(GridVector position, GridVector outward, uint8_t material) {
        const auto index = static_cast<uint32_t>(out_->vertex_count());
        const auto along = [&](double base, const double* row) {
            return static_cast<float>(base + voxel_m_ * (row[0] * position.x + row[1] * position.y +
                                                         row[2] * position.z));
        };
        push(out_->positions, {along(origin_.x, rotation_[0]), along(origin_.y, rotation_[1]),
                               along(origin_.z, rotation_[2])});
        push(out_->normals, rotated(unit(outward)));
        const auto& color = colors_[std::min<size_t>(material, colors_.size() - 1)];
        out_->colors.insert(out_->colors.end(), color.begin(), color.end());
        return index;
    }

    void add_vertices_up(int i, int j) {
        const int word_count = field_.word_count();
        const uint64_t* inside = field_.inside_bits(i, j);
        for (int w = 0; w < word_count; ++w) {
            for_each_bit(inside[w] ^ shifted_down(inside, w, word_count), w, [&](int q) {
                if (q == 0 && !(def_.close_floor && strips_.is_kept_on_floor(i, j))) return;
                const bool top = bit_at(inside, q);
                const float z = field_.crossing_up(i, j, q);
                const GridVector outward =
                    q == 0 ? GridVector{0, 0, -1}
                           : GridVector{-field_.slope(0, i, j, z), -field_.slope(1, i, j, z),
                                        top ? 1.0f : -1.0f};
                edge_vertex(2, i, j, q) =
                    add_vertex({field_.position(0, i), field_.position(1, j), z}, outward,
                               field_.material(i, j, field_.height(top ? q : q + 1)));
            });
        }
    }

    void add_vertices_aside(int axis, int i, int j) {
        const int next_i = i + (axis == 0), next_j = j + (axis == 1);
        const uint64_t* here = field_.inside_bits(i, j);
        const uint64_t* there = field_.inside_bits(next_i, next_j);
        const int first = axis == 0 ? i : j;
        const bool at_side = field_.position(axis, first) == field_.position(axis, first + 1);
        for (int w = 0; w < field_.word_count(); ++w) {
            uint64_t crossed = here[w] ^ there[w];
            if (at_side && crossed != 0) {  // one of the two columns is empty
                crossed &= here[w] != 0 ? strips_.kept_on_side(i, j, 1 - axis, w)
                                        : strips_.kept_on_side(next_i, next_j, 1 - axis, w);
            }
            for_each_bit(crossed, w, [&](int q) {
                const bool leaving = bit_at(here, q);
                const int low[2] = {i, j}, high[2] = {next_i, next_j};
                const int* inner = leaving ? low : high;
                const float z = field_.height(q);
                float t = field_.crossing_aside(inner, leaving ? high : low, z);
                if (!leaving) t = 1.0f - t;
                const float begin = field_.position(axis, axis == 0 ? i : j);
                const float end = field_.position(axis, axis == 0 ? next_i : next_j);
                GridVector position{field_.position(0, i), field_.position(1, j), z};
                GridVector outward;
                if (begin == end) {  // a side of the grid
                    outward = {axis == 0 ? 1.0f : 0.0f, axis == 1 ? 1.0f : 0.0f, 0};
                    if (!leaving) outward = {-outward.x, -outward.y, 0};
                } else {
                    const auto mixed = [t](float a, float b) { return a + t * (b - a); };
                    const float along = field_.step(axis, i, j, z);
                    const float across = mixed(field_.slope(1 - axis, i, j, z),
                                               field_.slope(1 - axis, next_i, next_j, z));
                    const float up =
                        mixed(field_.slope_up(i, j, z), field_.slope_up(next_i, next_j, z));
                    outward = axis == 0 ? GridVector{-along, -across, -up}
                                        : GridVector{-across, -along, -up};
                    (axis == 0 ? position.x : position.y) = mixed(begin, end);
                }
                edge_vertex(axis, i, j, q) =
                    add_vertex(position, outward, field_.material(inner[0], inner[1], z));
            });
        }
    }

    /// The whole squares of a side between two columns, as strips up.
    void add_side_strips(int i, int j, GridVector side) {
        const int axis = side.x != 0 ? 0 : 1, along = 1 - axis;
        const int column_i = i + (i == -2), column_j = j + (j == -2);  // on the side
        const int next_i = i + (axis == 1), next_j = j + (axis == 0);
        // Seen from outside: y goes to the right at the far end of x, x at the near end of y.
        const bool turned = axis == 0 ? side.x < 0 : side.y > 0;
        uint32_t last[2] = {0, 0};
        uint64_t before = 0;
        for (int w = 0; w < field_.word_count(); ++w) {
            const uint64_t whole = strips_.whole_of_side(column_i, column_j, along, w);
            const uint64_t reached = whole << 1 | before >> 63;  // a square ends here
            before = whole;
            const uint64_t kept[2] = {
                strips_.kept_on_side(column_i, column_j, along, w),
                strips_.kept_on_side(column_i + (along == 0), column_j + (along == 1), along, w)};
            for_each_bit((whole | reached) & (kept[0] | kept[1]), w, [&](int q) {
                const bool goes_on = (reached >> (q % 64) & 1) != 0;
                for (int line = 0; line < 2; ++line) {
                    if ((kept[line] >> (q % 64) & 1) == 0) continue;
                    const uint32_t vertex =
                        edge_vertex(axis, line == 0 ? i : next_i, line == 0 ? j : next_j, q);
                    if (goes_on) add_triangle(last[0], last[1], vertex, turned);
                    last[line] = vertex;
                }
            });
        }
    }

    /// The whole squares of the floor between two rows of columns, as strips along x.
    void add_floor_strips(int j) {
        uint32_t last[2] = {0, 0};
        for (int i = field_.cell_first(0); i <= field_.cell_last(0) + 1; ++i) {
            const bool reached = i > field_.cell_first(0) && strips_.is_whole_of_floor(i - 1, j);
            const bool whole = i <= field_.cell_last(0) && strips_.is_whole_of_floor(i, j);
            if (!reached && !whole) continue;
            for (int line = 0; line < 2; ++line) {
                if (!strips_.is_kept_on_floor(i, j + line)) continue;
                const uint32_t vertex = edge_vertex(2, i, j + line, 0);
                if (reached) add_triangle(last[0], last[1], vertex, false);
                last[line] = vertex;
            }
        }
    }

    void add_triangle(uint32_t a, uint32_t b, uint32_t c, bool turned) {
        if (turned) std::swap(a, b);
        out_->indices.insert(out_->indices.end(), {a, b, c});
    }

    /// The cells above samples (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
    void add_cells(const mesh::GridColumns& grid, int i, int j) {
        const int word_count = field_.word_count();
        const uint64_t* inside[4] = {field_.inside_bits(i, j), field_.inside_bits(i + 1, j),
                                     field_.inside_bits(i, j + 1),
                                     field_.inside_bits(i + 1, j + 1)};
        const auto side_of = [&](int cell, int axis) {
            return cell == -2 ? -1.0f : cell == grid.size[axis] ? 1.0f : 0.0f;
        };
        const GridVector side{side_of(i, 0), side_of(j, 1), 0};
        const bool at_one_side = (side.x == 0) != (side.y == 0);
        if (at_one_side) add_side_strips(i, j, side);
        const auto whole = [&](int w) {
            uint64_t cells = 0;
            if (at_one_side) {
                cells = strips_.whole_of_side(i + (i == -2), j + (j == -2), side.x != 0, w);
            }
            if (w == 0 && strips_.is_whole_of_floor(i, j)) cells |= 1;
            return cells;
        };
        for (int w = 0; w < word_count; ++w) {
            uint64_t any = 0, all = ~uint64_t{0};
            for (const uint64_t* bits : inside) {
                const uint64_t above = shifted_down(bits, w, word_count);
                any |= bits[w] | above;
                all &= bits[w] & above;
            }
            for_each_bit(any & ~all & ~whole(w), w, [&](int q) {
                if (q == 0 && !def_.close_floor) return;
                int corners = 0;
                for (int c = 0; c < 4; ++c) {
                    corners |= bit_at(inside[c], q) << c | bit_at(inside[c], q + 1) << (c + 4);
                }
                add_triangles(mesh::marching_cases()[static_cast<size_t>(corners)], i, j, q, side);
            });
        }
    }

    void add_triangles(const mesh::MarchingCase& triangles, int i, int j, int q, GridVector side) {
        const bool at_side = side.x != 0 || side.y != 0;
        for (int t = 0; t < triangles.triangle_count; ++t) {
            uint32_t vertices[3];
            int axes[3];
            for (int k = 0; k < 3; ++k) {
                const int edge = triangles.edges[3 * t + k];
                const int a = edge & 1, b = edge >> 1 & 1;
                axes[k] = edge / 4;
                vertices[k] = axes[k] == 0   ? edge_vertex(0, i, j + a, q + b)
                              : axes[k] == 1 ? edge_vertex(1, i + a, j, q + b)
                                             : edge_vertex(2, i + a, j + b, q);
            }
            if (at_side) {
                // Cells of no thickness: only the triangles in the plane of the cut remain, and
                // their rim is sharp, so they do not share vertices with the surface above.
                if (same_place(vertices[0], vertices[1]) || same_place(vertices[1], vertices[2]) ||
                    same_place(vertices[2], vertices[0])) {
                    continue;
                }
                for (int k = 0; k < 3; ++k) {
                    if (axes[k] != (side.x != 0 ? 0 : 1)) {
                        vertices[k] = copy_vertex(vertices[k], side);
                    }
                }
            }
            out_->indices.insert(out_->indices.end(), vertices, vertices + 3);
        }
    }

    bool same_place(uint32_t a, uint32_t b) const {
        const float* p = out_->positions.data();
        return std::equal(p + 3 * a, p + 3 * a + 3, p + 3 * b);
    }

    uint32_t copy_vertex(uint32_t vertex, GridVector outward) {
        const auto index = static_cast<uint32_t>(out_->vertex_count());
        for (size_t k = 0; k < 3; ++k) {
            out_->positions.push_back(out_->positions[3 * vertex + k]);
            out_->colors.push_back(out_->colors[3 * vertex + k]);
        }
        push(out_->normals, rotated(outward));
        return index;
    }

    SurfaceMeshDef def_;
    double rotation_[3][3];
    Vec3 origin_;
    double voxel_m_ = 0;
    std::vector<std::array<float, 3>> colors_;
    DisplayField field_;
    mesh::PlaneStrips strips_{field_};
    int sample_count_ = 0;
    std::vector<uint32_t> edge_vertices_;
    Mesh* out_ = nullptr;
};

}  // namespace

struct SurfaceMesher::Impl {
    struct Tile {
        bool read = false, dirty = false;
        uint64_t source_revision = 0, mesh_revision = 0;
        Mesh mesh;
        std::vector<LooseVoxel> loose;
    };

    Impl(const TileSource& tile_source, const SurfaceMeshDef& mesh_def)
        : source(tile_source), def(mesh_def), mesher(tile_source, mesh_def) {
        std::copy(std::begin(source.frame().size), std::end(source.frame().size), grid.size);
        for (int axis = 0; axis < 2; ++axis) {
            grid.tile_count[axis] = (grid.size[axis] + kTileSide - 1) / kTileSide;
        }
        tiles.resize(static_cast<size_t>(grid.tile_count[0]) *
                     static_cast<size_t>(grid.tile_count[1]));
        grid.tiles.resize(tiles.size());
    }

    size_t tile_index(int tx, int ty) const {
        assert(tx >= 0 && tx < grid.tile_count[0] && ty >= 0 && ty < grid.tile_count[1]);
        return static_cast<size_t>(ty * grid.tile_count[0] + tx);
    }

    /// True when the tile's runs are not what they were.
    bool read_columns(int tx, int ty) {
        if (def.layer == SurfaceMeshDef::Layer::terrain) {
            source.read_terrain(tx, ty, solid);
            mesh::find_terrain_runs(solid, grid.size[2], columns);
        } else {
            source.read_tile(tx, ty, volume, solid, material);
            mesh::find_soil_runs(volume, solid, material, grid.size[2], columns);
            read_loose(tx, ty);
        }
        mesh::TileColumns& known = grid.tiles[tile_index(tx, ty)];
        if (columns == known) return false;
        std::swap(known, columns);
        return true;
    }

    /// From the arrays of the tile just read.
    void read_loose(int tx, int ty) {
        std::vector<LooseVoxel>& loose = tiles[tile_index(tx, ty)].loose;
        loose.clear();
        mesh::find_loose_voxels(volume, solid, grid.size[2], loose_voxels);
        const GridFrame& frame = source.frame();
        for (const int v : loose_voxels) {
            const int x = tx * kTileSide + v % kTileSide,
                      y = ty * kTileSide + v / kTileSide % kTileSide;
            const int z = v / mesh::kTileColumns;
            if (x >= grid.size[0] || y >= grid.size[1]) continue;
            LooseVoxel voxel;
            voxel.center_m = frame.to_world({x + 0.5, y + 0.5, z + 0.5});
            voxel.velocity_m_s = source.velocity_m_s(x, y, z);
            voxel.side_m = static_cast<float>(frame.voxel_m);
            voxel.volume = volume[static_cast<size_t>(v)];
            voxel.color = source.materials()[material[static_cast<size_t>(v)]].color;
            voxel.seed = static_cast<uint32_t>((z * grid.size[1] + y) * grid.size[0] + x);
            loose.push_back(voxel);
        }
    }

    void mark_with_neighbours(int tx, int ty) {
        for (int y = std::max(0, ty - 1); y <= std::min(grid.tile_count[1] - 1, ty + 1); ++y) {
            for (int x = std::max(0, tx - 1); x <= std::min(grid.tile_count[0] - 1, tx + 1); ++x) {
                tiles[tile_index(x, y)].dirty = true;
            }
        }
    }

    const TileSource& source;
    SurfaceMeshDef def;
    mesh::GridColumns grid;
    std::vector<Tile> tiles;
    TileMesher mesher;
    mesh::TileColumns columns;
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    std::vector<int> loose_voxels;
};

SurfaceMesher::SurfaceMesher(const TileSource& source, const SurfaceMeshDef& def)
    : impl_(std::make_unique<Impl>(source, def)) {}
SurfaceMesher::~SurfaceMesher() = default;

SurfaceMeshReport SurfaceMesher::update() {
    SurfaceMeshReport report;
    for (int ty = 0; ty < tile_count_y(); ++ty) {
        for (int tx = 0; tx < tile_count_x(); ++tx) {
            Impl::Tile& tile = impl_->tiles[impl_->tile_index(tx, ty)];
            const uint64_t revision = impl_->source.tile_revision(tx, ty);
            if (tile.read && tile.source_revision == revision) continue;
            const bool changed = impl_->read_columns(tx, ty);
            if (changed || !tile.read) impl_->mark_with_neighbours(tx, ty);
            tile.read = true;
            tile.source_revision = revision;
            ++report.tile_read_count;
        }
    }
    for (int ty = 0; ty < tile_count_y(); ++ty) {
        for (int tx = 0; tx < tile_count_x(); ++tx) {
            Impl::Tile& tile = impl_->tiles[impl_->tile_index(tx, ty)];
            if (!tile.dirty) continue;
            impl_->mesher.build(impl_->grid, tx, ty, tile.mesh);
            tile.dirty = false;
            ++tile.mesh_revision;
            ++report.tile_built_count;
        }
    }
    return report;
}

int SurfaceMesher::tile_count_x() const { return impl_->grid.tile_count[0]; }
int SurfaceMesher::tile_count_y() const { return impl_->grid.tile_count[1]; }

const Mesh& SurfaceMesher::tile_mesh(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].mesh;
}

uint64_t SurfaceMesher::tile_mesh_revision(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].mesh_revision;
}

std::span<const LooseVoxel> SurfaceMesher::loose_soil(int tx, int ty) const {
    return impl_->tiles[impl_->tile_index(tx, ty)].loose;
}

void SurfaceMesher::gather(Mesh& mesh) const {
    mesh.clear();
    for (const Impl::Tile& tile : impl_->tiles) mesh.append(tile.mesh);
}

}  // namespace bsoil
