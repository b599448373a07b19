#include "mesh/tile_mesher.h"

#include <algorithm>
#include <bit>

namespace bsoil::mesh {
namespace {

constexpr uint32_t kNoVertex = ~0u;

/// Calls visit(q) for each set bit.
template <typename Visit>
void for_each_bit(uint64_t bits, int word, Visit visit) {
    for (; bits != 0; bits &= bits - 1) visit(64 * word + std::countr_zero(bits));
}

bool bit_at(const uint64_t* bits, int q) { return (bits[q / 64] >> (q % 64) & 1) != 0; }

/// Samples of the window of a field, for each axis an edge that leaves it.
size_t edge_count(int sample_count) {
    return static_cast<size_t>(3 * DisplayField::kWindow * DisplayField::kWindow * sample_count);
}

}  // namespace

void TileMesher::begin(const GridColumns& grid, const TileLevels& levels, int tx, int ty,
                       Mesh& out) {
    levels_ = &levels;
    field_.build(grid, levels, levels.at(tx, ty), tx, ty);
    strips_.build(levels);
    out_ = &out;
    sample_count_ = field_.sample_count_z();
    if (edge_vertices_.size() < edge_count(sample_count_)) {
        edge_vertices_.resize(edge_count(sample_count_));
    }
}

void TileMesher::build(const GridColumns& grid, const TileLevels& levels, int tx, int ty,
                       Mesh& out) {
    begin(grid, levels, tx, ty, out);
    writer_.begin(out);
    places_.clear();
    for (int j = field_.cell_first(1); j <= field_.cell_last(1) + 1; ++j) {
        for (int i = field_.cell_first(0); i <= field_.cell_last(0) + 1; ++i) {
            add_vertices_up(i, j);
            if (i <= field_.cell_last(0)) add_vertices_aside(0, i, j);
            if (j <= field_.cell_last(1)) add_vertices_aside(1, i, j);
        }
    }
    for (int j = field_.cell_first(1); j <= field_.cell_last(1); ++j) {
        if (close_floor_) add_floor_strips(j);
        for (int i = field_.cell_first(0); i <= field_.cell_last(0); ++i) {
            if (strips_.is_plain(i, j)) add_cells(i, j);
        }
    }
    if (levels.is_beside_finer(tx, ty)) add_split_tile(grid, tx, ty);
}

void TileMesher::add_border(const GridColumns& grid, const TileLevels& levels, int tx, int ty,
                            std::span<const Edge> edges, std::span<const GridVector> places,
                            Mesh& out) {
    begin(grid, levels, tx, ty, out);
    places_.assign(places.begin(), places.end());
    for (size_t v = 0; v < edges.size(); ++v) {
        const auto [axis, i, j, q] = edges[v];
        edge_vertex(axis, i, j, q) = static_cast<uint32_t>(v);
    }
    add_split_tile(grid, tx, ty);
}

/// The cells of a tile that finer ones touch.
void TileMesher::add_split_tile(const GridColumns& grid, int tx, int ty) {
    finer_field_.build(grid, *levels_, field_.level() - 1, tx, ty);
    finer_sample_count_ = finer_field_.sample_count_z();
    finer_edge_vertices_.assign(edge_count(finer_sample_count_), kNoVertex);
    for (int j = field_.cell_first(1); j <= field_.cell_last(1); ++j) {
        for (int i = field_.cell_first(0); i <= field_.cell_last(0); ++i) {
            if (strips_.is_plain(i, j)) continue;
            add_split_cells(levels_->finer_around(field_.level(), i, j), i, j, side_of(i, j));
        }
    }
}

/// On which sides of the grid the cells over a sample are: -1, 0 or 1 along x and y.
GridVector TileMesher::side_of(int i, int j) const {
    const auto along = [&](int cell, int axis) {
        return cell == -2 ? -1.0f : cell == field_.lattice(axis).count() ? 1.0f : 0.0f;
    };
    return {along(i, 0), along(j, 1), 0};
}

uint32_t& TileMesher::edge_vertex(int axis, int i, int j, int q) {
    const int column = field_.column_index(i, j);
    return edge_vertices_[static_cast<size_t>((column * 3 + axis) * sample_count_ + q)];
}

uint32_t& TileMesher::finer_edge_vertex(int axis, int i, int j, int q) {
    const int column = finer_field_.column_index(i, j);
    return finer_edge_vertices_[static_cast<size_t>((column * 3 + axis) * finer_sample_count_ + q)];
}

uint32_t TileMesher::add_vertex(GridVector position, GridVector outward, const Look& look) {
    const auto index = static_cast<uint32_t>(places_.size());
    places_.push_back(position);
    writer_.add(*out_, position, outward, look);
    return index;
}

uint32_t TileMesher::add_vertex_up(const DisplayField& field, int i, int j, int q) {
    const bool top = bit_at(field.inside_bits(i, j), q);
    const float z = field.crossing_up(i, j, q);
    const GridVector outward =
        q == 0 ? GridVector{0, 0, -1}
               : GridVector{-field.slope(0, i, j, z), -field.slope(1, i, j, z), top ? 1.0f : -1.0f};
    return add_vertex({field.position(0, i), field.position(1, j), z}, outward,
                      q == 0 ? writer_.look_of(field.material(i, j, 0))
                             : writer_.look_at(field, i, j, field.height(top ? q : q + 1)));
}

uint32_t TileMesher::add_vertex_aside(const DisplayField& field, int axis, int i, int j, int q) {
    const int next_i = i + (axis == 0), next_j = j + (axis == 1);
    const bool leaving = bit_at(field.inside_bits(i, j), q);
    const int low[2] = {i, j}, high[2] = {next_i, next_j};
    const int* inner = leaving ? low : high;
    const float z = field.height(q);
    const float begin = field.position(axis, low[axis]), end = field.position(axis, high[axis]);
    float t = field.crossing_aside(inner, leaving ? high : low, end - begin, z);
    if (!leaving) t = 1.0f - t;
    GridVector position{field.position(0, i), field.position(1, j), z};
    GridVector outward;
    if (begin == end) {  // a side of the grid
        outward = {axis == 0 ? 1.0f : 0.0f, axis == 1 ? 1.0f : 0.0f, 0};
        if (!leaving) outward = {-outward.x, -outward.y, 0};
    } else {
        const auto mixed = [t](float a, float b) { return a + t * (b - a); };
        const float along = field.step(axis, i, j, z);
        const float across =
            mixed(field.slope(1 - axis, i, j, z), field.slope(1 - axis, next_i, next_j, z));
        const float up = mixed(field.slope_up(i, j, z), field.slope_up(next_i, next_j, z));
        outward = axis == 0 ? GridVector{-along, -across, -up} : GridVector{-across, -along, -up};
        (axis == 0 ? position.x : position.y) = mixed(begin, end);
    }
    // A cut shows what is inside.
    if (begin == end) {
        return add_vertex(position, outward, writer_.look_inside(field, inner[0], inner[1], z));
    }
    return add_vertex(position, outward, writer_.look_at(field, inner[0], inner[1], z));
}

uint32_t TileMesher::copy_vertex(uint32_t vertex, GridVector outward) {
    const auto index = static_cast<uint32_t>(places_.size());
    places_.push_back(GridVector(places_[vertex]));
    writer_.add_copy(*out_, vertex, outward);
    return index;
}

void TileMesher::add_vertices_up(int i, int j) {
    const int word_count = field_.word_count();
    const uint64_t* inside = field_.inside_bits(i, j);
    for (int w = 0; w < word_count; ++w) {
        for_each_bit(inside[w] ^ shifted_down(inside, w, word_count), w, [&](int q) {
            if (q == 0 && !(close_floor_ && strips_.is_kept_on_floor(i, j))) return;
            edge_vertex(2, i, j, q) = add_vertex_up(field_, i, j, q);
        });
    }
}

void TileMesher::add_vertices_aside(int axis, int i, int j) {
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
            edge_vertex(axis, i, j, q) = add_vertex_aside(field_, axis, i, j, q);
        });
    }
}

