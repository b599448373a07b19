/// Which triangles of a mesh hang together, which way they face, and which parts are closed.
#pragma once

#include <vector>

#include "bsoil/result.h"
#include "bsoil/soil_def.h"

namespace bsoil {

/// A mesh of parts: sets of faces that share edges.
struct MeshTopology {
    static constexpr int kOpenEdge = -1;
    static constexpr int kManyFaces = -2;  ///< three or more faces share the edge
    struct Face {
        int vertex[3] = {0, 0, 0};  ///< counter-clockwise seen from outside
        int across[3] = {0, 0, 0};  ///< face beyond the edge from vertex k to k + 1, or see above
        int part = 0;
        Vec3 normal;  ///< unit; zero where the face has no area
    };
    struct Part {
        bool is_closed = false;
        Aabb box;
        double volume_m3 = 0;  ///< negative: a cavity
    };
    std::vector<Vec3> vertices;
    std::vector<Face> faces;
    std::vector<Part> parts;
};

/// Merges corners at the same place, drops triangles that are then no triangles, turns the faces of
/// a part one way and closed parts outwards, but for those within another that are turned against
/// it. The error names what no solid can be made of: no triangle, an index out of range, a
/// coordinate that is not finite or beyond 1e5 m, no area.
Result<MeshTopology> mesh_topology(const TriangleMesh& mesh);

/// The mesh, with faces in the gaps of parts that are then closed and whose walls are thinner than
/// wall_m on the mean: plates with a face left out here and there, as published meshes often have
/// them. Gaps of more than a tenth of a part's surface stay: it is an open sheet.
TriangleMesh with_gaps_closed(const MeshTopology& mesh, double wall_m);

}  // namespace bsoil
