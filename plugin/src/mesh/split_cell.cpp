#include "mesh/split_cell.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace bsoil::mesh {
namespace {

constexpr int kStride[3] = {1, 3, 9};
constexpr int kSampleCount = 27;
constexpr int kSplitEdgeCount = 3 * kSampleCount;  ///< an edge is its lower sample and its axis

constexpr int coordinate(int sample, int axis) { return sample / kStride[axis] % 3; }

/// The axis in which two samples differ.
constexpr int axis_between(int a, int b) {
    const int step = a < b ? b - a : a - b;
    return step >= kStride[2] ? 2 : step >= kStride[1] ? 1 : 0;
}

constexpr int split_edge_between(int a, int b) { return 3 * std::min(a, b) + axis_between(a, b); }

/// Bit f: both ends of the edge lie in face f of the cell.
int faces_of(int edge, bool is_whole) {
    const int low = edge / 3, high = low + (is_whole ? 2 : 1) * kStride[edge % 3];
    int faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            if (coordinate(low, axis) == 2 * side && coordinate(high, axis) == 2 * side) {
                faces |= 1 << (2 * axis + side);
            }
        }
    }
    return faces;
}

}  // namespace

SplitCell::SplitCell(const Borders& borders) {
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            // Across the face: u x v points along the axis, so the low side is walked by v, u.
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if (side == 0) std::swap(u, v);
            const int base = 2 * side * kStride[axis];
            const auto sample = [&](int a, int b) {
                return base + a * kStride[u] + b * kStride[v];
            };
            if (axis < 2 && borders.finer_side[2 * axis + side]) {
                const int step_u = borders.has_middle[u] ? 1 : 2;
                const int step_v = borders.has_middle[v] ? 1 : 2;
                for (int b = 0; b < 2; b += step_v) {
                    for (int a = 0; a < 2; a += step_u) {
                        Polygon& polygon = new_polygon();
                        polygon.add(sample(a, b));
                        polygon.add(sample(a + step_u, b));
                        polygon.add(sample(a + step_u, b + step_v));
                        polygon.add(sample(a, b + step_v));
                    }
                }
                continue;
            }
            const auto is_split = [&](int from, int along) {
                if (!borders.has_middle[along]) return false;
                const int x = coordinate(from, 0) / 2, y = coordinate(from, 1) / 2;
                switch (along) {
                    case 0:
                        return borders.finer_side[2 + y];
                    case 1:
                        return borders.finer_side[x];
                    default:
                        return borders.finer_upright[x + 2 * y];
                }
            };
            const int corners[4] = {sample(0, 0), sample(2, 0), sample(2, 2), sample(0, 2)};
            Polygon& polygon = new_polygon();
            for (int k = 0; k < 4; ++k) {
                const int from = corners[k], to = corners[(k + 1) % 4];
                polygon.add(from);
                if (is_split(from, axis_between(from, to))) polygon.add((from + to) / 2);
            }
        }
    }
    for (int p = 0; p < polygon_count_; ++p) {
        const Polygon& polygon = polygons_[p];
        for (int k = 0; k < polygon.size; ++k) samples_ |= 1u << polygon.samples[k];
    }
}

void SplitCell::add_triangles(uint32_t inside, std::vector<Edge>& corners) const {
    // As marching_cases.cpp: a contour piece of a face leads from the edge where the walk enters
    // the solid to the one where it leaves it.
    std::array<int8_t, kSplitEdgeCount> next{};
    std::array<bool, kSplitEdgeCount> is_whole{};
    next.fill(-1);
    for (int p = 0; p < polygon_count_; ++p) {
        const Polygon& polygon = polygons_[p];
        const auto at = [&](int k) { return static_cast<int>(polygon.samples[k % polygon.size]); };
        const auto is_in = [&](int k) { return (inside >> at(k) & 1) != 0; };
        const auto edge_from = [&](int k) {
            const int a = at(k), b = at(k + 1), edge = split_edge_between(a, b);
            is_whole[edge] = std::abs(a - b) == 2 * kStride[edge % 3];
            return edge;
        };
        for (int k = 0; k < polygon.size; ++k) {
            if (is_in(k) || !is_in(k + 1)) continue;
            int last = k + 1;
            while (is_in(last + 1)) ++last;
            const int enter = edge_from(k), leave = edge_from(last);
            next[enter] = static_cast<int8_t>(leave);
        }
    }
    for (int start = 0; start < kSplitEdgeCount; ++start) {
        std::array<int, kSplitEdgeCount> loop{}, faces{};
        int size = 0;
        for (int edge = start; next[edge] >= 0;) {
            faces[size] = faces_of(edge, is_whole[edge]);
            loop[size++] = edge;
            edge = std::exchange(next[edge], int8_t{-1});
        }
        // A fan. A diagonal in a face of the cell may meet one of the neighbouring cell's, and four
        // triangles would share an edge: the apex is where there are fewest.
        int apex = 0, fewest = kSplitEdgeCount;
        for (int a = 0; a < size; ++a) {
            int count = 0;
            for (int k = 2; k + 1 < size; ++k) count += (faces[a] & faces[(a + k) % size]) != 0;
            if (count < fewest) {
                fewest = count;
                apex = a;
            }
        }
        for (int k = 1; k + 1 < size; ++k) {
            for (const int corner : {apex, (apex + k) % size, (apex + k + 1) % size}) {
                const int edge = loop[corner], low = edge / 3;
                corners.push_back({{static_cast<uint8_t>(coordinate(low, 0)),
                                    static_cast<uint8_t>(coordinate(low, 1)),
                                    static_cast<uint8_t>(coordinate(low, 2))},
                                   static_cast<uint8_t>(edge % 3),
                                   is_whole[edge]});
            }
        }
    }
}

}  // namespace bsoil::mesh