/// The whole squares of a side between two columns, as strips up.
void TileMesher::add_side_strips(int i, int j, GridVector side) {
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
void TileMesher::add_floor_strips(int j) {
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

void TileMesher::add_triangle(uint32_t a, uint32_t b, uint32_t c, bool turned) {
    if (turned) std::swap(a, b);
    out_->indices.insert(out_->indices.end(), {a, b, c});
}

/// The cells above samples (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
void TileMesher::add_cells(int i, int j) {
    const int word_count = field_.word_count();
    const uint64_t* inside[4] = {field_.inside_bits(i, j), field_.inside_bits(i + 1, j),
                                 field_.inside_bits(i, j + 1), field_.inside_bits(i + 1, j + 1)};
    const GridVector side = side_of(i, j);
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
            if (q == 0 && !close_floor_) return;
            int corners = 0;
            for (int c = 0; c < 4; ++c) {
                corners |= bit_at(inside[c], q) << c | bit_at(inside[c], q + 1) << (c + 4);
            }
            add_case(marching_cases()[static_cast<size_t>(corners)], i, j, q, side);
        });
    }
}

void TileMesher::add_case(const MarchingCase& triangles, int i, int j, int q, GridVector side) {
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
        add_cell_triangle(vertices, axes, side);
    }
}

