#include "mesh_conversion.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "bsoil/distance_lattice.h"

namespace bsoil::bullet {
namespace {

constexpr int kAllParts = -1;  ///< of a mesh of several
/// Corners, and indices, of a mesh that go into its fingerprint.
constexpr int kFingerprintCount = 20000;
/// A solid that is cut reaches so much beyond the ball around the grid [share of it, voxels].
constexpr double kRegionSlack = 1.01;
constexpr double kRegionSlackVoxels = 4;
/// Points of a distance field along each axis that go into its fingerprint.
constexpr int kFieldProbes = 5;

/// A part of a mesh, locked for reading.
class LockedPart {
  public:
    LockedPart(const btStridingMeshInterface& mesh, int part) : mesh_(mesh), part_(part) {
        mesh.getLockedReadOnlyVertexIndexBase(&vertices_, vertex_count, vertex_type_,
                                              vertex_stride_, &indices_, index_stride_,
                                              triangle_count, index_type_, part);
        if (!vertices_) vertex_count = 0;
        if (!indices_) triangle_count = 0;
    }
    ~LockedPart() { mesh_.unLockReadOnlyVertexBase(part_); }
    LockedPart(const LockedPart&) = delete;

    bool is_readable() const {
        return (vertex_type_ == PHY_FLOAT || vertex_type_ == PHY_DOUBLE) &&
               (index_type_ == PHY_INTEGER || index_type_ == PHY_SHORT || index_type_ == PHY_UCHAR);
    }
    Vec3 vertex(int i) const {
        const unsigned char* at = vertices_ + static_cast<ptrdiff_t>(i) * vertex_stride_;
        if (vertex_type_ == PHY_DOUBLE) return read_vector<double>(at);
        return read_vector<float>(at);
    }
    std::array<int, 3> triangle(int t) const {
        const unsigned char* at = indices_ + static_cast<ptrdiff_t>(t) * index_stride_;
        if (index_type_ == PHY_INTEGER) return read_triple<int32_t>(at);
        if (index_type_ == PHY_SHORT) return read_triple<uint16_t>(at);
        return read_triple<uint8_t>(at);
    }

    int vertex_count = 0, triangle_count = 0;

  private:
    template <typename T>
    static Vec3 read_vector(const unsigned char* at) {
        T v[3];
        std::memcpy(v, at, sizeof v);
        return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
    }
    template <typename T>
    static std::array<int, 3> read_triple(const unsigned char* at) {
        T v[3];
        std::memcpy(v, at, sizeof v);
        return {static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2])};
    }

    const btStridingMeshInterface& mesh_;
    int part_;
    const unsigned char* vertices_ = nullptr;
    const unsigned char* indices_ = nullptr;
    PHY_ScalarType vertex_type_ = PHY_FLOAT, index_type_ = PHY_INTEGER;
    int vertex_stride_ = 0, index_stride_ = 0;
};

Status read_part(const btStridingMeshInterface& mesh, int part, Vec3 scaling, TriangleMesh& out) {
    const LockedPart from(mesh, part);
    if (from.triangle_count <= 0) return Done{};
    if (!from.is_readable()) {
        return Error{"part " + std::to_string(part) +
                     " has corners or indices of an unknown type; take PHY_FLOAT or "
                     "PHY_DOUBLE corners and integer indices"};
    }
    const int first = static_cast<int>(out.vertices.size());
    for (int v = 0; v < from.vertex_count; ++v) {
        const Vec3 p = from.vertex(v);
        out.vertices.push_back({p.x * scaling.x, p.y * scaling.y, p.z * scaling.z});
    }
    for (int t = 0; t < from.triangle_count; ++t) {
        std::array<int, 3> triangle = from.triangle(t);
        for (int& index : triangle) {
            if (index < 0 || index >= from.vertex_count) {
                return Error{"triangle " + std::to_string(t) + " of part " + std::to_string(part) +
                             " has vertex index " + std::to_string(index) + ", must be 0 to " +
                             std::to_string(from.vertex_count - 1)};
            }
            index += first;
        }
        out.triangles.push_back(triangle);
    }
    return Done{};
}

