// Meshes follow the soil: what was kept up to date equals what is made anew.
#include <fmt/format.h>

#include <cmath>

#include "bsoil/surface_mesh.h"
#include "check.h"

namespace bsoil::random_worlds {
namespace {

constexpr int kUpdateEvery = 30;

/// The mesh of one soil, kept up to date.
class KeptMesh {
  public:
    explicit KeptMesh(const Soil& soil) : tiles_(soil), mesher_(tiles_) {}

    void update() { mesher_.update(); }
    void compare(const std::string& name, double time_s, Failures& failures) {
        mesher_.update();
        Mesh kept, anew;
        mesher_.gather(kept);
        SurfaceMesher other(tiles_);
        other.update();
        other.gather(anew);
        if (kept.positions != anew.positions || kept.indices != anew.indices ||
            kept.normals != anew.normals || kept.colors != anew.colors) {
            failures.add("mesh kept", name, time_s,
                         fmt::format("{} triangles as made anew", anew.triangle_count()),
                         fmt::format("{} that differ", kept.triangle_count()));
        }
        const GridFrame& frame = tiles_.frame();
        for (size_t i = 0; i + 2 < anew.positions.size(); i += 3) {
            const Vec3 at{anew.positions[i], anew.positions[i + 1], anew.positions[i + 2]};
            const Vec3 g = frame.to_grid(at);
            // Single precision, of coordinates of 10 m: well below a tenth of a voxel.
            constexpr double kSlack = 0.1;
            if (!is_finite(at) || g.x < -kSlack || g.y < -kSlack || g.z < -kSlack ||
                g.x > frame.size[0] + kSlack || g.y > frame.size[1] + kSlack ||
                g.z > frame.size[2] + kSlack) {
                failures.add("mesh in grid", name, time_s, "vertices within the grid",
                             fmt::format("({} {} {}) voxels", g.x, g.y, g.z));
                break;
            }
        }
        for (const uint32_t index : anew.indices) {
            if (index >= anew.vertex_count()) {
                failures.add("mesh indices", name, time_s, "vertices that exist",
                             fmt::format("{}", index));
                break;
            }
        }
    }

  private:
    SoilTiles tiles_;
    SurfaceMesher mesher_;
};

class MeshCheck final : public Check {
  public:
    explicit MeshCheck(const BuiltWorld& world) {
        for (const bullet::SoilAction* soil : world.soils()) {
            meshes_.push_back(std::make_unique<KeptMesh>(soil->soil()));
        }
    }

    void after_step(BuiltWorld& world, Failures&) override {
        if (world.step_count() % kUpdateEvery != 0) return;
        for (const auto& mesh : meshes_) mesh->update();
    }
    void at_end(BuiltWorld& world, bool, Failures& failures) override {
        for (size_t i = 0; i < meshes_.size(); ++i) {
            meshes_[i]->compare(fmt::format("soil {}", i), world.time_s(), failures);
        }
    }

  private:
    std::vector<std::unique_ptr<KeptMesh>> meshes_;
};

}  // namespace

std::unique_ptr<Check> make_mesh_check(const BuiltWorld& world) {
    return std::make_unique<MeshCheck>(world);
}

}  // namespace bsoil::random_worlds
