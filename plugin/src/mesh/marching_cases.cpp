#include "mesh/marching_cases.h"

namespace bsoil::mesh {
namespace {

constexpr int kEdgeCount = 12;

/// The corners of a face, counter-clockwise seen from outside the cell.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                              {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/// The edge between two corners that differ in one coordinate.
constexpr int edge_between(int a, int b) {
    const int lower = a & b;
    switch (a ^ b) {
        case 1:
            return lower >> 1;
        case 2:
            return 4 + ((lower & 1) | ((lower >> 2) << 1));
        default:
            return 8 + (lower & 3);
    }
}

/// Bit f: the edge lies in face f.
constexpr std::array<int, kEdgeCount> faces_of_edges() {
    std::array<int, kEdgeCount> faces{};
    for (int face = 0; face < 6; ++face) {
        for (int i = 0; i < 4; ++i) {
            faces[edge_between(kFaces[face][i], kFaces[face][(i + 1) % 4])] |= 1 << face;
        }
    }
    return faces;
}

/// How many diagonals of the fan about loop[apex] lie in a face of the cell. Such a diagonal may
/// meet one of the neighbouring cell, and four triangles would share an edge.
constexpr int face_diagonal_count(const std::array<int, kEdgeCount>& loop, int size, int apex) {
    constexpr auto faces = faces_of_edges();
    int count = 0;
    for (int i = 2; i + 1 < size; ++i) {
        count += (faces[loop[apex]] & faces[loop[(apex + i) % size]]) != 0;
    }
    return count;
}

constexpr MarchingCase build_case(int inside_corners) {
    const auto inside = [&](int corner) { return (inside_corners >> corner & 1) != 0; };
    // A contour piece of a face leads from the edge where the walk enters the solid to the one
    // where it leaves it. Each edge is walked in opposite directions by its two faces: pieces chain
    // up.
    std::array<int, kEdgeCount> next{};
    next.fill(-1);
    for (const auto& face : kFaces) {
        for (int i = 0; i < 4; ++i) {
            if (inside(face[i]) || !inside(face[(i + 1) % 4])) continue;
            int leave = i + 1;
            while (inside(face[(leave + 1) % 4])) ++leave;
            next[edge_between(face[i], face[(i + 1) % 4])] =
                edge_between(face[leave % 4], face[(leave + 1) % 4]);
        }
    }
    MarchingCase result;
    for (int start = 0; start < kEdgeCount; ++start) {
        std::array<int, kEdgeCount> loop{};
        int size = 0;
        for (int edge = start; next[edge] >= 0;) {
            loop[size++] = edge;
            const int following = next[edge];
            next[edge] = -1;
            edge = following;
        }
        if (size == 0) continue;
        int apex = 0;
        for (int i = 1; i < size; ++i) {
            if (face_diagonal_count(loop, size, i) < face_diagonal_count(loop, size, apex)) {
                apex = i;
            }
        }
        for (int i = 1; i + 1 < size; ++i) {
            const int corners[3] = {apex, (apex + i) % size, (apex + i + 1) % size};
            for (int k = 0; k < 3; ++k) {
                result.edges[3 * result.triangle_count + k] =
                    static_cast<uint8_t>(loop[corners[k]]);
            }
            ++result.triangle_count;
        }
    }
    return result;
}

}  // namespace

const std::array<MarchingCase, 256>& marching_cases() {
    static const std::array<MarchingCase, 256> cases = [] {
        std::array<MarchingCase, 256> built;
        for (int i = 0; i < 256; ++i) built[i] = build_case(i);
        return built;
    }();
    return cases;
}

}  // namespace bsoil::mesh