/// only: the part to read; all of them where it is kAllParts.
Result<TriangleMesh> read_mesh(const btStridingMeshInterface& mesh, Vec3 scaling,
                               int only = kAllParts) {
    TriangleMesh out;
    for (int part = 0; part < mesh.getNumSubParts(); ++part) {
        if (only == kAllParts || part == only) {
            if (const Status s = read_part(mesh, part, scaling, out); !s) return Error{s.error()};
        }
    }
    return out;
}

/// A mesh shape's triangles, how they are scaled, and how thick Bullet takes them.
struct MeshSource {
    const btStridingMeshInterface* mesh = nullptr;
    int part = kAllParts;
    Vec3 scaling{1, 1, 1};
    double margin_m = 0;
};

Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

MeshSource source_of(const btCollisionShape& shape) {
    MeshSource out;
    if (shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE) {
        const auto& gimpact = static_cast<const btGImpactShapeInterface&>(shape);
        const btGImpactMeshShapePart* part = nullptr;
        if (gimpact.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE) {
            const auto& whole = static_cast<const btGImpactMeshShape&>(gimpact);
            out.mesh = whole.getMeshInterface();
            if (whole.getMeshPartCount() > 0) part = whole.getMeshPart(0);
        } else {
            part = static_cast<const btGImpactMeshShapePart*>(&gimpact);
            out.mesh = static_cast<const btGImpactMeshShapePart::TrimeshPrimitiveManager*>(
                           part->getPrimitiveManager())
                           ->m_meshInterface;
            out.part = part->getPart();
        }
        if (part) {
            out.scaling = from_bullet(part->getLocalScaling());
            out.margin_m = static_cast<double>(part->getMargin());
        }
        return out;
    }
    const bool is_scaled = shape.getShapeType() == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE;
    const auto& bvh = is_scaled
                          ? *static_cast<const btScaledBvhTriangleMeshShape&>(shape).getChildShape()
                          : static_cast<const btBvhTriangleMeshShape&>(shape);
    out.mesh = bvh.getMeshInterface();
    out.scaling = from_bullet(out.mesh->getScaling());
    if (is_scaled) out.scaling = times(out.scaling, from_bullet(shape.getLocalScaling()));
    out.margin_m = static_cast<double>(shape.getMargin());
    return out;
}

Aabb box_of(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return {from_bullet(low), from_bullet(high)};
}

Aabb region_of(const GridBall& grid) {
    const double r = kRegionSlack * grid.radius_m + kRegionSlackVoxels * grid.voxel_m;
    return {grid.center_m - Vec3{r, r, r}, grid.center_m + Vec3{r, r, r}};
}

/// Only what is larger than the grid is cut to it: a moving body would have to be cut anew in each
/// step.
bool is_cut(const btCollisionShape& shape, const GridBall& grid) {
    if (shape.getShapeType() == TERRAIN_SHAPE_PROXYTYPE) return true;
    const Aabb box = box_of(shape);
    return length(box.max - box.min) > 2 * grid.radius_m;
}

Result<Shapes> lattice_shape(DistanceLattice::LatticeResult&& lattice) {
    if (!lattice) return Error{lattice.error()};
    ConvexShape out = of_kind(ConvexShape::Kind::lattice);
    out.lattice = std::move(*lattice);
    return Shapes{out};
}

bool is_beyond(const Aabb& box, double margin_m, const Aabb& region) {
    const auto is_apart = [&](double Vec3::*axis) {
        return box.min.*axis - margin_m > region.max.*axis ||
               box.max.*axis + margin_m < region.min.*axis;
    };
    return is_apart(&Vec3::x) || is_apart(&Vec3::y) || is_apart(&Vec3::z);
}

/// No shapes where nothing of the mesh lies in the region.
Result<Shapes> lattice_of(const TriangleMesh& mesh, const LatticeDef& def) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Aabb box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    for (const auto& triangle : mesh.triangles) {
        for (const int index : triangle) {
            const Vec3 p = mesh.vertices[static_cast<size_t>(index)];
            box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y),
                       std::min(box.min.z, p.z)};
            box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y),
                       std::max(box.max.z, p.z)};
        }
    }
    if (!mesh.triangles.empty() && is_beyond(box, def.margin_m, def.region)) return Shapes{};
    return lattice_shape(DistanceLattice::from_mesh(mesh, def));
}