/// The cells above those samples where finer tiles touch them.
void TileMesher::add_split_cells(const TileLevels::FinerAround& around, int i, int j,
                                 GridVector side) {
    const auto finer = [&](int dx, int dy) {
        return around.finer[static_cast<size_t>(dy + 1)][static_cast<size_t>(dx + 1)];
    };
    SplitCell::Borders borders;
    borders.finer_side = {finer(-1, 0), finer(1, 0), finer(0, -1), finer(0, 1)};
    for (size_t c = 0; c < 4; ++c) {
        const int dx = (c & 1) != 0 ? 1 : -1, dy = (c & 2) != 0 ? 1 : -1;
        borders.finer_upright[c] = finer(dx, 0) || finer(0, dy) || finer(dx, dy);
    }
    borders.has_middle = {field_.lattice(0).has_middle(i), field_.lattice(1).has_middle(j), true};
    SplitCell regular(borders);
    borders.has_middle[2] = false;
    SplitCell flat(borders);  // at the floor, and at the top of a grid of odd height

    const int first[3] = {i, j, 0},
              corner[2] = {field_.lattice(0).in_finer(i), field_.lattice(1).in_finer(j)};
    const uint64_t* bits[9];
    for (int c = 0; c < 9; ++c) {
        const int x = c % 3, y = c / 3;
        const auto along = [&](int axis, int step) {
            if (step == 2) return field_.lattice(axis).in_finer(first[axis] + 1);
            const bool has_middle = borders.has_middle[static_cast<size_t>(axis)];
            return corner[axis] + (has_middle ? step : 0);
        };
        bits[c] = finer_field_.inside_bits(along(0, x), along(1, y));
    }
    const Lattice& upright = field_.lattice(2);
    for (int q = close_floor_ ? 0 : 1; q + 1 < sample_count_; ++q) {
        const bool has_middle = upright.has_middle(q - 2);
        const SplitCell& cell = has_middle ? regular : flat;
        const int finer_q = upright.in_finer(q - 2) + 2;
        uint32_t inside = 0;
        for (int s = 0; s < 27; ++s) {
            const int z = s / 9;
            const int sample = finer_q + (has_middle ? z : z / 2);
            inside |= static_cast<uint32_t>(bit_at(bits[s % 9], sample)) << s;
        }
        inside &= cell.samples();
        if (inside == 0 || inside == cell.samples()) continue;
        split_corners_.clear();
        cell.add_triangles(inside, split_corners_);
        const int at[3] = {i, j, q};
        for (size_t t = 0; t + 2 < split_corners_.size(); t += 3) {
            uint32_t vertices[3];
            int axes[3];
            for (size_t k = 0; k < 3; ++k) {
                vertices[k] = vertex_of(split_corners_[t + k], at);
                axes[k] = split_corners_[t + k].axis;
            }
            add_cell_triangle(vertices, axes, side);
        }
    }
}

/// Of an edge of a split cell, its own lattice's or the finer one's.
uint32_t TileMesher::vertex_of(const SplitCell::Edge& edge, const int cell[3]) {
    const auto is_even = [](int x) { return x % 2 == 0; };
    if (edge.is_whole && std::all_of(std::begin(edge.at), std::end(edge.at), is_even)) {
        return edge_vertex(edge.axis, cell[0] + edge.at[0] / 2, cell[1] + edge.at[1] / 2,
                           cell[2] + edge.at[2] / 2);
    }
    int at[3];
    for (int axis = 0; axis < 3; ++axis) {
        const int shift = axis == 2 ? 2 : 0;  // sample 0 upwards is index -2 of the lattice
        const Lattice& lattice = field_.lattice(axis);
        const int index = cell[axis] - shift;
        at[axis] = shift + (edge.at[axis] == 2 ? lattice.in_finer(index + 1)
                                               : lattice.in_finer(index) + edge.at[axis]);
    }
    uint32_t& vertex = finer_edge_vertex(edge.axis, at[0], at[1], at[2]);
    if (vertex == kNoVertex) {
        vertex = edge.axis == 2 ? add_vertex_up(finer_field_, at[0], at[1], at[2])
                                : add_vertex_aside(finer_field_, edge.axis, at[0], at[1], at[2]);
    }
    return vertex;
}

void TileMesher::add_cell_triangle(uint32_t (&vertices)[3], const int (&axes)[3], GridVector side) {
    if (side.x != 0 || side.y != 0) {
        // Cells of no thickness: only the triangles in the plane of the cut remain, and their rim
        // is sharp, so they do not share vertices with the surface above.
        const GridVector at[3] = {places_[vertices[0]], places_[vertices[1]], places_[vertices[2]]};
        if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) return;
        for (int k = 0; k < 3; ++k) {
            if (axes[k] != (side.x != 0 ? 0 : 1)) vertices[k] = copy_vertex(vertices[k], side);
        }
    }
    out_->indices.insert(out_->indices.end(), vertices, vertices + 3);
}

}  // namespace bsoil::mesh