Result<LatticeDef> lattice_def(double margin_m, const GridBall& grid) {
    if (!(std::isfinite(margin_m) && margin_m >= 0)) {
        return Error{"margin is " + std::to_string(margin_m) +
                     " m, must be finite and not negative"};
    }
    LatticeDef def;
    def.voxel_m = grid.voxel_m;
    def.margin_m = margin_m;
    return def;
}

Result<Shapes> triangle_mesh(const btCollisionShape& shape, const GridBall& grid) {
    const MeshSource source = source_of(shape);
    if (!is_finite(source.scaling) || source.scaling.x == 0 || source.scaling.y == 0 ||
        source.scaling.z == 0) {
        return Error{"local scaling is zero or not finite; take 1 where it has its size"};
    }
    Result<LatticeDef> def = lattice_def(source.margin_m, grid);
    if (!def) return Error{def.error()};
    if (is_cut(shape, grid)) def->region = region_of(grid);
    const Result<TriangleMesh> mesh = read_mesh(*source.mesh, source.scaling, source.part);
    if (!mesh) return Error{mesh.error()};
    return lattice_of(*mesh, *def);
}

double& component(Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// Opens what Bullet keeps from the public.
struct HeightfieldAccess : btHeightfieldTerrainShape {
    static int width(const btHeightfieldTerrainShape& s) {
        return s.*&HeightfieldAccess::m_heightStickWidth;
    }
    static int length(const btHeightfieldTerrainShape& s) {
        return s.*&HeightfieldAccess::m_heightStickLength;
    }
    static uint64_t diagonals(const btHeightfieldTerrainShape& s) {
        return (s.*&HeightfieldAccess::m_flipQuadEdges ? 1u : 0u) |
               (s.*&HeightfieldAccess::m_useDiamondSubdivision ? 2u : 0u) |
               (s.*&HeightfieldAccess::m_useZigzagSubdivision ? 4u : 0u);
    }
};

void add_heights(Fingerprint& print, const btHeightfieldTerrainShape& shape) {
    const int width = HeightfieldAccess::width(shape), length = HeightfieldAccess::length(shape);
    print.add(static_cast<uint64_t>(width));
    print.add(static_cast<uint64_t>(length));
    print.add(HeightfieldAccess::diagonals(shape));
    print.add(shape.getLocalScaling());
    print.add(static_cast<double>(shape.getMargin()));
    const int64_t count = static_cast<int64_t>(width) * length;
    for (int64_t i = 0; i < count; i += 1 + count / kFingerprintCount) {
        btVector3 vertex;
        shape.getVertex(static_cast<int>(i % width), static_cast<int>(i / width), vertex);
        print.add(vertex);
    }
}

/// Triangles of a heightfield, corners in one place merged.
class SurfaceReader : public btTriangleCallback {
  public:
    void processTriangle(btVector3* triangle, int, int) override {
        std::array<int, 3> indices{};
        for (size_t k = 0; k < 3; ++k) {
            const Vec3 p = from_bullet(triangle[k]);
            if (!is_finite(p)) {
                all_finite = false;
                return;
            }
            const auto [known, is_new] = index_.try_emplace(
                std::tuple(p.x, p.y, p.z), static_cast<int>(surface.vertices.size()));
            if (is_new) surface.vertices.push_back(p);
            indices[k] = known->second;
        }
        surface.triangles.push_back(indices);
    }
    TriangleMesh surface;
    bool all_finite = true;

  private:
    std::map<std::tuple<double, double, double>, int> index_;
};

/// Walls down from the rim of a surface, and the same surface at the bottom.
void close_below(TriangleMesh& mesh, int up, double bottom) {
    const int count = static_cast<int>(mesh.vertices.size());
    for (int v = 0; v < count; ++v) {
        Vec3 p = mesh.vertices[static_cast<size_t>(v)];
        component(p, up) = bottom;
        mesh.vertices.push_back(p);
    }
    std::map<std::pair<int, int>, int> passes;  // of each edge, up minus down
    for (const auto& t : mesh.triangles) {
        for (size_t k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            passes[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    const size_t triangle_count = mesh.triangles.size();
    for (size_t i = 0; i < triangle_count; ++i) {
        const auto t = mesh.triangles[i];
        mesh.triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
    }
    for (const auto& [edge, balance] : passes) {
        if (balance == 0) continue;
        const auto [a, b] =
            balance > 0 ? std::pair(edge.first, edge.second) : std::pair(edge.second, edge.first);
        mesh.triangles.push_back({b, a, a + count});
        mesh.triangles.push_back({b, a + count, b + count});
    }
}

Result<Shapes> heightfield(const btHeightfieldTerrainShape& shape, const GridBall& grid) {
    Result<LatticeDef> def = lattice_def(static_cast<double>(shape.getMargin()), grid);
    if (!def) return Error{def.error()};
    const Vec3 scaling = from_bullet(shape.getLocalScaling());
    if (!is_finite(scaling) || !(scaling.x > 0 && scaling.y > 0 && scaling.z > 0)) {
        return Error{"local scaling is not finite or not above 0; take 1 where it has its size"};
    }
    def->region = region_of(grid);
    const int up = shape.getUpAxis();
    // Whatever its height.
    Vec3 low = def->region.min, high = def->region.max;
    component(low, up) = -1e5;
    component(high, up) = 1e5;
    SurfaceReader reader;
    shape.processAllTriangles(&reader, to_bullet(low), to_bullet(high));
    if (!reader.all_finite) {
        return Error{
            "has a height that is not finite; look for a division by zero where it was made"};
    }
    if (reader.surface.triangles.empty()) return Shapes{};
    low = def->region.min;
    double bottom = component(low, up);
    for (Vec3 p : reader.surface.vertices) bottom = std::min(bottom, component(p, up));
    close_below(reader.surface, up, bottom - kRegionSlackVoxels * grid.voxel_m - def->margin_m);
    return lattice_of(reader.surface, *def);
}

Result<Shapes> distance_field(const btSdfCollisionShape& shape, const GridBall& grid) {
    const Aabb box = box_of(shape);
    if (!(is_finite(box.min) && is_finite(box.max) && box.min.x < box.max.x &&
          box.min.y < box.max.y && box.min.z < box.max.z)) {
        return Error{"has no distance field; call initializeSDF first"};
    }
    // Bullet's query changes nothing.
    auto& field = const_cast<btSdfCollisionShape&>(shape);
    const auto distance_m = [&](Vec3 p) {
        const Vec3 q{std::clamp(p.x, box.min.x, box.max.x), std::clamp(p.y, box.min.y, box.max.y),
                     std::clamp(p.z, box.min.z, box.max.z)};
        btScalar distance = 0;
        btVector3 normal;
        const double beside = length(p - q);
        if (!field.queryPoint(to_bullet(q), distance, normal)) return beside + grid.voxel_m;
        // Outside of its box there is nothing, even where the solid reaches the box's faces.
        return beside > 0 ? std::max(beside, static_cast<double>(distance) + beside)
                          : static_cast<double>(distance);
    };
    return convert_distance(shape, distance_m, box, grid);
}

}  // namespace

Result<Shapes> convert_distance(const btCollisionShape& shape,
                                const std::function<double(Vec3)>& distance_m, const Aabb& bounds,
                                const GridBall& grid) {
    Result<LatticeDef> def = lattice_def(0, grid);
    if (!def) return Error{def.error()};
    if (is_cut(shape, grid)) def->region = region_of(grid);
    if (is_beyond(bounds, 0, def->region)) return Shapes{};
    return lattice_shape(DistanceLattice::from_distance(distance_m, bounds, *def));
}

bool is_mesh(const btCollisionShape& shape) {
    switch (shape.getShapeType()) {
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case TERRAIN_SHAPE_PROXYTYPE:
            return true;
        case GIMPACT_SHAPE_PROXYTYPE:
            return static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() !=
                   CONST_GIMPACT_COMPOUND_SHAPE;
        case SDF_SHAPE_PROXYTYPE:
            return dynamic_cast<const btSdfCollisionShape*>(&shape) != nullptr;
        default:
            return false;
    }
}

Result<Shapes> convert_mesh(const btCollisionShape& shape, const GridBall& grid) {
    if (shape.getShapeType() == TERRAIN_SHAPE_PROXYTYPE) {
        return heightfield(static_cast<const btHeightfieldTerrainShape&>(shape), grid);
    }
    if (shape.getShapeType() == SDF_SHAPE_PROXYTYPE) {
        return distance_field(static_cast<const btSdfCollisionShape&>(shape), grid);
    }
    return triangle_mesh(shape, grid);
}

Result<Shapes> convert_triangle(const btVector3* corners, double margin_m, double scale,
                                const GridBall& grid) {
    const Result<LatticeDef> def = lattice_def(margin_m * scale, grid);
    if (!def) return Error{def.error()};
    TriangleMesh mesh;
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(scale * from_bullet(corners[k]));
    mesh.triangles.push_back({0, 1, 2});
    return lattice_of(mesh, *def);
}

Result<std::vector<btVector3>> mesh_points(const btStridingMeshInterface& mesh,
                                           const btVector3& scaling) {
    const Result<TriangleMesh> read = read_mesh(mesh, from_bullet(scaling));
    if (!read) return Error{read.error()};
    std::vector<bool> used(read->vertices.size(), false);
    for (const auto& triangle : read->triangles) {
        for (const int index : triangle) used[static_cast<size_t>(index)] = true;
    }
    std::vector<btVector3> points;
    for (size_t v = 0; v < used.size(); ++v) {
        if (used[v]) points.push_back(to_bullet(read->vertices[v]));
    }
    return points;
}

void add_mesh(Fingerprint& print, const btStridingMeshInterface& mesh) {
    for (int p = 0; p < mesh.getNumSubParts(); ++p) {
        const LockedPart part(mesh, p);
        print.add(static_cast<uint64_t>(part.vertex_count));
        print.add(static_cast<uint64_t>(part.triangle_count));
        if (!part.is_readable()) continue;
        for (int v = 0; v < part.vertex_count; v += 1 + part.vertex_count / kFingerprintCount) {
            print.add(part.vertex(v));
        }
        for (int t = 0; t < part.triangle_count; t += 1 + part.triangle_count / kFingerprintCount) {
            for (const int index : part.triangle(t)) print.add(static_cast<uint64_t>(index));
        }
    }
}

void add_grid(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid) {
    const Aabb box = box_of(shape);
    print.add(box.min);
    print.add(box.max);
    print.add(grid.voxel_m);
    if (is_cut(shape, grid)) {
        print.add(grid.center_m);
        print.add(grid.radius_m);
    }
}

void add_mesh(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid) {
    const Aabb box = box_of(shape);
    add_grid(print, shape, grid);
    if (shape.getShapeType() == SDF_SHAPE_PROXYTYPE) {
        auto& field =
            const_cast<btSdfCollisionShape&>(static_cast<const btSdfCollisionShape&>(shape));
        for (int i = 0; i < kFieldProbes * kFieldProbes * kFieldProbes; ++i) {
            const auto share = [](int n) { return (n % kFieldProbes + 0.5) / kFieldProbes; };
            const Vec3 size = box.max - box.min;
            const Vec3 p = box.min + times(size, {share(i), share(i / kFieldProbes),
                                                  share(i / kFieldProbes / kFieldProbes)});
            btScalar distance = 0;
            btVector3 normal;
            if (is_finite(p) && length(size) > 0 &&
                field.queryPoint(to_bullet(p), distance, normal)) {
                print.add(static_cast<double>(distance));
            }
        }
        return;
    }
    if (shape.getShapeType() == TERRAIN_SHAPE_PROXYTYPE) {
        add_heights(print, static_cast<const btHeightfieldTerrainShape&>(shape));
        return;
    }
    const MeshSource source = source_of(shape);
    print.add(source.scaling);
    print.add(source.margin_m);
    add_mesh(print, *source.mesh);
}

}  // namespace bsoil::bullet
